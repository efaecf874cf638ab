"""The waves along the labels of the streaming engine, and their source."""

import contextlib
from functools import reduce
from operator import and_

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import IN_USE_BITS, PIXEL_BITS, MatcherConfig

from ...parts.delay import data_register
from ..settings import minimum_shape
from ..stage import CostArray
from ..stream import FLAGS


__all__ = ["ColumnSums", "Completion", "Issue", "Pixel", "VerticalWave", "Wave", "WaveSource", "column_sums"]


class ColumnSums(data.StructLayout):
    """A column of a picture as matching costs need it: its pixel, and that pixel's sums with the ones above and below it and with that of
    the wave before."""
    def __init__(self):
        super().__init__({"line": PIXEL_BITS, **dict.fromkeys(("above", "below", "across"), PIXEL_BITS + 1)})


def column_sums(m: Module, name: str, column: data.View, issue: Value, wave: data.View) -> None:
    """Registers with the :class:`ColumnSums` of ``column``, which drive ``wave``; added here once, and not in the cell of every label.

    ``issue``: a wave with this column is issued. ``name``: of the picture.
    """
    before = Signal(PIXEL_BITS, name=f"{name}_before", reset_less=True)
    with m.If(issue):
        m.d.sync += before.eq(column.line)
    others = {"line": 0, "above": column.minus, "below": column.plus, "across": before}
    m.d.sync += [data_register(m, wave[part], f"wave_{name}_{part}").eq(column.line + other) for part, other in others.items()]


class Wave(data.StructLayout):
    """A column at label ``d``: left at ``x``, right at ``x - d``; with the further fields that ``columns`` has of either side, which are
    those at ``x - 1``, as a wave completes the costs there.

    ``inside``: the right column lies in the picture; ``pre``: it is padding before a line. ``in_use``: labels in use, with
    or without ``valid``.
    """
    def __init__(self, config: MatcherConfig, columns: data.StructLayout):
        more = {name: field.shape for name, field in columns if name.startswith(("left_", "right_"))}
        super().__init__({
            "valid": 1, "pre": 1, "inside": 1, "left": ColumnSums(), "right": ColumnSums(), **more, "in_use": range(config.labels + 1),
        })


class Pixel(data.StructLayout):
    """A pixel's data apart from its costs: grey levels of it and of the pixel below it, which neighbours exist."""
    def __init__(self):
        super().__init__({"pixel": PIXEL_BITS, "lower": PIXEL_BITS, "has_upper": 1, "has_lower": 1, **FLAGS})


class Completion(data.StructLayout):
    """Effect of a wave beyond advancing by one column.

    ``clear``: a line begins, its sums start from 0. ``complete``: it completes a pixel, or is a flush cycle, which only advances
    pixels in flight. ``starts_line``: that pixel is the first of its line, or padding. ``in_picture``: it is no padding.

    With a lead only: ``leads``: it completes a column in front of its line, which has no pixel, but a pixel of the right picture.
    ``closes``: no more candidates of the line before follow.
    """
    def __init__(self, config: MatcherConfig):
        lead = {"leads": 1, "closes": 1} if config.lead else {}
        super().__init__({"clear": 1, "complete": 1, "starts_line": 1, "in_picture": 1, **lead})


class VerticalWave(data.StructLayout):
    """A wave's data for joining costs of neighbouring lines, in step with the costs of the pixel that it completes.

    ``column`` of the line, and ``write``: there is such a pixel, its costs are kept. ``above`` and ``below``: the neighbour of the pixel
    above it is alike, see :func:`golden.matcher.vertical.alike`.
    """
    def __init__(self, config: MatcherConfig):
        super().__init__({"column": range(config.max_width), "write": 1, "above": 1, "below": 1})


class Issue(data.StructLayout):
    """The word issued to an array of costs in a cycle.

    ``wave``: the column. ``completion``, and ``store``: the completed pixel's costs are kept. ``pixel`` with ``pixel_valid``: the pixel
    above it, which can now be labelled. ``vertical``: with costs of neighbouring lines joined.
    """
    def __init__(self, config: MatcherConfig, costs: type[CostArray]):
        joined = {} if costs.join_threshold_of(config) is None else {"vertical": VerticalWave(config)}
        super().__init__({"wave": Wave(config, costs.columns_of(config)), "completion": Completion(config), "store": 1, "pixel": Pixel(),
                          "pixel_valid": 1, **joined})


