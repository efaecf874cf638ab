"""The engine of the method ``recursive``: array of costs, labels, check, output queue."""

from typing import Any

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, MatcherConfig, Recursive

from ...parts.arithmetic import bit_length
from ...parts.delay import StreamRegister
from ...parts.queue import Queue
from ..lines import LineStore
from ..settings import setting_shape
from ..stream import FLAGS, CensusWord, LabelWord, Least, copy_flags
from ..streaming.right_view import LeftRightCheck, RightWave
from ..streaming.sub_pixel import FRACTION, FractionCell
from ..streaming.support import StepDelay
from ..streaming.waves import Wave
from .carried import CarriedSource
from .from_below import FromBelowGroup, FromBelowSource, LowerFinal, OwnSlot
from .gates import GateFill, GateWord
from .group import TREE, Final, LeastBeside, RecursiveGroup, beside_costs, recursive_groups
from .line_below import LineBelowWave
from .mean import MeanGroup
from .source import Entry, RecursiveSource, Step
from .support import LowerPixel, SupportedPixel, Supports, sparing_delay


__all__ = ["RecursiveArray", "RecursiveEngine"]


# Pixels in flight beyond those in the pipelines: in the registers of the source's decision, of the delay of a step and of the queue.
MARGIN = 14

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
        Constant from a frame's first step on.
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
        return RecursiveGroup.SUMS + 1 + RecursiveGroup.total_of(config) + TREE + len(recursive_groups(config)) + fraction

    @staticmethod
    def steps_behind(config: MatcherConfig) -> int:
        """Steps from one to the completion of its pixel: until the mean of the pixel below it, and the least of all labels, are there."""
        method = config.method_as(Recursive)
        if not method.propagation.from_below:
            return 0
        # Steps that complete no pixel, at a line's start: the one before it, those of the fan, the first column's.
        support = Supports.lag_of(config) + method.propagation.fan + 2
        return support + RecursiveGroup.LOWER_SUMS + 1 + MeanGroup.latency_of(config) + TREE + len(recursive_groups(config))

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
            m.d.comb += lower.write.eq(later("kept_top", kept_later, TREE + top, clean=True))
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
        completion, right, least = group.final_i.completion, group.right_o, group.least_o
        m.d.sync += completed.eq(completion.complete | completion.leads if config.lead else completion.complete)
        m.d.comb += [self.right.eq(right.least.index), self.right_valid.eq(completed & right.in_picture)]

        # The label, with its pixel; the least cost, for the next line.
        pixel = later("pixel", pixel, total + TREE + top, clean=True)
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


class Checked(data.StructLayout):
    """A label on its way to its check, with its fraction if disparities have fraction bits."""
    def __init__(self, config: MatcherConfig):
        fraction = {"fraction": Shape.cast(FRACTION)} if config.method_as(Recursive).refinement.sub_pixel else {}
        super().__init__({
            **fraction, "valid": 1, "label": range(config.labels), "x": range(config.max_width), "grey": PIXEL_BITS,
            "size": LabelWord(config)["size"].shape, **FLAGS,
        })


