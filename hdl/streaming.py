"""The streaming engine: the same disparities, one pixel a cycle."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.fifo import SyncFIFOBuffered
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, WEIGHT_BITS, MatcherConfig

from .delay import Delay, multiply
from .stream import FLAGS, ColumnWord, DisparityWord, copy_flags
from .systolic import BecCell, BecGroup, BecWave, DownCell, DownWave, UpCell, UpWave


__all__ = ["BecArray", "LabelArray", "StreamingEngine", "WaveSource"]


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
    wave : Out(BecWave())
    store : Out(1)
    pixel : Out(Pixel()), pixel_valid : Out(1)
    """
    def __init__(self):
        super().__init__({
            "i": In(stream.Signature(ColumnWord())),
            "go": In(1),
            "wave": Out(BecWave()),
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
        m.d.comb += now.eq(self.i.p)

        with m.FSM():
            with m.State("before"):
                m.d.comb += [pre.eq(1), issue.eq(self.i.valid & self.go)]
                with m.If(issue):
                    m.d.sync += [line_zero.eq(self.i.p.first), line_one.eq(line_zero)]
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
        m.d.sync += [
            self.wave.valid.eq(issue), self.wave.pre.eq(pre), self.wave.inside.eq(~pre),
            self.wave.left.eq(now.left), self.wave.right.eq(now.right),
            self.store.eq(issue & emit & ~before.below),
            self.pixel_valid.eq(issue & emit & ~line_zero),
        ]
        with m.If(issue & emit & ~line_zero):
            m.d.sync += [
                first.eq(before.end),
                self.pixel.pixel.eq(before.left.minus), self.pixel.lower.eq(before.left.line),
                self.pixel.has_upper.eq(~line_one), self.pixel.has_lower.eq(~before.below),
                self.pixel.first.eq(first), self.pixel.last.eq(before.last), self.pixel.end.eq(before.end),
            ]
        return m


class BecArray(wiring.Component):
    """Basic energy calculation, laid out along the labels; golden: :func:`golden.cost.matching_cost`, :func:`golden.cost.local_disparity`.

    Each label's costs go to its own line memory, which the labelling reads at its own pace: there the skew of one cycle a label
    costs nothing.

    Timing: ``local`` :meth:`latency_of` cycles after the wave that completed its pixel. The cost that was ``store``-th is read at
    ``address`` ``store % depth``; label ``d`` shows it in ``cost[d]`` ``d + 2`` cycles after ``address``.

    Memory: ``D * depth`` costs.

    Members
    -------
    wave : In(BecWave()), store : In(1)
    local : Out(range(D))
    address : In(range(depth))
    cost : Out(ArrayLayout(cost_bits, D))
        Complements.
    """
    def __init__(self, config: MatcherConfig, depth):
        self.config = config
        self.depth = depth
        self.groups = [range(low, min(low + BecGroup.SIZE, config.disparities))
                       for low in range(0, config.disparities, BecGroup.SIZE)]
        super().__init__({
            "wave": In(BecWave()),
            "store": In(1),
            "local": Out(range(config.disparities)),
            "address": In(range(depth)),
            "cost": Out(data.ArrayLayout(config.cost_bits, config.disparities)),
        })

    @staticmethod
    def latency_of(config: MatcherConfig):
        """Cycles from a wave to the local disparity that it completes."""
        return BecCell.LATENCY + BecGroup.TREE + -(-config.disparities // BecGroup.SIZE)

    def elaborate(self, platform):
        m = Module()
        config, depth = self.config, self.depth

        # Where the next cost goes; the order walks from group to group as the waves do.
        place = Signal(range(depth))
        m.submodules.store_delay = store_delay = Delay(1, BecCell.LATENCY - 1, clean=True)
        m.d.comb += store_delay.i.eq(self.store)
        with m.If(store_delay.o):
            m.d.sync += place.eq(Mux(place == depth - 1, 0, place + 1))
        write, write_place = store_delay.o, place
        read_place = self.address

        wave, least = self.wave, None
        for labels in self.groups:
            later       = Signal(name=f"write_{labels[0]}")
            later_place = Signal(range(depth), name=f"write_place_{labels[0]}", reset_less=True)
            m.d.sync += [later.eq(write), later_place.eq(write_place)]
            write, write_place = later, later_place

            m.submodules[f"group_{labels[0]}"] = group = BecGroup(config, labels)
            m.d.comb += group.i.eq(wave)
            if least is not None:
                m.d.comb += group.least_i.eq(least)
            wave, least = group.o, group.least_o

            for n, label in enumerate(labels):
                m.submodules[f"edata_{label}"] = memory = Memory(shape=config.cost_bits, depth=depth, init=[])
                write_port = memory.write_port()
                read_port = memory.read_port()
                m.d.comb += [write_port.en.eq(write), write_port.addr.eq(write_place), write_port.data.eq(group.cost[n])]
                here = Signal(range(depth), name=f"read_place_{label}", reset_less=True)
                m.d.sync += here.eq(read_place)
                m.d.comb += [read_port.en.eq(1), read_port.addr.eq(here), self.cost[label].eq(read_port.data)]
                read_place = here
        m.d.comb += self.local.eq(least.index)
        return m


class LabelArray(wiring.Component):
    """For every label ``p`` that the left neighbour may have, the disparity ``T(p) = argmin_d A(d) + w1*|d - p|``.

    An L1 distance transform that carries its argument: upward, then downward in place, one label a cycle each; RAM delays bring every
    label's upward result to its turn on the way down, and the answers together at the end. Equal to evaluating (2-15) for each ``p``,
    ties to the smaller disparity. ``T`` is monotone and idempotent. Golden: :func:`golden.labelling.transition`.

    Timing: ``transition`` :attr:`latency` cycles after ``up``; a pixel a cycle.

    Memory: delays of ``2 * (D - 1 - d)`` cycles of an energy and a label, of ``d`` cycles of a label.

    Members
    -------
    up : In(UpWave(config))
    down : In(DownWave(config))
        In the cycle of ``up``, at label ``D - 1``.
    cost : In(ArrayLayout(cost_bits, D))
        Complements; label ``d`` is read ``d`` cycles after ``up``.
    transition : Out(ArrayLayout(range(D), D))
    """
    #: Labels whose answers wait in one memory.
    GROUP = 5

    def __init__(self, config: MatcherConfig):
        self.config = config
        labels = config.disparities
        super().__init__({
            "up": In(UpWave(config)),
            "down": In(DownWave(config)),
            "cost": In(data.ArrayLayout(config.cost_bits, labels)),
            "transition": Out(data.ArrayLayout(range(labels), labels)),
        })

    @property
    def latency(self):
        """Cycles from ``up`` to ``transition``."""
        turn = self.config.disparities - 1 + UpCell.LATENCY
        return turn + self.config.disparities - 1 + DownCell.LATENCY + 1

    def elaborate(self, platform):
        m = Module()
        config = self.config
        labels = config.disparities

        # Up.
        ups = []
        wave, least = self.up, None
        for label in range(labels):
            cell = UpCell(config, label)
            m.submodules[f"up_{label}"] = cell
            m.d.comb += [cell.i.eq(wave), cell.cost.eq(self.cost[label])]
            if least is not None:
                m.d.comb += cell.least_i.eq(least)
            wave, least = cell.o, cell.least_o
            ups.append(least)

        # Down. The top label turns at once; each label below waits two cycles more: one for the way up, one for the way down.
        m.submodules.down_delay = down_delay = Delay(DownWave(config), labels - 1 + UpCell.LATENCY)
        m.d.comb += down_delay.i.eq(self.down)
        answers = [None] * labels
        wave, least = down_delay.o, None
        for label in reversed(range(labels)):
            cell = DownCell(config, label)
            m.submodules[f"down_{label}"] = cell
            m.submodules[f"wait_{label}"] = wait = Delay(ups[label].shape(), 2 * (labels - 1 - label))
            m.d.comb += [wait.i.eq(ups[label]), cell.up.eq(wait.o), cell.i.eq(wave)]
            if least is not None:
                m.d.comb += cell.least_i.eq(least)
            wave, least = cell.o, cell.least_o
            answers[label] = least.index

        # Together. Label 0 is last; the others of a group wait for its lowest in registers, the group for label 0 in a memory.
        for low in range(0, labels, self.GROUP):
            group = range(low, min(low + self.GROUP, labels))
            shape = data.ArrayLayout(range(labels), len(group))
            m.submodules[f"align_{low}"] = align = Delay(shape, low)
            for label in group:
                m.submodules[f"align_{low}_{label}"] = skew = Delay(range(labels), label - low)
                m.d.comb += [skew.i.eq(answers[label]), align.i[label - low].eq(skew.o)]
                m.d.sync += self.transition[label].eq(align.o[label - low])
        return m


class StreamingEngine(wiring.Component):
    """BEC and graph cut at one pixel a cycle; ``LINEAR`` arithmetic. The golden model is :func:`golden.labelling.match`.

    What recursion remains is ``f = T[f]``: the array prepares the answer for every label that the left neighbour may have, and one
    multiplexer of ``D`` labels picks.

    The arrays never stop. A pixel enters BEC only while the queue between BEC and the labelling has room for all that are on their way,
    and is admitted to the labelling only while the output FIFO has, and its upper neighbour's disparity is in the line memory: lines
    shorter than the array's latency run at a lower rate.

    Timing: a pixel a cycle and two more a line; :attr:`latency` cycles from a wave to its disparity.

    Memory: ``D`` line memories of ``max_width`` costs and some, a line of disparities, a line of pixels, delays of :class:`LabelArray`.

    Members
    -------
    i : In(stream.Signature(ColumnWord()))
        With the line below, see :class:`hdl.lines.LineStore`.
    o : Out(stream.Signature(DisparityWord(config)))
    u1, u2, u3 : In(WEIGHT_BITS)
        Weights; sampled with the first pixel of a frame that is admitted.
    """
    clocks_per_pixel = 1

    def __init__(self, config: MatcherConfig):
        self.config = config
        # Pixels between BEC's entry and the labelling's: BEC's depth, and what the queue's own registers hold up.
        self.source = WaveSource()
        self.array = LabelArray(config)
        self.queue_depth = BecArray.latency_of(config) + 10
        # A cost is overwritten one line, and all that may be queued, after it was stored; reading may lag by the admission's pipeline.
        self.bec = BecArray(config, config.max_width + self.queue_depth + self.admission_latency)
        self.output_depth = self.admission_latency + self.array.latency + 8
        super().__init__({
            "i": In(stream.Signature(ColumnWord())),
            "o": Out(stream.Signature(DisparityWord(config))),
            "u1": In(WEIGHT_BITS),
            "u2": In(WEIGHT_BITS),
            "u3": In(WEIGHT_BITS),
        })

    @property
    def admission_latency(self):
        """Cycles from a pixel's admission to its wave at label 0."""
        label_bits = (self.config.disparities - 1).bit_length()
        return 2 + (WEIGHT_BITS - 1).bit_length() + 1 + max((label_bits - 1).bit_length(), 1) + 2

    @property
    def latency(self):
        """Cycles from the wave that completes the pixel below to a disparity at ``o``, if nothing waits."""
        return 1 + BecArray.latency_of(self.config) + 2 + self.admission_latency + self.array.latency + 3

    def elaborate(self, platform):
        m = Module()
        config = self.config
        labels = config.disparities
        m.submodules.source = source = self.source
        m.submodules.bec = bec = self.bec
        m.submodules.array = array = self.array
        wiring.connect(m, wiring.flipped(self.i), source.i)
        m.d.comb += [bec.wave.eq(source.wave), bec.store.eq(source.store)]

        # Queue: a pixel joins its local disparity there.
        queued = data.StructLayout({"pixel": Pixel(), "local": range(labels)})
        beside = data.StructLayout({"pixel": Pixel(), "valid": 1})
        m.submodules.beside = beside_delay = Delay(beside, BecArray.latency_of(config), clean=True)
        m.submodules.queue = queue = SyncFIFOBuffered(width=queued.size, depth=self.queue_depth + 2)
        head = Signal(queued)
        admit = Signal()
        joined = Signal(queued)
        m.d.comb += [
            beside_delay.i.pixel.eq(source.pixel), beside_delay.i.valid.eq(source.pixel_valid),
            joined.pixel.eq(beside_delay.o.pixel), joined.local.eq(bec.local),
            queue.w_data.eq(joined), queue.w_en.eq(beside_delay.o.valid),
            head.eq(queue.r_data), queue.r_en.eq(admit),
        ]
        on_the_way = Signal(range(self.queue_depth + 2))  # pixels between source and admission
        m.d.sync += on_the_way.eq(on_the_way + source.pixel_valid - admit)
        m.d.comb += source.go.eq(on_the_way + source.pixel_valid < self.queue_depth)

        # Admission.
        x        = Signal(range(config.max_width))
        width    = Signal(range(config.max_width))  # less one; of this frame, known from its first line on
        inside   = Signal(range(self.output_depth + 1))  # admitted, disparity not yet in the line memory
        unread   = Signal(range(self.output_depth + 1))  # admitted, disparity not yet taken from the output FIFO
        chosen   = Signal()
        taken    = Signal()
        m.d.comb += admit.eq(queue.r_rdy & (unread < self.output_depth) & (~head.pixel.has_upper | (inside <= width)))
        m.d.sync += [inside.eq(inside + admit - chosen), unread.eq(unread + admit - taken)]
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

        # Stage 1: grey levels and labels of pixel and neighbours.
        admitted  = Signal(queued, reset_less=True)
        has_left  = Signal(reset_less=True)
        left      = Signal(PIXEL_BITS, reset_less=True)
        names = ("u1", "u2", "u3")
        sampled   = [Signal(WEIGHT_BITS, name=f"{name}_sampled", reset_less=True) for name in names]
        weights   = [Signal(WEIGHT_BITS, name=f"{name}_of_frame", reset_less=True) for name in names]
        m.d.sync += [weight.eq(sample) for weight, sample in zip(weights, sampled, strict=True)]
        with m.If(admit):
            m.d.sync += [admitted.eq(head), has_left.eq(x != 0), left.eq(admitted.pixel.pixel)]
            with m.If(head.pixel.first):
                m.d.sync += [sample.eq(getattr(self, name)) for sample, name in zip(sampled, names, strict=True)]

        # Stage 2: likeness 256 - |dI|, 0 without a neighbour.
        likeness = []
        for name, grey, present in (("left", left, has_left), ("upper", upper_read.data, admitted.pixel.has_upper),
                                    ("lower", admitted.pixel.lower, admitted.pixel.has_lower)):
            pixel = admitted.pixel.pixel
            value = Signal(range(257), name=f"likeness_{name}", reset_less=True)
            m.d.sync += value.eq(Mux(present, 256 - Mux(pixel > grey, pixel - grey, grey - pixel), 0))
            likeness.append(value)
        vertices = Signal(data.StructLayout({"upper": range(labels), "lower": range(labels)}), reset_less=True)
        # Above the first line there is none: its cone is flat, but no unwritten word may decide where its vertex is.
        m.d.sync += [vertices.upper.eq(Mux(admitted.pixel.has_upper, result_read.data, 0)), vertices.lower.eq(admitted.local)]

        # Slopes, (2*u*(256 - dI) << q) >> 8; cones at label 0; ramp at label D-1.
        slopes = []
        for name, weight, value in zip(("w1", "w2", "w3"), weights, likeness, strict=True):
            product, slope_latency = multiply(m, f"product_{name}", value, weight)
            slope = Signal(range(config.slope_max + 1), name=name, reset_less=True)
            m.d.sync += slope.eq((product << config.fraction_bits + 1) >> 8)
            slopes.append(slope)
        m.submodules.vertices = vertices_delay = Delay(vertices.shape(), slope_latency + 1)
        m.d.comb += vertices_delay.i.eq(vertices)
        upper, lower = vertices_delay.o.upper, vertices_delay.o.lower
        w1, w2, w3 = slopes
        cone_upper, cone_latency = multiply(m, "cone_upper", w2, upper)
        cone_lower, _ = multiply(m, "cone_lower", w3, lower)
        m.submodules.slopes = slopes_delay = Delay(data.ArrayLayout(range(config.slope_max + 1), 3), cone_latency)
        m.submodules.cone_vertices = cone_vertices = Delay(vertices.shape(), cone_latency)
        m.d.comb += [*(slopes_delay.i[n].eq(slope) for n, slope in enumerate(slopes)), cone_vertices.i.eq(vertices_delay.o)]

        # Two stages: sums, then steps.
        sorted_vertices = Signal(data.StructLayout({"low": range(labels), "high": range(labels)}), reset_less=True)
        upper_first     = Signal(reset_less=True)
        v1, v2, v3 = (slopes_delay.o[n] for n in range(3))
        both   = Signal(range(2 * config.slope_max + 1), reset_less=True)
        apart  = Signal(range(-config.slope_max, config.slope_max + 1), reset_less=True)
        w1_now = Signal(range(config.slope_max + 1), reset_less=True)
        cone   = Signal(range(2 * config.smooth_max + 1), reset_less=True)
        ramp   = Signal(range(2 * config.smooth_max + 1), reset_less=True)
        upper, lower = cone_vertices.o.upper, cone_vertices.o.lower
        m.d.sync += [
            upper_first.eq(upper < lower),
            sorted_vertices.low.eq(Mux(upper < lower, upper, lower)), sorted_vertices.high.eq(Mux(upper < lower, lower, upper)),
        ]
        m.d.sync += [both.eq(v2 + v3), apart.eq(v2 - v3), w1_now.eq(v1), cone.eq(cone_upper + cone_lower)]
        m.d.sync += ramp.eq(sum(((v1 << place) for place in range(8) if 2 * (labels - 1) >> place & 1), Const(0, 1)))
        up, down = Signal(UpWave(config), reset_less=True), Signal(DownWave(config), reset_less=True)
        m.d.sync += [
            up.cone.eq(cone), up.low.eq(sorted_vertices.low), up.high.eq(sorted_vertices.high),
            up.falling.eq(-both - w1_now), up.between.eq(Mux(upper_first, apart, -apart) - w1_now), up.rising.eq(both - w1_now),
            down.ramp.eq(ramp), down.step.eq(w1_now << 1),
        ]
        m.d.comb += [array.up.eq(up), array.down.eq(down), array.cost.eq(bec.cost)]
        assert 2 + slope_latency + 1 + cone_latency + 2 == self.admission_latency

        # Whose turn it is: `d + 2` cycles after `address` label d shows the cost; its wave is there d cycles after label 0's.
        m.submodules.admitted = admitted_delay = Delay(1, self.admission_latency - 3, clean=True)
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
        disparity = Signal(range(labels))
        done      = Signal()
        done_turn = Signal(turn, reset_less=True)
        m.d.sync += [done.eq(turn_delay.o.valid), done_turn.eq(turn_delay.o)]
        with m.If(turn_delay.o.valid):
            m.d.sync += disparity.eq(choose(array.transition, disparity))
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
    values = [values[n] for n in range(len(values))]
    for bit in index:
        values = [Mux(bit, values[n + 1], values[n]) if n + 1 < len(values) else values[n] for n in range(0, len(values), 2)]
    return values[0]
