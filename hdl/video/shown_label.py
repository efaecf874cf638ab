"""The label that the monitor shows of a disparity that may have an offset and a fraction."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig

from ..matcher.settings import minimum_shape
from ..matcher.stream import DisparityWord


__all__ = ["ShownLabel"]


class ShownLabel(wiring.Component):
    """The label of a disparity: its integer part (floor) less the least disparity of its picture.

    Where the least disparity is a setting, it may change between two pairs, while the matcher still sends the picture of the one before:
    the value of the pair started last applies from the next picture's first word on.

    Timing: combinational.

    Members
    -------
    minimum : In(minimum_shape(config))
        Least disparity of the pair that starts; only if it is a setting of the configuration's method.
    start : In(1)
        A pair starts.
    i : In(DisparityWord(config)), step : In(1)
        A word of the matcher, and whether it is transferred.
    label : Out(range(D))
    """
    def __init__(self, config: MatcherConfig):
        self.config = config
        self.is_set = "minimum" in config.settings
        super().__init__({
            **({"minimum": In(minimum_shape(config))} if self.is_set else {}),
            "start": In(1), "i": In(DisparityWord(config)), "step": In(1), "label": Out(range(config.labels)),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        minimum: Value = Const(self.config.minimum)
        if self.is_set:
            started, shown = (Signal(minimum_shape(self.config), name=f"minimum_{name}", init=self.config.minimum)
                              for name in ("started", "shown"))
            minimum = Mux(self.i.first, started, shown)
            with m.If(self.start):
                m.d.sync += started.eq(self.minimum)
            with m.If(self.step):
                m.d.sync += shown.eq(minimum)
        fraction_bits = self.config.method.disparity_scale.bit_length() - 1  # the scale is a power of two
        m.d.comb += self.label.eq((self.i.disparity >> fraction_bits) - minimum)
        return m
