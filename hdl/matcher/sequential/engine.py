"""The sequential engine: graph cut as the thesis sequences it."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, WEIGHT_BITS, MatcherConfig

from ..lines import EdataMemory, LineStore
from ..stream import FLAGS, BecWord, DisparityWord, copy_flags
from .argmin import ComparatorTree
from .bec import Bec
from .smooth import Smooth


__all__ = ["CostSummation", "SequentialEngine"]


class CostSummation(wiring.Component):
    """Energy of every label: its matching cost plus three smoothness terms (thesis figure 30).

    The golden model is :func:`golden.matcher.labelling.cost_summation`.

    Smooth2 and Smooth3 are known long before Smooth1, which needs the disparity of the pixel before: they are added first.

    Width: exact; an energy is at most ``config.energy_max``.

    Timing: ``energy`` holds the terms ``s1`` of one cycle ago, the others of two; one set a cycle.

    Members
    -------
    cost : In(ArrayLayout(cost_bits, D))
    s1, s2, s3 : In(ArrayLayout(range(smooth_max + 1), D))
    energy : Out(ArrayLayout(energy_bits, D))
    """
    LATENCY = 1
    EARLY_LATENCY = 2

    def __init__(self, config: MatcherConfig):
        self.config = config
        labels = config.labels
        term = data.ArrayLayout(range(config.smooth_max + 1), labels)
        super().__init__({
            "cost": In(data.ArrayLayout(config.matching_cost.bits, labels)),
            "s1": In(term),
            "s2": In(term),
            "s3": In(term),
            "energy": Out(data.ArrayLayout(config.energy_bits, labels)),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        early = Signal(self.energy.shape(), reset_less=True)
        for d in range(self.config.labels):
            m.d.sync += [
                early[d].eq((self.cost[d] << self.config.rule.energy_shift) + (self.s2[d] + self.s3[d])),
                self.energy[d].eq(early[d] + self.s1[d]),
            ]
        return m


class SequentialEngine(wiring.Component):
    """Graph cut implementation block (thesis figures 25, 26): disparities by rule (2-15), all labels of a pixel at once.

    The golden model is :func:`golden.matcher.labelling.labelling`. With ``b(x, y+1)`` from BEC the pixel above it can be
    labelled: its costs are in the Edata memory, the disparity above it in a line memory, and that to its left is the one before. The last
    line is labelled without BEC; it has no lower neighbour.

    The main controller is two small machines. The *feeder* fetches a pixel and starts Smooth2 and Smooth3 while the *loop* still works
    on the pixel before. The loop, ``f(x-1) -> Smooth1 -> summation -> comparison -> f(x)``, sets the rate.

    Timing: a pixel each :attr:`clocks_per_pixel` cycles; at a line's start the feeder waits for the loop to finish (a line of one pixel
    reads the disparity above it from the pixel before). A new frame waits for the frame before it; filling THESIS's look-up tables
    overlaps its first line.

    Memory: ``max_width`` words of ``D * cost_bits + 16`` bits, ``max_width`` disparities, three look-up tables.

    Members
    -------
    i : In(stream.Signature(BecWord(config)))
    o : Out(stream.Signature(DisparityWord(config)))
    u1, u2, u3 : In(WEIGHT_BITS)
        Weights; sampled with the first word of a frame.
    """
    lines_below = 0
    rows = 3
    padding_clocks = 2  # cycles of padding in a line
    preroll_clocks = 0  # and before its first column, once that has been offered

    def __init__(self, config: MatcherConfig, bec: Bec | None = None):
        if config.labels not in config.SEQUENTIAL_LABELS:
            raise ValueError(f"the engine sequential computes at most {config.SEQUENTIAL_LABELS[-1]} disparities, "
                             f"not {config.labels}; choose the engine streaming")
        self.config = config
        self.bec = bec
        self.smooths = [Smooth(config) for _ in range(3)]
        self.tree = ComparatorTree(config.energy_bits, config.labels)
        super().__init__({
            "i": In(stream.Signature(BecWord(config))),
            "o": Out(stream.Signature(DisparityWord(config))),
            "u1": In(WEIGHT_BITS),
            "u2": In(WEIGHT_BITS),
            "u3": In(WEIGHT_BITS),
        })

    @property
    def clocks_per_pixel(self) -> int:
        """Cycles of the loop."""
        return Smooth.LATENCY + CostSummation.LATENCY + self.tree.latency

    @property
    def fill_clocks(self) -> int:
        """Cycles in which a frame's look-up tables are filled."""
        return self.smooths[0].table.fill_clocks

    @property
    def full_rate_width(self) -> int:
        """Shortest line, in pixels, that is labelled at :attr:`clocks_per_pixel`: any."""
        return 1

    def latency_clocks(self, lines: int, line_clocks: int) -> int:
        """Bound of a disparity's latency beyond ``lines`` lines of :attr:`clocks_per_pixel` a pixel, in cycles, behind line store and BEC.

        The pixels in the Plus Line FIFO and in BEC's five stages advance at the rate of the loop; each of three line starts costs BEC's
        and the feeder's latency once more, and a frame's first line may wait for the look-up tables.
        """
        assert self.bec
        waiting = (LineStore.PLUS_DEPTH + 8) * self.clocks_per_pixel
        return waiting + 2 * self.bec.latency + 6 * self.clocks_per_pixel

    def frame_clocks(self, width: int, height: int, lines_above: int, line_clocks: int) -> int:
        """Cycles from one frame's first disparity to the next one's, if neither ``i`` nor ``o`` stalls.

        The first line fills the Edata memory at BEC's rate, or while the look-up tables are filled; then a line is labelled as the one
        below it arrives. Exact from two lines on; a single line takes two cycles less.
        """
        assert self.bec
        first = max(width * self.bec.clocks_per_pixel, self.fill_clocks + 1)
        return first + height * (width * self.clocks_per_pixel + self.line_clocks)

    @property
    def line_clocks(self) -> int:
        """Cycles that a line takes beyond its pixels': the feeder starts when the loop is done, and overlaps its last two cycles."""
        return Smooth.PIXEL_LATENCY + CostSummation.EARLY_LATENCY - 1

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        x_shape = range(config.max_width)

        edata_word = data.StructLayout({
            "cost": data.ArrayLayout(config.matching_cost.bits, config.labels), "pixel": PIXEL_BITS, "upper": PIXEL_BITS,
        })
        m.submodules.edata_memory = edata_memory = EdataMemory(edata_word, config.max_width)
        m.submodules.result_memory = result_memory = Memory(shape=range(config.labels), depth=config.max_width, init=[])
        result_read = result_memory.read_port()
        result_write = result_memory.write_port()
        smooth1, smooth2, smooth3 = self.smooths
        m.submodules.smooth1 = smooth1
        m.submodules.smooth2 = smooth2
        m.submodules.smooth3 = smooth3
        m.submodules.summation = summation = CostSummation(config)
        m.submodules.comparison = tree = self.tree

        # Feeder: fetches pixel (x, y) with `take`. The fetched word is valid from the next cycle until the next `take`.
        take    = Signal()
        x       = Signal(x_shape)
        width   = Signal(x_shape)   # less one
        row_one = Signal()          # the line in BEC is line 1: the one labelled has none above it
        fed       = Signal()        # a pixel is fetched and its loop has not begun
        fed_x     = Signal(x_shape, reset_less=True)
        fed_flags = Signal(data.StructLayout(FLAGS), reset_less=True)
        fed_local = Signal(range(config.labels), reset_less=True)
        fed_plus  = Signal(PIXEL_BITS, reset_less=True)
        has_left  = Signal(reset_less=True)
        has_upper = Signal(reset_less=True)
        has_lower = Signal(reset_less=True)
        before    = Signal(PIXEL_BITS, reset_less=True)

        # Loop: `start` as soon as the fetched pixel's early terms are ready in time, then one cycle for each phase.
        start = Signal()
        busy  = Signal()
        phase = Signal(range(self.clocks_per_pixel))
        done  = Signal()            # the disparity is at the tree's output from this cycle on
        at_x  = Signal(x_shape, reset_less=True)
        idle  = Signal()
        m.d.comb += idle.eq(~busy & ~done & ~fed)

        filled = Signal()
        fill   = Signal()
        m.d.comb += filled.eq(smooth1.filled & smooth2.filled & smooth3.filled)
        weights = []
        for name, smooth in (("u1", smooth1), ("u2", smooth2), ("u3", smooth3)):
            weight = Signal(WEIGHT_BITS, name=f"{name}_of_frame", reset_less=True)
            weights.append(weight.eq(getattr(self, name)))
            # A look-up table needs its weight with `fill`, in the cycle that samples it.
            m.d.comb += [smooth.weight.eq(Mux(fill, getattr(self, name), weight)), smooth.fill.eq(fill)]

        m.d.comb += [
            edata_memory.column.eq(x),
            edata_memory.i.cost.eq(self.i.p.cost), edata_memory.i.pixel.eq(self.i.p.pixel), edata_memory.i.upper.eq(self.i.p.upper),
            result_read.addr.eq(x), result_read.en.eq(take),
        ]
        can_take = Signal()
        # Smooth3 reads its look-up table a cycle later: a frame whose first line is short waits for the tables.
        m.d.comb += can_take.eq(Mux(x == 0, idle & filled, ~fed))
        flush = Signal()

        with m.FSM():
            with m.State("first line"):  # nothing to compute yet: fill the Edata memory
                with m.If(self.i.valid & (~self.i.p.first | idle)):
                    m.d.comb += [self.i.ready.eq(1), edata_memory.exchange.eq(1), edata_memory.write.eq(1)]
                    m.d.sync += x.eq(x + 1)
                    with m.If(self.i.p.first):
                        m.d.comb += fill.eq(1)
                        m.d.sync += weights
                    with m.If(self.i.p.last):
                        m.d.sync += [x.eq(0), width.eq(x), row_one.eq(1)]
                        m.next = "lines"
                    with m.If(self.i.p.end):
                        m.next = "last line"

            with m.State("lines"):
                with m.If(self.i.valid & can_take):
                    m.d.comb += [self.i.ready.eq(1), edata_memory.exchange.eq(1), edata_memory.write.eq(1), take.eq(1)]
                    m.d.sync += x.eq(x + 1)
                    with m.If(self.i.p.last):
                        m.d.sync += [x.eq(0), row_one.eq(0)]
                    with m.If(self.i.p.end):
                        m.next = "last line"

            with m.State("last line"):
                m.d.comb += flush.eq(1)
                with m.If(can_take):
                    m.d.comb += [edata_memory.exchange.eq(1), take.eq(1)]
                    m.d.sync += x.eq(x + 1)
                    with m.If(x == width):
                        m.d.sync += x.eq(0)
                        m.next = "first line"

        # Early terms start a cycle after `take`. A loop that starts `lead` cycles later is in step with them.
        lead = Smooth.PIXEL_LATENCY + CostSummation.EARLY_LATENCY - Smooth.LATENCY - CostSummation.LATENCY
        age = Signal(lead)
        early_read = Signal()
        m.d.sync += [early_read.eq(take), age.eq(Mux(take, 0, Cat(fed, age)))]
        with m.If(take):
            m.d.sync += [
                fed.eq(1), fed_x.eq(x), fed_local.eq(self.i.p.local), fed_plus.eq(self.i.p.pixel), before.eq(edata_memory.o.pixel),
                has_left.eq(x != 0), has_upper.eq(~row_one), has_lower.eq(~flush),
                fed_flags.first.eq(row_one & (x == 0)), fed_flags.last.eq(x == width), fed_flags.end.eq(flush & (x == width)),
            ]
        with m.Elif(start):
            m.d.sync += fed.eq(0)

        pixel = edata_memory.o.pixel
        m.d.comb += [
            smooth1.label.eq(tree.o.index), smooth1.read.eq(start),
            smooth1.pixel.eq(pixel), smooth1.neighbour.eq(before), smooth1.present.eq(has_left),
            # A neighbour outside the picture has no label: neither an unwritten word nor an idle payload may reach a table's address.
            smooth2.label.eq(Mux(has_upper, result_read.data, 0)), smooth2.read.eq(early_read),
            smooth2.pixel.eq(pixel), smooth2.neighbour.eq(edata_memory.o.upper), smooth2.present.eq(has_upper),
            smooth3.label.eq(Mux(has_lower, fed_local, 0)), smooth3.read.eq(early_read),
            smooth3.pixel.eq(pixel), smooth3.neighbour.eq(fed_plus), smooth3.present.eq(has_lower),
            summation.cost.eq(edata_memory.o.cost),
            summation.s1.eq(smooth1.energy), summation.s2.eq(smooth2.energy), summation.s3.eq(smooth3.energy),
            tree.i.eq(summation.energy),
        ]

        # Loop. `phase` counts cycles since `start`. The disparity stays at the tree's output, and with it the word at `o`, until the
        # next one replaces it; so a pixel starts only once the word of the one before is accepted.
        last_phase = Signal()
        m.d.comb += [
            start.eq(fed & age[-1] & ~busy & (~self.o.valid | self.o.ready)),
            last_phase.eq(busy & (phase == self.clocks_per_pixel - 1)),
            tree.enable.eq(busy & (phase >= Smooth.LATENCY + CostSummation.LATENCY)),
            self.o.p.disparity.eq(tree.o.index),
            result_write.addr.eq(at_x), result_write.data.eq(tree.o.index), result_write.en.eq(done),
        ]
        m.d.sync += [done.eq(last_phase), phase.eq(phase + 1)]
        with m.If(start):
            m.d.sync += [busy.eq(1), phase.eq(1), at_x.eq(fed_x), *copy_flags(self.o.p, fed_flags)]
        with m.Elif(last_phase):
            m.d.sync += busy.eq(0)
        with m.If(last_phase):
            m.d.sync += self.o.valid.eq(1)
        with m.Elif(self.o.ready):
            m.d.sync += self.o.valid.eq(0)
        return m