class RecursiveEngine(wiring.Component):
    """Labels of least cost at one pixel a cycle, checked against the right view.

    Golden: :func:`golden.matcher.recursive.method.stages`.

    The only feedback is from a line to the next one: there is no loop within a line. The array never stalls; a pixel is completed only
    while the output queue has room for all that are in flight. The third line of a frame with other gates than the one before waits until
    the tables are filled, :attr:`hdl.matcher.recursive.gates.GateFill.CLOCKS` cycles after the frame's start.

    Timing: a pixel a cycle, and :attr:`padding_clocks` and :attr:`preroll_clocks` more a line; :attr:`latency` cycles from a step to the
    label that it makes known.

    Members
    -------
    i : In(stream.Signature(CensusWord(config)))
        With one line below the picture, or two with costs from below, see :class:`hdl.matcher.lines.LineStore`.
    o : Out(stream.Signature(LabelWord(config)))
    in_use, near_threshold, far_threshold, step_threshold, above_share, below_share with costs from below, gate_numerator, gate_offset,
    gate_floor, minimum, check
        Settings; sampled as the first column of a frame is accepted.
    """
    clocks_per_pixel = 1
    padding_clocks = 2  # cycles of padding in a line
    rows = 3

    def __init__(self, config: MatcherConfig):
        self.config = config
        method = config.method_as(Recursive)
        self.lag = Supports.lag_of(config)
        self.lines_below = 1 + method.propagation.from_below
        self.settings = ("in_use", *sampled_settings(config), *GateFill.SETTINGS, "minimum", "check")
        # What a label needs: its support, the right picture's labels, and the pipelines.
        flush = RecursiveArray.steps_behind(config) + self.lag + method.propagation.fan + max(config.labels, self._pipeline) + 4
        self.source = RecursiveSource(config, flush)
        self.array = RecursiveArray(config)
        self.checker = LeftRightCheck(config, config.labels + config.lead + FractionCell.LATENCY + 8)
        self.queue_depth = self.lag + config.labels + self._pipeline + LeftRightCheck.LATENCY + MARGIN
        super().__init__({
            "i": In(stream.Signature(CensusWord(config))),
            "o": Out(stream.Signature(LabelWord(config))),
            **{name: In(setting_shape(config.settings[name])) for name in self.settings},
        })

    @property
    def _pipeline(self) -> int:
        """Cycles from a step to the label of the pixel whose support it completes, and of the delay behind it."""
        return RecursiveArray.latency_of(self.config) + StepDelay.LATENCY

    @property
    def full_rate_width(self) -> int:
        """Shortest line, in pixels, that is labelled at :attr:`clocks_per_pixel`; shorter ones take so many cycles more."""
        return self.source.flushed_width

    @property
    def preroll_clocks(self) -> int:
        """Cycles in a line, once its first column has been offered, before that one is accepted."""
        return self.config.method_as(Recursive).propagation.fan

    @property
    def latency(self) -> int:
        """Cycles from the issue of the last pixel that a label depends on to the label at ``o``, if nothing stalls."""
        behind = StepDelay.LATENCY if self.lines_below > 1 else 0
        return 1 + behind + self._pipeline + LeftRightCheck.LATENCY + 2 + StreamRegister.LATENCY

    def latency_clocks(self, lines: int, line_clocks: int) -> int:
        """Bound of a label's latency beyond ``lines`` lines of a pixel a cycle, in cycles, behind a line store."""
        steps = RecursiveArray.steps_behind(self.config) + self.lag + self.config.labels
        return LineStore.PLUS_DEPTH + self.latency + steps + (lines + 2) * line_clocks

    def frame_clocks(self, width: int, height: int, lines_above: int, line_clocks: int) -> int:
        """Cycles from one frame's first label to the next one's, if pixels are offered and labels taken without a pause.

        ``lines_above`` lines only fill the line store, at a cycle beyond their pixels each; as many lines as the picture has and
        :attr:`lines_below` take ``line_clocks``. Exact where a line is labelled at full rate. Flush cycles follow a narrower one: then an
        upper bound.
        """
        if width >= self.full_rate_width:
            # The next frame's first line does not wait behind padding, which the last line of the one before has had.
            in_front = line_clocks - self.config.lead - self.preroll_clocks - self.padding_clocks
            return (height + self.lines_below) * (width + line_clocks) + lines_above * (width + 1 + self.config.lead) - in_front
        flush = self.source.flush_waves
        return (height + lines_above + self.lines_below) * (width + line_clocks + flush) + flush

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        method = config.method_as(Recursive)
        m.submodules.source = source = self.source
        m.submodules.array = array = self.array
        m.submodules.check = check = self.checker
        wiring.connect(m, wiring.flipped(self.i), source.i)
        m.d.comb += [source.in_use.eq(self.in_use), source.minimum.eq(self.minimum), array.wave.eq(source.wave),
                     array.entry.eq(source.entry), array.step.eq(source.o)]
        m.submodules.gates = gates = GateFill(config)
        m.d.comb += [gates.start.eq(source.starts_frame), source.hold.eq(gates.busy), array.gates.eq(gates.o)]
        m.d.comb += [getattr(gates, name).eq(getattr(self, name)) for name in GateFill.SETTINGS]
        sampled = sampled_settings(config)
        held = Signal(data.StructLayout({name: setting_shape(config.settings[name]) for name in (*sampled, "minimum", "check")}),
                      reset_less=True)
        with m.If(source.starts_frame):
            m.d.sync += [held[name].eq(getattr(self, name)) for name in (*sampled, "minimum", "check")]
        m.d.comb += [getattr(array, name).eq(held[name]) for name in sampled]

        # The labels wait for those of the right picture.
        pixel = array.pixel
        m.submodules.waiting = waiting = StepDelay(Checked(config), config.labels)
        m.d.comb += [
            waiting.step.eq(pixel.step), waiting.i.valid.eq(pixel.in_picture), waiting.i.label.eq(array.label),
            waiting.i.x.eq(pixel.column), waiting.i.grey.eq(pixel.grey), waiting.i.size.eq(bit_length(pixel.size)),
            *copy_flags(waiting.i, pixel),
            *([waiting.i.fraction.eq(array.fraction)] if method.refinement.sub_pixel else []),
        ]
        stepped = Signal(StepDelay.LATENCY)
        m.d.sync += stepped.eq(Cat(pixel.step, stepped))
        word  = waiting.o
        valid = Signal()
        m.d.comb += valid.eq(stepped[-1] & word.valid)
        # The settings of the frame that is checked: it starts after the last label of the one before.
        of_frame = Signal(data.StructLayout({name: setting_shape(config.settings[name]) for name in ("minimum", "check")}), reset_less=True)
        now = Signal.like(of_frame)
        m.d.comb += now.eq(of_frame)
        with m.If(valid & word.first):
            m.d.comb += [now[name].eq(held[name]) for name in ("minimum", "check")]
            m.d.sync += of_frame.eq(now)
        m.d.comb += [
            check.right.eq(array.right), check.right_valid.eq(array.right_valid),
            check.x.eq(word.x), check.label.eq(word.label), check.valid.eq(valid),
            check.minimum.eq(now.minimum), check.enable.eq(now.check),
        ]
        m.submodules.checked = checked = sparing_delay(Checked(config), check.LATENCY, clean=True)
        m.d.comb += [checked.i.eq(word), checked.i.valid.eq(valid)]

        label: Value = checked.o.label
        if method.refinement.sub_pixel:
            label = checked.o.label * method.disparity_scale + Mux(check.passed, checked.o.fraction, 0)
        m.submodules.queue = queue = Queue(LabelWord(config), self.queue_depth)
        m.submodules.register = register = StreamRegister(LabelWord(config))
        wiring.connect(m, queue.o, register.i)
        wiring.connect(m, register.o, wiring.flipped(self.o))
        m.d.comb += [
            queue.i.valid.eq(checked.o.valid), queue.i.p.label.eq(label), queue.i.p.passed.eq(check.passed),
            queue.i.p.size.eq(checked.o.size), queue.i.p.grey.eq(checked.o.grey), *copy_flags(queue.i.p, checked.o),
        ]

        # Room for all in flight, decided a cycle ahead.
        in_flight = Signal(range(self.queue_depth + 2))
        accepted = queue.o.valid & queue.o.ready
        completes = array.completes
        m.d.sync += [in_flight.eq(in_flight + completes - accepted), source.go.eq(in_flight + completes < self.queue_depth - 3)]
        return m
