"""The streaming engine: the same disparities, one pixel a cycle."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, MatcherConfig

from ...parts.arithmetic import choose
from ...parts.delay import NO_COLLISION, Delay, SkidRegister, StreamRegister
from ...parts.queue import Queue
from ..lines import LineStore
from ..settings import setting_shape
from ..stage import CostArray, LabelOutput, Selected
from ..stream import copy_flags
from .cones import Cones, Neighbours
from .label_array import LabelArray
from .labels import LabelMemory, Queued
from .waves import WaveSource


__all__ = ["StreamingEngine"]


# Pixels in flight between source and admission beyond those inside the array: in the registers of the source's decision (2), of the
# source (1), of the queue (2) and of its head (2), and those that keep the labelling busy while the source issues the padding cycles of a
# line, twice, around a decision that is made two pixels early. Too few would cost cycles, never a wrong disparity.
QUEUE_MARGIN = 14

# Likewise for the output: registers of the admission's decision, of the selection and of the queue.
OUTPUT_MARGIN = 9


class StreamingEngine(wiring.Component):
    """Costs and graph cut at one pixel a cycle; ``LINEAR`` arithmetic.

    The golden models are :func:`golden.matcher.labelling.match` and :func:`golden.matcher.fused.stages`, depending on
    the array of costs and the label output.

    The remaining recursion is ``f = T[f]``: the array of labels computes the result for every label that the left neighbour may have, and
    a multiplexer of ``D`` labels selects one.

    The arrays never stall. A pixel is issued only while the queue between costs and labelling has room for all that are in flight, and is
    admitted to the labelling only while the output queue has, and its upper neighbour's disparity is in the line memory: lines shorter
    than the array's latency run at a lower rate.

    Timing: a pixel a cycle and two more a line; :attr:`latency` cycles from a wave to its disparity.

    Memory: ``D`` data terms for ``max_width + queue_depth + admission_latency + D - D/4`` pixels at most, a line of disparities, a line of
    pixels, the delays of :class:`LabelArray`, and the memories of the array of costs and of the label output.

    Parameters
    ----------
    config : MatcherConfig
    costs : type of CostArray
    label_output : type of LabelOutput
    registered : bool
        Whether ``o`` is registered, for stages behind it with much logic on its payload.

    Members
    -------
    i : In(stream.Signature(costs.columns_of(config)))
        With the lines below, see :class:`hdl.matcher.lines.LineStore`.
    o : Out(stream.Signature(label_output's o))
    u1, u2, u3
        Weights; sampled a cycle after the first pixel of a frame was admitted.
    in_use, and the settings of ``costs``
        Sampled as the first column of a frame is accepted.
    Settings of ``label_output``
        Sampled with the first pixel of a frame that is admitted.
    """
    clocks_per_pixel = 1
    padding_clocks = 2  # cycles of padding in a line
    preroll_clocks = 0  # and before its first column, once that has been offered
    rows = 3

    def __init__(self, config: MatcherConfig, costs: type[CostArray], label_output: type[LabelOutput], *, registered: bool = False):
        self.config = config
        self.registered = registered
        self.size_max = costs.size_max_of(config)
        self.source = WaveSource(config, costs)
        self.array = LabelArray(config)
        # Pixels between the array of costs and the labelling.
        self.costs_latency = costs.latency_of(config) + costs.lag_of(config)
        # Columns of a lead count as pixels of their line: the right labels that they start are kept as long. A pixel waits for those of two
        # lines at most, as flush cycles follow a shorter line than its support may need.
        self.queue_depth = self.costs_latency + QUEUE_MARGIN + 2 * config.lead
        # A cost is overwritten one line, and all that may be queued, after it was stored. Reading is later by the admission's pipeline
        # and by the line memory's skew. One more, so that no word is overwritten in the cycle that reads it.
        self.costs = costs(config, config.max_width + self.queue_depth + self.admission_latency + LabelMemory.skew_of(config) + 1)
        self.output_depth = self.admission_latency + self.array.latency + label_output.latency + OUTPUT_MARGIN
        self.label_output = label_output(
            config, costs, in_flight=config.line_width + self.queue_depth + self.output_depth + config.lead + config.labels,
            array_latency=self.array.latency, selection_latency=self.selection_latency)
        names = dict.fromkeys((*config.rule.weights._fields, "in_use", *costs.settings, *label_output.settings))
        super().__init__({
            "i": In(stream.Signature(costs.columns_of(config))),
            "o": Out(stream.Signature(self.label_output.o.shape())),
            **{name: In(setting_shape(config.settings[name])) for name in names},
        })

    @property
    def lines_below(self) -> int:
        """Lines that follow a picture so that its last one is labelled; one more if costs of neighbouring lines are joined."""
        return 2 if self.source.joins else 1

    @property
    def admission_latency(self) -> int:
        """Cycles from a pixel's admission to its wave at label 0."""
        return 2 + Cones.latency_of(self.config, self.size_max)

    @property
    def selection_latency(self) -> int:
        """Cycles from a pixel's admission to its label."""
        return self.admission_latency + self.array.latency + 1

    @property
    def round_trip(self) -> int:
        """Cycles from a pixel's admission to that of the pixel below it, at least."""
        return self.selection_latency + 2

    @property
    def full_rate_width(self) -> int:
        """Shortest line, in pixels, that is labelled at :attr:`clocks_per_pixel`; shorter ones take as long."""
        return self.round_trip

    @property
    def latency(self) -> int:
        """Cycles from the issue of the last pixel that a disparity depends on to the disparity at ``o``, if nothing stalls."""
        labelling = self.selection_latency + self.label_output.latency
        queue = 2 + StreamRegister.LATENCY + SkidRegister.LATENCY
        return 1 + self.costs_latency + queue + labelling + 2 + StreamRegister.LATENCY * self.registered

    def latency_clocks(self, lines: int, line_clocks: int) -> int:
        """Bound of a disparity's latency beyond ``lines`` lines of a pixel a cycle, in cycles, behind a line store.

        Every line that it waits for begins late by the cycles that a line takes beyond its pixels, at least by those of the admission,
        and so do a few at the ends.
        """
        return LineStore.PLUS_DEPTH + self.latency + (lines + 4) * max(3, line_clocks)

    def frame_clocks(self, width: int, height: int, lines_above: int, line_clocks: int) -> int:
        """Cycles from one frame's first disparity to the next one's, if pixels are offered and disparities taken without a pause.

        ``lines_above`` lines only fill the line store, at a cycle beyond their pixels each; as many lines as the picture has and
        :attr:`lines_below` take ``line_clocks``. Exact where a line is labelled at full rate. A narrower one waits for the disparities
        above it, and may need flush cycles: then an upper bound.
        """
        if width >= max(self.full_rate_width, self.source.flushed_width):
            filling, beyond = 1 + self.config.lead, line_clocks - self.config.lead
            return (height + lines_above + self.lines_below) * (width + line_clocks) - lines_above * (line_clocks - filling) - (beyond - 2)
        flush = self.source.flush_waves
        line = width + line_clocks + (flush if width < self.source.flushed_width else 0)
        return (lines_above + 1 + self.lines_below) * line + flush + (height - 1) * max(line, self.round_trip + 4)

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        labels = config.labels
        m.submodules.source = source = self.source
        m.submodules.costs = costs = self.costs
        m.submodules.array = array = self.array
        wiring.connect(m, wiring.flipped(self.i), source.i)
        m.d.comb += [source.in_use.eq(self.in_use), costs.i.eq(source.o)]
        m.d.comb += [getattr(source, name).eq(getattr(self, name)) for name in costs.settings]

        x = Signal(range(config.max_width))  # of the pixel that is admitted next

        # Queue.
        m.submodules.queue = queue = Queue(Queued(config), self.queue_depth + 2)
        m.submodules.queue_register = queue_register = StreamRegister(Queued(config))  # the memory block's own
        m.submodules.head = head_register = SkidRegister(Queued(config))
        wiring.connect(m, queue.o, queue_register.i)
        wiring.connect(m, queue_register.o, head_register.i)
        head = head_register.o.p
        admit = Signal()
        m.d.comb += [queue.i.payload.eq(costs.queued), queue.i.valid.eq(costs.queued_valid), head_register.o.ready.eq(admit)]
        in_flight = Signal(range(self.queue_depth + 2))  # pixels between source and admission
        issued, admitted_columns = source.o.pixel_valid, admit
        if config.lead:
            issued, admitted_columns = issued + source.lead_issued, Mux(admit & (x == 0), config.lead + 1, admit)
        m.d.sync += in_flight.eq(in_flight + issued - admitted_columns)
        # Registered: a wave that is issued in this cycle is in flight when the next one is decided.
        m.d.sync += source.go.eq(in_flight + issued < self.queue_depth - 2)

        # Admission.
        width    = Signal(range(config.max_width))  # less one; of this frame, known from its first line on
        inside   = Signal(range(self.output_depth + 1))  # admitted, disparity not yet in the line memory
        unread   = Signal(range(self.output_depth + 1))  # admitted, disparity not yet read from the output FIFO
        chosen   = Signal()
        accepted = Signal()  # a disparity, by the output
        # Decided a cycle ahead, to shorten the paths from it: another pixel may be admitted in between. None is right behind a line's last
        # one, because the width may change there.
        room     = Signal()  # in the output FIFO
        above    = Signal()  # the disparity above the next pixel is known
        m.d.comb += admit.eq(head_register.o.valid & room & (~head.pixel.has_upper | above))
        # Whether as many as `inside + admit - chosen` are no more than a line: compared for each of its values, while `admit` is decided.
        fewer, same, more = (Signal(name=f"inside_{name}") for name in ("fewer", "same", "more"))
        m.d.comb += [fewer.eq(inside <= width + 1), same.eq(inside <= width), more.eq(inside < width)]
        as_decided = Mux(admit, Mux(chosen, same, more), Mux(chosen, fewer, same))
        m.d.sync += [
            inside.eq(inside + admit - chosen), unread.eq(unread + admit - accepted),
            room.eq(unread < self.output_depth - 1), above.eq(as_decided & ~(admit & head.pixel.last)),
        ]
        with m.If(admit):
            m.d.sync += x.eq(x + 1)
            with m.If(head.pixel.last):
                m.d.sync += [x.eq(0), width.eq(x)]

        admitted = Signal(Queued(config), reset_less=True)
        m.submodules.upper_pixels = upper_pixels = Memory(
            shape=PIXEL_BITS, depth=config.max_width, init=[], attrs=NO_COLLISION)
        upper_read = upper_pixels.read_port()
        upper_write = upper_pixels.write_port()
        m.submodules.result_memory = result_memory = Memory(
            shape=range(labels), depth=config.max_width, init=[], attrs=NO_COLLISION)
        result_read = result_memory.read_port()
        result_write = result_memory.write_port()
        # Read in every cycle, for the pixel that is admitted next. Neither is then read where it is written: no pixel is admitted right
        # behind the last one of its line, and a disparity is known above a pixel from the cycle after its writing on.
        admitted_x = Signal.like(x, reset_less=True)
        begun = Signal()  # a pixel was admitted in the cycle before
        m.d.sync += [admitted_x.eq(x), begun.eq(admit)]
        m.d.comb += [
            upper_read.addr.eq(x), upper_read.en.eq(1),
            upper_write.addr.eq(admitted_x), upper_write.en.eq(begun), upper_write.data.eq(admitted.pixel.pixel),
            result_read.addr.eq(x), result_read.en.eq(1),
        ]

        # The pixel with its neighbours, and the waves that it starts along the labels.
        m.submodules.cones = cones = Cones(config, self.size_max)
        has_left = Signal(reset_less=True)
        left     = Signal(PIXEL_BITS, reset_less=True)
        sampled  = Signal(cones.weights.shape(), reset_less=True)
        with m.If(admit):
            m.d.sync += [admitted.eq(head), has_left.eq(x != 0), left.eq(admitted.pixel.pixel)]
        # Weights a cycle later, so that there is no path from the decision to their registers.
        begins   = Signal()
        of_frame = Mux(begins, Cat(self.u1, self.u2, self.u3), sampled)
        m.d.sync += begins.eq(admit & head.pixel.first)
        pixel = admitted.pixel
        neighbours = Signal(Neighbours(config, self.size_max), reset_less=True)
        weights    = Signal.like(sampled, reset_less=True)
        m.d.sync += [
            neighbours.pixel.eq(pixel.pixel), sampled.eq(of_frame), weights.eq(of_frame),
            neighbours.left.eq(left), neighbours.upper.eq(upper_read.data), neighbours.lower.eq(pixel.lower),
            neighbours.has_left.eq(has_left), neighbours.has_upper.eq(pixel.has_upper), neighbours.has_lower.eq(pixel.has_lower),
            neighbours.upper_label.eq(result_read.data), neighbours.lower_label.eq(admitted.local),
        ]
        if self.size_max:
            m.d.comb += costs.take.eq(admit)
            m.d.sync += neighbours.size.eq(costs.size)
        m.d.comb += [
            cones.i.eq(neighbours), cones.weights.eq(weights),
            array.up.eq(cones.up), array.down.eq(cones.down), array.cost.eq(costs.cost),
        ]

        # Address: the cost of label d is read `d + 2` cycles after it; the wave of label d is d cycles after that of label 0.
        m.submodules.address_delay = admitted_delay = Delay(1, self.admission_latency - 3, clean=True)
        address = Signal(range(costs.depth))
        m.d.comb += [admitted_delay.i.eq(admit), costs.address.eq(address)]
        advance = Signal()
        m.d.sync += advance.eq(admitted_delay.o)
        with m.If(advance):
            m.d.sync += address.eq(Mux(address == costs.depth - 1, 0, address + 1))

        # Selection.
        label_output = self.label_output
        turn = data.StructLayout({name: field.shape for name, field in Selected(config, label_output.settings) if name != "label"})
        m.submodules.turn = turn_delay = Delay(turn, self.selection_latency - 1, clean=True)
        m.d.comb += [turn_delay.i.valid.eq(admit), turn_delay.i.x.eq(x), *copy_flags(turn_delay.i, head.pixel)]
        if label_output.settings:
            # Those of the frame, from its first pixel on.
            shapes = {name: setting_shape(config.settings[name]) for name in label_output.settings}
            held = Signal(data.StructLayout(shapes), reset_less=True)
            with m.If(head.pixel.first):
                m.d.comb += [turn_delay.i[name].eq(getattr(self, name)) for name in label_output.settings]
            with m.Else():
                m.d.comb += [turn_delay.i[name].eq(held[name]) for name in label_output.settings]
            with m.If(admit & head.pixel.first):
                m.d.sync += [held[name].eq(getattr(self, name)) for name in label_output.settings]
        # A register for each bit's multiplexer, and one for the other readers: a single one would drive as many inputs as there are labels,
        # for each bit of a label, all over the device. Their initial values differ, so that no tool merges them; a line's first pixel has
        # no left neighbour, so that any value will do.
        bits      = (labels - 1).bit_length()
        *chosen_by, disparity = (
            Signal(range(labels), name=f"disparity_{copy}", init=copy % labels, reset_less=True) for copy in range(bits + 1))
        selected  = Signal(range(labels))
        done      = Signal()
        done_turn = Signal(turn, reset_less=True)
        m.d.comb += selected.eq(Cat(choose([value[bit] for value in array.transition], index) for bit, index in enumerate(chosen_by)))
        m.d.sync += [done.eq(turn_delay.o.valid), done_turn.eq(turn_delay.o)]
        with m.If(turn_delay.o.valid):
            m.d.sync += [index.eq(selected) for index in (*chosen_by, disparity)]
        m.d.comb += [
            result_write.addr.eq(done_turn.x), result_write.data.eq(disparity), result_write.en.eq(done), chosen.eq(done),
        ]

        # Output.
        m.submodules.label_output = label_output
        wiring.connect(m, costs.sideband, label_output.sideband)
        known = {name: done_turn[name] for name in turn.members} | {"valid": done, "label": disparity}
        m.d.comb += [label_output.i[name].eq(value) for name, value in known.items()]
        if self.size_max:
            m.d.comb += label_output.size.eq(neighbours.size)
        m.submodules.output = output = Queue(label_output.o.shape(), self.output_depth)
        source_of_o = output.o
        m.d.comb += [output.i.payload.eq(label_output.o), output.i.valid.eq(label_output.o_valid),
                     accepted.eq(output.o.valid & output.o.ready)]
        if self.registered:
            m.submodules.output_register = register = StreamRegister(label_output.o.shape())
            wiring.connect(m, output.o, register.i)
            source_of_o = register.o
        wiring.connect(m, source_of_o, wiring.flipped(self.o))
        return m
