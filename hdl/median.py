"""The median of the labels, and what leaves the refinement: disparities with their confidence."""

from amaranth import *
from amaranth.hdl import Mux
from amaranth.lib import data, stream, wiring
from amaranth.lib.fifo import SyncFIFOBuffered
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.confidence import WINDOW
from golden.config import MINIMUM_BITS, MatcherConfig

from .confidence import Confidence, VoteColumn
from .delay import Delay, StreamRegister, data_register
from .selection import Selection, merge, select, sort
from .stream import FLAGS, DisparityWord, LabelWord, copy_flags


__all__ = ["LabelColumns", "Median", "MedianColumns", "SlotWord"]


REACH = WINDOW // 2


class SlotWord(data.StructLayout):
    """A column of labels and what concerns the pixel two columns before it, whose window it completes if ``shown``: its frame flags.

    ``opens``: first column of its line. ``enable`` and ``minimum`` are those of the frame.
    """
    def __init__(self, config: MatcherConfig):
        super().__init__({"column": VoteColumn(config), "opens": 1, "shown": 1, "enable": 1, "minimum": MINIMUM_BITS, **FLAGS})


class LabelColumns(wiring.Component):
    """Turns lines of labels into columns of five lines for the windows of the line two above; lines outside the picture repeat.

    Two columns follow each line, which repeat its last, and two lines each frame, which repeat its last; none waits for what comes next.
    The first line fills all four line memories.

    Timing: ``W + 2`` columns a line, ``H + 2`` lines a frame, one a cycle while ``go`` and labels come; a column :attr:`LATENCY` cycles
    after its label was taken.

    Memory: ``max_width`` words of four labels, four bits and two sizes.

    Parameters
    ----------
    config : :class:`MatcherConfig`

    Members
    -------
    i : In(stream.Signature(LabelWord(config)))
    enable : In(1), minimum : In(8)
        Sampled with the word marked ``first`` as it is taken.
    go : In(1)
    coming : Out(1)
        A column that is ``shown`` has been started: it is sure to come.
    o : Out(SlotWord(config)), valid : Out(1)
    """
    LATENCY = 2

    def __init__(self, config: MatcherConfig):
        self.config = config
        super().__init__({
            "i": In(stream.Signature(LabelWord(config))),
            "enable": In(1),
            "minimum": In(MINIMUM_BITS),
            "go": In(1),
            "coming": Out(1),
            "o": Out(SlotWord(config)),
            "valid": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        config = self.config
        label, size = self.i.p.label, self.i.p.size

        # What is started in this cycle.
        x       = Signal(range(config.max_width))
        width   = Signal.like(x)              # of this frame, less one
        columns = Signal(range(REACH + 1))    # of this line before this one, and
        lines   = Signal(range(REACH + 1))    # lines of this frame before this one; both stop at two
        past    = Signal(range(REACH + 2))    # the picture's last line is 1, those below it follow; before it 0
        fresh   = Signal()                    # no pixel of this frame has been shown
        again   = Signal(range(REACH))        # number of the column that repeats the line's last
        start   = Signal()
        below   = Signal()
        repeats = Signal()
        closes  = Signal()                    # the line
        shown   = Signal()
        enable  = Signal(reset_less=True)
        minimum = Signal(MINIMUM_BITS, reset_less=True)
        with m.FSM():
            with m.State("line"):
                m.d.comb += [self.i.ready.eq(self.go), start.eq(self.go & self.i.valid)]
                with m.If(start):
                    m.d.sync += x.eq(x + 1)
                    with m.If(self.i.p.first):
                        m.d.sync += [enable.eq(self.enable), minimum.eq(self.minimum), fresh.eq(1)]
                    with m.If(self.i.p.last):
                        m.d.sync += [width.eq(x), x.eq(0), past.eq(self.i.p.end)]
                        m.next = "repeats"
            with m.State("line below"):
                m.d.comb += [start.eq(self.go), below.eq(1)]
                with m.If(start):
                    m.d.sync += x.eq(x + 1)
                    with m.If(x == width):
                        m.d.sync += x.eq(0)
                        m.next = "repeats"
            with m.State("repeats"):
                m.d.comb += [start.eq(self.go), repeats.eq(1), closes.eq(again == REACH - 1)]
                with m.If(start):
                    m.d.sync += again.eq(again + 1)
                    with m.If(closes):
                        m.d.sync += again.eq(0)
                        with m.If(past == 0):
                            m.next = "line"
                        with m.Elif(past == REACH + 1):
                            m.d.sync += past.eq(0)
                            m.next = "line"
                        with m.Else():
                            m.d.sync += past.eq(past + 1)
                            m.next = "line below"
        ends = past == REACH + 1
        m.d.comb += [shown.eq((columns == REACH) & (lines == REACH)), self.coming.eq(start & shown)]
        with m.If(start):
            with m.If(shown):
                m.d.sync += fresh.eq(0)
            with m.If(closes):
                m.d.sync += [columns.eq(0), lines.eq(Mux(ends, 0, Mux(lines == REACH, REACH, lines + 1)))]
            with m.Elif(columns != REACH):
                m.d.sync += columns.eq(columns + 1)

        # The memory gives the lines above the one that comes; below the picture that repeats the last.
        stored = data.StructLayout({"label": data.ArrayLayout(label.shape(), WINDOW - 1), "passed": WINDOW - 1,
                                    "size": data.ArrayLayout(size.shape(), REACH)})
        m.submodules.memory = memory = Memory(shape=stored, depth=config.max_width, init=[])
        read = memory.read_port()
        write = memory.write_port()
        m.d.comb += [read.addr.eq(x), read.en.eq(start & ~repeats)]

        started     = Signal()
        new         = Signal()
        new_pixel   = Signal(LabelWord(config), reset_less=True)
        new_x       = Signal.like(x, reset_less=True)
        new_top     = Signal(reset_less=True)
        new_below   = Signal(reset_less=True)
        given       = Signal(SlotWord(config), reset_less=True)
        m.d.sync += [
            started.eq(start), new.eq(start & ~repeats), new_pixel.eq(self.i.p), new_x.eq(x), new_top.eq(lines == 0), new_below.eq(below),
            given.opens.eq(columns == 0), given.shown.eq(shown), given.first.eq(fresh), given.last.eq(closes), given.end.eq(closes & ends),
        ]
        above  = read.data
        newest = Mux(new_below, above.label[-1], new_pixel.label)
        newest_passed = Mux(new_below, above.passed[-1], new_pixel.passed)

        # The column, which is then written back a line higher. One that repeats stays; only what it is for changes.
        word   = data_register(m, self.o)
        sizes  = Signal(data.ArrayLayout(size.shape(), REACH), reset_less=True)
        column = word.column
        kept   = Signal()
        kept_x = Signal.like(x, reset_less=True)
        m.d.sync += [
            self.valid.eq(started), kept.eq(new), kept_x.eq(new_x), word.enable.eq(enable), word.minimum.eq(minimum),
            *(word[name].eq(given[name]) for name in ("opens", "shown", *FLAGS)),
        ]
        with m.If(new):
            m.d.sync += [
                *(line.eq(Mux(new_top, newest, old)) for line, old in zip(column.label, above.label)), column.label[-1].eq(newest),
                column.passed.eq(Cat(Mux(new_top, newest_passed.replicate(WINDOW - 1), above.passed), newest_passed)),
                column.size.eq(above.size[0]), Cat(sizes).eq(Cat(*above.size[1:], new_pixel.size)),
            ]
        m.d.comb += [
            write.addr.eq(kept_x), write.en.eq(kept), write.data.passed.eq(column.passed[1:]), write.data.size.eq(sizes),
            *(line.eq(lower) for line, lower in zip(write.data.label, column.label[1:])),
        ]
        return m


class MedianColumns(wiring.Component):
    """Median of the window of ``config.fused.median`` columns and lines around the pixel two columns before the one that comes.

    Golden: :func:`golden.refine.median`. Each column is sorted once, each pair of neighbours merged once: a window of five is a pair, the
    pair before the one before it and the newest column; a window of three is a pair and the newest column but one.

    Timing: a column a cycle at most; :attr:`latency` cycles.

    Parameters
    ----------
    config : :class:`MatcherConfig`

    Members
    -------
    i : In(data.ArrayLayout(labels, 5))
        Topmost line first.
    valid : In(1)
        A column comes.
    opens : In(1)
        It is the first of its line, and stands for those to the left of the picture too.
    o : Out(labels), done : Out(1)
    """
    def __init__(self, config: MatcherConfig):
        self.config = config
        self.shape = shape = LabelWord(config)["label"].shape
        self.side = side = config.fused.median

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
    def latency(self):
        """Cycles: four networks and the register between columns and pairs."""
        return self.sort.latency + 1 + self.pair.latency + (self.pairs.latency if self.pairs else 0) + self.select.latency

    def elaborate(self, platform):
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
            m.d.sync += [Value.cast(newer).eq(self.sort.o), Value.cast(older).eq(Mux(opens[now], self.sort.o, newer))]
        m.d.comb += self.pair.i.eq(Cat(older, newer))

        # Pairs as they come, and those before them; before a line's first there is only itself.
        paired = now + 1 + self.pair.latency
        before = [Signal(self.pair.o.shape(), name=f"pair_before_{n}", reset_less=True) for n in (1, 2, 3)]
        first  = Signal(reset_less=True)  # the one before is its line's first
        with m.If(valid[paired]):
            m.d.sync += [
                first.eq(opens[paired]), Value.cast(before[0]).eq(self.pair.o), Value.cast(before[1]).eq(before[0]),
                Value.cast(before[2]).eq(Mux(first, before[0], before[1])),
            ]
        candidates, alone = before[1], newer
        if self.pairs:
            m.submodules.pairs = pairs = self.pairs
            m.d.comb += Value.cast(pairs.i).eq(Cat(before[0], before[2]))
            candidates, alone = pairs.o, self.sort.o

        # The column that the pairs leave out comes last.
        m.submodules.alone = alone_delay = Delay(column, self.latency - self.select.latency - now)
        m.d.comb += [
            Value.cast(alone_delay.i).eq(alone), Value.cast(self.select.i).eq(Cat(candidates, alone_delay.o)), self.o.eq(self.select.o[0]),
        ]
        return m


def contenders(order, side):
    """Of wires sorted from the least value to the greatest, those that may be the median when all the window's other values come."""
    middle = side * side // 2
    later = side * side - len(order)
    return order[max(middle - later, 0):middle + 1]


class Median(wiring.Component):
    """Median of labels, and with it disparity and confidence of a pixel: what leaves the refinement.

    Golden: :func:`golden.refine.median`, then ``disparity = label + minimum * config.disparity_scale``, and
    :func:`golden.confidence.confidence` of the label among those that came.

    Frames are rectangular, closed by ``end`` and at most ``max_width`` wide; each may have a size of its own.

    Timing: a pixel a cycle, :attr:`LINE_CLOCKS` cycles more a line, :attr:`FRAME_LINES` lines more a frame: during them nothing is taken,
    for the last lines leave without waiting for the next frame. If nothing waits, a pixel is offered :attr:`LINES` lines of
    ``W + LINE_CLOCKS`` cycles and :attr:`latency` cycles after it was taken. The pipeline never stops: a column enters only while the
    output queue has room for all that are on their way. ``i.ready`` comes from registers, ``o`` leaves one.

    Memory: that of :class:`LabelColumns`; a column, a sorted column and a result for the time that networks and votes take; an output
    queue of :attr:`latency` words.

    Parameters
    ----------
    config : :class:`MatcherConfig`
        Of the cost ``FUSED``.

    Members
    -------
    i : In(stream.Signature(LabelWord(config)))
    o : Out(stream.Signature(DisparityWord(config)))
    enable : In(1)
        Off: labels leave unchanged, as late.
    minimum : In(8)
        Disparity of the label 0, pixels. Both are sampled with the word marked ``first`` as it is taken.
    """
    LINES = FRAME_LINES = REACH
    LINE_CLOCKS = REACH

    def __init__(self, config: MatcherConfig):
        self.config = config
        self.columns = LabelColumns(config)
        self.median = MedianColumns(config)
        self.confidence = Confidence(config)
        super().__init__({
            "i": In(stream.Signature(LabelWord(config))),
            "o": Out(stream.Signature(DisparityWord(config))),
            "enable": In(1),
            "minimum": In(MINIMUM_BITS),
        })

    @property
    def pipeline(self):
        """Cycles from a label to the disparity that its column completes."""
        return LabelColumns.LATENCY + self.median.latency + self.confidence.latency

    @property
    def latency(self):
        """Cycles beyond :attr:`LINES` lines from a pixel to its disparity, if nothing waits."""
        return REACH + self.pipeline + 2 + StreamRegister.LATENCY

    def elaborate(self, platform):
        m = Module()
        config = self.config
        m.submodules.columns, m.submodules.median, m.submodules.confidence = self.columns, self.median, self.confidence
        columns, median, confidence = self.columns, self.median, self.confidence
        wiring.connect(m, wiring.flipped(self.i), columns.i)
        m.d.comb += [
            columns.enable.eq(self.enable), columns.minimum.eq(self.minimum),
            median.i.eq(columns.o.column.label), median.valid.eq(columns.valid), median.opens.eq(columns.o.opens),
        ]

        # The column meets its median.
        m.submodules.aside = aside = Delay(SlotWord(config), median.latency)
        slot  = aside.o
        label = Mux(slot.enable, median.o, confidence.center)
        m.d.comb += [
            aside.i.eq(columns.o),
            confidence.i.eq(slot.column), confidence.advance.eq(median.done), confidence.opens.eq(slot.opens),
            confidence.disparity.eq(label),
        ]

        # The disparity meets its confidence.
        word  = Signal(DisparityWord(config), reset_less=True)
        shown = Signal(confidence.latency)
        m.d.sync += [
            word.disparity.eq(label + slot.minimum * config.disparity_scale), word.passed.eq(confidence.center_passed),
            *copy_flags(word, slot), shown.eq(Cat(median.done & slot.shown, shown)),
        ]
        m.submodules.result = result = Delay(DisparityWord(config), confidence.latency - 1)
        m.d.comb += result.i.eq(word)

        # Room is decided a cycle ahead: two columns may have been started since.
        depth  = self.pipeline + 7
        unread = Signal(range(depth + 1))  # started, not yet taken from the queue
        sure   = Signal(DisparityWord(config))
        m.submodules.output = output = SyncFIFOBuffered(width=sure.shape().size, depth=depth)
        m.submodules.register = register = StreamRegister(DisparityWord(config))
        wiring.connect(m, register.o, wiring.flipped(self.o))
        m.d.sync += [
            unread.eq(unread + columns.coming - (output.r_rdy & output.r_en)), columns.go.eq(unread < depth - 1),
        ]
        m.d.comb += [
            sure.eq(result.o), sure.confidence.eq(confidence.o),
            output.w_data.eq(sure), output.w_en.eq(shown[-1]),
            register.i.payload.eq(output.r_data), register.i.valid.eq(output.r_rdy), output.r_en.eq(register.i.ready),
        ]
        return m
