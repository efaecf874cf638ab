"""The cores with a bus, by the name of the interface: ports are named as tools expect them, and so recognise the buses."""

from collections.abc import Mapping
from typing import Any, ClassVar

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Member, Out

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


class BusMatcher(wiring.Component):
    """A :class:`RegisteredMatcher` between the ports of a bus; the clock and its reset are ports, too."""
    #: For the manifest.
    interface: ClassVar[str]
    marks: ClassVar[Mapping[str, str]]

    def __init__(self, config: MatcherConfig, height: int, closes: Closes, ports: Mapping[str, Member]):
        self.config = config
        self.core = RegisteredMatcher(config, height, closes)
        self.matcher = self.core.matcher
        super().__init__(ports)

    @property
    def about(self) -> dict[str, Any]:
        """Entries of the manifest: interface, what its marks mean, registers with their byte offsets."""
        return {
            "interface": self.interface,
            "marks": dict(self.marks),
            "registers": [{
                "name": register.name, "offset": WORD_BYTES * register.address, "kind": str(register.kind), "bits": register.width,
                "signed": register.signed, "minimum": register.minimum, "maximum": register.maximum, "reset": register.reset,
                "unit": register.unit, "description": register.description,
                "words": {str(value): word for value, word in register.words.items()},
            } for register in self.core.registers],
        }

    def _connect(self, m: Module, clk: Value, rst: Value, bus: Any, prefix: str, response: Any) -> None:
        """The clock; and the registers, whose ports have names with ``prefix``, behind ``bus``."""
        m.domains.sync = sync = ClockDomain(local=True)
        m.d.comb += [sync.clk.eq(clk), sync.rst.eq(rst)]
        m.submodules.core = core = self.core
        m.submodules.bus = bus
        wiring.connect(m, bus.command, core.command)
        wiring.connect(m, core.response, response)
        for name, member in bus.PORTS.items():
            inner, outer = getattr(bus, name), getattr(self, f"{prefix}{name}")
            m.d.comb += inner.eq(outer) if member.flow is In else outer.eq(inner)

    def _output(self, m: Module, payload: data.View) -> None:
        m.d.comb += [payload[name].eq(self.core.o.p[name]) for name, _ in payload.shape()]


class AxiMatcher(BusMatcher):
    """The matcher with AXI4-Stream for pixels and disparities, and AXI4-Lite for its registers.

    Golden: as of :class:`RegisteredMatcher`, where the stream closes lines.

    Parameters
    ----------
    config : MatcherConfig
    height : int
        Lines of a frame after reset.

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
    marks: ClassVar = {"s_axis_tuser": "first pixel of a frame", "s_axis_tlast": "last pixel of a line",
                       "m_axis_tuser": "first pixel of a frame", "m_axis_tlast": "last pixel of a line"}

    def __init__(self, config: MatcherConfig, height: int):
        self.bus = AxiLite()
        super().__init__(config, height, Closes.LINE, {
            "aclk": In(1),
            "aresetn": In(1),
            **{f"s_axi_{name}": member for name, member in AxiLite.PORTS.items()},
            "s_axis_tdata": In(InputData()), "s_axis_tuser": In(1), "s_axis_tlast": In(1),
            "s_axis_tvalid": In(1), "s_axis_tready": Out(1),
            "m_axis_tdata": Out(OutputData(config)), "m_axis_tuser": Out(1), "m_axis_tlast": Out(1),
            "m_axis_tvalid": Out(1), "m_axis_tready": In(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        core = self.core
        self._connect(m, self.aclk, ~self.aresetn, self.bus, "s_axi_", self.bus.response)
        m.d.comb += [
            core.i.p.left.eq(self.s_axis_tdata.left), core.i.p.right.eq(self.s_axis_tdata.right),
            core.i.p.first.eq(self.s_axis_tuser), core.i.p.closes.eq(self.s_axis_tlast),
            core.i.valid.eq(self.s_axis_tvalid), self.s_axis_tready.eq(core.i.ready),
            self.m_axis_tuser.eq(core.o.p.first), self.m_axis_tlast.eq(core.o.p.last),
            self.m_axis_tvalid.eq(core.o.valid), core.o.ready.eq(self.m_axis_tready),
        ]
        self._output(m, self.m_axis_tdata)
        return m


class AvalonMatcher(BusMatcher):
    """The matcher with Avalon-ST for pixels and disparities, a frame being a packet, and Avalon-MM for its registers.

    Golden: as of :class:`RegisteredMatcher`, where the stream closes frames.

    Parameters
    ----------
    config : MatcherConfig
    height : int
        Lines of a frame after reset.

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
    marks: ClassVar = {"asi_startofpacket": "first pixel of a frame", "asi_endofpacket": "last pixel of a frame",
                       "aso_startofpacket": "first pixel of a frame", "aso_endofpacket": "last pixel of a frame"}

    def __init__(self, config: MatcherConfig, height: int):
        self.bus = AvalonMemoryMapped()
        super().__init__(config, height, Closes.FRAME, {
            "clk": In(1),
            "reset": In(1),
            **{f"avs_{name}": member for name, member in AvalonMemoryMapped.PORTS.items()},
            "asi_data": In(InputData()), "asi_startofpacket": In(1), "asi_endofpacket": In(1), "asi_valid": In(1), "asi_ready": Out(1),
            "aso_data": Out(OutputData(config)), "aso_startofpacket": Out(1), "aso_endofpacket": Out(1),
            "aso_valid": Out(1), "aso_ready": In(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        core = self.core
        self._connect(m, self.clk, self.reset, self.bus, "avs_", self.bus.result)
        m.d.comb += [
            core.i.p.left.eq(self.asi_data.left), core.i.p.right.eq(self.asi_data.right),
            core.i.p.first.eq(self.asi_startofpacket), core.i.p.closes.eq(self.asi_endofpacket),
            core.i.valid.eq(self.asi_valid), self.asi_ready.eq(core.i.ready),
            self.aso_startofpacket.eq(core.o.p.first), self.aso_endofpacket.eq(core.o.p.end),
            self.aso_valid.eq(core.o.valid), core.o.ready.eq(self.aso_ready),
        ]
        self._output(m, self.aso_data)
        return m


#: By the name that ``python -m hdl.build --core --interface`` takes.
INTERFACES: Mapping[str, type[AxiMatcher] | type[AvalonMatcher]] = {
    core.interface: core for core in (AxiMatcher, AvalonMatcher)}
