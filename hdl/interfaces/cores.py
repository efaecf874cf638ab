"""The cores with a bus, by the name of the interface: ports are named as tools expect them, and so recognise the buses."""

from collections.abc import Mapping
from types import SimpleNamespace
from typing import Any, ClassVar, NamedTuple

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, MatcherConfig
from golden.host.core_registers import WORD_BYTES
from golden.video.frame_rule import Closes

from ..matcher.stream import FLAGS, DisparityWord
from .avalon_mm import AvalonMemoryMapped
from .axi_lite import AxiLite
from .core import RegisteredMatcher


__all__ = ["INTERFACES", "AvalonMatcher", "AxiMatcher", "BusMatcher", "InputData", "OutputData"]


class InputData(data.StructLayout):
    """A pixel of both pictures, grey levels: left in the low byte, right in the high byte."""
    def __init__(self):
        super().__init__({"left": PIXEL_BITS, "right": PIXEL_BITS})


class OutputData(data.FlexibleLayout):
    """The fields of a disparity, without flags, from the lowest bit on; bits above them, up to whole bytes, are 0."""
    def __init__(self, config: MatcherConfig):
        fields = {name: field for name, field in DisparityWord(config) if name not in FLAGS}
        bits = max(field.offset + field.width for field in fields.values())
        super().__init__(-(-bits // 8) * 8, fields)


class StreamPorts(NamedTuple):
    """Names of a stream's ports; ``first`` marks the first word of a frame, ``closes`` the last of a line or of a frame."""
    data: str
    first: str
    closes: str
    valid: str
    ready: str


class BusMatcher(wiring.Component):
    """A :class:`RegisteredMatcher` between the ports of a bus; the clock and its reset are ports, too. A subclass names the ports.

    Parameters
    ----------
    config : MatcherConfig
    height : int
        Lines of a frame after reset.
    """
    #: For the manifest.
    interface: ClassVar[str]
    closes: ClassVar[Closes]
    clock_port: ClassVar[str]
    reset_port: ClassVar[str]
    active_low = False
    #: The bus of the registers, and what the names of its ports begin with.
    bus_type: ClassVar[type[AxiLite] | type[AvalonMemoryMapped]]
    prefix: ClassVar[str]
    pixels: ClassVar[StreamPorts]
    disparities: ClassVar[StreamPorts]

    def __init__(self, config: MatcherConfig, height: int):
        self.config = config
        self.core = RegisteredMatcher(config, height, self.closes)
        self.matcher = self.core.matcher
        self.bus = self.bus_type()
        taken, given = self.pixels, self.disparities
        super().__init__({
            self.clock_port: In(1),
            self.reset_port: In(1),
            **{f"{self.prefix}{name}": member for name, member in self.bus_type.PORTS.items()},
            taken.data: In(InputData()), taken.first: In(1), taken.closes: In(1), taken.valid: In(1), taken.ready: Out(1),
            given.data: Out(OutputData(config)), given.first: Out(1), given.closes: Out(1), given.valid: Out(1), given.ready: In(1),
        })

    @property
    def about(self) -> dict[str, Any]:
        """Entries of the manifest: interface, what its marks mean, registers with their byte offsets."""
        marks = {"first": "first pixel of a frame", "closes": f"last pixel of a {self.closes.value}"}
        return {
            "interface": self.interface,
            "marks": {getattr(ports, name): meaning for ports in (self.pixels, self.disparities) for name, meaning in marks.items()},
            "registers": [{
                "name": register.name, "offset": WORD_BYTES * register.address, "kind": str(register.kind), "bits": register.width,
                "signed": register.signed, "minimum": register.minimum, "maximum": register.maximum, "reset": register.reset,
                "unit": register.unit, "description": register.description,
                "words": {str(value): word for value, word in register.words.items()},
            } for register in self.core.registers],
        }

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.domains.sync = sync = ClockDomain(local=True)
        reset = getattr(self, self.reset_port)
        m.d.comb += [sync.clk.eq(getattr(self, self.clock_port)), sync.rst.eq(~reset if self.active_low else reset)]
        m.submodules.core = core = self.core
        m.submodules.bus = bus = self.bus
        wiring.connect(m, bus.command, core.command)
        wiring.connect(m, core.response, bus.result)
        for name, member in bus.PORTS.items():
            inner, outer = getattr(bus, name), getattr(self, f"{self.prefix}{name}")
            m.d.comb += inner.eq(outer) if member.flow is In else outer.eq(inner)

        taken, given = (SimpleNamespace(**{name: getattr(self, port) for name, port in ports._asdict().items()})
                        for ports in (self.pixels, self.disparities))
        pixel, disparity = core.i.p, core.o.p
        m.d.comb += [
            pixel.left.eq(taken.data.left), pixel.right.eq(taken.data.right), pixel.first.eq(taken.first), pixel.closes.eq(taken.closes),
            core.i.valid.eq(taken.valid), taken.ready.eq(core.i.ready),
            *(given.data[name].eq(disparity[name]) for name, _ in given.data.shape()),
            given.first.eq(disparity.first), given.closes.eq(disparity.last if self.closes is Closes.LINE else disparity.end),
            given.valid.eq(core.o.valid), core.o.ready.eq(given.ready),
        ]
        return m


class AxiMatcher(BusMatcher):
    """The matcher with AXI4-Stream for pixels and disparities, and AXI4-Lite for its registers.

    Golden: as of :class:`RegisteredMatcher`, where the stream closes lines.

    Members
    -------
    aclk : In(1)
        Clock of all ports.
    aresetn : In(1)
        Synchronous, active low.
    s_axis_tdata : In(InputData()), s_axis_tuser : In(1), s_axis_tlast : In(1), s_axis_tvalid : In(1), s_axis_tready : Out(1)
        Pixels; ``tuser`` at the first of a frame, ``tlast`` at the last of a line.
    m_axis_tdata : Out(OutputData(config)), m_axis_tuser : Out(1), m_axis_tlast : Out(1), m_axis_tvalid : Out(1), m_axis_tready : In(1)
        Disparities, likewise.
    s_axi_*
        As of :class:`hdl.interfaces.axi_lite.AxiLite`.
    """
    interface = "axi"
    closes = Closes.LINE
    clock_port, reset_port, active_low = "aclk", "aresetn", True
    bus_type, prefix = AxiLite, "s_axi_"
    pixels = StreamPorts("s_axis_tdata", "s_axis_tuser", "s_axis_tlast", "s_axis_tvalid", "s_axis_tready")
    disparities = StreamPorts("m_axis_tdata", "m_axis_tuser", "m_axis_tlast", "m_axis_tvalid", "m_axis_tready")


class AvalonMatcher(BusMatcher):
    """The matcher with Avalon-ST for pixels and disparities, a frame being a packet, and Avalon-MM for its registers.

    Golden: as of :class:`RegisteredMatcher`, where the stream closes frames.

    Members
    -------
    clk : In(1)
        Clock of all ports.
    reset : In(1)
        Synchronous, active high.
    asi_data : In(InputData()), asi_startofpacket : In(1), asi_endofpacket : In(1), asi_valid : In(1), asi_ready : Out(1)
        Pixels; a symbol a beat, ready latency 0. Lines end where the register ``width`` says.
    aso_data : Out(OutputData(config)), aso_startofpacket : Out(1), aso_endofpacket : Out(1), aso_valid : Out(1), aso_ready : In(1)
        Disparities, likewise.
    avs_*
        As of :class:`hdl.interfaces.avalon_mm.AvalonMemoryMapped`.
    """
    interface = "avalon"
    closes = Closes.FRAME
    clock_port, reset_port = "clk", "reset"
    bus_type, prefix = AvalonMemoryMapped, "avs_"
    pixels = StreamPorts("asi_data", "asi_startofpacket", "asi_endofpacket", "asi_valid", "asi_ready")
    disparities = StreamPorts("aso_data", "aso_startofpacket", "aso_endofpacket", "aso_valid", "aso_ready")


#: By the name that ``python -m hdl.build --core --interface`` takes.
INTERFACES: Mapping[str, type[AxiMatcher] | type[AvalonMatcher]] = {
    core.interface: core for core in (AxiMatcher, AvalonMatcher)}
