"""The streaming engine: the same disparities, one pixel a cycle."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.fifo import SyncFIFOBuffered
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import IN_USE_BITS, PIXEL_BITS, WEIGHT_BITS, MatcherConfig

from .bec_array import BecArray, BecWave
from .cones import Cones, Neighbours
from .delay import Delay, StreamRegister, data_register
from .label_array import LabelArray
from .stream import FLAGS, ColumnWord, DisparityWord, copy_flags


__all__ = ["StreamingEngine", "WaveSource"]


class Pixel(data.StructLayout):
    """What the engine must know of a pixel beside its costs: grey levels of it and of the pixel below it, which neighbours exist."""
    def __init__(self):
        super().__init__({"pixel": PIXEL_BITS, "lower": PIXEL_BITS, "has_upper": 1, "has_lower": 1, **FLAGS})


class WaveSource(wiring.Component):
    """Turns lines of columns into waves for the BEC array: one before each line, its columns, one past it; edges repeat.

    The wave of column ``x`` completes pixel ``x - 1``. For it goes out, in the same cycle, what concerns BEC (``store``: its costs go to
    memory) and what concerns the labelling: the pixel above it (``pixel_valid``), which has now all it needs.

    Timing: ``W + 2`` waves a line, one a cycle while ``go`` and columns come.

    Members
    -------
    i : In(stream.Signature(ColumnWord()))
    go : In(1)
    in_use : In(IN_USE_BITS)
        Labels in use; sampled before the first column of a frame.
    wave : Out(BecWave(config))
    store : Out(1)
    pixel : Out(Pixel()), pixel_valid : Out(1)
    """
    def __init__(self, config: MatcherConfig):
        self.config = config
        super().__init__({
            "i": In(stream.Signature(ColumnWord())),
            "go": In(1),
            "in_use": In(IN_USE_BITS),
            "wave": Out(BecWave(config)),
            "store": Out(1),
            "pixel": Out(Pixel()),
            "pixel_valid": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        before    = Signal(ColumnWord(), reset_less=True)  # the column whose pixel the next wave completes
        line_zero = Signal()                               # BEC's line: 0 has none above it to label,
        line_one  = Signal()                               # what 1 lets label has no upper neighbour
        issue = Signal()
        pre   = Signal()
        emit  = Signal()
        now   = Signal(ColumnWord())
        in_use = data_register(m, self.wave.in_use, "wave_in_use")
        m.d.comb += now.eq(self.i.p)

        with m.FSM():
            with m.State("before"):
                m.d.comb += [pre.eq(1), issue.eq(self.i.valid & self.go)]
                with m.If(issue):
                    m.d.sync += [line_zero.eq(self.i.p.first), line_one.eq(line_zero)]
                    with m.If(self.i.p.first):
                        labels = self.config.disparities
                        m.d.sync += in_use.eq(Mux(self.in_use > labels, labels, self.in_use))
                    m.next = "first column"
            with m.State("first column"):
                m.d.comb += [issue.eq(self.i.valid & self.go), self.i.ready.eq(self.go)]
                with m.If(issue):
                    m.d.sync += before.eq(now)
                    m.next = "columns"
                    with m.If(now.last):
                        m.next = "past"
            with m.State("columns"):
                m.d.comb += [issue.eq(self.i.valid & self.go), self.i.ready.eq(self.go), emit.eq(1)]
                with m.If(issue):
                    m.d.sync += before.eq(now)
                    with m.If(now.last):
                        m.next = "past"
            with m.State("past"):
                m.d.comb += [now.eq(before), issue.eq(self.go), emit.eq(1)]
                with m.If(issue):
                    m.next = "before"

        first = Signal(init=1)  # the next pixel to be labelled is the first of its frame
        m.d.sync += [data_register(m, self.wave[field], f"wave_{field}").eq(value) for field, value in (
            ("pre", pre), ("inside", ~pre), ("left", now.left), ("right", now.right))]
        pixel = data_register(m, self.pixel)
        m.d.sync += [
            self.wave.valid.eq(issue),
            self.store.eq(issue & emit & ~before.below),
            self.pixel_valid.eq(issue & emit & ~line_zero),
        ]
        with m.If(issue & emit & ~line_zero):
            m.d.sync += [
                first.eq(before.end),
                pixel.pixel.eq(before.left.minus), pixel.lower.eq(before.left.line),
                pixel.has_upper.eq(~line_one), pixel.has_lower.eq(~before.below),
                pixel.first.eq(first), pixel.last.eq(before.last), pixel.end.eq(before.end),
            ]
        return m


class StreamingEngine(wiring.Component):
    """BEC and graph cut at one pixel a cycle; ``LINEAR`` arithmetic. The golden model is :func:`golden.labelling.match`.

    What recursion remains is ``f = T[f]``: the array prepares the answer for every label that the left neighbour may have, and one
    multiplexer of ``D`` labels picks.

    The arrays never stop. A pixel enters BEC only while the queue between BEC and the labelling has room for all that are on their way,
    and is admitted to the labelling only while the output FIFO has, and its upper neighbour's disparity is in the line memory: lines
    shorter than the array's latency run at a lower rate.

    Timing: a pixel a cycle and two more a line; :attr:`latency` cycles from a wave to its disparity.

    Memory: ``D`` costs for ``max_width + queue_depth + admission_latency + D - D/4`` pixels at most, a line of disparities, a line of
    pixels, and the delays of :class:`LabelArray`.

    Members
    -------
    i : In(stream.Signature(ColumnWord()))
        With the line below, see :class:`hdl.lines.LineStore`.
    o : Out(stream.Signature(DisparityWord(config)))
    u1, u2, u3 : In(WEIGHT_BITS)
        Weights; sampled with the first pixel of a frame that is admitted.
    in_use : In(IN_USE_BITS)
        Labels in use; sampled as the first column of a frame comes.
    """
    clocks_per_pixel = 1

    def __init__(self, config: MatcherConfig):
        self.config = config
        # Pixels between BEC's entry and the labelling's: BEC's depth, and what the queue's own registers hold up.
        self.source = WaveSource(config)
        self.array = LabelArray(config)
        # (These depths carry the rate. Too small a one would cost clocks, never a wrong disparity.)
        self.queue_depth = BecArray.latency_of(config) + 13
        # A cost is overwritten one line, and all that may be queued, after it was stored. Reading lags by the admission's pipeline, and in
        # the top group by a cycle for each label below it; storing lags by a cycle for each group below it.
        *below, top = BecArray.groups_of(config)
        lag = self.admission_latency + top[0] - len(below)
        self.bec = BecArray(config, config.max_width + self.queue_depth + lag)
        self.output_depth = self.admission_latency + self.array.latency + 9
        super().__init__({
            "i": In(stream.Signature(ColumnWord())),
            "o": Out(stream.Signature(DisparityWord(config))),
            "u1": In(WEIGHT_BITS),
            "u2": In(WEIGHT_BITS),
            "u3": In(WEIGHT_BITS),
            "in_use": In(IN_USE_BITS),
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
        """Cycles from the wave that completes the pixel below to a disparity at ``o``, if nothing waits."""
        return 1 + BecArray.latency_of(self.config) + 2 + StreamRegister.LATENCY + self.admission_latency + self.array.latency + 3

    def elaborate(self, platform):
        m = Module()
        config = self.config
        labels = config.disparities
        m.submodules.source = source = self.source
        m.submodules.bec = bec = self.bec
        m.submodules.array = array = self.array
        wiring.connect(m, wiring.flipped(self.i), source.i)
        m.d.comb += [bec.wave.eq(source.wave), bec.store.eq(source.store), source.in_use.eq(self.in_use)]

        # Queue: a pixel joins its local disparity there.
        queued = data.StructLayout({"pixel": Pixel(), "local": range(labels)})
        beside = data.StructLayout({"pixel": Pixel(), "valid": 1})
        m.submodules.beside = beside_delay = Delay(beside, BecArray.latency_of(config), clean=True)
        m.submodules.queue = queue = SyncFIFOBuffered(width=queued.size, depth=self.queue_depth + 2)
        m.submodules.head = head_register = StreamRegister(queued)
        head = head_register.o.p
        admit = Signal()
        joined = Signal(queued)
        m.d.comb += [
            beside_delay.i.pixel.eq(source.pixel), beside_delay.i.valid.eq(source.pixel_valid),
            joined.pixel.eq(beside_delay.o.pixel), joined.local.eq(bec.local),
            queue.w_data.eq(joined), queue.w_en.eq(beside_delay.o.valid),
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
            with m.If(head.pixel.first):
                m.d.sync += sampled.eq(Cat(self.u1, self.u2, self.u3))
        pixel = admitted.pixel
        neighbours = Signal(Neighbours(config), reset_less=True)
        weights    = Signal.like(sampled, reset_less=True)
        m.d.sync += [
            neighbours.pixel.eq(pixel.pixel), weights.eq(sampled),
            neighbours.left.eq(left), neighbours.upper.eq(upper_read.data), neighbours.lower.eq(pixel.lower),
            neighbours.has_left.eq(has_left), neighbours.has_upper.eq(pixel.has_upper), neighbours.has_lower.eq(pixel.has_lower),
            neighbours.upper_label.eq(result_read.data), neighbours.lower_label.eq(admitted.local),
        ]
        m.d.comb += [
            cones.i.eq(neighbours), cones.weights.eq(weights),
            array.up.eq(cones.up), array.down.eq(cones.down), array.cost.eq(bec.cost),
        ]

        # Whose turn it is: `d + 2` cycles after `address` label d shows the cost; its wave is there d cycles after label 0's.
        m.submodules.address_delay = admitted_delay = Delay(1, self.admission_latency - 3, clean=True)
        address = Signal(range(bec.depth))
        m.d.comb += [admitted_delay.i.eq(admit), bec.address.eq(address)]
        advance = Signal()
        m.d.sync += advance.eq(admitted_delay.o)
        with m.If(advance):
            m.d.sync += address.eq(Mux(address == bec.depth - 1, 0, address + 1))

        # Selection.
        turn = data.StructLayout({"valid": 1, "x": range(config.max_width), **FLAGS})
        m.submodules.turn = turn_delay = Delay(turn, self.admission_latency + array.latency, clean=True)
        m.d.comb += [turn_delay.i.valid.eq(admit), turn_delay.i.x.eq(x), *copy_flags(turn_delay.i, head.pixel)]
        # A register for each bit's multiplexer: one alone would drive as many inputs as there are labels, for each bit of a label.
        # They begin unlike, so that no tool makes one of them; a line's first pixel has no left neighbour, and any will do for it.
        bits      = (labels - 1).bit_length()
        chosen_by = [Signal(range(labels), name=f"disparity_{bit}", init=bit % labels, reset_less=True) for bit in range(bits)]
        disparity = chosen_by[0]
        selected  = Signal(range(labels))
        done      = Signal()
        done_turn = Signal(turn, reset_less=True)
        m.d.comb += selected.eq(Cat(choose([value[bit] for value in array.transition], index) for bit, index in enumerate(chosen_by)))
        m.d.sync += [done.eq(turn_delay.o.valid), done_turn.eq(turn_delay.o)]
        with m.If(turn_delay.o.valid):
            m.d.sync += [index.eq(selected) for index in chosen_by]
        m.d.comb += [
            result_write.addr.eq(done_turn.x), result_write.data.eq(disparity), result_write.en.eq(done), chosen.eq(done),
        ]

        word = Signal(DisparityWord(config))
        m.submodules.output = output = SyncFIFOBuffered(width=word.shape().size, depth=self.output_depth)
        m.d.comb += [
            word.disparity.eq(disparity), *copy_flags(word, done_turn),
            output.w_data.eq(word), output.w_en.eq(done),
            self.o.payload.eq(output.r_data), self.o.valid.eq(output.r_rdy), output.r_en.eq(self.o.ready),
            taken.eq(self.o.valid & self.o.ready),
        ]
        return m


def choose(values, index):
    """``values[index]`` as a tree of two-input choices, the lowest bit of the index first."""
    for bit in index:
        values = [Mux(bit, values[n + 1], values[n]) if n + 1 < len(values) else values[n] for n in range(0, len(values), 2)]
    return values[0]
