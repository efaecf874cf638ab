"""The label that the monitor shows of a disparity that may have an offset and a fraction."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.config import MINIMUM_BITS, MatcherConfig

from ..matcher.stream import DisparityWord


__all__ = ["ShownLabel"]


class ShownLabel(wiring.Component):
    """The label of a disparity: its integer part (floor) less the least disparity of its picture. Cost ``FUSED``.

    The least disparity may change between two pairs, while the matcher still sends the picture of the one before: the value of the pair
    started last applies from the next picture's first word on.

    Timing: combinational.

    Members
    -------
    minimum : In(MINIMUM_BITS), start : In(1)
        Least disparity of the pair that starts.
    i : In(DisparityWord(config)), step : In(1)
        A word of the matcher, and whether it is transferred.
    label : Out(range(D))
    """
    def __init__(self, config: MatcherConfig):
        self.config = config
        super().__init__({
            "minimum": In(MINIMUM_BITS), "start": In(1), "i": In(DisparityWord(config)), "step": In(1),
            "label": Out(range(config.labels)),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        started, shown = (Signal(MINIMUM_BITS, name=f"minimum_{name}", init=self.config.minimum) for name in ("started", "shown"))
        of_picture = Mux(self.i.first, started, shown)
        with m.If(self.start):
            m.d.sync += started.eq(self.minimum)
        with m.If(self.step):
            m.d.sync += shown.eq(of_picture)
        m.d.comb += self.label.eq(self.i.disparity // self.config.method.disparity_scale - of_picture)
        return m
