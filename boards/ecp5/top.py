"""Top level for a board with an ECP5: its PLLs, and DVI by registers in the pins."""

from collections.abc import Callable
from typing import Any

from amaranth import *
from amaranth.lib import io

from golden.video.formats import DisplayFormat
from hdl.video.side_by_side import SideBySide
from hdl.video.tmds import DviLink, PairSerializer

from ..loop.top import LoopTop, Pin, Wiring
from .pll import Pll
from .sdram_pins import connect_sdram


__all__ = ["DviTop"]


class DviTop(LoopTop):
    """A board with DVI at the connector that its :class:`boards.loop.top.Wiring` names; other parameters as of
    :class:`boards.loop.top.LoopTop`.

    Clocks: the PLL of ``pixel`` also makes ``shift``, five times as fast. It has no reset: its counter finds the words by itself.

    Pins: the four channels of DVI have a double-data-rate register in the pin, an SDRAM is as :func:`boards.ecp5.sdram_pins.connect_sdram`
    has it.

    Parameters
    ----------
    clock_hz : int
        Of ``sync``.
    """
    def __init__(self, core: Any, clock_hz: int, wiring: Wiring, display: DisplayFormat | None):
        pixel_pll = Pll(wiring.clock_hz, [PairSerializer.PAIRS * display.pixel_clock_hz, display.pixel_clock_hz]) if display else None
        super().__init__(core, wiring, Pll(wiring.clock_hz, [clock_hz]), display, pixel_pll)

    def connect_memory(self, m: Module, port: Callable[[Pin], Any]) -> None:
        connect_sdram(m, self.core.memory, port(Pin(self.wiring.sdram)))

    def connect_monitor(self, m: Module, port: Callable[[Pin], Any], screen: SideBySide) -> None:
        assert self.pixel_pll
        m.domains.shift = ClockDomain(reset_less=True)
        m.d.comb += ClockSignal("shift").eq(self.pixel_pll.clocks[0])
        m.submodules.link = link = DomainRenamer("pixel")(DviLink())
        m.submodules.serializer = serializer = PairSerializer(len(link.words))
        m.d.comb += [
            *(getattr(link, name).eq(getattr(screen, name)) for name in ("red", "green", "blue", "de", "hsync", "vsync")),
            *(to.eq(word) for to, word in zip(serializer.words, link.words)),
        ]
        dvi = port(Pin(self.wiring.dvi))
        pairs = [serializer.first, serializer.second]
        data = len(dvi.d)
        m.submodules.dvi_data = buffer = io.DDRBuffer("o", dvi.d, o_domain="shift")
        m.d.comb += [half.eq(pair[:data]) for half, pair in zip(buffer.o, pairs)]
        m.submodules.dvi_clock = buffer = io.DDRBuffer("o", dvi.clk, o_domain="shift")
        m.d.comb += [half.eq(pair[data:]) for half, pair in zip(buffer.o, pairs)]
