"""The last stage of the refinement: median of the labels, disparities with their confidence."""

from typing import ClassVar

from amaranth import *
from amaranth.hdl import Mux
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import Fused, MatcherConfig
from golden.matcher.confidence import WINDOW

from ...parts.delay import Delay, StreamRegister
from ...parts.queue import Queue
from ...parts.sorting_network import Selection, merge, select, sort
from ..settings import minimum_shape
from ..stage import Stage
from ..stream import DisparityWord, LabelWord, copy_flags
from .confidence import Confidence
from .window import REACH, LabelColumns, SlotWord


__all__ = ["Median", "MedianColumns"]


class MedianColumns(wiring.Component):
    """Median of the window of ``median_size`` columns and lines around the pixel two columns before the latest one.

    Golden: :func:`golden.matcher.refine.median`. Each column is sorted once, each pair of neighbours merged once: a window of five is a
    pair, the pair two columns before it and the newest column; a window of three is a pair and the newest column but one.

    Timing: a column a cycle at most; :attr:`latency` cycles.

    Parameters
    ----------
    config : :class:`MatcherConfig`

    Members
    -------
    i : In(data.ArrayLayout(labels, 5))
        Topmost line first.
    valid : In(1)
        ``i`` is valid.
    opens : In(1)
        ``i`` is the first column of its line, replicated to the left of the picture.
    o : Out(labels), done : Out(1)
    """
    def __init__(self, config: MatcherConfig):
        self.config = config
        self.shape = shape = LabelWord(config)["label"].shape
        self.side = side = config.method_as(Fused).refinement.median_size

        self.sort = Selection(shape, side, *sort(range(side)))
        exchanges, order = merge(range(side), range(side, 2 * side))
        self.pair = Selection(shape, 2 * side, exchanges, contenders(order, side))
        self.pairs = None
        if side == 5:
            exchanges, order = merge(range(2 * side), range(2 * side, 4 * side))
            self.pairs = Selection(shape, 4 * side, exchanges, contenders(order, side))
        left = contenders(order, side)
        exchanges, wire = select(range(len(left)), range(len(left), len(left) + side), side * side // 2 + 1 - order.index(left[0]))
        self.select = Selection(shape, len(left) + side, exchanges, [wire])
        super().__init__({
            "i": In(data.ArrayLayout(shape, WINDOW)),
            "valid": In(1),
            "opens": In(1),
            "o": Out(shape),
            "done": Out(1),
        })

    @property
    def latency(self) -> int:
        """Cycles: four networks and the register between columns and pairs."""
        return self.sort.latency + 1 + self.pair.latency + (self.pairs.latency if self.pairs else 0) + self.select.latency

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.sort, m.submodules.pair, m.submodules.select = self.sort, self.pair, self.select
        column = data.ArrayLayout(self.shape, self.side)

        valid_later = Signal(self.latency)
        opens_later = Signal(self.latency, reset_less=True)
        valid, opens = Cat(self.valid, valid_later), Cat(self.opens, opens_later)
        m.d.sync += [valid_later.eq(valid), opens_later.eq(opens)]
        m.d.comb += self.done.eq(valid[-1])

        # Sorted columns.
        above = (WINDOW - self.side) // 2
        m.d.comb += [line.eq(self.i[above + n]) for n, line in enumerate(self.sort.i)]
        now = self.sort.latency
        newer = Signal(column, reset_less=True)
        older = Signal(column, reset_less=True)
        with m.If(valid[now]):
            m.d.sync += [newer.eq(self.sort.o), older.eq(Mux(opens[now], self.sort.o, newer))]
        m.d.comb += self.pair.i.eq(Cat(older, newer))

        # The latest pair and those before it; before a line's first pair that one is replicated.
        paired = now + 1 + self.pair.latency
        before = [Signal(self.pair.o.shape(), name=f"pair_before_{n}", reset_less=True) for n in (1, 2, 3)]
        first  = Signal(reset_less=True)  # the pair before is its line's first
        with m.If(valid[paired]):
            m.d.sync += [
                first.eq(opens[paired]), before[0].eq(self.pair.o), before[1].eq(before[0]),
                before[2].eq(Mux(first, before[0], before[1])),
            ]
        candidates, alone = before[1], newer
        if self.pairs:
            m.submodules.pairs = pairs = self.pairs
            m.d.comb += pairs.i.eq(Cat(before[0], before[2]))
            candidates, alone = pairs.o, self.sort.o

        # The column that is in no pair is merged last.
        m.submodules.alone = alone_delay = Delay(column, self.latency - self.select.latency - now)
        m.d.comb += [
            alone_delay.i.eq(alone), self.select.i.eq(Cat(candidates, alone_delay.o)), self.o.eq(self.select.o[0]),
        ]
        return m


def contenders(order: list[int], side: int) -> list[int]:
    """Of wires sorted from the least value to the greatest, those that may be the median of the window once its other values are merged."""
    middle = side * side // 2
    later = side * side - len(order)
    return order[max(middle - later, 0):middle + 1]


class Median(Stage):
    """Median of labels, with which a pixel's disparity and confidence follow: the end of the refinement.

    Golden: :func:`golden.matcher.refine.median`, then ``disparity = label + minimum * config.method.disparity_scale``, and
    :func:`golden.matcher.confidence.confidence` of the label among those before the median.

    Frames must be rectangular, closed by ``end`` and at most ``max_width`` wide; they may differ in size.

    Timing: a pixel a cycle, :attr:`line_clocks` cycles more a line, :attr:`frame_lines` lines more a frame, in which no pixel is
    accepted: the last lines are output without waiting for the next frame. If ``o`` does not stall, a pixel is valid :attr:`lines` lines
    of ``W + line_clocks`` cycles and :attr:`latency` cycles after it was accepted. ``i.ready`` and ``o`` are registered.

    Memory: that of :class:`LabelColumns`; a column, a sorted column and a result for the time that networks and votes take; an output
    queue of :attr:`latency` words.

    Parameters
    ----------
    config : :class:`MatcherConfig`
        With the method :class:`golden.config.Fused`.

    Members
    -------
    i : In(stream.Signature(LabelWord(config)))
    o : Out(stream.Signature(DisparityWord(config)))
    enable : In(1)
        Off: labels are unchanged, at the same latency.
    minimum : In(minimum_shape(config))
        Disparity of the label 0, pixels. Both are sampled as the word marked ``first`` is accepted.
    """
    name = "median"
    settings: ClassVar = {"enable": "median", "minimum": "minimum"}
    lines = frame_lines = REACH
    line_clocks = REACH

    def __init__(self, config: MatcherConfig):
        self.config = config
        self.columns = LabelColumns(config)
        self.median = MedianColumns(config)
        self.confidence = Confidence(config)
        super().__init__({
            "i": In(stream.Signature(LabelWord(config))),
            "o": Out(stream.Signature(DisparityWord(config))),
            "enable": In(1),
            "minimum": In(minimum_shape(config)),
        })

    @property
    def pipeline(self) -> int:
        """Cycles from a label to the disparity that its column completes."""
        return LabelColumns.LATENCY + self.median.latency + self.confidence.latency

    @property
    def latency(self) -> int:
        """Cycles beyond :attr:`lines` lines from a pixel to its disparity, if ``o`` does not stall."""
        return REACH + self.pipeline + 2 + StreamRegister.LATENCY

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        m.submodules.columns, m.submodules.median, m.submodules.confidence = self.columns, self.median, self.confidence
        columns, median, confidence = self.columns, self.median, self.confidence
        wiring.connect(m, wiring.flipped(self.i), columns.i)
        m.d.comb += [
            columns.enable.eq(self.enable), columns.minimum.eq(self.minimum),
            median.i.eq(columns.o.column.label), median.valid.eq(columns.valid), median.opens.eq(columns.o.opens),
        ]

        # The column in step with its median.
        m.submodules.aside = slot_delay = Delay(SlotWord(config), median.latency)
        slot  = slot_delay.o
        label = Mux(slot.enable, median.o, confidence.center)
        m.d.comb += [
            slot_delay.i.eq(columns.o),
            confidence.i.eq(slot.column), confidence.advance.eq(median.done), confidence.opens.eq(slot.opens),
            confidence.disparity.eq(label),
        ]

        # The disparity in step with its confidence.
        word  = Signal(DisparityWord(config), reset_less=True)
        shown = Signal(confidence.latency)
        m.d.sync += [
            word.disparity.eq(label + slot.minimum * config.method.disparity_scale), word.passed.eq(confidence.center_passed),
            *copy_flags(word, slot), shown.eq(Cat(median.done & slot.shown, shown)),
        ]
        m.submodules.result = result = Delay(DisparityWord(config), confidence.latency - 1)
        m.d.comb += result.i.eq(word)

        # The pipeline never stalls: a column is issued only while the output queue has room for all in flight. This is decided a cycle
        # ahead, hence the margin of two columns.
        depth  = self.pipeline + 4
        unread = Signal(range(depth + 1))  # issued, not yet read from the queue
        final  = Signal(DisparityWord(config))
        m.submodules.output = output = Queue(DisparityWord(config), depth)
        m.submodules.register = register = StreamRegister(DisparityWord(config))
        wiring.connect(m, output.o, register.i)
        wiring.connect(m, register.o, wiring.flipped(self.o))
        m.d.sync += [
            unread.eq(unread + columns.issued - (output.o.valid & output.o.ready)), columns.go.eq(unread < depth - 1),
        ]
        m.d.comb += [
            final.eq(result.o), final.confidence.eq(confidence.o),
            output.i.payload.eq(final), output.i.valid.eq(shown[-1]),
        ]
        return m
