"""Line memories: the line store in front of BEC, and the Edata memory between BEC and GC."""

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

from ..parts.delay import NO_COLLISION, StreamRegister
from ..parts.queue import Queue
from .stream import ColumnWord, PixelPair, line_names


__all__ = ["EdataMemory", "LineStore"]


def _ports(memory: Memory, name: str) -> tuple[ReadPort, WritePort]:
    """Read and write port, whose signals bear the name of the line that the memory holds."""
    size = {"addr_width": ceil_log2(memory.depth), "shape": memory.shape}
    return (ReadPort(ReadPort.Signature(**size), memory=memory, domain="sync", path=(f"{name}_read",)),
            WritePort(WritePort.Signature(**size), memory=memory, domain="sync", path=(f"{name}_write",)))


class LineStore(wiring.Component):
    """Plus Line, Line and Minus Line FIFOs of both pictures, and the control that moves lines through them (thesis figure 19).

    Gives, for every pixel of a line, the ``rows // 2`` pixels above and below it; lines outside the picture repeat the nearest. The
    golden model is :func:`golden.matcher.lines.line_store`.

    The Plus Line FIFO takes pixels as they come. As pixel ``(x, y+1)`` leaves it, the Line memory gives up ``(x, y)`` and takes it,
    and the Minus Line memory gives up ``(x, y-1)`` and takes ``(x, y)``. After the pixel marked ``end``, the last line follows without
    waiting for the next frame. More than three rows are more memories in that chain, and ``rows // 2`` last lines.
    While these leave, no more of the next frame is taken than the FIFO holds.

    Frames: the first line sets the width. What comes out is always rectangular and closed by ``end``, whatever comes in. A frame
    that is ragged raises ``error`` for one cycle, is cut after the line at fault (which repeats its last pixel if it was short) and
    the rest of it, up to the next ``first``, is dropped: a line that is too short or too long, ``first`` before ``end``, pixels before
    ``first``, ``end`` without ``last``. A first line longer than ``max_width`` (or cut by ``first``) gives nothing at all.

    With ``lines_below`` that many lines more follow the last one, marked ``below``: only those of their pixels that lie above the picture's
    end mean anything. The streaming engine walks along them for the last line's disparities; ``end`` is then the end of the last of them.

    Timing: at most one column a cycle; at a line's start one cycle more. ``o`` leaves a register. What the memories give passes through
    one too, because a memory block is slow to give its word.

    Memory: ``(rows - 1) * max_width * 16`` bits and the Plus Line FIFO, ``PLUS_DEPTH * 19`` bits. That FIFO is kept short: what waits in it
    is latency, and a whole line would be one more than the method needs.

    Parameters
    ----------
    config : :class:`MatcherConfig`
    rows : int
        Lines of a column: 3, 5 or 7.
    lines_below : int
        At most ``rows // 2``: further down nothing of the picture is left in a column.

    Members
    -------
    i : In(stream.Signature(PixelPair()))
    o : Out(stream.Signature(ColumnWord(rows)))
    error : Out(1)
    """
    PLUS_DEPTH = 32

    def __init__(self, config: MatcherConfig, *, rows: int = 3, lines_below: int = 0):
        if rows not in range(3, 8, 2):
            raise ValueError(f"a line store gives columns of 3, 5 or 7 lines, not {rows!r}")
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
        max_width = self.config.max_width
        reach = self.rows // 2

        # Plus Line FIFO.
        m.submodules.plus_fifo = fifo = Queue(PixelPair(), self.PLUS_DEPTH)
        m.submodules.plus_register = plus_register = StreamRegister(PixelPair())
        come, head = plus_register.o, plus_register.o.p
        wiring.connect(m, wiring.flipped(self.i), fifo.i)
        wiring.connect(m, fifo.o, plus_register.i)

        # Line and Minus Line memories: read a column, a cycle later write it back moved down by one line.
        pair = data.StructLayout({"left": PIXEL_BITS, "right": PIXEL_BITS})
        coming, *stored = reversed(line_names(self.rows))
        read, write = {}, {}
        for name in stored:
            m.submodules[f"{name}_memory"] = memory = Memory(shape=pair, depth=max_width, init=[], attrs=NO_COLLISION)
            read[name], write[name] = _ports(memory, name)

        # What is being issued to the memories in this cycle.
        x        = Signal(range(max_width))
        width    = Signal(range(max_width))  # of this frame, less one
        row_zero = Signal()                  # the first line: stored, nothing to give yet
        row_one  = Signal()                  # the line after it, and so on; at the last of these rows the first line leaves
        row      = [row_zero, row_one, *(Signal(name=f"row_{n}") for n in range(2, reach + 1))]
        issue    = Signal()
        plus     = Signal(pair)
        early    = Signal()                  # a line leaves after the last one has come, and others will
        flush    = Signal()
        below    = Signal()
        closes_frame = Signal()              # the line is the last to leave

        # The column that comes out of the memories.
        held       = Signal()
        held_shown = Signal()
        held_x     = Signal.like(x, reset_less=True)
        held_plus  = Signal(pair, reset_less=True)
        held_flush = Signal(reset_less=True)
        held_below = Signal(reset_less=True)
        held_end   = Signal(reset_less=True)
        held_top   = Signal(reset_less=True)
        held_last  = Signal(reset_less=True)
        leave      = Signal()
        m.submodules.column = column_register = StreamRegister(ColumnWord(self.rows))
        wiring.connect(m, column_register.o, wiring.flipped(self.o))
        given = column_register.i
        m.d.comb += leave.eq(held & (given.ready | ~held_shown))

        # A line starts only when the one before it is written back: lines of one pixel read what was just written.
        can_issue = Signal()
        m.d.comb += can_issue.eq(~held | (leave & (x != 0)))

        with m.If(issue):
            m.d.sync += [
                held.eq(1), held_shown.eq(~reduce(or_, row[:-1]) | flush), held_x.eq(x), held_plus.eq(plus), held_flush.eq(flush),
                held_below.eq(below), held_end.eq(closes_frame), held_top.eq(row[-1]), held_last.eq(x == width),
            ]
        with m.Elif(leave):
            m.d.sync += held.eq(0)

        # Above the picture its first line comes again, and moves down with the others. Below it the last line does: it stays in the first
        # memory until nothing more of it is wanted.
        again, take = held_flush, leave
        if reach > 1:
            held_early = Signal(reset_less=True)
            again, take = held_flush | held_early, leave & ~held_early
            with m.If(issue):
                m.d.sync += held_early.eq(early)
        for name in stored:
            m.d.comb += [read[name].addr.eq(x), read[name].en.eq(issue)]
        for name, lower in zip(stored, (coming, *stored)):
            m.d.comb += [write[name].addr.eq(held_x), write[name].en.eq(take if lower == coming else leave)]
            m.d.comb += write[name].data.eq(held_plus if lower == coming else Cat(given.p.left[lower], given.p.right[lower]))
        m.d.comb += [
            given.valid.eq(held & held_shown),
            given.p.first.eq(held_top & (held_x == 0)),
            given.p.last.eq(held_last),
            given.p.end.eq(held_last & held_end),
            given.p.below.eq(held_below),
        ]
        for column, side in ((given.p.left, "left"), (given.p.right, "right")):
            pixel = {name: read[name].data[side] for name in stored}
            for name in stored:
                m.d.comb += column[name].eq(Mux(held_top, pixel["line"], pixel[name]) if name.startswith("minus") else pixel[name])
            m.d.comb += column[coming].eq(Mux(again, pixel[stored[0]], held_plus[side]))

        # Control. `expected` distinguishes pixels that follow a good frame without `first` from the rest of a ragged one.
        expected = Signal(init=1)
        next_row = [row_one.eq(0), *(row[n].eq(row[n - 1]) for n in range(2, reach + 1))]
        last_lines = [*(f"last line but {n}" for n in range(reach - 1, 0, -1)), "last line"]
        with m.FSM():
            with m.State("between frames"):
                with m.If(come.valid):
                    with m.If(head.first):
                        m.d.sync += [x.eq(0), row_zero.eq(1), row_one.eq(0)]
                        m.next = "line"
                    with m.Else():
                        m.d.comb += [come.ready.eq(1), self.error.eq(expected)]
                        m.d.sync += expected.eq(0)

            with m.State("line"):
                m.d.comb += plus.eq(Cat(head.left, head.right))
                with m.If(come.valid & head.first & ~((x == 0) & row_zero)):
                    m.d.comb += self.error.eq(1)
                    with m.If(row_zero):
                        m.next = "between frames"  # nothing has been shown of this frame
                    with m.Elif(x == 0):
                        m.next = last_lines[0]
                    with m.Else():
                        m.next = "pad"
                with m.Elif(come.valid & can_issue):
                    closes = head.last | head.end
                    m.d.comb += [issue.eq(1), come.ready.eq(1), self.error.eq(head.end & ~head.last)]
                    m.d.sync += [x.eq(x + 1), expected.eq(0)]
                    with m.If(row_zero):
                        with m.If(closes):
                            m.d.sync += [x.eq(0), width.eq(x), row_zero.eq(0), row_one.eq(1)]
                            with m.If(head.end):
                                m.d.sync += expected.eq(1)
                                m.next = last_lines[0]
                        with m.Elif(x == max_width - 1):
                            m.d.comb += self.error.eq(1)
                            m.next = "between frames"
                    with m.Elif(x == width):
                        m.d.sync += [x.eq(0), *next_row]
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
                m.d.comb += plus.eq(held_plus)
                with m.If(can_issue):
                    m.d.comb += issue.eq(1)
                    m.d.sync += x.eq(x + 1)
                    with m.If(x == width):
                        m.d.sync += [x.eq(0), *next_row]
                        m.next = last_lines[0]

            # A state for each line that leaves after the last one has come, and one for each line below.
            lines_below = [f"line below {n}" for n in range(self.lines_below)]
            for state, following in pairwise([*last_lines, *lines_below, "between frames"]):
                with m.State(state):
                    m.d.comb += early.eq(1) if state in last_lines[:-1] else flush.eq(1)
                    m.d.comb += [below.eq(state in lines_below), closes_frame.eq(following == "between frames")]
                    with m.If(can_issue):
                        m.d.comb += issue.eq(1)
                        m.d.sync += x.eq(x + 1)
                        with m.If(x == width):
                            m.d.sync += [x.eq(0), *([] if state in lines_below else next_row)]
                            m.next = following
        return m


class EdataMemory(wiring.Component):
    """The words of one line, between BEC and GC: gives up the word of the line above as it takes the one of this line.

    The golden model is :func:`golden.matcher.lines.edata_memory`.

    Timing: ``o`` holds the old word of ``column`` from the cycle after ``exchange`` until the next; ``i`` is written if ``write`` is
    high with ``exchange``. The old word is read in the cycle that writes the new one (M9K: old data on collision).

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
