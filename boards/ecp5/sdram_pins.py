"""Pins of an SDRAM on an ECP5: a register in each of them, and the memory's clock."""

from typing import Any

from amaranth import *
from amaranth.lib import io

from golden.video.sdram import WORD_BITS
from hdl.loop.sdram import SdramPins


__all__ = ["connect_sdram"]


def connect_sdram(m: Module, memory: SdramPins, pins: Any) -> None:
    """Connect a controller to the pins of a board's memory.

    The memory's clock is that of ``sync``, inverted by a double-data-rate register: its edge is half a clock after each change at the pins,
    and its words are registered by the same edge. They are read half a clock later in ``sync``, as :class:`SdramPins` has it.

    The way from that edge through the clock's pin, the memory and a data pin may take a clock. nextpnr does not know it: of 16.7 ns at
    60 MHz the memory takes 6 to 6.5 ns (tAC in data sheets, with a CAS latency of 2), and the rest is left to pins and board.

    Parameters
    ----------
    m : Module
        Of the top level.
    memory : SdramPins
        Of the system.
    pins : port
        ``clk``, ``clk_en``, ``cs``, ``ras``, ``cas``, ``we``, ``ba``, ``a``, ``dqm`` and ``dq``.
    """
    m.submodules.memory_clk = clock = io.DDRBuffer("o", pins.clk)
    m.d.comb += [clock.o[0].eq(0), clock.o[1].eq(1)]
    command = Value.cast(memory.command)
    values = {"clk_en": memory.enable, "cs": 1, "ras": command[0], "cas": command[1], "we": command[2], "ba": memory.bank,
              "a": memory.address, "dqm": memory.mask}
    for name, value in values.items():
        m.submodules[f"memory_{name}"] = buffer = io.FFBuffer("o", getattr(pins, name))
        m.d.comb += buffer.o.eq(value)

    # Words: Amaranth's buffers with registers have no input that is registered with the other edge.
    m.domains.memory = ClockDomain(clk_edge="neg", reset_less=True)
    m.d.comb += ClockSignal("memory").eq(ClockSignal())
    read = Signal(WORD_BITS)
    for bit in range(WORD_BITS):
        word, off = Signal(name=f"memory_word_{bit}"), Signal(name=f"memory_off_{bit}")
        for name, value, register in (("word", memory.word[bit], word), ("off", ~memory.drive, off)):
            m.submodules[f"memory_{name}_{bit}"] = Instance(
                "OFS1P3DX", i_SCLK=ClockSignal(), i_SP=Const(1), i_CD=Const(0), i_D=value, o_Q=register)
        m.submodules[f"memory_dq_{bit}"] = Instance("BB", i_I=word, i_T=off, o_O=read[bit], io_B=pins.dq.io[bit])
    m.d.memory += memory.found.eq(read)
