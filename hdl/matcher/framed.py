"""The matcher behind frame timing signals: for a camera without a stream, and for boards other than this project's."""

from typing import Any

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, MatcherConfig

from .frame_timing import FrameTiming
from .matcher import Matcher
from .stream import FLAGS, DisparityWord


__all__ = ["FramedMatcher"]


class FramedMatcher(wiring.Component):
    """The matcher between frame timing signals and a stream of disparities, with its clock and its reset as ports.

    Golden: :func:`golden.matcher.matcher.match`.

    Parameters
    ----------
    config : MatcherConfig
    core : component
        Takes :class:`hdl.matcher.stream.PixelPair`, gives ``DisparityWord(config)``; by default :class:`hdl.matcher.matcher.Matcher`. Lines
        that it holds beyond a frame's end must pass before the next frame begins, or that one is dropped and counted.

    Members
    -------
    clk : In(1)
        Everything is in this clock's domain.
    reset_n : In(1)
        Asynchronous, low active; synchronised here.
    frame_valid, line_valid, pixel_valid, left, right, dropped
        As of :class:`hdl.matcher.frame_timing.FrameTiming`.
    disparity : Out, disparity_valid : Out(1), disparity_ready : In(1)
        The outgoing stream; with it ``disparity_first``, ``disparity_last``, ``disparity_end`` : Out(1), and the further fields of
        :class:`hdl.matcher.stream.DisparityWord` that the method has.
    error, clear, and the settings of :func:`hdl.matcher.settings.setting_ports`
        As of :class:`hdl.matcher.matcher.Matcher`; all further members that ``core`` has.
    """
    def __init__(self, config: MatcherConfig, core: Any = None):
        self.config = config
        # Two lines: what a camera may send while the matcher outputs the lines around a frame's end.
        self.timing = FrameTiming(max(64, 2 * config.max_width))
        self.matcher = Matcher(config) if core is None else core
        members = {name: member for name, member in self.matcher.signature.members.items() if name not in ("i", "o")}
        self._inputs, self._outputs = ({name: member for name, member in members.items() if member.flow is flow} for flow in (In, Out))
        self._fields = {name: field.shape for name, field in DisparityWord(config) if name not in FLAGS}
        super().__init__({
            "clk": In(1),
            "reset_n": In(1),
            "frame_valid": In(1),
            "line_valid": In(1),
            "pixel_valid": In(1),
            "left": In(PIXEL_BITS),
            "right": In(PIXEL_BITS),
            **self._inputs,
            **{name: Out(shape) for name, shape in self._fields.items()},
            "disparity_first": Out(1),
            "disparity_last": Out(1),
            "disparity_end": Out(1),
            "disparity_valid": Out(1),
            "disparity_ready": In(1),
            "dropped": Out(16),
            **self._outputs,
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.domains.sync = sync = ClockDomain(local=True)
        m.domains.por = ClockDomain(reset_less=True, local=True)
        reset_n = Signal()
        m.submodules.reset_synchronizer = FFSynchronizer(self.reset_n, reset_n, o_domain="por")
        m.d.comb += [sync.clk.eq(self.clk), ClockSignal("por").eq(self.clk), sync.rst.eq(~reset_n)]

        m.submodules.timing = timing = self.timing
        m.submodules.matcher = matcher = self.matcher
        wiring.connect(m, timing.o, matcher.i)
        m.d.comb += [getattr(timing, name).eq(getattr(self, name))
                     for name in ("frame_valid", "line_valid", "pixel_valid", "left", "right")]
        m.d.comb += [getattr(matcher, name).eq(getattr(self, name)) for name in self._inputs]
        m.d.comb += [getattr(self, name).eq(getattr(matcher, name)) for name in self._outputs]
        m.d.comb += [getattr(self, name).eq(matcher.o.p[name]) for name in self._fields]
        m.d.comb += [
            self.disparity_first.eq(matcher.o.p.first),
            self.disparity_last.eq(matcher.o.p.last), self.disparity_end.eq(matcher.o.p.end),
            self.disparity_valid.eq(matcher.o.valid), matcher.o.ready.eq(self.disparity_ready),
            self.dropped.eq(timing.dropped),
        ]
        return m
