"""The last stage of the refinement: median of the labels, disparities with their confidence."""

from amaranth import *
from amaranth.hdl import Mux, ValueLike
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from golden.config import Fused, MatcherConfig
from golden.matcher.confidence import WINDOW

from ...parts.delay import Delay
from ...parts.sorting_network import Selection, merge, select, sort
from ..stream import LabelWord
from .window_stage import WindowStage


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
    rows = WINDOW

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

    @staticmethod
    def part_of(column: data.View) -> ValueLike:
        """What ``i`` is of a column."""
        return column.label

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


class Median(WindowStage):
    """Median of labels, with which a pixel's disparity and confidence follow: the end of the refinement.

    Golden: :func:`golden.matcher.refine.median`, and what :class:`WindowStage` adds.

    Memory: a column and a sorted column for the time that the networks take, and that of :class:`WindowStage`.
    """
    selection = MedianColumns
    lines = frame_lines = line_clocks = WINDOW // 2
