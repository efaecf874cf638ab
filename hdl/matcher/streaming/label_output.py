"""From a selected label to the engine's output word: the label alone, or checked against the right view."""

from amaranth import *
from amaranth.lib import data
from amaranth.lib.wiring import In, Out

from golden.config import Fused, MatcherConfig

from ...parts.arithmetic import bit_length
from ...parts.delay import Delay
from ..stage import CostArray, LabelOutput, Selected
from ..stream import FLAGS, DisparityWord, LabelWord, copy_flags
from .right_view import LeftRightCheck
from .sub_pixel import SubPixel


__all__ = ["CheckedLabel", "PlainLabel"]


class PlainLabel(LabelOutput):
    """The label is the disparity; golden: :func:`golden.matcher.labelling.match`.

    Timing: combinational.

    Members
    -------
    As of :class:`hdl.matcher.stage.LabelOutput`; ``o`` is a :class:`hdl.matcher.stream.DisparityWord`.
    """
    def __init__(self, config: MatcherConfig, costs: type[CostArray], *, in_flight: int, array_latency: int, selection_latency: int):
        super().__init__({
            "i": In(Selected(config, self.settings)), "sideband": In(costs.sideband_of(config)),
            "o": Out(DisparityWord(config)), "o_valid": Out(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.d.comb += [self.o.disparity.eq(self.i.label), *copy_flags(self.o, self.i), self.o_valid.eq(self.i.valid)]
        return m


class CheckedLabel(LabelOutput):
    """Left-right check of the label, its sub-pixel fraction if there is one, and the bit length of its support's size.

    Golden: :func:`golden.matcher.fused.stages`, from the labels on.

    Timing: :attr:`latency` cycles, a label a cycle.

    Members
    -------
    As of :class:`hdl.matcher.stage.LabelOutput`; ``o`` is a :class:`hdl.matcher.stream.LabelWord`.
    """
    settings = ("minimum", "check")
    latency = LeftRightCheck.LATENCY

    def __init__(self, config: MatcherConfig, costs: type[CostArray], *, in_flight: int, array_latency: int, selection_latency: int):
        self.config = config
        self.selection_latency = selection_latency
        self.check = LeftRightCheck(config, in_flight)
        self.sub_pixel = SubPixel(config, array_latency + 1) if config.method_as(Fused).refinement.sub_pixel else None
        super().__init__({
            "i": In(Selected(config, self.settings)), "sideband": In(costs.sideband_of(config)),
            "size": In(range(costs.size_max_of(config) + 1)),
            "o": Out(LabelWord(config)), "o_valid": Out(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config, check = self.config, self.check
        m.submodules.check = check
        m.d.comb += [
            check.right.eq(self.sideband.right), check.right_valid.eq(self.sideband.right_valid),
            check.x.eq(self.i.x), check.label.eq(self.i.label), check.valid.eq(self.i.valid),
            check.minimum.eq(self.i.minimum), check.enable.eq(self.i.check),
        ]
        carried = data.StructLayout({"valid": 1, "label": self.i.label.shape(), **FLAGS})
        m.submodules.checked = checked = Delay(carried, check.LATENCY, clean=True)
        m.d.comb += [
            checked.i.valid.eq(self.i.valid), checked.i.label.eq(self.i.label), *copy_flags(checked.i, self.i),
            self.o_valid.eq(checked.o.valid), self.o.passed.eq(check.passed), *copy_flags(self.o, checked.o),
        ]
        if self.sub_pixel:
            m.submodules.sub_pixel = sub_pixel = self.sub_pixel
            m.submodules.fraction = fraction = Delay(Value.cast(sub_pixel.fraction).shape(), check.LATENCY - 1)
            m.d.comb += [
                sub_pixel.sums.eq(self.sideband.cost), sub_pixel.label.eq(self.i.label), fraction.i.eq(sub_pixel.fraction),
                self.o.label.eq(checked.o.label * config.method.disparity_scale + Mux(check.passed, fraction.o, 0)),
            ]
        else:
            m.d.comb += self.o.label.eq(checked.o.label)
        # The size is known two cycles after admission.
        m.submodules.size = size = Delay(self.o.size.shape(), self.selection_latency - 2 + check.LATENCY)
        m.d.comb += [size.i.eq(bit_length(self.size)), self.o.size.eq(size.o)]
        return m
