"""Top level for the Cyclone III board: clocks, resets, pins and the memory controller around the video system."""

from fractions import Fraction
from typing import Any

from amaranth import *
from amaranth.hdl import Elaboratable, ValueLike
from amaranth.lib import io
from amaranth.lib.cdc import FFSynchronizer, ResetSynchronizer
from amaranth.lib.wiring import Component, Flow

from golden.video.formats import DisplayFormat
from hdl.video.ports import DOMAINS, SystemPorts

from ..altera.pll import OUTPUTS, altpll
from .platform import FAMILY, OSCILLATOR_HZ, Cyclone3Platform


__all__ = ["BoardTop", "pll_ratio"]


def pll_ratio(pixel_clock_hz: int) -> Fraction:
    """Frequency of the display's PLL as a multiple of the oscillator's 50 MHz.

    Examples
    --------
    >>> pll_ratio(65_000_000), pll_ratio(27_000_000)
    (Fraction(13, 10), Fraction(27, 50))
    """
    return Fraction(pixel_clock_hz, OSCILLATOR_HZ)


def _ports(interface: Any) -> set[tuple[tuple[str | int, ...], tuple[Flow, Shape]]]:
    """Paths of an interface's ports, with their directions and shapes."""
    return {(path, (member.flow, Shape.cast(member.shape))) for path, member, _ in interface.signature.flatten(interface)}


