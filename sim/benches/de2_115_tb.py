"""The cocotb half of ``test_de2_115.py``: the pins of the DE2-115, whose system is the stand-in of :mod:`sim.models.loop_double`."""

import cocotb
import numpy as np

from sim.benches.loop_pins import LoopPins, lit
from sim.kit.display_cases import SMALL_DISPLAY
from sim.models.loop_double import double_picture
from sim.models.monitor import Monitor


def pins(dut):
    return LoopPins(dut, "clk50_0__io", "button_0__io", pressed=0, half_ns=10)


@cocotb.test()
async def line_leds_and_reset(dut):
    """And no sync is added to green."""
    await pins(dut).check_line_leds_and_reset()
    assert int(dut.dac_0__sync_n__io.value) == 0


@cocotb.test()
async def picture_at_the_converter(dut):
    """What a strict monitor samples with the converter's clock is golden's picture; no pin changes at that clock's rising edge."""
    board = pins(dut)
    monitor = Monitor(SMALL_DISPLAY)
    clock, word = "", None

    def sample():
        nonlocal clock, word
        # The clock is "Z" during reset.
        clock_before, word_before, clock = clock, word, str(dut.dac_0__clk__io.value)
        blue, green, red, hsync, vsync = (int(getattr(dut, f"vga_0__{name}__io").value) for name in ("b", "g", "r", "hs", "vs"))
        word = blue | green << 8 | red << 16 | int(dut.dac_0__blank_n__io.value) << 24 | hsync << 25 | vsync << 26
        if (clock_before, clock) == ("0", "1"):
            assert word == word_before
            monitor.clock(word)

    board.press(False)
    await board.clocks(40)
    await board.clocks(int(2.3 * SMALL_DISPLAY.h_total * SMALL_DISPLAY.v_total), sample)
    assert monitor.frames >= 1
    np.testing.assert_array_equal(monitor.pictures[0], double_picture(SMALL_DISPLAY))


@cocotb.test()
async def plls_that_lose_their_lock(dut):
    """Each resets what its clock drives."""
    board = pins(dut)
    changes, before = 0, None

    def sample():
        nonlocal changes, before
        level = str(dut.vga_0__hs__io.value)     # "Z" during reset
        changes, before = changes + (level != before), level

    board.press(True)
    dut.uart_0__rx__io.value = 1
    await board.clocks(3)
    board.press(False)
    await board.clocks(10)
    dut.uart_0__rx__io.value = 0
    await board.clocks(4)
    assert lit(dut) == 1
    dut.pll.block.locks.value = 0
    await board.clocks(3)
    assert lit(dut) == 0
    dut.pll.block.locks.value = 1

    dut.pixel_pll.block.locks.value = 0
    await board.clocks(4)
    await board.clocks(1, sample)
    changes = 0
    await board.clocks(3 * SMALL_DISPLAY.h_total, sample)
    assert changes == 0
    dut.pixel_pll.block.locks.value = 1
    await board.clocks(3 * SMALL_DISPLAY.h_total, sample)
    assert changes >= 4
