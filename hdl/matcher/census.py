"""Census of both pictures at every pixel."""

from itertools import pairwise

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.wiring import In, Out

from golden.config import Fused, MatcherConfig

from ..parts.delay import data_register
from .stage import Stage
from .stream import CensusWord, ColumnWord, copy_flags, line_names


__all__ = ["CensusStage"]


class CensusStage(Stage):
    """Census of the left and of the right picture at every pixel, beside the three lines around it.

    The golden model is :func:`golden.matcher.census.census`: a bit for each neighbour in the window, set where it is darker than the
    centre.

    Columns go through a window as wide as the census. A line's first column fills it, and its last one comes again until the line has
    left: pixels outside the picture repeat the nearest. The line store in front repeats lines and gives rectangular frames; this stage
    relies on them. A word marked ``below`` passes as any other; its census means nothing.

    Timing: a word leaves :attr:`latency` cycles after its own column came, if the next ones follow it at once and no line is before it.
    A line of ``W`` columns takes ``W + census_columns // 2`` cycles; its last words do not wait for the next line. ``o`` and ``i.ready``
    leave registers.

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

    def __init__(self, config: MatcherConfig):
        self.config = config
        method = config.method_as(Fused)
        self.rows = max(5 if method.vertical else 3, method.cost.census_rows)
        self.line_clocks = max(1, method.cost.census_columns // 2)
        super().__init__({
            "i": In(stream.Signature(ColumnWord(self.rows))),
            "o": Out(stream.Signature(CensusWord(config))),
        })

    @property
    def latency(self) -> int:
        """Cycles from a column to the census at it."""
        return 2 + self.config.method_as(Fused).cost.census_columns // 2

    def elaborate(self, platform: object) -> Module:
        m = Module()
        columns = self.config.method_as(Fused).cost.census_columns
        reach = columns // 2

        # A column that cannot go on waits here, so that `i.ready` comes from a register: the line store decides much by it.
        spare       = Signal(ColumnWord(self.rows), reset_less=True)
        spare_valid = Signal()
        come        = Signal(ColumnWord(self.rows))
        come_valid  = Signal()
        come_ready  = Signal()
        m.d.comb += [self.i.ready.eq(~spare_valid), come.eq(Mux(spare_valid, spare, self.i.p)), come_valid.eq(spare_valid | self.i.valid)]
        m.d.sync += spare_valid.eq(come_valid & ~come_ready)
        with m.If(~spare_valid):
            m.d.sync += spare.eq(self.i.p)

        # The window: its newest column is the rightmost. What it holds right of its centre has yet to leave.
        window = [Signal(ColumnWord(self.rows), name=f"column_{n}", reset_less=True) for n in range(columns)]
        newest, centre = window[-1], window[reach]
        waiting = Signal(reach + 1)          # the column has yet to leave: a bit for each from the centre (bit 0) to the newest
        closing = Signal(reach + 1, init=1)  # the column is the last of its line; at the centre: the next one begins a line
        repeat  = Signal()                   # the line's last column comes again
        ready   = Signal()
        leave   = Signal()
        m.d.comb += [
            ready.eq(self.o.ready | ~self.o.valid),
            leave.eq(waiting[0] & ready),
            come_ready.eq(ready & ~repeat),
        ]
        with m.If(leave):
            m.d.sync += waiting[0].eq(0)
        with m.If(ready & (come_valid | repeat)):
            now_closing = Cat(closing[1:], ~repeat & come.last)
            m.d.sync += [waiting.eq(Cat(waiting[1:], ~repeat)), closing.eq(now_closing), repeat.eq(now_closing[1:].any())]
            m.d.sync += [column.eq(Mux(closing[0], come, later)) for column, later in pairwise(window)]
            with m.If(~repeat):
                m.d.sync += newest.eq(come)

        # Comparisons, straight into registers.
        first_row = (self.rows - self.config.method_as(Fused).cost.census_rows) // 2
        names = line_names(self.rows)[first_row:self.rows - first_row]
        payload = data_register(m, self.o.payload)
        with m.If(self.o.ready):
            m.d.sync += self.o.valid.eq(0)
        with m.If(leave):
            m.d.sync += [self.o.valid.eq(1), payload.below.eq(centre.below), *copy_flags(payload, centre)]
            for side in ("left", "right"):
                neighbours = [column[side][name] for name in names for column in window if not (name == "line" and column is centre)]
                m.d.sync += payload[f"{side}_census"].eq(Cat(pixel < centre[side].line for pixel in neighbours))
                m.d.sync += [payload[side][name].eq(centre[side][name]) for name in line_names(3)]
            if self.config.method_as(Fused).vertical:
                m.d.sync += payload.above.eq(centre.left.minus2)
        return m
