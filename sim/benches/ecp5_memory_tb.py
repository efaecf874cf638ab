"""The cocotb half of ``test_ecp5.py`` for a board with an SDRAM, whose system is a stand-in of :mod:`sim.models.loop_double`."""

import cocotb
from cocotb.triggers import Timer
from cocotb.types import LogicArray

from sim.benches.loop_pins import lit
from sim.models.loop_double import MemoryDouble
from sim.models.sdram import PinWord, SdramMemory


CLOCK_HZ = 60_000_000
HALF_NS = 8
# Words, and rows that are opened for them twice.
CLOCKS = MemoryDouble.POWER_UP + 200 + 4 * MemoryDouble.WORDS + 2 * 16 * 12


def pin_word(dut, reading):
    """The levels at an edge of the memory's clock, but of data while a word is read; command and chip select are low active."""
    def level(name):
        return int(getattr(dut, f"sdram_0__{name}__io").value)

    assert level("cs") == 0
    word = dut.sdram_0__dq__io.value
    driven = int(not reading and word.is_resolvable)
    command = sum((1 - level(name)) << place for place, name in enumerate(("ras", "cas", "we")))
    return PinWord(level("clk_en"), command, level("ba"), level("a"), level("dqm"), int(word) if driven else 0, driven)


@cocotb.test()
async def words(dut):
    memory = SdramMemory(CLOCK_HZ, power_up=MemoryDouble.POWER_UP * 1e9 / CLOCK_HZ)
    dut.button_fire_0__io.value = 0
    dut.uart_0__rx__io.value = 1
    data, before = dut.sdram_0__dq__io, 0
    for _ in range(CLOCKS):
        for level in (1, 0):
            dut.clk25_0__io.value = level
            await Timer(HALF_NS // 2, unit="ns")
            clock = int(dut.sdram_0__clk__io.value)
            if clock and not before:
                memory.edge(pin_word(dut, memory.upcoming is not None))
            before = clock
            await Timer(HALF_NS // 2, unit="ns")
            # A word is there for a quarter of a clock before its edge and after it; before that the pins are changing.
            word = memory.upcoming
            data.value = LogicArray("Z" * 16) if word is None else LogicArray("X" * 16) if clock else word
    assert (memory.words_written, memory.words_read) == (MemoryDouble.WORDS, MemoryDouble.WORDS)
    assert lit(dut) == MemoryDouble.WORDS
