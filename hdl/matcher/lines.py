"""Line memories: the line store in front of the engine, and the Edata memory of the sequential engine."""

from functools import reduce
from itertools import pairwise
from operator import or_

from amaranth import *
from amaranth.hdl import ShapeLike
from amaranth.lib import data, stream, wiring
from amaranth.lib.memory import Memory, ReadPort, WritePort
from amaranth.lib.wiring import In, Out
from amaranth.utils import ceil_log2

from golden.config import PIXEL_BITS, MatcherConfig

from ..parts.delay import NO_COLLISION, SkidRegister, StreamRegister
from ..parts.queue import Queue
from .stream import ColumnWord, PixelPair, line_names


__all__ = ["EdataMemory", "LineStore"]


def _ports(memory: Memory, name: str) -> tuple[ReadPort, WritePort]:
    """Read and write port, with signals named after the line that the memory holds."""
    size = {"addr_width": ceil_log2(memory.depth), "shape": memory.shape}
    return (ReadPort(ReadPort.Signature(**size), memory=memory, domain="sync", path=(f"{name}_read",)),
            WritePort(WritePort.Signature(**size), memory=memory, domain="sync", path=(f"{name}_write",)))


class LineStore(wiring.Component):
    """Plus Line, Line and Minus Line FIFOs of both pictures, and the control that moves lines through them (thesis figure 19).

    Outputs every pixel with the ``rows // 2`` pixels above and below it; edge replication above and below the picture. The golden model is
    :func:`golden.matcher.lines.line_store`.

    As pixel ``(x, y+1)`` is read from the Plus Line FIFO it replaces ``(x, y)`` in the Line memory, which replaces ``(x, y-1)`` in the
    Minus Line memory; more than three rows are more memories in that chain. After the pixel marked ``end`` the last ``rows // 2`` lines
    are output without waiting for the next frame; meanwhile no more of the next frame is accepted than the FIFO holds.

    Frames: the first line sets the width. Frames at ``o`` are always rectangular and closed by ``end``. A ragged frame raises ``error``
    for one cycle, is cut after the faulty line (padded with its last pixel if it was short), and dropped from there to the next
    ``first``. Ragged means: a line that is too short or too long, ``first`` before ``end``, pixels before ``first``, ``end`` without
    ``last``. A frame whose first line is longer than ``max_width``, or cut by ``first``, is dropped whole.

    With ``lines_below`` as many lines follow the last one, marked ``below``; only the pixels of their columns that lie in the picture are
    defined. The streaming engine needs them for the disparities of the last line. ``end`` then marks the end of the last of them.

    Timing: at most one column a cycle; at a line's start one cycle more. ``o`` is registered.

    Memory: ``(rows - 1) * max_width * 16`` bits and the Plus Line FIFO, ``PLUS_DEPTH * 19`` bits. That FIFO is short, as it adds
    latency.

    Parameters
    ----------
    config : :class:`MatcherConfig`
    rows : int
        Lines of a column: 3, 5 or 7.
    lines_below : int
        At most ``rows // 2``: columns further down hold no pixel of the picture.

    Members
    -------
    i : In(stream.Signature(PixelPair()))
    o : Out(stream.Signature(ColumnWord(rows)))
    error : Out(1)
    """
    PLUS_DEPTH = 32

    def __init__(self, config: MatcherConfig, *, rows: int = 3, lines_below: int = 0):
        if rows not in range(3, 8, 2):
            raise ValueError(f"the columns of a line store have 3, 5 or 7 lines, not {rows!r}")
        if lines_below not in range(rows // 2 + 1):
            raise ValueError(f"below the picture, columns of {rows} lines hold pixels for 0 to {rows // 2} lines, not {lines_below!r}")
        self.config = config
        self.rows = rows
        self.lines_below = lines_below
        super().__init__({
            "i": In(stream.Signature(PixelPair())),
            "o": Out(stream.Signature(ColumnWord(rows))),
            "error": Out(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        max_width = self.config.line_width
        reach = self.rows // 2

        # Plus Line FIFO.
        m.submodules.plus_fifo = fifo = Queue(PixelPair(), self.PLUS_DEPTH)
        m.submodules.plus_register = plus_register = StreamRegister(PixelPair())  # the memory block's own
        m.submodules.plus_head = plus_head = SkidRegister(PixelPair())
        plus_line, head = plus_head.o, plus_head.o.p
        wiring.connect(m, wiring.flipped(self.i), fifo.i)
        wiring.connect(m, fifo.o, plus_register.i)
        wiring.connect(m, plus_register.o, plus_head.i)

        # Line and Minus Line memories: read a column, a cycle later write it back moved down by one line.
        pair = data.StructLayout({"left": PIXEL_BITS, "right": PIXEL_BITS})
        newest, *stored = reversed(line_names(self.rows))
        read, write = {}, {}
        for name in stored:
            m.submodules[f"{name}_memory"] = memory = Memory(shape=pair, depth=max_width, init=[], attrs=NO_COLLISION)
            read[name], write[name] = _ports(memory, name)

        # What is being issued to the memories in this cycle.
        x        = Signal(range(max_width))
        width    = Signal(range(max_width))  # of this frame, less one
        at_start = Signal(init=1)            # x == 0
        at_end   = Signal()                  # x == width, from the second line on
        row_zero = Signal()                  # the first line: stored, nothing to output yet
        row_one  = Signal()                  # the line after it, and so on; with the last of these the first line is output
        row      = [row_zero, row_one, *(Signal(name=f"row_{n}") for n in range(2, reach + 1))]
        issue    = Signal()
        plus     = Signal(pair)
        early    = Signal()                  # a line is output after the last one was accepted, and is not the last itself
        flush    = Signal()
        below    = Signal()
        closes_frame = Signal()              # the line is the last to be output

        # The column that is being read from the memories, and the one that has been read, with its words in registers behind the blocks.
        flags = dict.fromkeys(("shown", "flush", "early", "below", "end", "top", "last"), 1)
        about = data.StructLayout({"x": x.shape(), "plus": pair, **flags})
        reading = Signal()
        ahead   = Signal(about, reset_less=True)
        held    = Signal()
        here    = Signal(about, reset_less=True)
        word    = {name: Signal(pair, name=f"{name}_word", reset_less=True) for name in stored}
        output  = Signal()
        move    = Signal()
        m.submodules.column = column_register = SkidRegister(ColumnWord(self.rows))
        wiring.connect(m, column_register.o, wiring.flipped(self.o))
        column_i = column_register.i
        m.d.comb += [output.eq(held & (column_i.ready | ~here.shown)), move.eq(~held | output)]

        # A line starts only when the one before it is written back: a line of one pixel reads the word that was written last.
        can_issue = Signal()
        written = ~reading & (~held | (output & (here.x != 0)))
        m.d.comb += can_issue.eq(Mux(at_start, written, ~reading | move))

        with m.If(issue):
            m.d.sync += [
                reading.eq(1), ahead.shown.eq(~reduce(or_, row[:-1]) | flush), ahead.x.eq(x), ahead.plus.eq(plus), ahead.flush.eq(flush),
                ahead.early.eq(early), ahead.below.eq(below), ahead.end.eq(closes_frame), ahead.top.eq(row[-1]), ahead.last.eq(at_end),
            ]
        with m.Elif(move):
            m.d.sync += reading.eq(0)
        with m.If(move):
            m.d.sync += [held.eq(reading), here.eq(ahead), *(word[name].eq(read[name].data) for name in stored)]

        # Edge replication: line 0 fills the rows above. The last line is kept in the first memory, and read again for the rows below.
        for name in stored:
            m.d.comb += [read[name].addr.eq(x), read[name].en.eq(issue)]
        for name, lower in zip(stored, (newest, *stored)):
            m.d.comb += [write[name].addr.eq(here.x), write[name].en.eq(output & ~here.early if lower == newest else output)]
            m.d.comb += write[name].data.eq(here.plus if lower == newest else Cat(column_i.p.left[lower], column_i.p.right[lower]))
        m.d.comb += [
            column_i.valid.eq(held & here.shown),
            column_i.p.first.eq(here.top & (here.x == 0)),
            column_i.p.last.eq(here.last),
            column_i.p.end.eq(here.last & here.end),
            column_i.p.below.eq(here.below),
        ]
        for column, side in ((column_i.p.left, "left"), (column_i.p.right, "right")):
            for name in stored:
                at_top = here.top & name.startswith("minus")
                m.d.comb += column[name].eq(Mux(at_top, word["line"][side], word[name][side]))
            m.d.comb += column[newest].eq(Mux(here.flush | here.early, word[stored[0]][side], here.plus[side]))

        # Control. `expected`: a pixel without `first` is an error, as it is not the rest of a ragged frame.
        expected = Signal(init=1)
        step = [x.eq(x + 1), at_start.eq(0), at_end.eq(x + 1 == width)]
        restart = [x.eq(0), at_start.eq(1), at_end.eq(width == 0)]
        next_row = [row_one.eq(0), *(row[n].eq(row[n - 1]) for n in range(2, reach + 1))]
        last_lines = [*(f"last line but {n}" for n in range(reach - 1, 0, -1)), "last line"]
        with m.FSM():
            with m.State("between frames"):
                with m.If(plus_line.valid):
                    with m.If(head.first):
                        m.d.sync += [*restart, row_zero.eq(1), row_one.eq(0)]
                        m.next = "line"
                    with m.Else():
                        m.d.comb += [plus_line.ready.eq(1), self.error.eq(expected)]
                        m.d.sync += expected.eq(0)

            with m.State("line"):
                m.d.comb += plus.eq(Cat(head.left, head.right))
                with m.If(plus_line.valid & head.first & ~(at_start & row_zero)):
                    m.d.comb += self.error.eq(1)
                    with m.If(row_zero):
                        m.next = "between frames"  # nothing of this frame has been output
                    with m.Elif(at_start):
                        m.next = last_lines[0]
                    with m.Else():
                        m.next = "pad"
                with m.Elif(plus_line.valid & can_issue):
                    closes = head.last | head.end
                    m.d.comb += [issue.eq(1), plus_line.ready.eq(1), self.error.eq(head.end & ~head.last)]
                    m.d.sync += [*step, expected.eq(0)]
                    with m.If(row_zero):
                        with m.If(closes):
                            m.d.sync += [*restart, width.eq(x), at_end.eq(at_start), row_zero.eq(0), row_one.eq(1)]
                            with m.If(head.end):
                                m.d.sync += expected.eq(1)
                                m.next = last_lines[0]
                        with m.Elif(x == max_width - 1):
                            m.d.comb += self.error.eq(1)
                            m.next = "between frames"
                    with m.Elif(at_end):
                        m.d.sync += [*restart, *next_row]
                        with m.If(~closes):
                            m.d.comb += self.error.eq(1)
                            m.next = last_lines[0]
                        with m.Elif(head.end):
                            m.d.sync += expected.eq(1)
                            m.next = last_lines[0]
                    with m.Elif(closes):
                        m.d.comb += self.error.eq(1)
                        m.d.sync += expected.eq(head.end)
                        m.next = "pad"

            with m.State("pad"):
                m.d.comb += plus.eq(ahead.plus)
                with m.If(can_issue):
                    m.d.comb += issue.eq(1)
                    m.d.sync += step
                    with m.If(at_end):
                        m.d.sync += [*restart, *next_row]
                        m.next = last_lines[0]

            # A state for each line that is output after the last one was accepted, and one for each line below.
            lines_below = [f"line below {n}" for n in range(self.lines_below)]
            for state, following in pairwise([*last_lines, *lines_below, "between frames"]):
                with m.State(state):
                    m.d.comb += early.eq(1) if state in last_lines[:-1] else flush.eq(1)
                    m.d.comb += [below.eq(state in lines_below), closes_frame.eq(following == "between frames")]
                    with m.If(can_issue):
                        m.d.comb += issue.eq(1)
                        m.d.sync += step
                        with m.If(at_end):
                            m.d.sync += [*restart, *([] if state in lines_below else next_row)]
                            m.next = following
        return m


class EdataMemory(wiring.Component):
    """The words of one line, between costs and labelling: outputs the word of the line above as it stores the one of this line.

    The golden model is :func:`golden.matcher.lines.edata_memory`.

    Timing: ``o`` is the old word of ``column`` from the cycle after ``exchange`` until the next ``exchange``; ``i`` is written if ``write``
    is high with ``exchange``. The old word is read in the cycle that writes the new one: the memory must return old data on collision.

    Memory: ``max_width`` words.

    Parameters
    ----------
    shape : shape-like
        Of a word.
    max_width : int
        Words.

    Members
    -------
    column : In(range(max_width))
    exchange, write : In(1)
    i : In(shape)
    o : Out(shape)
    """
    LATENCY = 1

    def __init__(self, shape: ShapeLike, max_width: int):
        self.shape = shape
        self.max_width = max_width
        super().__init__({
            "column": In(range(max_width)),
            "exchange": In(1),
            "write": In(1),
            "i": In(shape),
            "o": Out(shape),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.memory = memory = Memory(shape=self.shape, depth=self.max_width, init=[])
        read = memory.read_port()
        write = memory.write_port()
        m.d.comb += [
            read.addr.eq(self.column), read.en.eq(self.exchange), self.o.eq(read.data),
            write.addr.eq(self.column), write.en.eq(self.exchange & self.write), write.data.eq(self.i),
        ]
        return m
