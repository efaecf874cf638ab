"""Top level for the DE2-115: its PLLs, and VGA by the converter on the board."""

from collections.abc import Callable
from typing import Any

from amaranth import *
from amaranth.lib import io

from golden.video.formats import DisplayFormat
from hdl.video.side_by_side import SideBySide

from ..altera.pll import Pll
from ..loop.top import LoopTop, Pin, Wiring
from .platform import FAMILY, OSCILLATOR_HZ


__all__ = ["WIRING", "VgaTop"]


#: Button 0 is the reset.
WIRING = Wiring(
    clock=Pin("clk50"), clock_hz=OSCILLATOR_HZ, reset=Pin("button", 0), rx=Pin("uart", signal="rx"), tx=Pin("uart", signal="tx"),
    leds=tuple(Pin("led", number) for number in range(8)))

# Output of the screen to the pin.
_OUTPUTS = {
    "red": Pin("vga", signal="r"), "green": Pin("vga", signal="g"), "blue": Pin("vga", signal="b"),
    "de": Pin("dac", signal="blank_n"), "hsync": Pin("vga", signal="hs"), "vsync": Pin("vga", signal="vs"),
}


class VgaTop(LoopTop):
    """The board's top level; parameters as of :class:`boards.loop.top.LoopTop`.

    Pins: colours and sync signals have a register in the pin. The converter's clock is sent inverted, by a double-data-rate register, so
    that its rising edge is in the middle of a pixel; no sync is added to green.

    Parameters
    ----------
    clock_hz : int
        Of ``sync``.
    """
    def __init__(self, core: Any, clock_hz: int, display: DisplayFormat):
        super().__init__(core, WIRING, Pll(FAMILY, OSCILLATOR_HZ, clock_hz), display, Pll(FAMILY, OSCILLATOR_HZ, display.pixel_clock_hz))

    def connect_monitor(self, m: Module, port: Callable[[Pin], Any], screen: SideBySide) -> None:
        for name, pin in _OUTPUTS.items():
            m.submodules[f"vga_{name}"] = register = io.FFBuffer("o", port(pin), o_domain="pixel")
            m.d.comb += register.o.eq(getattr(screen, name))
        m.submodules.dac_clock = clock = io.DDRBuffer("o", port(Pin("dac", signal="clk")), o_domain="pixel")
        m.d.comb += [clock.o[0].eq(0), clock.o[1].eq(1)]
        m.submodules.dac_sync = level = io.Buffer("o", port(Pin("dac", signal="sync_n")))
        m.d.comb += level.o.eq(0)
