"""Top level for a board without cameras: clocks, resets, pins and a monitor around the system that matches pairs of a serial line."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any, Protocol

from amaranth import *
from amaranth.build import Platform
from amaranth.lib import io
from amaranth.lib.cdc import ResetSynchronizer
from amaranth.lib.wiring import In

from golden.video.formats import DisplayFormat
from hdl.video.side_by_side import SideBySide


__all__ = ["LoopTop", "Pin", "PllBlock", "Wiring"]


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
        A connector for DVI: a resource with the differential pairs ``d``, of three channels, and ``clk``; empty if there is none.
    sdram : str
        A resource as :func:`amaranth_boards.resources.SDRAMResource` makes it, of 256 Mbit and 16 bits; empty if there is none.
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
    sdram: str = ""
    levels: Mapping[Pin, int] = field(default_factory=dict)


class PllBlock(Protocol):
    """A vendor's PLL: input ``clock``, outputs ``clocks`` and ``locked``."""
    clock: Signal
    clocks: Signal
    locked: Signal

    def elaborate(self, platform: Any) -> Module:
        ...


class LoopTop(Elaboratable, ABC):
    """A system with a serial line, as :class:`hdl.loop.system.LoopSystem`, on a board. A subclass connects the board's monitor
    and memory.

    Clocks: a PLL makes ``sync`` of the oscillator, a second one ``pixel`` of a board with a monitor. The two are asynchronous to each
    other: the picture memory alone has a port in either, and answers what it held before or after a write.

    Resets: a button, and a PLL that is not locked, reset ``sync`` and ``pixel``.

    Parameters
    ----------
    core : wiring.Component
        ``uart_rx``, ``uart_tx``, ``leds``; with a display the picture memory, as :class:`hdl.video.side_by_side.SideBySide` reads it, in
        ports whose names begin with ``display_``, in ``pixel``; ``memory``, if pictures are in an SDRAM. It has
        ``width``, ``height`` and ``config`` as attributes.
    wiring : Wiring
    pll : PllBlock
        Its first output is ``sync``.
    display : DisplayFormat or None
        ``None`` without a monitor.
    pixel_pll : PllBlock or None
        Its last output is ``pixel``; with a monitor only.
    """
    def __init__(self, core: Any, wiring: Wiring, pll: PllBlock, display: DisplayFormat | None, pixel_pll: PllBlock | None):
        self.core = core
        self.wiring = wiring
        self.display = display
        self.pll = pll
        self.pixel_pll = pixel_pll
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
        if "memory" in core.signature.members:
            self.connect_memory(m, port)
        if self.screen and self.pixel_pll:
            m.domains.pixel = ClockDomain()
            m.submodules.pixel_pll = self.pixel_pll
            m.d.comb += [self.pixel_pll.clock.eq(oscillator), ClockSignal("pixel").eq(self.pixel_pll.clocks[-1])]
            m.submodules.pixel_reset = ResetSynchronizer(~self.pixel_pll.locked | pressed, domain="pixel")
            m.submodules.screen = screen = DomainRenamer("pixel")(self.screen)
            for name, member in core.signature.members.items():
                if (part := name.removeprefix("display_")) != name:
                    inner, outer = getattr(core, name), getattr(screen, part)
                    m.d.comb += inner.eq(outer) if member.flow is In else outer.eq(inner)
            self.connect_monitor(m, port, screen)
        return m

    @abstractmethod
    def connect_monitor(self, m: Module, port: Callable[[Pin], Any], screen: SideBySide) -> None:
        """Connect the outputs of ``screen``, which are in ``pixel``, to the board's monitor; ``port`` requests a pin."""

    def connect_memory(self, m: Module, port: Callable[[Pin], Any]) -> None:
        """Connect the core's ``memory`` to the board's SDRAM; ``port`` requests a pin. Boards that have one override it."""
        raise ValueError(f"the core has its pictures in an SDRAM, and {type(self).__name__} connects none")
