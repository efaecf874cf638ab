"""The last stage of the refinement with grey levels: weighted median of the labels, disparities with their confidence."""

from amaranth import *
from amaranth.hdl import Mux, ValueLike
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig
from golden.matcher.recursive.weighted_median import SIZE, THRESHOLDS

from ...parts.arithmetic import add_all, choose
from ...parts.delay import Delay
from ..stream import LabelWord
from .window import LabelColumn, window_columns
from .window_stage import WindowStage


__all__ = ["VoteSum", "Votes", "WeightedMedian", "WeightedMedianColumns"]


PIXELS = SIZE * SIZE
REACH = SIZE // 2

#: Bits of a label that are found at once.
DIGIT_BITS = 2

#: Bit length of the most votes of a pixel: 4, doubled. Votes are powers of two or none, so that a bit length tells them.
LENGTH_MAX = len(THRESHOLDS) + 1
VOTES_MAX = PIXELS << LENGTH_MAX - 1


class Votes(wiring.Component):
    """Votes of the pixels of a window. Golden: :func:`golden.matcher.recursive.weighted_median.votes`.

    Timing: as :func:`hdl.matcher.refine.window.window_columns`, with any pauses; :attr:`LATENCY` cycles.

    Members
    -------
    grey : In(data.ArrayLayout(8, 7)), passed : In(7)
        The newest column, topmost line first. ``passed`` is that of the column of the cycle before.
    advance : In(1), opens : In(1)
        Of the column of ``grey``.
    o : Out(data.ArrayLayout(range(LENGTH_MAX + 1), 49))
        Bit length of the votes of each pixel around the one three columns before the newest one, which is first; by columns.
    """
    LATENCY = 3

    def __init__(self, config: MatcherConfig):
        self.config = config
        super().__init__({
            "grey": In(data.ArrayLayout(LabelWord(config)["grey"].shape, SIZE)),
            "passed": In(SIZE),
            "advance": In(1),
            "opens": In(1),
            "o": Out(data.ArrayLayout(range(LENGTH_MAX + 1), PIXELS)),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        advance, opens = Signal(), Signal(reset_less=True)  # of ``passed``
        m.d.sync += [advance.eq(self.advance), opens.eq(self.opens)]
        window = window_columns(m, self.grey, self.advance, self.opens, SIZE, "grey_column")
        passed = Cat(window_columns(m, self.passed, advance, opens, SIZE, "passed_column"))
        center = window[REACH][REACH]
        for n, grey in enumerate(grey for column in window for grey in column):
            difference = Signal(range(-255, 256), name=f"difference_{n}", reset_less=True)
            length     = Signal(range(LENGTH_MAX + 1), name=f"length_{n}", reset_less=True)
            m.d.sync += difference.eq(grey - center)
            votes: Value = C(0)
            for number, threshold in enumerate(reversed(THRESHOLDS), 1):
                votes = Mux(within(difference, threshold), number + passed[n], votes)
            m.d.sync += length.eq(votes)
            m.d.comb += self.o[n].eq(length)
        return m


def within(difference: Value, threshold: int) -> Value:
    """Whether a signed value is ``threshold``, a power of two, at most, or its negative at least: in tables, without a carry chain."""
    above = difference[threshold.bit_length() - 1:]
    return (above == 0) | above.all() | (difference == threshold)


class VoteSum(wiring.Component):
    """Sum of the votes of those pixels of a window that are not ``left_out``.

    Timing: a window a cycle; :attr:`latency` cycles.

    Members
    -------
    i : In(data.ArrayLayout(range(LENGTH_MAX + 1), 49))
        As the output of :class:`Votes`.
    left_out : In(49)
    o : Out(range(VOTES_MAX + 1))
    """
    def __init__(self):
        super().__init__({"i": In(data.ArrayLayout(range(LENGTH_MAX + 1), PIXELS)), "left_out": In(PIXELS), "o": Out(range(VOTES_MAX + 1))})

    @property
    def latency(self) -> int:
        """Cycles: votes, and the levels of a tree."""
        return 1 + (PIXELS - 1).bit_length()

    def elaborate(self, platform: object) -> Module:
        m = Module()
        terms = []
        for n, (length, left_out) in enumerate(zip(self.i, self.left_out)):
            votes = Signal(LENGTH_MAX, name=f"votes_{n}", reset_less=True)
            m.d.sync += votes.eq(Cat((length == bits) & ~left_out for bits in range(1, LENGTH_MAX + 1)))
            terms.append((votes, 1 << LENGTH_MAX - 1))
        total, _ = add_all(m, terms)
        m.d.comb += self.o.eq(total)
        return m


class WeightedMedianColumns(wiring.Component):
    """Weighted median of the window of seven columns and lines around the pixel three columns before the latest one.

    Golden: :func:`golden.matcher.recursive.weighted_median.weighted_median`. A label is found digit by digit, the most significant first;
    a digit is :data:`DIGIT_BITS` bits, or one. Of the pixels whose label agrees with the digits found, the votes of those with a smaller
    digit next are summed, for every digit: the digit is the greatest for which twice the sum is less than ``rest``, which is all votes at
    first; ``rest`` then is less by that. With two bits a digit, there are more sums than with one, but half of the waiting.

    Timing: a column a cycle at most; :attr:`latency` cycles, :attr:`digit_clocks` of them a digit.

    Memory: for the time that a digit takes, votes, and digits of the column that are not used yet.

    Parameters
    ----------
    config : :class:`MatcherConfig`

    Members
    -------
    i : In(LabelColumn(config, 7))
        Topmost line first.
    valid : In(1)
        ``i`` is valid.
    opens : In(1)
        ``i`` is the first column of its line, replicated to the left of the picture.
    o : Out(labels), done : Out(1)
    """
    rows = SIZE

    def __init__(self, config: MatcherConfig):
        self.config = config
        self.shape = shape = LabelWord(config)["label"].shape
        self.bits = Shape.cast(shape).width
        self.votes = Votes(config)
        self.total = VoteSum()
        # The lowest bit of each digit to the sums of the votes for digits below 1, 2 and so on. The first one may have fewer bits.
        self.sums = {low: [VoteSum() for _ in range(1, 1 << min(DIGIT_BITS, self.bits - low))]
                     for low in reversed(range(0, self.bits, DIGIT_BITS))}
        super().__init__({
            "i": In(LabelColumn(config, SIZE)),
            "valid": In(1),
            "opens": In(1),
            "o": Out(shape),
            "done": Out(1),
        })

    @staticmethod
    def part_of(column: data.View) -> ValueLike:
        """What ``i`` is of a column: all of it."""
        return column

    @property
    def digit_clocks(self) -> int:
        """Cycles from the votes of those that agree with some digits to the votes of those that agree with one more."""
        return self.total.latency + 2

    @property
    def latency(self) -> int:
        """Cycles: the votes, and each digit."""
        return Votes.LATENCY + len(self.sums) * self.digit_clocks - 1

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.votes, m.submodules.total = votes, total = self.votes, self.total
        valid_later = Signal(self.latency)
        opens_later = Signal(self.latency, reset_less=True)
        valid, opens = Cat(self.valid, valid_later), Cat(self.opens, opens_later)
        m.d.sync += [valid_later.eq(valid), opens_later.eq(opens)]

        passed = Signal(SIZE, reset_less=True)
        m.d.sync += passed.eq(self.i.passed)
        m.d.comb += [
            votes.grey.eq(self.i.grey), votes.passed.eq(passed), votes.advance.eq(self.valid), votes.opens.eq(self.opens),
            self.done.eq(valid[-1]),
        ]

        # The labels' bits by lines, the least significant ones of all lines first; from digit to digit only the lower ones.
        m.submodules.labels = labels = Delay(SIZE * self.bits, Votes.LATENCY - 1)
        m.d.comb += labels.i.eq(Cat(label[bit] for bit in range(self.bits) for label in self.i.label))
        column: Value = labels.o
        now    = Votes.LATENCY - 1            # cycles from the input to ``column``; votes are a cycle later
        voting = Value.cast(votes.o)          # of the pixels that agree so far
        found: Value = Const(0, 0)
        rest: Value = Const(0, 0)
        m.d.comb += [total.i.eq(voting), total.left_out.eq(0)]
        for low, sums in self.sums.items():
            # For every sum, which pixels it leaves out.
            reached = Cat(digit >= n for n in range(1, len(sums) + 1) for digit in _digits(column[low * SIZE:]))
            window = window_columns(m, reached, valid[now], opens[now], SIZE, f"reached_{low}")
            for n, below in enumerate(sums):
                m.submodules[f"below_{low}_{n + 1}"] = below
                m.d.comb += [below.i.eq(voting), below.left_out.eq(Cat(part[n * SIZE:(n + 1) * SIZE] for part in window))]

            # What is needed once they are summed, and votes a cycle later.
            wait = self.total.latency + 1
            now += wait
            parts = {"column": column, "found": found, "rest": rest, **({"voting": voting} if low else {})}
            m.submodules[f"carried_{low}"] = carried = Delay(data.StructLayout({name: len(part) for name, part in parts.items()}), wait)
            m.d.comb += [carried.i[name].eq(part) for name, part in parts.items()]
            rest_now = carried.o.rest if len(found) else total.o
            twice    = [below.o << 1 for below in sums]
            digit    = Signal(range(len(sums) + 1), name=f"digit_{low}", reset_less=True)
            higher   = Signal(len(found), name=f"higher_{low}", reset_less=True)
            m.d.sync += higher.eq(carried.o.found)
            for n, votes_below in enumerate(twice):
                if n == 0:
                    m.d.sync += digit.eq(votes_below < rest_now)
                else:
                    with m.If(votes_below < rest_now):
                        m.d.sync += digit.eq(n + 1)
            found = Cat(digit, higher)
            if low:
                column = carried.o.column
                agree  = window_columns(m, column[low * SIZE:], valid[now], opens[now], SIZE, f"agree_{low}")
                rests  = [Signal(range(VOTES_MAX + 1), name=f"rest_{low}_{n}", reset_less=True) for n in range(len(sums) + 1)]
                lower  = Signal(SIZE * low, name=f"lower_{low}", reset_less=True)
                voters = Signal(len(voting), name=f"voters_{low}", reset_less=True)
                digits = [each for part in agree for each in _digits(part)]
                m.d.sync += [
                    *(left.eq(rest_now - below) for left, below in zip(rests, [0, *twice])), lower.eq(column),
                    voters.eq(Cat(Mux(each == digit, length, 0)
                                  for each, length in zip(digits, data.View(votes.o.shape(), carried.o.voting)))),
                ]
                column, rest, voting = lower, Value.cast(choose(rests, digit)), voters
            now += 1
        m.d.comb += self.o.eq(found)
        return m


def _digits(column: Value) -> list[Value]:
    """The digit of each line of a column."""
    return [column[line::SIZE] for line in range(SIZE)]


class WeightedMedian(WindowStage):
    """Weighted median of labels, with which a pixel's disparity and confidence follow: the end of the refinement.

    Golden: :func:`golden.matcher.recursive.weighted_median.weighted_median`, and what :class:`WindowStage` adds.

    Memory: that of :class:`WeightedMedianColumns` and of :class:`WindowStage`.
    """
    selection = WeightedMedianColumns
    lines = frame_lines = line_clocks = REACH
