"""The streaming engine: the same disparities, one pixel a cycle."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.fifo import SyncFIFOBuffered
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import IN_USE_BITS, MINIMUM_BITS, PIXEL_BITS, WEIGHT_BITS, Fused, MatcherConfig

from ...parts.arithmetic import choose
from ...parts.delay import Delay, StreamRegister
from ..stream import FLAGS, CensusWord, ColumnWord, DisparityWord, LabelWord, copy_flags
from .bec_array import BecArray, Queued, groups_of
from .cones import Cones, Neighbours
from .fused_array import FusedArray
from .label_array import LabelArray
from .right_view import LeftRightCheck
from .sub_pixel import SubPixel
from .waves import WaveSource


__all__ = ["StreamingEngine"]


class StreamingEngine(wiring.Component):
    """BEC and graph cut at one pixel a cycle; ``LINEAR`` arithmetic. The golden model is :func:`golden.matcher.labelling.match`,
    with the cost ``FUSED`` :func:`golden.matcher.fused.stages` up to the check.

    What recursion remains is ``f = T[f]``: the array prepares the answer for every label that the left neighbour may have, and one
    multiplexer of ``D`` labels picks.

    The arrays never stop. A pixel enters BEC only while the queue between BEC and the labelling has room for all that are on their way,
    and is admitted to the labelling only while the output FIFO has, and its upper neighbour's disparity is in the line memory: lines
    shorter than the array's latency run at a lower rate.

    Timing: a pixel a cycle and two more a line; :attr:`latency` cycles from a wave to its disparity.

    Memory: ``D`` costs for ``max_width + queue_depth + admission_latency + D - D/4`` pixels at most, a line of disparities, a line of
    pixels, and the delays of :class:`LabelArray`. With the cost ``FUSED`` also those of :class:`FusedArray`, and the right
    picture's labels, see :class:`LeftRightCheck`.

    Members
    -------
    i : In(stream.Signature(ColumnWord())), or of CensusWord(config) with the cost ``FUSED``
        With the line below, see :class:`hdl.matcher.lines.LineStore`.
    o : Out(stream.Signature(DisparityWord(config))), or of LabelWord(config) with the cost ``FUSED``
    u1, u2, u3 : In(WEIGHT_BITS)
        Weights; sampled a cycle after the first pixel of a frame was admitted.
    in_use : In(IN_USE_BITS)
        Labels in use; sampled as the first column of a frame comes.
    minimum : In(MINIMUM_BITS)
        Least disparity, pixels, by which the right picture is delayed; cost ``FUSED`` only, sampled likewise.
    check : In(1)
        Left-right check; without it every pixel passes. Cost ``FUSED`` only, sampled with the first pixel of a frame that is admitted.
    """
    clocks_per_pixel = 1

    def __init__(self, config: MatcherConfig):
        self.config = config
        self.fused = isinstance(config.method, Fused)
        costs = FusedArray if self.fused else BecArray
        self.source = WaveSource(config)
        self.array = LabelArray(config)
        # Pixels between the entry of the array of costs and the labelling's: its depth, and what the queue's own registers hold up.
        # (These depths carry the rate. Too small a one would cost clocks, never a wrong disparity.)
        self.queue_depth = costs.latency_of(config) + costs.lag_of(config) + 13
        # A cost is overwritten one line, and all that may be queued, after it was stored. Reading lags by the admission's pipeline, and in
        # the top group by a cycle for each label below it; storing lags by a cycle for each group below it. One more, so that it is never
        # overwritten as it is read.
        *below, top = groups_of(config)
        lag = self.admission_latency + top[0] - len(below) + 1
        self.costs = costs(config, config.max_width + self.queue_depth + lag)
        self.check_latency = LeftRightCheck.LATENCY if self.fused else 0
        self.register_latency = StreamRegister.LATENCY if self.fused else 0  # behind the output FIFO
        self.output_depth = self.admission_latency + self.array.latency + self.check_latency + 9
        more = {"minimum": In(MINIMUM_BITS), "check": In(1)} if self.fused else {}
        super().__init__({
            "i": In(stream.Signature(CensusWord(config) if self.fused else ColumnWord())),
            "o": Out(stream.Signature(LabelWord(config) if self.fused else DisparityWord(config))),
            "u1": In(WEIGHT_BITS),
            "u2": In(WEIGHT_BITS),
            "u3": In(WEIGHT_BITS),
            "in_use": In(IN_USE_BITS),
            **more,
        })

    @property
    def admission_latency(self):
        """Cycles from a pixel's admission to its wave at label 0."""
        return 2 + Cones.latency_of(self.config)

    @property
    def round_trip(self):
        """Cycles from a pixel's admission to that of the pixel below it, at least."""
        return self.admission_latency + self.array.latency + 3

    @property
    def latency(self):
        """Cycles from the wave that completes the pixel below, and all that its costs take, to a disparity at ``o``, if nothing waits."""
        costs = self.costs.latency_of(self.config) + self.costs.lag_of(self.config)
        labelling = self.admission_latency + self.array.latency + self.check_latency
        return 1 + costs + 2 + StreamRegister.LATENCY + labelling + 3 + self.register_latency

    def elaborate(self, platform):
        m = Module()
        config = self.config
        labels = config.labels
        m.submodules.source = source = self.source
        m.submodules.costs = costs = self.costs
        m.submodules.array = array = self.array
        wiring.connect(m, wiring.flipped(self.i), source.i)
        m.d.comb += [
            source.in_use.eq(self.in_use), costs.wave.eq(source.wave), costs.pixel.eq(source.pixel),
            costs.pixel_valid.eq(source.pixel_valid),
        ]
        if self.fused:
            m.d.comb += [source.minimum.eq(self.minimum), costs.completion.eq(source.completion)]
            if (isinstance(config.method, Fused) and config.method.vertical):
                m.d.comb += costs.vertical.eq(source.vertical)
        else:
            m.d.comb += costs.store.eq(source.store)

        # Queue.
        queued = Queued(config)
        m.submodules.queue = queue = SyncFIFOBuffered(width=queued.size, depth=self.queue_depth + 2)
        m.submodules.head = head_register = StreamRegister(queued)
        head = head_register.o.p
        admit = Signal()
        m.d.comb += [
            queue.w_data.eq(costs.queued), queue.w_en.eq(costs.queued_valid),
            head_register.i.payload.eq(queue.r_data), head_register.i.valid.eq(queue.r_rdy), queue.r_en.eq(head_register.i.ready),
            head_register.o.ready.eq(admit),
        ]
        on_the_way = Signal(range(self.queue_depth + 2))  # pixels between source and admission
        m.d.sync += on_the_way.eq(on_the_way + source.pixel_valid - admit)
        # From a register: a wave that this cycle may still let in is on its way when the next one is decided.
        m.d.sync += source.go.eq(on_the_way + source.pixel_valid < self.queue_depth - 2)

        # Admission.
        x        = Signal(range(config.max_width))
        width    = Signal(range(config.max_width))  # less one; of this frame, known from its first line on
        inside   = Signal(range(self.output_depth + 1))  # admitted, disparity not yet in the line memory
        unread   = Signal(range(self.output_depth + 1))  # admitted, disparity not yet taken from the output FIFO
        chosen   = Signal()
        taken    = Signal()
        # Decided a cycle ahead, so that what depends on it has the cycle to itself: another pixel may be admitted in between, and behind
        # a line's last one nothing is, because the width may change there.
        room     = Signal()  # in the output FIFO
        above    = Signal()  # the disparity above the next pixel is known
        still_inside = Signal.like(inside)
        m.d.comb += [
            admit.eq(head_register.o.valid & room & (~head.pixel.has_upper | above)),
            still_inside.eq(inside + admit - chosen),
        ]
        m.d.sync += [
            inside.eq(still_inside), unread.eq(unread + admit - taken),
            room.eq(unread < self.output_depth - 1), above.eq((still_inside <= width) & ~(admit & head.pixel.last)),
        ]
        with m.If(admit):
            m.d.sync += x.eq(x + 1)
            with m.If(head.pixel.last):
                m.d.sync += [x.eq(0), width.eq(x)]

        m.submodules.upper_pixels = upper_pixels = Memory(shape=PIXEL_BITS, depth=config.max_width, init=[])
        upper_read = upper_pixels.read_port()
        upper_write = upper_pixels.write_port()
        m.submodules.result_memory = result_memory = Memory(shape=range(labels), depth=config.max_width, init=[])
        result_read = result_memory.read_port()
        result_write = result_memory.write_port()
        m.d.comb += [
            upper_read.addr.eq(x), upper_read.en.eq(admit),
            upper_write.addr.eq(x), upper_write.en.eq(admit), upper_write.data.eq(head.pixel.pixel),
            result_read.addr.eq(x), result_read.en.eq(admit),
        ]

        # The pixel between its neighbours, and the waves that it sends along the labels.
        m.submodules.cones = cones = Cones(config)
        admitted = Signal(queued, reset_less=True)
        has_left = Signal(reset_less=True)
        left     = Signal(PIXEL_BITS, reset_less=True)
        sampled  = Signal(cones.weights.shape(), reset_less=True)
        with m.If(admit):
            m.d.sync += [admitted.eq(head), has_left.eq(x != 0), left.eq(admitted.pixel.pixel)]
        # Weights a cycle later, so that no path leads from the decision to their registers.
        begins   = Signal()
        of_frame = Mux(begins, Cat(self.u1, self.u2, self.u3), sampled)
        m.d.sync += begins.eq(admit & head.pixel.first)
        pixel = admitted.pixel
        neighbours = Signal(Neighbours(config), reset_less=True)
        weights    = Signal.like(sampled, reset_less=True)
        m.d.sync += [
            neighbours.pixel.eq(pixel.pixel), sampled.eq(of_frame), weights.eq(of_frame),
            neighbours.left.eq(left), neighbours.upper.eq(upper_read.data), neighbours.lower.eq(pixel.lower),
            neighbours.has_left.eq(has_left), neighbours.has_upper.eq(pixel.has_upper), neighbours.has_lower.eq(pixel.has_lower),
            neighbours.upper_label.eq(result_read.data), neighbours.lower_label.eq(admitted.local),
        ]
        if self.fused:
            m.d.comb += costs.take.eq(admit)
            m.d.sync += neighbours.n.eq(costs.n)
        m.d.comb += [
            cones.i.eq(neighbours), cones.weights.eq(weights),
            array.up.eq(cones.up), array.down.eq(cones.down), array.cost.eq(costs.cost),
        ]

        # Whose turn it is: `d + 2` cycles after `address` label d shows the cost; its wave is there d cycles after label 0's.
        m.submodules.address_delay = admitted_delay = Delay(1, self.admission_latency - 3, clean=True)
        address = Signal(range(costs.depth))
        m.d.comb += [admitted_delay.i.eq(admit), costs.address.eq(address)]
        advance = Signal()
        m.d.sync += advance.eq(admitted_delay.o)
        with m.If(advance):
            m.d.sync += address.eq(Mux(address == costs.depth - 1, 0, address + 1))

        # Selection.
        settings = {"minimum": MINIMUM_BITS, "check": 1} if self.fused else {}
        turn = data.StructLayout({"valid": 1, "x": range(config.max_width), **settings, **FLAGS})
        m.submodules.turn = turn_delay = Delay(turn, self.admission_latency + array.latency, clean=True)
        m.d.comb += [turn_delay.i.valid.eq(admit), turn_delay.i.x.eq(x), *copy_flags(turn_delay.i, head.pixel)]
        if self.fused:
            # Those of the frame, from its first pixel on.
            held = Signal(data.StructLayout(settings), reset_less=True)
            with m.If(head.pixel.first):
                m.d.comb += [turn_delay.i[name].eq(getattr(self, name)) for name in settings]
            with m.Else():
                m.d.comb += [turn_delay.i[name].eq(held[name]) for name in settings]
            with m.If(admit & head.pixel.first):
                m.d.sync += [held[name].eq(getattr(self, name)) for name in settings]
        # A register for each bit's multiplexer, and one for all else that a disparity goes to: one alone would drive as many inputs as
        # there are labels, for each bit of a label, all over the device. They begin unlike, so that no tool makes one of them; a line's
        # first pixel has no left neighbour, and any will do for it.
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

        word = Signal(self.o.p.shape())
        word_valid = done
        if self.fused:
            word_valid = self._check(m, word, disparity, done, done_turn)
            # From the register behind the memory of sizes: two cycles after the admission.
            m.submodules.size = size = Delay(word.size.shape(), turn_delay.clocks - 1 + self.check_latency)
            m.d.comb += [size.i.eq(_bit_length(neighbours.n)), word.size.eq(size.o)]
        else:
            m.d.comb += [word.disparity.eq(disparity), *copy_flags(word, done_turn)]
        m.submodules.output = output = SyncFIFOBuffered(width=word.shape().size, depth=self.output_depth)
        given = self.o
        if self.fused:  # the fill decides by what comes
            m.submodules.output_register = register = StreamRegister(word.shape())
            wiring.connect(m, register.o, wiring.flipped(self.o))
            given = register.i
        m.d.comb += [
            output.w_data.eq(word), output.w_en.eq(word_valid),
            given.payload.eq(output.r_data), given.valid.eq(output.r_rdy), output.r_en.eq(given.ready),
            taken.eq(given.valid & given.ready),
        ]
        return m

    def _check(self, m, word, label, done, turn):
        """Left-right check of the label chosen: fills ``word`` but for the size; returns when it is valid."""
        config = self.config
        # How many right labels may come between a pixel's own and its turn: a line, and all that are on their way.
        latest = config.max_width + self.queue_depth + self.output_depth + config.labels
        m.submodules.check = check = LeftRightCheck(config, latest)
        m.d.comb += [
            check.right.eq(self.costs.right), check.right_valid.eq(self.costs.right_valid),
            check.x.eq(turn.x), check.label.eq(label), check.valid.eq(done),
            check.minimum.eq(turn.minimum), check.enable.eq(turn.check),
        ]
        beside = data.StructLayout({"valid": 1, "label": label.shape(), **FLAGS})
        m.submodules.checked = checked = Delay(beside, check.LATENCY, clean=True)
        m.d.comb += [
            checked.i.valid.eq(done), checked.i.label.eq(label), *copy_flags(checked.i, turn),
            word.passed.eq(check.passed), *copy_flags(word, checked.o),
        ]
        if config.method_as(Fused).refinement.sub_pixel:
            m.submodules.sub_pixel = sub_pixel = SubPixel(config, self.array.latency + 1)
            m.submodules.fraction = fraction = Delay(Value.cast(sub_pixel.fraction).shape(), check.LATENCY - 1)
            m.d.comb += [
                sub_pixel.sums.eq(self.costs.cost), sub_pixel.label.eq(label), fraction.i.eq(sub_pixel.fraction),
                word.label.eq(checked.o.label * config.method.disparity_scale + Mux(check.passed, fraction.o, 0)),
            ]
        else:
            m.d.comb += word.label.eq(checked.o.label)
        return checked.o.valid


def _bit_length(value):
    """Bits of a number without leading zeros."""
    bits = len(value)
    length = Const(0, bits.bit_length())
    for place in range(bits):
        length = Mux(value[place], place + 1, length)
    return length
