"""Census of both pictures at every pixel."""

from itertools import pairwise
from typing import ClassVar

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Member, Out

from golden.config import PIXEL_BITS, MatcherConfig

from ..parts.delay import data_register
from .stage import Stage
from .stream import CensusWord, ColumnWord, copy_flags, line_names


__all__ = ["BlindCensusStage", "CensusStage"]


class CensusStage(Stage):
    """Census of the left and of the right picture at every pixel, added to the three lines around it.

    The golden model is :func:`golden.matcher.census.census`: a bit for each neighbour in the window, set where it is darker than the
    centre.

    Edge replication: to the left and to the right here, above and below by the line store in front, whose frames are rectangular. The
    census of a word marked ``below`` is undefined.

    Timing: a word is output :attr:`latency` cycles after its column was accepted, if the next columns follow without a pause and the
    line before has been output. A line of ``W`` columns takes ``W + census_columns // 2`` cycles; its last words do not wait for the next
    line. ``o`` and ``i.ready`` are registered.

    Parameters
    ----------
    config : :class:`MatcherConfig`

    Members
    -------
    i : In(stream.Signature(ColumnWord(rows)))
        As many :attr:`rows` as the census has, three at least, five with vertical support.
    o : Out(stream.Signature(CensusWord(config)))
    """
    name = "census"

    def __init__(self, config: MatcherConfig, **members: Member):
        self.config = config
        method = config.refined
        self.rows = max(5 if method.census_above else 3, method.cost.census_rows)
        self.line_clocks = max(1, method.cost.census_columns // 2)
        super().__init__({
            "i": In(stream.Signature(ColumnWord(self.rows))),
            "o": Out(stream.Signature(CensusWord(config))),
            **members,
        })

    @property
    def latency(self) -> int:
        """Cycles from a column to the census at it."""
        return 2 + self.config.refined.cost.census_columns // 2

    def _limits(self, m: Module, moves: Value, following: data.View, centre: data.View) -> dict[str, Value]:
        """Grey level of either picture below which a neighbour of ``centre`` has a bit; as it ``moves``, ``following`` is the next one."""
        return {side: centre[side].line for side in ("left", "right")}

    def elaborate(self, platform: object) -> Module:
        m = Module()
        columns = self.config.refined.cost.census_columns
        reach = columns // 2

        # A skid buffer, so that `i.ready` is a register: much of the line store depends on it.
        spare       = Signal(ColumnWord(self.rows), reset_less=True)
        spare_valid = Signal()
        next_column = Signal(ColumnWord(self.rows))
        next_valid  = Signal()
        next_ready  = Signal()
        m.d.comb += [self.i.ready.eq(~spare_valid), next_column.eq(Mux(spare_valid, spare, self.i.p))]
        m.d.comb += next_valid.eq(spare_valid | self.i.valid)
        m.d.sync += spare_valid.eq(next_valid & ~next_ready)
        with m.If(~spare_valid):
            m.d.sync += spare.eq(self.i.p)

        # The window: its newest column is the rightmost. The columns to the right of its centre have yet to be output. A line's first
        # column fills it, its last one is repeated until the centre has reached it.
        window = [Signal(ColumnWord(self.rows), name=f"column_{n}", reset_less=True) for n in range(columns)]
        newest, centre = window[-1], window[reach]
        pending = Signal(reach + 1)          # columns yet to be output, from the centre (bit 0) to the newest
        closing = Signal(reach + 1, init=1)  # columns that are the last of their line; at the centre: the next one starts a line
        repeat  = Signal()                   # the line's last column is repeated
        ready   = Signal()
        output  = Signal()
        m.d.comb += [
            ready.eq(self.o.ready | ~self.o.valid),
            output.eq(pending[0] & ready),
            next_ready.eq(ready & ~repeat),
        ]
        with m.If(output):
            m.d.sync += pending[0].eq(0)
        moves = Signal()
        m.d.comb += moves.eq(ready & (next_valid | repeat))
        with m.If(moves):
            now_closing = Cat(closing[1:], ~repeat & next_column.last)
            m.d.sync += [pending.eq(Cat(pending[1:], ~repeat)), closing.eq(now_closing), repeat.eq(now_closing[1:].any())]
            m.d.sync += [column.eq(Mux(closing[0], next_column, later)) for column, later in pairwise(window)]
            with m.If(~repeat):
                m.d.sync += newest.eq(next_column)

        # Comparisons, straight into registers.
        limits = self._limits(m, moves, [*window[1:], next_column][reach], centre)
        first_row = (self.rows - self.config.refined.cost.census_rows) // 2
        names = line_names(self.rows)[first_row:self.rows - first_row]
        payload = data_register(m, self.o.payload)
        with m.If(self.o.ready):
            m.d.sync += self.o.valid.eq(0)
        with m.If(output):
            m.d.sync += [self.o.valid.eq(1), payload.below.eq(centre.below), *copy_flags(payload, centre)]
            for side, limit in limits.items():
                neighbours = [column[side][name] for name in names for column in window if not (name == "line" and column is centre)]
                m.d.sync += payload[f"{side}_census"].eq(Cat(pixel < limit for pixel in neighbours))
                m.d.sync += [payload[side][name].eq(centre[side][name]) for name in line_names(3)]
            if self.config.refined.census_above:
                m.d.sync += payload.above.eq(centre.left.minus2)
        return m


class BlindCensusStage(CensusStage):
    """A :class:`CensusStage` that is blind to small differences: a neighbour has a bit if it is darker by more than ``threshold``.

    Golden: :func:`golden.matcher.census.census` with that :attr:`golden.config.RecursiveCost.census_threshold`.

    Members
    -------
    threshold : In(3)
        Grey levels; sampled with the word marked ``first``.
    """
    settings: ClassVar = {"threshold": "census_threshold"}

    def __init__(self, config: MatcherConfig):
        super().__init__(config, threshold=In(3))

    def _limits(self, m: Module, moves: Value, following: data.View, centre: data.View) -> dict[str, Value]:
        held = Signal.like(self.threshold, reset_less=True)
        now = Mux(following.first, self.threshold, held)
        # Once for all neighbours, and a cycle ahead: of each sum with one of them there would be an adder in front of every comparison.
        limits: dict[str, Value] = {}
        for side in ("left", "right"):
            limits[side] = Signal(signed(PIXEL_BITS + 1), name=f"{side}_limit", reset_less=True)
            with m.If(moves):
                m.d.sync += limits[side].eq(following[side].line - now)
        with m.If(moves):
            m.d.sync += held.eq(now)
        return limits
