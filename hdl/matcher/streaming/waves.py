"""What travels along the labels of the streaming engine, and where it starts: columns become waves."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import IN_USE_BITS, MINIMUM_BITS, PIXEL_BITS, Fused, MatcherConfig

from ...parts.delay import data_register
from ..stream import FLAGS, CensusWord, Column, ColumnWord


__all__ = ["BecWave", "Completion", "Pixel", "VerticalWave", "WaveSource"]


class BecWave(data.StructLayout):
    """A column on its way along the labels: left at ``x``, right at ``x - d``; with the cost ``FUSED`` the census of both.

    ``inside``: the right column is one; ``pre``: it is no column, but stands before a line. ``in_use``: labels in use, with or without
    ``valid``.
    """
    def __init__(self, config: MatcherConfig):
        census = dict.fromkeys(("left_census", "right_census"), config.method.cost.neighbours) if isinstance(config.method, Fused) else {}
        super().__init__({
            "valid": 1, "pre": 1, "inside": 1, "left": Column(), "right": Column(), **census, "in_use": range(config.labels + 1),
        })


class Pixel(data.StructLayout):
    """What the engine must know of a pixel beside its costs: grey levels of it and of the pixel below it, which neighbours exist."""
    def __init__(self):
        super().__init__({"pixel": PIXEL_BITS, "lower": PIXEL_BITS, "has_upper": 1, "has_lower": 1, **FLAGS})


class Completion(data.StructLayout):
    """What a wave does to the cost ``FUSED`` beside moving a column on.

    ``clear``: a line begins, its sums start from 0. ``complete``: it completes a pixel, or nothing but moves on what waits for pixels to
    be completed. ``fresh``: that pixel is the first of its line, or there is none. ``real``: it is one of the picture.
    """
    def __init__(self):
        super().__init__({"clear": 1, "complete": 1, "fresh": 1, "real": 1})


class VerticalWave(data.StructLayout):
    """What vertical support must know of a wave, as the costs of the pixel come that it completes in BEC's line.

    ``column`` of the line, and ``write``: there is such a pixel, its costs are kept. ``above`` and ``below``: the neighbour of the pixel
    above it is alike, see :func:`golden.matcher.vertical.alike`.
    """
    def __init__(self, config: MatcherConfig):
        super().__init__({"column": range(config.max_width), "write": 1, "above": 1, "below": 1})


class WaveSource(wiring.Component):
    """Turns lines of columns into waves for the array of costs: one before each line, its columns, one past it; edges repeat.

    The wave of column ``x`` completes pixel ``x - 1``. For it goes out, in the same cycle, what concerns the array (``store``: its costs
    go to memory) and what concerns the labelling: the pixel above it (``pixel_valid``), which has now all it needs.

    With the cost ``FUSED`` a support needs pixels to the right of its own, and a label of the right picture ``D`` of them. The next
    line's pixels will do, for none of them counts; where no line follows, or it would be too short for the right picture's labels to be
    ready in time, :attr:`flush_waves` waves without a pixel follow instead.

    With vertical support the array's costs are joined a line later: what a wave completes is the pixel above its own, what it lets label
    the one above that.

    Timing: ``W + 2`` waves a line, one a cycle while ``go`` and columns come.

    Members
    -------
    i : In(stream.Signature(ColumnWord())), or of CensusWord(config) with the cost ``FUSED``
    go : In(1)
    in_use : In(IN_USE_BITS)
        Labels in use; sampled before the first column of a frame.
    minimum : In(MINIMUM_BITS)
        Least disparity, pixels; cost ``FUSED`` only, sampled likewise.
    wave : Out(BecWave(config))
    store : Out(1)
    pixel : Out(Pixel()), pixel_valid : Out(1)
    completion : Out(Completion())
        Cost ``FUSED`` only.
    vertical : Out(VerticalWave(config))
        With vertical support only.
    """
    def __init__(self, config: MatcherConfig):
        self.config = config
        self.fused = isinstance(config.method, Fused)
        self.vertical_support = (isinstance(config.method, Fused) and config.method.vertical)
        more = {"minimum": In(MINIMUM_BITS), "completion": Out(Completion())} if self.fused else {}
        if self.vertical_support:
            more["vertical"] = Out(VerticalWave(config))
        super().__init__({
            "i": In(stream.Signature(CensusWord(config) if self.fused else ColumnWord())),
            "go": In(1),
            "in_use": In(IN_USE_BITS),
            "wave": Out(BecWave(config)),
            "store": Out(1),
            "pixel": Out(Pixel()),
            "pixel_valid": Out(1),
            **more,
        })

    @property
    def flush_waves(self):
        """Waves without a pixel that follow a frame, or a line of less than ``D`` pixels."""
        return max(self.config.labels, self.config.method_as(Fused).arms.reach + 1) if self.fused else 0

    def elaborate(self, platform):
        m = Module()
        before    = Signal.like(self.i.p, reset_less=True)  # the column whose pixel the next wave completes
        # BEC's line, of the first ones: the last of these lets pixels be labelled that have no upper neighbour, those before it let none.
        line = [Signal(name=f"line_{n}") for n in range(3 if self.vertical_support else 2)]
        # What a wave completes is below the picture.
        beneath = Signal() if self.vertical_support else before.below
        issue = Signal()
        pre   = Signal()
        past  = Signal()
        emit  = Signal()
        now   = Signal.like(self.i.p)
        in_use = data_register(m, self.wave.in_use, "wave_in_use")
        m.d.comb += now.eq(self.i.p)
        flush = self._flush(m, issue, before) if self.fused else None

        with m.FSM():
            with m.State("before"):
                m.d.comb += [pre.eq(1), issue.eq(self.i.valid & self.go)]
                with m.If(issue):
                    m.d.sync += [at.eq(above) for at, above in zip(line, [self.i.p.first, *line])]
                    if self.vertical_support:
                        m.d.sync += beneath.eq(before.below & ~self.i.p.first)
                    with m.If(self.i.p.first):
                        labels = self.config.labels
                        m.d.sync += in_use.eq(Mux(self.in_use > labels, labels, self.in_use))
                        if self.fused:
                            m.d.sync += self.least.eq(self.minimum)
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
                m.d.comb += [now.eq(before), past.eq(1), issue.eq(self.go), emit.eq(1)]
                with m.If(issue):
                    m.next = "before"
                    if self.fused:
                        with m.If(self.flush_follows):
                            m.next = "flush"
            if self.fused:
                with m.State("flush"):
                    m.d.comb += [pre.eq(1), flush.eq(1), issue.eq(self.go)]
                    with m.If(issue & self.flush_ends):
                        m.next = "before"

        first = Signal(init=1)  # the next pixel to be labelled is the first of its frame
        waves = [("pre", pre), ("left", now.left), ("right", now.right)]
        if self.fused:
            waves += [("inside", ~pre & ~past & self.reached), ("left_census", now.left_census), ("right_census", now.right_census)]
        else:
            waves += [("inside", ~pre)]
        m.d.sync += [data_register(m, self.wave[field], f"wave_{field}").eq(value) for field, value in waves]
        pixel = data_register(m, self.pixel)
        store = emit & ~beneath
        own, upper = before.left.line, before.left.minus
        if self.vertical_support:
            store &= ~line[0]
            own, upper = before.left.minus, before.above
            self._vertical(m, issue, emit, before, ~line[0] & ~line[1])
        labels = emit & ~Cat(line[:-1]).any()
        m.d.sync += [
            self.wave.valid.eq(issue),
            self.store.eq(issue & store),
            self.pixel_valid.eq(issue & labels),
        ]
        if self.fused:
            # The arms need the grey level of every pixel that is completed.
            m.d.sync += pixel.lower.eq(own)
        with m.If(issue & labels):
            m.d.sync += [
                first.eq(before.end),
                pixel.pixel.eq(upper), pixel.lower.eq(own),
                pixel.has_upper.eq(~line[-1]), pixel.has_lower.eq(~beneath),
                pixel.first.eq(first), pixel.last.eq(before.last), pixel.end.eq(before.end),
            ]
        if self.fused:
            begins = Signal()  # the next pixel to be completed is the first of its line
            with m.If(issue):
                m.d.sync += begins.eq(~emit)
            m.d.sync += self.completion.eq(Cat(issue & pre & ~flush, issue & (emit | flush), flush | begins, store))
        return m

    def _vertical(self, m, issue, emit, before, has_above):
        """Tells which neighbours of the pixel above the array's line are like it."""
        threshold = self.config.method_as(Fused).vertical.vertical_threshold
        column = Signal(range(self.config.max_width))
        with m.If(issue):
            m.d.sync += column.eq(Mux(emit, column + 1, 0))

        def alike(other):
            difference = other - before.left.minus
            return (difference >= -threshold) & (difference <= threshold)

        m.d.sync += [
            self.vertical.column.eq(column), self.vertical.write.eq(issue & emit),
            self.vertical.above.eq(alike(before.above) & has_above), self.vertical.below.eq(alike(before.left.line) & ~before.below),
        ]

    def _flush(self, m, issue, before):
        """Counts waves that only move on what waits, and columns up to the least disparity and up to ``D``."""
        config = self.config
        flush = Signal()
        self.least = Signal(MINIMUM_BITS, reset_less=True)
        self.reached = Signal()        # the column has a right one at label 0
        self.flush_follows = Signal()
        self.flush_ends = Signal()
        waves = Signal(range(self.flush_waves))
        column = Signal(range(max(config.MINIMUMS[-1], config.labels) + 1))  # of the line; stays at its greatest value
        taken = self.i.valid & self.i.ready
        m.d.comb += [
            self.reached.eq(column >= self.least),
            self.flush_follows.eq((column < config.labels) | before.end),
            self.flush_ends.eq(waves == self.flush_waves - 1),
        ]
        with m.If(issue & flush):
            m.d.sync += waves.eq(Mux(self.flush_ends, 0, waves + 1))
        with m.If(taken & ~column.all()):
            m.d.sync += column.eq(column + 1)
        with m.If(issue & ~taken):
            m.d.sync += column.eq(0)
        return flush
