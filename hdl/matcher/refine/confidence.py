"""Confidence of a disparity: the votes of its neighbourhood."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.config import CONFIDENCE_BITS, MatcherConfig
from golden.matcher.confidence import WINDOW

from ...parts.arithmetic import add_all
from ..stream import LabelWord
from .window import VoteColumn, column_registers, take_column


__all__ = ["Confidence"]


class Confidence(wiring.Component):
    """Confidence ``(a + p + 2 * g) >> 2`` of a label within its window; the golden model is :func:`golden.matcher.confidence.confidence`.

    Width: exact; ``25 + 25 + 2 * 6`` is the most, hence four bits.

    Timing: a column a cycle while ``advance`` is high. A column completes the window of the pixel two columns before it: in the same
    cycle ``center`` is its label before the median and ``disparity`` must be its result; ``o`` is its confidence :attr:`latency` cycles
    later. Edge replication: to the left by the column that ``opens`` a line; to the right the last column must be repeated at ``i``.

    Parameters
    ----------
    config : :class:`MatcherConfig`
        With a method that refines its labels.

    Members
    -------
    i : In(VoteColumn(config))
    advance : In(1)
        ``i`` is valid.
    opens : In(1)
        ``i`` is the first column of its line.
    disparity : In(range(labels))
        In units of ``1 / disparity_scale`` pixel, as ``i``.
    center : Out(range(labels)), center_passed : Out(1)
    o : Out(CONFIDENCE_BITS)
    """
    def __init__(self, config: MatcherConfig):
        self.config = config
        word = LabelWord(config)
        super().__init__({
            "i": In(VoteColumn(config)),
            "advance": In(1),
            "opens": In(1),
            "disparity": In(word["label"].shape),
            "center": Out(word["label"].shape),
            "center_passed": Out(1),
            "o": Out(CONFIDENCE_BITS),
        })

    @property
    def latency(self) -> int:
        """Cycles: window, differences, votes, and the levels of a tree of their sum and the size."""
        return 3 + (WINDOW * WINDOW).bit_length()

    def elaborate(self, platform: object) -> Module:
        m = Module()
        scale = self.config.method.disparity_scale
        reach = WINDOW // 2

        window = column_registers(self.i, WINDOW)
        m.d.comb += [self.center.eq(window[reach - 1].label[reach]), self.center_passed.eq(window[reach - 1].passed[reach])]
        take_column(m, window, self.i, self.advance, self.opens)
        # Least label that agrees; below zero it wraps, and so do the differences.
        greatest = self.config.labels * scale - 1 + scale
        least    = Signal(range(greatest + 1), reset_less=True)
        m.d.sync += least.eq(self.disparity - scale)

        # Differences, from 0 to twice the scale where labels agree. The others are greater: they wrap round once at most.
        passed      = Signal(WINDOW * WINDOW, reset_less=True)
        differences = [Signal(range(greatest + 1), name=f"difference_{n}", reset_less=True) for n in range(WINDOW * WINDOW)]
        m.d.sync += passed.eq(Cat(column.passed for column in window))
        labels = [label for column in window for label in column.label]
        m.d.sync += [difference.eq(label - least) for difference, label in zip(differences, labels)]

        # A vote, two if it passed.
        votes = [Signal(range(3), name=f"votes_{n}", reset_less=True) for n in range(WINDOW * WINDOW)]
        for vote, difference, double in zip(votes, differences, passed):
            agrees = difference <= 2 * scale
            m.d.sync += vote.eq(Cat(agrees & ~double, agrees & double))

        # Their sum with the size.
        size = window[reach].size
        for n in range(2):
            later = Signal.like(size, name=f"size_{n}", reset_less=True)
            m.d.sync += later.eq(size)
            size = later
        terms = [*((vote, 2) for vote in votes), (size << 1, 2 * self.config.refined.arms.support_max.bit_length())]
        total, _ = add_all(m, terms)
        m.d.comb += self.o.eq(total >> 2)
        return m