class WaveSource(wiring.Component):
    """Turns lines of columns into waves for the array of costs: one before each line, its columns, one past it; edge replication.

    The wave of column ``x`` completes pixel ``x - 1``. The word issued holds the data of both the array and the labelling:
    the pixel above it, which can now be labelled.

    An array may need pixels to the right of the one completed. Those of the next line serve as padding; where no line follows, or a line
    is too short, ``flush_waves`` flush cycles follow instead.

    With a lead the first columns of a line have no left pixel: their waves complete nothing but pixels of the right picture.

    Where costs of neighbouring lines are joined, all this is a line later: a wave completes the pixel above its column, and the one above
    that can be labelled.

    Timing: ``W + 2`` waves a line of ``W`` columns, one a cycle while ``go`` and ``i.valid``; ``o`` a cycle after the column was accepted.

    Members
    -------
    i : In(stream.Signature(costs.columns_of(config)))
    go : In(1)
    in_use : In(IN_USE_BITS)
        Labels in use; sampled before the first column of a frame.
    minimum : In(minimum_shape(config))
        Least disparity, pixels; if the array lists it among its settings, sampled likewise.
    o : Out(Issue(config, costs))
    lead_issued : Out(1)
        With a lead only: ``o`` completes a column of the lead of a line above which one can be labelled.
    """
    def __init__(self, config: MatcherConfig, costs: type[CostArray]):
        self.config = config
        self.flush_waves = costs.flush_waves_of(config)
        self.join_threshold = costs.join_threshold_of(config)
        self.shifts = "minimum" in costs.settings
        self.supports = bool(costs.size_max_of(config))
        super().__init__({
            "i": In(stream.Signature(costs.columns_of(config))),
            "go": In(1),
            "in_use": In(IN_USE_BITS),
            **({"minimum": In(minimum_shape(config))} if self.shifts else {}),
            **({"lead_issued": Out(1)} if config.lead else {}),
            "o": Out(Issue(config, costs)),
        })

    @property
    def flushed_width(self) -> int:
        """Lines of fewer pixels are followed by flush cycles: those of the next one are too few for the right picture's labels, and, with a
        lead, for a support."""
        return max(self.config.labels, self.flush_waves) if self.config.lead else self.config.labels

    @property
    def joins(self) -> bool:
        """Whether costs of neighbouring lines are joined."""
        return self.join_threshold is not None

    def elaborate(self, platform: object) -> Module:
        m = Module()
        before    = Signal.like(self.i.p, reset_less=True)  # the column whose pixel the next wave completes
        # One-hot counter of a frame's first lines; pixels without an upper neighbour start at its last state, before it none do.
        line = [Signal(name=f"line_{n}") for n in range(3 if self.joins else 2)]
        # The pixel that a wave completes is below the picture.
        beneath = Signal() if self.joins else before.below
        issue = Signal()
        pre   = Signal()
        past  = Signal()
        emit  = Signal()
        flush = Signal()
        now   = Signal.like(self.i.p)
        in_use = data_register(m, self.o.wave.in_use, "wave_in_use")
        m.d.comb += now.eq(self.i.p)
        least = Signal(minimum_shape(self.config), reset_less=True)
        lead = self.config.lead
        leads = Signal()  # a column of the lead is completed
        flush_follows, flush_ends, reached, in_lead = self._columns(m, issue, flush, before, least)

        with m.FSM():
            with m.State("before"):
                m.d.comb += [pre.eq(1), issue.eq(self.i.valid & self.go)]
                with m.If(issue):
                    m.d.sync += [at.eq(above) for at, above in zip(line, [self.i.p.first, *line])]
                    if self.joins:
                        m.d.sync += beneath.eq(before.below & ~self.i.p.first)
                    with m.If(self.i.p.first):
                        labels = self.config.labels
                        m.d.sync += in_use.eq(Mux(self.in_use > labels, labels, self.in_use))
                        if self.shifts:
                            m.d.sync += least.eq(self.minimum)
                    m.next = "first column"
            with m.State("first column"):
                m.d.comb += [issue.eq(self.i.valid & self.go), self.i.ready.eq(self.go)]
                if lead:
                    m.d.comb += leads.eq(in_lead != 0)
                with m.If(issue):
                    m.d.sync += before.eq(now)
                    with m.If(in_lead == lead) if lead else contextlib.nullcontext():
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
                m.d.comb += [now.eq(before), past.eq(1), issue.eq(self.go), emit.eq(1)]
                with m.If(issue):
                    m.next = "before"
                    if self.flush_waves:
                        with m.If(flush_follows):
                            m.next = "flush"
            if self.flush_waves:
                with m.State("flush"):
                    m.d.comb += [pre.eq(1), flush.eq(1), issue.eq(self.go)]
                    with m.If(issue & flush_ends):
                        m.next = "before"

        # The wave.
        o = self.o
        inside = ~pre & ~past & reached if self.shifts else ~pre
        more = {name: before[name] for name in o.wave.shape().members if name.startswith(("left_", "right_"))}
        waves = {"pre": pre, "inside": inside, **more}
        for side in ("left", "right"):
            column_sums(m, side, now[side], issue, o.wave[side])
        m.d.sync += [data_register(m, o.wave[field], f"wave_{field}").eq(value) for field, value in waves.items()]

        # The pixel completed, and the pixel that can be labelled.
        stored = [~beneath]
        completed, upper = before.left.line, before.left.minus
        if self.joins:
            stored.append(~line[0])
            completed, upper = before.left.minus, before.above
            self._vertical(m, issue, emit, before, ~line[0] & ~line[1])
        store = reduce(and_, stored, emit)
        labels = emit & ~Cat(line[:-1]).any()
        first  = Signal(init=1)  # the next pixel to be labelled is the first of its frame
        pixel  = data_register(m, o.pixel, "pixel")
        if self.supports:
            m.d.sync += pixel.lower.eq(completed)  # supports need every pixel that is completed
        with m.If(issue & labels):
            m.d.sync += [
                first.eq(before.end),
                pixel.pixel.eq(upper), pixel.lower.eq(completed),
                pixel.has_upper.eq(~line[-1]), pixel.has_lower.eq(~beneath),
                pixel.first.eq(first), pixel.last.eq(before.last), pixel.end.eq(before.end),
            ]
        begins = Signal()  # the next pixel to be completed is the first of its line
        with m.If(issue):
            m.d.sync += begins.eq(~emit)
        in_picture = store
        of_lead = {}
        if lead:
            in_picture = reduce(and_, stored, emit | leads)
            open_line = Signal()  # pixels of the line before may have further candidates
            with m.If(issue & (leads | emit | flush)):
                m.d.sync += open_line.eq((leads | emit) & ~past)
            of_lead = {"leads": (o.completion.leads, issue & leads), "closes": (o.completion.closes, flush | ~open_line),
                      "lead_issued": (self.lead_issued, issue & leads & ~Cat(line[:-1]).any())}
        control = {
            "valid": (o.wave.valid, issue), "store": (o.store, issue & store), "pixel_valid": (o.pixel_valid, issue & labels),
            "clear": (o.completion.clear, issue & pre & ~flush), "complete": (o.completion.complete, issue & (emit | flush)),
            "starts_line": (o.completion.starts_line, flush | begins), "in_picture": (o.completion.in_picture, in_picture), **of_lead,
        }
        for name, (port, value) in control.items():
            register = Signal(name=f"{name}_now")
            m.d.sync += register.eq(value)
            m.d.comb += port.eq(register)
        return m

    def _vertical(self, m, issue, emit, before, has_above):
        """Drives ``vertical``: which neighbours of the pixel above the array's line are alike."""
        threshold = self.join_threshold
        column = Signal(range(self.config.max_width))
        with m.If(issue):
            m.d.sync += column.eq(Mux(emit, column + 1, 0))

        def alike(other):
            difference = other - before.left.minus
            return (difference >= -threshold) & (difference <= threshold)

        vertical = Signal(self.o.vertical.shape())
        m.d.comb += self.o.vertical.eq(vertical)
        m.d.sync += [
            vertical.column.eq(column), vertical.write.eq(issue & emit),
            vertical.above.eq(alike(before.above) & has_above), vertical.below.eq(alike(before.left.line) & ~before.below),
        ]

    def _columns(self, m, issue, flush, before, least):
        """Counts columns up to the least disparity and up to :attr:`flushed_width`, and flush cycles.

        Returns
        -------
        flush_follows, flush_ends : Value
            The line needs a flush behind it; the flush ends with this cycle.
        reached : Value
            The column has a right one at label 0.
        in_lead : Value
            Columns of this line's lead before this one.
        """
        config = self.config
        if not self.shifts and not self.flush_waves:
            return Const(0), Const(0), Const(1), Const(0)
        waves = Signal(range(max(self.flush_waves, 1)))
        # Of the line, from its lead on; stays at its greatest value.
        column = Signal(range(-config.lead, max(config.MINIMUMS[-1], config.labels) + 1), init=-config.lead)
        accepted = self.i.valid & self.i.ready
        flush_ends = waves == self.flush_waves - 1
        with m.If(issue & flush):
            m.d.sync += waves.eq(Mux(flush_ends, 0, waves + 1))
        greatest = column == (1 << len(column) - 1) - 1 if config.lead else column.all()
        with m.If(accepted & ~greatest):
            m.d.sync += column.eq(column + 1)
        with m.If(issue & ~accepted):
            m.d.sync += column.eq(-config.lead)
        return (column < self.flushed_width) | before.end, flush_ends, column >= least, column + config.lead if config.lead else Const(0)
