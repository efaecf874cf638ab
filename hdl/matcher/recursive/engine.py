"""The engine of the method ``recursive``: source, array, check, output queue."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, MatcherConfig, Recursive

from ...parts.arithmetic import bit_length
from ...parts.delay import SkidRegister, StreamRegister
from ...parts.queue import Queue
from ..lines import LineStore
from ..settings import setting_shape
from ..stream import FLAGS, CensusWord, LabelWord, copy_flags
from ..streaming.right_view import LeftRightCheck
from ..streaming.sub_pixel import FRACTION, FractionCell
from ..streaming.support import StepDelay
from .array import RecursiveArray, sampled_settings
from .gates import GateFill
from .source import RecursiveSource
from .support import Supports, sparing_delay


__all__ = ["RecursiveEngine"]


# Pixels in flight beyond those in the pipelines: in the registers of the source's decision, of the delay of a step and of the queue.
MARGIN = 15


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
        Settings; sampled as the source takes up a frame, soon after its first column was accepted if nothing stalls.
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
        return 1 + behind + self._pipeline + LeftRightCheck.LATENCY + Queue.LATENCY + StreamRegister.LATENCY + SkidRegister.LATENCY

    def latency_clocks(self, lines: int, line_clocks: int) -> int:
        """Bound of a label's latency beyond ``lines`` lines of a pixel a cycle, in cycles, behind a line store."""
        steps = RecursiveArray.steps_behind(self.config) + self.lag + self.config.labels
        return LineStore.PLUS_DEPTH + StreamRegister.LATENCY + self.latency + steps + (lines + 2) * line_clocks

    def frame_clocks(self, width: int, height: int, lines_above: int, line_clocks: int) -> int:
        """Cycles from one frame's first label to the next one's, if pixels are offered and labels taken without a pause.

        ``lines_above`` lines only fill the line store, at a cycle beyond their pixels each; as many lines as the picture has and
        ``lines_below`` take ``line_clocks``. Exact where a line is labelled at full rate. Flush cycles follow a narrower one: then an
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
        # The census is far from the source: what follows from a word that is valid has a period of its own.
        m.submodules.arrival = arrival = StreamRegister(CensusWord(config))
        wiring.connect(m, wiring.flipped(self.i), arrival.i)
        wiring.connect(m, arrival.o, source.i)
        m.d.comb += [source.in_use.eq(self.in_use), source.minimum.eq(self.minimum), array.wave.eq(source.wave),
                     array.entry.eq(source.entry), array.step.eq(source.o)]
        m.submodules.gates = gates = GateFill(config)
        # The settings are sampled a cycle after a frame's start, well before its first pixel is completed.
        starts_frame = Signal()
        m.d.sync += starts_frame.eq(source.starts_frame)
        m.d.comb += [gates.start.eq(starts_frame), source.hold.eq(gates.busy), array.gates.eq(gates.o)]
        m.d.comb += [getattr(gates, name).eq(getattr(self, name)) for name in GateFill.SETTINGS]
        sampled = sampled_settings(config)
        held = Signal(data.StructLayout({name: setting_shape(config.settings[name]) for name in (*sampled, "minimum", "check")}),
                      reset_less=True)
        with m.If(starts_frame):
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
        m.submodules.output = output = SkidRegister(LabelWord(config))
        # The first register is the memory block's, the other one lies at the next stage.
        wiring.connect(m, queue.o, register.i)
        wiring.connect(m, register.o, output.i)
        wiring.connect(m, output.o, wiring.flipped(self.o))
        m.d.comb += [
            queue.i.valid.eq(checked.o.valid), queue.i.p.label.eq(label), queue.i.p.passed.eq(check.passed),
            queue.i.p.size.eq(checked.o.size), queue.i.p.grey.eq(checked.o.grey), *copy_flags(queue.i.p, checked.o),
        ]

        # Room for all in flight, decided two cycles ahead: the queue and the source are far apart.
        in_flight = Signal(range(self.queue_depth + 2))
        room      = Signal()
        accepted = queue.o.valid & queue.o.ready
        completes = array.completes
        m.d.sync += [
            in_flight.eq(in_flight + completes - accepted), room.eq(in_flight + completes < self.queue_depth - 4), source.go.eq(room),
        ]
        return m
