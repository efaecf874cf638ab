"""The array of the method ``recursive``: what all its labels share, and groups of them."""

from typing import Any

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig, Recursive

from ..settings import setting_shape
from ..stream import CensusWord, Least
from ..streaming.right_view import RightWave
from ..streaming.sub_pixel import FRACTION, FractionCell
from ..streaming.support import StepDelay
from ..streaming.waves import Wave
from .carried import CarriedSource
from .from_below import FromBelowGroup, FromBelowSource, LowerFinal, OwnSlot
from .gates import GateWord
from .group import TREE, Final, LeastBeside, RecursiveGroup, beside_costs, recursive_groups
from .line_below import LineBelowWave
from .mean import MeanGroup
from .source import Entry, Step
from .support import LowerPixel, SupportedPixel, Supports, sparing_delay


__all__ = ["RecursiveArray", "sampled_settings"]


# Settings that the engine samples for the array at a frame's start.
_SAMPLED = ("near_threshold", "far_threshold", "step_threshold", "above_share", "below_share")


def sampled_settings(config: MatcherConfig) -> list[str]:
    """Settings of the array; the share of the costs from below is one if there are any."""
    return [name for name in _SAMPLED if name in config.settings]


class RecursiveArray(wiring.Component):
    """Costs ``A`` of all labels, laid out along the labels, a group working a cycle after the group below it; never stalls.

    Golden: :func:`golden.matcher.recursive.method.recursion`, :func:`golden.matcher.refine.right_view`.

    With costs from below the means of a line over supports are there before that of the line above is completed: a step completes its
    pixel :meth:`steps_behind` steps later.

    Timing: ``label`` with its ``pixel`` :meth:`latency_of` cycles after the step that completes the last pixel of the support.

    Members
    -------
    wave : In(Wave(config, CensusWord(config))), entry : In(Entry(config)), step : In(Step(config))
        Of :class:`hdl.matcher.recursive.source.RecursiveSource`.
    gates : In(GateWord(config))
        Of :class:`hdl.matcher.recursive.gates.GateFill`.
    completes : Out(1)
        A pixel is completed; its label will follow.
    near_threshold, far_threshold, step_threshold, above_share, and below_share with costs from below : In
        Constant from the step on that completes a frame's first pixel.
    label : Out(range(D)), pixel : Out(SupportedPixel(config))
    fraction : Out(FRACTION)
        With fraction bits only: eighths of a pixel from the label; 0 at the first and at the last one.
    right : Out(range(D)), right_valid : Out(1)
        Labels of the right picture, in the order of its pixels: that of a pixel ``D`` steps after its own.
    """
    def __init__(self, config: MatcherConfig):
        self.config = config
        self.from_below = config.method_as(Recursive).propagation.from_below
        self.source = CarriedSource(config)
        label = range(config.labels)
        super().__init__({
            "wave": In(Wave(config, CensusWord(config))), "entry": In(Entry(config)), "step": In(Step(config)),
            "gates": In(GateWord(config)), "completes": Out(1),
            **{name: In(setting_shape(config.settings[name])) for name in sampled_settings(config)},
            "label": Out(label), "pixel": Out(SupportedPixel(config)), "right": Out(label), "right_valid": Out(1),
            **({"fraction": Out(FRACTION)} if config.method_as(Recursive).refinement.sub_pixel else {}),
        })

    @staticmethod
    def latency_of(config: MatcherConfig) -> int:
        """Cycles from a step to the label of the pixel whose support it completes."""
        fraction = FractionCell.LATENCY if config.method_as(Recursive).refinement.sub_pixel else 0
        to_costs = RecursiveGroup.SUMS + 1 + RecursiveGroup.total_of(config) + RecursiveGroup.LATENCY
        return to_costs + TREE + len(recursive_groups(config)) + fraction

    @staticmethod
    def steps_behind(config: MatcherConfig) -> int:
        """Steps from one to the completion of its pixel: until the mean of the pixel below it, and the least of all labels, are there."""
        method = config.method_as(Recursive)
        if not method.propagation.from_below:
            return 0
        # Steps that complete no pixel, at a line's start: the one before it, those of the fan, the first column's.
        support = Supports.lag_of(config) + method.propagation.fan + 2
        to_means = RecursiveGroup.LOWER_SUMS + 1 + MeanGroup.latency_of(config) + RecursiveGroup.LATENCY
        written = support + to_means + TREE + len(recursive_groups(config))
        # It is read in the next cycle at the earliest, and some cycles after the step that is behind.
        return written + 1 - StepDelay.LATENCY - FromBelowSource.least_read()

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config, entry = self.config, self.entry
        method = config.method_as(Recursive)
        top = len(recursive_groups(config))
        step = self._step(m)
        m.submodules.carried = carried = self.source
        m.submodules.supports = supports = Supports(config, RecursiveGroup.SUMS, Step(config), SupportedPixel(config))
        m.d.comb += [
            carried.i.eq(step), carried.gates.eq(self.gates), self.completes.eq(step.completion.in_picture),
            *self._support(supports, step),
        ]

        def later(name: str, value: Value, cycles: int, clean: bool = False) -> Value:
            m.submodules[name] = delay = sparing_delay(value.shape(), cycles, clean=clean)
            m.d.comb += delay.i.eq(value)
            return delay.o

        below = Signal(LineBelowWave(config))
        final = Signal(Final(config))
        pixel = supports.pixel
        m.d.comb += [
            *(below[name].eq(entry[name]) for name in below.shape().members),
            final.column.eq(pixel.column), final.write.eq(pixel.in_picture), final.completion.complete.eq(pixel.step),
            final.completion.starts_line.eq(pixel.starts_line), final.completion.in_picture.eq(pixel.in_picture),
        ]
        if config.lead:
            leads = pixel.leads & pixel.step
            m.d.comb += [
                final.completion.complete.eq(pixel.step & ~leads), final.completion.leads.eq(leads),
                final.completion.closes.eq(pixel.closes), final.completion.in_picture.eq(pixel.in_picture | leads),
            ]
        total = RecursiveGroup.total_of(config)
        eighths = later("eighths", supports.sums, RecursiveGroup.SHARE, clean=True)
        inputs = {
            "below": later("below", below, RecursiveGroup.BELOW, clean=True), "address": carried.address,
            "pixel_least": carried.pixel_least, "place": carried.place, "taps": carried.taps,
            "share": later("share", self.above_share, RecursiveGroup.SHARE),
            "eighths": eighths,
            "sums": later("sums", eighths, RecursiveGroup.SUMS - RecursiveGroup.SHARE, clean=True),
            "ends": supports.mean, "centre": later("centre", supports.centre, total - RecursiveGroup.CENTRE),
            "final": later("final", final, total, clean=True),
        }
        lower = None
        if self.from_below:
            m.submodules.lower_supports = lower_supports = Supports(config, RecursiveGroup.LOWER_SUMS, Entry(config), LowerPixel(config))
            m.submodules.from_below = lower = FromBelowSource(config)
            kept, slot = Signal(LowerFinal(config)), Signal(OwnSlot(config))
            m.d.comb += [
                *self._support(lower_supports, entry), lower.i.eq(step), lower.gates.eq(self.gates),
                kept.write.eq(lower_supports.pixel.in_picture), kept.slot.eq(lower_supports.pixel.slot),
                slot.tick.eq(entry.tick), slot.slot.eq(entry.slot),
            ]
            kept_later = later("kept", kept, MeanGroup.latency_of(config), clean=True)
            m.d.comb += lower.write.eq(later("kept_top", kept_later, RecursiveGroup.LATENCY + TREE + top, clean=True))
            inputs |= {
                "lower_sums": later("lower_sums", lower_supports.sums, RecursiveGroup.LOWER_SUMS, clean=True),
                "lower_ends": lower_supports.mean, "lower_final": kept_later,
                "own_write": later("own_write", slot, RecursiveGroup.LOWER_SUMS, clean=True),
                "lower_address": lower.address, "lower_pixel_least": lower.pixel_least, "lower_gate": lower.gate,
                "own_address": lower.own_address,
                "lower_share": later("lower_share", self.below_share, RecursiveGroup.LOWER_ADDRESS + FromBelowGroup.OWN),
            }
        wave = later("wave", self.wave, RecursiveGroup.WAVE, clean=True)
        # Nothing enters the lowest group from below.
        inputs |= {"right": Signal(RightWave(config)), "least": Signal(LeastBeside(config))}
        if method.refinement.sub_pixel:
            inputs["top"] = Signal(config.data_bits)
        if self.from_below:
            inputs["lower_least"] = Signal(Least(method.own_max.bit_length(), config.labels))
        before = None
        for labels in recursive_groups(config):
            m.submodules[f"group_{labels[0]}"] = group = RecursiveGroup(config, labels)
            m.d.comb += [group.i.eq(wave), *(getattr(group, f"{name}_i").eq(value) for name, value in inputs.items())]
            if before is not None:
                for name in beside_costs(config):
                    m.d.comb += [
                        getattr(group, f"{name}lower_i").eq(getattr(before, f"{name}lower_o")),
                        getattr(before, f"{name}upper_i").eq(getattr(group, f"{name}upper_o")),
                    ]
            inputs = {name: getattr(group, f"{name}_o") for name in inputs}
            wave, before = group.o, group
        if lower is not None:
            m.d.comb += lower.least.eq(~group.lower_least_o.value)

        # The label of a right pixel is final once it has passed the top label: `right` as the next pixel advances.
        completed = Signal()
        completion, right, least = group.final_o.completion, group.right_o, group.least_o
        m.d.sync += completed.eq(completion.complete | completion.leads if config.lead else completion.complete)
        m.d.comb += [self.right.eq(right.least.index), self.right_valid.eq(completed & right.in_picture)]

        # The label, with its pixel; the least cost, for the next line.
        pixel = later("pixel", pixel, total + RecursiveGroup.LATENCY + TREE + top, clean=True)
        m.d.comb += [
            carried.write.eq(pixel.in_picture), carried.column.eq(pixel.column), carried.least.eq(~least.value),
        ]
        if not method.refinement.sub_pixel:
            m.d.comb += [self.label.eq(least.index), self.pixel.eq(pixel)]
            return m
        m.submodules.fraction = fraction = FractionCell(config)
        m.d.comb += [
            fraction.before.eq(least.beside.before), fraction.centre.eq(least.value), fraction.after.eq(least.beside.after),
            self.label.eq(later("label", least.index, FractionCell.LATENCY)),
            self.pixel.eq(later("pixel_later", pixel, FractionCell.LATENCY, clean=True)),
            self.fraction.eq(Mux((self.label == 0) | (self.label == config.labels - 1), 0, fraction.fraction)),
        ]
        return m

    def _step(self, m: Module) -> data.View:
        """The step whose pixel is completed now."""
        if not self.from_below:
            return self.step
        m.submodules.behind = behind = StepDelay(Step(self.config), self.steps_behind(self.config))
        ticked = Signal(StepDelay.LATENCY)
        step = Signal(Step(self.config))
        m.d.sync += ticked.eq(Cat(self.entry.tick, ticked))
        m.d.comb += [behind.i.eq(self.step), behind.step.eq(self.entry.tick), step.eq(behind.o)]
        with m.If(~ticked[-1]):
            m.d.comb += [step.advance.eq(0), step.opens.eq(0), step.completion.eq(0)]
        return step

    def _support(self, supports: Supports, word: data.View) -> list[Any]:
        """The arms of the supports of the pixels of these words."""
        return [supports.i.eq(word), supports.near.eq(self.near_threshold), supports.far.eq(self.far_threshold),
                supports.smooth.eq(self.step_threshold)]