class BoardTop(Elaboratable):
    """A video system on the board of :class:`boards.cyclone3.platform.Cyclone3Platform`; other platforms lack its resources.

    Clocks: the display's PLL derives the pixel clock from the 50 MHz oscillator, the memory controller ``sync`` from the same; a camera's
    domain has the clock that the decoder sends with the bytes. All four are asynchronous to each other.

    Resets: the button CPU_RESET resets PLL and memory controller, and all domains with them. Receivers leave reset before their senders:
    ``sync`` when the controller's clock runs and the display's PLL has locked, then ``display``, then each camera's domain, each two cycles
    of its clock after the domain before. A camera's domain stays in reset until its clock runs.

    Pins: camera bytes and DVI pixels have a register in the pin. The DVI clock is sent inverted, by a double-data-rate register, so that
    the transmitter's rising edge is in the middle of a pixel. Other inputs are synchronised to ``sync`` by two registers; I2C lines are
    open-drain.

    The DVI transmitter is configured by I2C when switch 0 is open: ISEL is low during reset, as required after power-up, and high
    afterwards; its address is 0x70. When switch 0 is closed, it is configured by levels (24 bits a pixel, switched on), and the I2C lines,
    which are two of these levels, stay high.

    Parameters
    ----------
    core : wiring.Component
        With the ports :class:`hdl.video.ports.SystemPorts`.
    display : DisplayFormat
    """
    def __init__(self, core: Component, display: DisplayFormat):
        wrong = {"__".join(map(str, path)) for path, _ in _ports(core) ^ _ports(SystemPorts().create())}
        if wrong:
            raise ValueError(f"the board's top level takes the ports of SystemPorts(); these differ: {', '.join(sorted(wrong))}")
        self.core = core
        self.display = display

    def elaborate(self, platform: Cyclone3Platform) -> Module:
        m = Module()
        m.submodules.core = core = self.core
        m.domains += [ClockDomain(domain) for domain in DOMAINS]

        def port(name: str, number: int = 0) -> Any:
            return platform.request(name, number, dir="-")

        def level_of(name: str, pin: io.PortLike) -> Value:
            m.submodules[f"{name}_pin"] = buffer = io.Buffer("i", pin)
            return buffer.i

        def drive(name: str, pin: io.PortLike, value: ValueLike) -> None:
            m.submodules[f"{name}_pin"] = buffer = io.Buffer("o", pin)
            m.d.comb += buffer.o.eq(value)

        def synchronized(name: str, level: Value) -> Signal:
            value = Signal.like(level, name=name)
            m.submodules[f"{name}_synchronizer"] = FFSynchronizer(level, value)
            return value

        def input_pin(name: str, pin: io.PortLike) -> Signal:
            return synchronized(name, level_of(name, pin))

        def open_drain(name: str, pin: io.PortLike, low: ValueLike) -> Signal:
            m.submodules[f"{name}_pin"] = buffer = io.Buffer("io", pin)
            m.d.comb += [buffer.o.eq(0), buffer.oe.eq(low)]
            return synchronized(name, buffer.i)

        # Clocks and resets.
        oscillator = level_of("oscillator", port("clk50"))
        pressed = level_of("reset_button", port("rst"))
        locked = self._display_pll(m, oscillator, pressed)
        memory_reset_n = self._memory(m, port("ddr2"), oscillator, pressed)
        cameras = {"left_camera": port("camera", 0), "right_camera": port("camera", 1)}
        for domain, camera in cameras.items():
            m.d.comb += ClockSignal(domain).eq(level_of(f"{domain}_clock", camera.clk))
        for domain, cause in (("sync", ~(locked & memory_reset_n)), ("display", ResetSignal("sync")),
                              *((camera, ResetSignal("display")) for camera in cameras)):
            m.submodules[f"{domain}_reset"] = ResetSynchronizer(cause, domain=domain)

        # Cameras.
        for domain, data, camera in zip(cameras, (core.left_data, core.right_data), cameras.values(), strict=True):
            m.submodules[f"{domain}_data"] = buffer = io.FFBuffer("i", camera.data, i_domain=domain)
            m.d.comb += data.eq(buffer.i)
        decoder = port("decoder")
        drive("decoder_reset", decoder.reset_n, core.decoder_reset_n)
        drive("decoder_powerdown", decoder.powerdown_n, core.decoder_powerdown_n)
        m.d.comb += [
            core.decoder_scl.eq(open_drain("decoder_scl", decoder.scl, core.decoder_scl_low)),
            core.decoder_sda.eq(open_drain("decoder_sda", decoder.sda, core.decoder_sda_low)),
        ]

        # Monitor.
        dvi = port("dvi")
        m.submodules.dvi_clock = clock = io.DDRBuffer("o", dvi.clk, o_domain="display")
        m.d.comb += [clock.o[0].eq(0), clock.o[1].eq(1)]
        for name in ("red", "green", "blue", "de", "hsync", "vsync"):
            m.submodules[f"dvi_{name}"] = buffer = io.FFBuffer("o", getattr(dvi, name), o_domain="display")
            m.d.comb += buffer.o.eq(getattr(core, name))
        by_i2c = input_pin("dvi_by_i2c", port("switch", 0))
        isel = Signal()
        m.d.sync += isel.eq(by_i2c)
        # The clock is single-ended, DE is driven by this design, and the address bits are 0.
        for name, value in (("isel", isel), ("power_up", 1), ("clk_n", 0), ("dken", 0), ("ctl", 0)):
            drive(f"dvi_{name}", getattr(dvi, name), value)
        m.d.comb += [
            core.dvi_scl.eq(open_drain("dvi_scl", dvi.scl, core.dvi_scl_low & isel)),
            core.dvi_sda.eq(open_drain("dvi_sda", dvi.sda, core.dvi_sda_low & isel)),
        ]

        # Console, buttons, LEDs.
        uart = port("uart")
        m.d.comb += core.uart_rx.eq(input_pin("uart_rx", uart.rx))
        drive("uart_tx", uart.tx, core.uart_tx)
        m.d.comb += core.buttons.eq(Cat(input_pin(f"button_{n}", port("button", n)) for n in range(len(core.buttons))))
        for n, led in enumerate(core.leds):
            drive(f"led_{n}", port("led", n), led)
        return m

    def _display_pll(self, m: Module, oscillator: Value, reset: Value) -> Signal:
        """Drive the clock of ``display``; return the signal that it is stable."""
        ratio = pll_ratio(self.display.pixel_clock_hz)
        clocks = Signal(OUTPUTS)
        locked = Signal()
        m.submodules.display_pll = altpll(FAMILY, OSCILLATOR_HZ, ratio, oscillator, reset, clocks, locked)
        m.d.comb += ClockSignal("display").eq(clocks[0])
        return locked

    def _memory(self, m: Module, pins: Any, oscillator: Value, reset: Value) -> Signal:
        """Add the controller that Quartus generates as ``stereo_ddr2``, drive the clock of ``sync``; return the controller's reset,
        active low.
        """
        bus = self.core.memory
        reset_n = Signal()
        unused = {name: Signal(name=f"memory_{name}") for name in
                  ("local_refresh_ack", "local_wdata_req", "reset_request_n", "aux_full_rate_clk", "aux_half_rate_clk")}
        m.submodules.ddr2 = Instance("stereo_ddr2",
            i_pll_ref_clk=oscillator, i_global_reset_n=~reset, i_soft_reset_n=C(1, 1),
            o_phy_clk=ClockSignal("sync"), o_reset_phy_clk_n=reset_n,
            **{f"i_local_{name}": getattr(bus, name) for name in
               ("address", "write_req", "read_req", "burstbegin", "wdata", "be", "size")},
            **{f"o_local_{name}": getattr(bus, name) for name in ("ready", "rdata", "rdata_valid", "init_done")},
            **{f"o_{name}": signal for name, signal in unused.items()},
            **{f"o_mem_{name}": getattr(pins, name).io for name in
               ("cke", "cs_n", "ras_n", "cas_n", "we_n", "odt", "addr", "ba", "dm")},
            **{f"io_mem_{name}": getattr(pins, name).io for name in ("clk", "clk_n", "dq", "dqs")})
        return reset_n
