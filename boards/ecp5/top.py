"""Top level for a board with an ECP5: clocks, resets, pins and a monitor around the system that matches pairs of a serial line."""

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from amaranth import *
from amaranth.build import Platform
from amaranth.lib import io
from amaranth.lib.cdc import ResetSynchronizer

from golden.video.formats import DisplayFormat
from hdl.video.side_by_side import SideBySide
from hdl.video.tmds import DviLink, PairSerializer

from .pll import Pll


__all__ = ["LoopTop", "Pin", "Wiring"]


@dataclass(frozen=True)
class Pin:
    """A resource of a platform by name and number, or a signal of it."""
    name: str
    number: int = 0
    signal: str = ""

    def of(self, resource: Any) -> io.PortLike:
        """The pin of the resource."""
        port: io.PortLike = getattr(resource, self.signal) if self.signal else resource
        return port


@dataclass(frozen=True)
class Wiring:
    """Which resources of a board's platform the top level takes.

    Parameters
    ----------
    clock : Pin
        Oscillator.
    clock_hz : int
    reset : Pin
        A button, 1 if it is pressed.
    rx, tx : Pin
        Serial line, seen from the FPGA.
    leds : tuple of Pin
        Eight, the lowest one first.
    dvi : str
        The connector: a resource with the differential pairs ``d``, of three channels, and ``clk``; empty if there is none.
    levels : mapping
        Pins that the board needs at a level.
    """
    clock: Pin
    clock_hz: int
    reset: Pin
    rx: Pin
    tx: Pin
    leds: tuple[Pin, ...]
    dvi: str = ""
    levels: Mapping[Pin, int] = field(default_factory=dict)


class LoopTop(Elaboratable):
    """A system with a serial line, as :class:`hdl.loop.system.LoopSystem`, on a board.

    Clocks: a PLL makes ``sync`` of the oscillator, a second one ``pixel`` and ``shift``, five times as fast, of a board with a monitor.
    ``sync`` and ``pixel`` are asynchronous to each other: the picture memory alone has a port in either, and answers what it held before or
    after a write.

    Resets: a button, and a PLL that is not locked, reset ``sync`` and ``pixel``. ``shift`` has none: its counter finds the words by itself.

    Pins: the four channels of DVI have a double-data-rate register in the pin.

    Parameters
    ----------
    core : wiring.Component
        ``uart_rx``, ``uart_tx``, ``leds``; with a display the picture memory, as :class:`hdl.video.side_by_side.SideBySide` reads it, in
        ports whose names begin with ``display_``, in ``pixel``. It has ``width``, ``height`` and ``config`` as attributes.
    clock_hz : int
        Of ``sync``.
    wiring : Wiring
    display : DisplayFormat or None
        ``None`` without a monitor.
    """
    def __init__(self, core: Any, clock_hz: int, wiring: Wiring, display: DisplayFormat | None):
        self.core = core
        self.wiring = wiring
        self.display = display
        self.pll = Pll(wiring.clock_hz, [clock_hz])
        self.pixel_pll = Pll(wiring.clock_hz, [PairSerializer.PAIRS * display.pixel_clock_hz, display.pixel_clock_hz]) if display else None
        self.screen = SideBySide(display, core.width, core.height, core.config.labels) if display else None

    def elaborate(self, platform: Platform) -> Module:
        m = Module()
        wires = self.wiring
        m.submodules.core = core = self.core
        requested: dict[tuple[str, int], Any] = {}

        def port(pin: Pin) -> io.PortLike:
            at = pin.name, pin.number
            if at not in requested:
                requested[at] = platform.request(*at, dir="-")
            return pin.of(requested[at])

        def level_of(name: str, pin: Pin) -> Value:
            m.submodules[f"{name}_pin"] = buffer = io.Buffer("i", port(pin))
            return buffer.i

        def drive(name: str, pin: Pin, value: Value | int) -> None:
            m.submodules[f"{name}_pin"] = buffer = io.Buffer("o", port(pin))
            m.d.comb += buffer.o.eq(value)

        # Clocks and resets.
        m.domains.sync = ClockDomain()
        oscillator = level_of("oscillator", wires.clock)
        pressed = level_of("reset", wires.reset)
        m.submodules.pll = self.pll
        m.d.comb += [self.pll.clock.eq(oscillator), ClockSignal().eq(self.pll.clocks[0])]
        m.submodules.sync_reset = ResetSynchronizer(~self.pll.locked | pressed)

        # Serial line, LEDs.
        m.d.comb += core.uart_rx.eq(level_of("uart_rx", wires.rx))
        drive("uart_tx", wires.tx, core.uart_tx)
        for number, led in enumerate(wires.leds):
            drive(f"led_{number}", led, core.leds[number])
        for number, (pin, level) in enumerate(wires.levels.items()):
            drive(f"level_{number}", pin, level)
        if self.screen:
            self._monitor(m, port, oscillator, pressed)
        return m

    def _monitor(self, m: Module, port: Any, oscillator: Value, pressed: Value) -> None:
        assert self.pixel_pll and self.screen
        m.domains.pixel = ClockDomain()
        m.domains.shift = ClockDomain(reset_less=True)
        m.submodules.pixel_pll = pll = self.pixel_pll
        m.d.comb += [pll.clock.eq(oscillator), ClockSignal("shift").eq(pll.clocks[0]), ClockSignal("pixel").eq(pll.clocks[1])]
        m.submodules.pixel_reset = ResetSynchronizer(~pll.locked | pressed, domain="pixel")

        m.submodules.screen = screen = DomainRenamer("pixel")(self.screen)
        m.submodules.link = link = DomainRenamer("pixel")(DviLink())
        m.submodules.serializer = serializer = PairSerializer(len(link.words))
        m.d.comb += [
            self.core.display_address.eq(screen.address),
            *(getattr(screen, name).eq(getattr(self.core, f"display_{name}")) for name in ("left", "label", "known")),
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
