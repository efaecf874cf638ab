"""Turns lines of columns into waves for the array, and the steps in which the costs of the line above are read."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import IN_USE_BITS, PIXEL_BITS, MatcherConfig, Recursive

from ...parts.delay import data_register
from ..settings import minimum_shape
from ..stream import FLAGS, CensusWord
from ..streaming.waves import Completion, Wave, column_sums


__all__ = ["SLOTS", "Entry", "RecursiveSource", "Step"]


#: With costs from below, words of the rings between the two halves of the array, one a step: as many as a memory block has of 36 bits.
SLOTS = 256


class Entry(data.StructLayout):
    """Effect of a wave on the costs of its line and of the line above.

    ``write``: the costs in ``column`` are kept; ``below``: the pixel there is like the one above it.

    With costs from below only: ``tick``: there is a step, in the ring place ``slot``. ``upper_below``: the pixel above is like the one two
    lines above. ``completion``: of the pixel above, whose mean is carried up; ``grey``: of that pixel.
    """
    def __init__(self, config: MatcherConfig):
        below = {"tick": 1, "slot": range(SLOTS), "upper_below": 1, "completion": Completion(config), "grey": PIXEL_BITS} \
            if config.method_as(Recursive).propagation.from_below else {}
        super().__init__({"column": range(config.max_width), "write": 1, "below": 1, **below})


class Step(data.StructLayout):
    """Effect of a wave on the pixel that it completes, and on what is read of the line above that one.

    ``advance``: the taps on the line above advance by a column; ``ahead``: the column of that line that enters them. ``completion``: of the
    pixel in ``column``. ``opens``: the first column; ``edge``: so near to the left border that the left tap is replicated. ``has_above``:
    there is a line above the pixel's. ``grey``: of the pixel, with its flags.

    With costs from below only: its ``slot``; ``has_below``: there is a pixel below it, which there is not in a lead; ``lower_grey``: of
    that one.
    """
    def __init__(self, config: MatcherConfig):
        column = range(config.max_width)
        below = {"slot": range(SLOTS), "has_below": 1, "lower_grey": PIXEL_BITS} \
            if config.method_as(Recursive).propagation.from_below else {}
        super().__init__({
            "advance": 1, "ahead": column, "completion": Completion(config), "column": column, "opens": 1, "edge": 1, "has_above": 1,
            "grey": PIXEL_BITS, **below, **FLAGS,
        })


class RecursiveSource(wiring.Component):
    """Lines of columns as waves: one before each line, its columns, one past it; edge replication.

    The wave of column ``x`` completes pixel ``x - 1`` of the line above it, whose costs need those of the line below; with costs from
    below, which need one line more, that of the line above that one. In front of each line, ``fan`` steps read the first columns of the
    line above the one completed.

    With a lead the first columns of a line have no left pixel: their waves complete padding, and a pixel of the right picture each.

    Supports, and labels of the right picture, need pixels to the right of the one completed. Those of the next line serve as padding; where
    no line follows, ``flush_waves`` flush cycles do instead. They also follow a line of fewer pixels than :attr:`flushed_width`: the costs
    of its first pixels are needed by the next line before they would be there.

    Timing: ``W + fan + 2`` cycles a line of ``W`` columns, those of the lead among them, while ``go`` and ``i.valid``; ``wave``, ``entry``
    and ``o`` a cycle after the column was accepted.

    Parameters
    ----------
    config : MatcherConfig
    flush_waves : int
        Cycles.

    Members
    -------
    i : In(stream.Signature(CensusWord(config)))
        With one line below the picture, or two with costs from below.
    go : In(1)
        A pixel may be completed.
    hold : In(1)
        No line may start whose pixels need costs from another one.
    in_use : In(IN_USE_BITS)
        Labels in use; sampled before the first column of a frame.
    minimum : In(minimum_shape(config))
        Least disparity, pixels; sampled likewise.
    wave : Out(Wave(config, CensusWord(config)))
    entry : Out(Entry(config))
    o : Out(Step(config))
    starts_frame : Out(1)
        In front of a frame: settings are to be sampled.
    """
    def __init__(self, config: MatcherConfig, flush_waves: int):
        self.config = config
        self.flush_waves = flush_waves
        super().__init__({
            "i": In(stream.Signature(CensusWord(config))), "go": In(1), "hold": In(1),
            "in_use": In(IN_USE_BITS), "minimum": In(minimum_shape(config)),
            "wave": Out(Wave(config, CensusWord(config))), "entry": Out(Entry(config)), "o": Out(Step(config)), "starts_frame": Out(1),
        })

    @property
    def flushed_width(self) -> int:
        """Lines of fewer pixels are followed by flush cycles."""
        return self.flush_waves

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        method = config.method_as(Recursive)
        fan, threshold = method.propagation.fan, method.line_below.lower_threshold
        from_below = method.propagation.from_below
        before = Signal.like(self.i.p, reset_less=True)   # the column whose pixel the next wave completes
        now    = Signal.like(self.i.p)
        top    = Signal()                                 # the frame's first line: it completes nothing
        second = Signal()
        third  = Signal()
        below  = Signal()                                 # the line before is not in the picture
        lead   = config.lead
        column = Signal(range(max(config.max_width, self.flushed_width) + lead + 1))  # columns of this line that have been accepted
        width  = Signal(range(config.max_width))          # of this frame, less one
        ahead  = Signal(range(config.max_width))
        cycles = Signal(range(max(self.flush_waves, fan)))
        least  = Signal(range(config.MINIMUMS.stop + lead), reset_less=True)          # columns before the right picture's at label 0
        reached = Signal()                                # the right picture has a column at label 0
        issue, pre, past, emit, preroll, flush = (Signal(name=name) for name in ("issue", "pre", "past", "emit", "preroll", "flush"))
        in_use = data_register(m, self.wave.in_use, "wave_in_use")
        m.d.comb += [now.eq(self.i.p), reached.eq(column >= least)]

        with m.FSM():
            with m.State("before"):
                m.d.comb += [pre.eq(1), issue.eq(self.i.valid & self.go & (~self.hold | self.i.p.first | top))]
                with m.If(issue):
                    m.d.sync += [
                        top.eq(self.i.p.first), second.eq(top & ~self.i.p.first), third.eq(second & ~self.i.p.first),
                        below.eq(before.below & ~self.i.p.first), column.eq(0), ahead.eq(0),
                    ]
                    with m.If(self.i.p.first):
                        m.d.comb += self.starts_frame.eq(1)
                        m.d.sync += [in_use.eq(Mux(self.in_use > config.labels, config.labels, self.in_use)), least.eq(self.minimum + lead)]
                    m.next = "fan"
            with m.State("fan"):
                m.d.comb += preroll.eq(1)
                m.d.sync += cycles.eq(cycles + 1)
                with m.If(cycles == fan - 1):
                    m.d.sync += cycles.eq(0)
                    m.next = "columns"
            with m.State("columns"):
                m.d.comb += [issue.eq(self.i.valid & self.go), self.i.ready.eq(self.go), emit.eq(column != 0)]
                with m.If(issue):
                    m.d.sync += [before.eq(now), column.eq(column + 1)]
                    with m.If(now.last):
                        m.next = "past"
                        with m.If(top):
                            m.d.sync += width.eq(column - lead)
            with m.State("past"):
                m.d.comb += [now.eq(before), past.eq(1), issue.eq(self.go), emit.eq(1)]
                with m.If(issue):
                    m.next = "before"
                    with m.If((column < self.flushed_width + lead) | before.end):
                        m.next = "flush"
            with m.State("flush"):
                m.d.comb += [pre.eq(1), flush.eq(1), issue.eq(self.go)]
                with m.If(issue):
                    m.d.sync += cycles.eq(cycles + 1)
                    with m.If(cycles == self.flush_waves - 1):
                        m.d.sync += cycles.eq(0)
                        m.next = "before"

        # The wave.
        wave = self.wave
        more = {name: before[name] for name in wave.shape().members if name.startswith(("left_", "right_"))}
        for side in ("left", "right"):
            column_sums(m, side, now[side], issue & ~flush, wave[side])
        parts = {"pre": pre, "inside": ~pre & ~past & reached, **more}
        m.d.sync += [data_register(m, wave[field], f"wave_{field}").eq(value) for field, value in parts.items()]
        valid = Signal(name="wave_valid_now")
        m.d.comb += wave.valid.eq(valid)
        m.d.sync += valid.eq(issue & ~flush)

        # Grey levels: `minus` is the line above that of the wave, `above` that above it.
        def alike(upper: Value, lower: Value) -> Value:
            difference = lower - upper
            return (difference >= -threshold) & (difference <= threshold)

        place  = Signal(range(config.max_width))  # of the pixel that is completed next
        pixel  = emit & (column > lead)           # not a column of the lead
        leads  = emit & (column <= lead) & ~past
        tick   = issue | preroll
        first, active = (third, ~top & ~second) if from_below else (second, ~top)   # the first line completed, and from it on
        completes = pixel & active
        with m.If(issue & pixel | preroll):
            m.d.sync += ahead.eq(ahead + (ahead != width))
        with m.If(issue):
            m.d.sync += place.eq(Mux(pixel, place + 1, 0))
        entry, step = Signal(Entry(config)), Signal(Step(config))
        m.d.comb += [self.entry.eq(entry), self.o.eq(step)]
        m.d.sync += [
            entry.column.eq(place), entry.write.eq(issue & pixel),
            entry.below.eq(alike(before.left.minus, before.left.line) & ~before.below),
            step.advance.eq(issue & pixel | preroll), step.ahead.eq(ahead), step.column.eq(place), step.opens.eq(place == 0),
            step.edge.eq(place < fan), step.has_above.eq(~first), step.grey.eq(before.above if from_below else before.left.minus),
            step.first.eq(first & (place == 0)), step.last.eq(before.last), step.end.eq(before.end),
            step.completion.clear.eq(issue & pre & ~flush), step.completion.complete.eq(issue & (completes | leads & active | flush)),
            step.completion.starts_line.eq(flush | (place == 0)), step.completion.in_picture.eq(issue & completes),
        ]
        if lead:
            m.d.sync += [step.completion.leads.eq(issue & leads & active), step.completion.closes.eq(flush | (column == 1))]
        if from_below:
            slot = Signal(range(SLOTS))
            m.d.sync += [
                slot.eq(slot + tick), entry.tick.eq(tick), entry.slot.eq(slot), entry.grey.eq(before.left.minus),
                entry.upper_below.eq(alike(before.above, before.left.minus) & ~below),
                entry.completion.clear.eq(issue & pre & ~flush),
                entry.completion.complete.eq(issue & (pixel & ~top | leads & ~top | flush)),
                entry.completion.starts_line.eq(flush | (place == 0) | below),
                entry.completion.in_picture.eq(issue & pixel & ~top & ~below),
                step.slot.eq(slot), step.has_below.eq(~below & ~leads if lead else ~below), step.lower_grey.eq(before.left.minus),
            ]
        return m
