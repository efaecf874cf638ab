"""Line memories: the line store in front of BEC, and the Edata memory between BEC and GC."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.fifo import SyncFIFOBuffered
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, MatcherConfig

from .delay import StreamRegister
from .stream import ColumnWord, PixelPair


__all__ = ["EdataMemory", "LineStore"]


class LineStore(wiring.Component):
    """Plus Line, Line and Minus Line FIFOs of both pictures, and the control that moves lines through them (thesis figure 19).

    Gives, for every pixel of a line, the pixels above and below it; lines outside the picture repeat the nearest. The golden
    model is :func:`golden.lines.line_store`.

    The Plus Line FIFO takes pixels as they come. As pixel ``(x, y+1)`` leaves it, the Line memory gives up ``(x, y)`` and takes it,
    and the Minus Line memory gives up ``(x, y-1)`` and takes ``(x, y)``. After the pixel marked ``end``, the last line follows without
    waiting for the next frame.

    Frames: the first line sets the width. What comes out is always rectangular and closed by ``end``, whatever comes in. A frame
    that is ragged raises ``error`` for one cycle, is cut after the line at fault (which repeats its last pixel if it was short) and
    the rest of it, up to the next ``first``, is dropped: a line that is too short or too long, ``first`` before ``end``, pixels before
    ``first``, ``end`` without ``last``. A first line longer than ``max_width`` (or cut by ``first``) gives nothing at all.

    With ``line_below`` a line more follows the last one, marked ``below``: only its minus pixels mean anything. The streaming engine
    walks along it for the last line's disparities; ``end`` is then the end of that line.

    Timing: at most one column a cycle; at a line's start one cycle more. ``o`` leaves a register. What the memories give passes through
    one too, because a memory block is slow to give its word.

    Memory: ``2 * max_width * 16`` bits and the Plus Line FIFO, ``PLUS_DEPTH * 19`` bits. That FIFO is kept short: what waits in it
    is latency, and three whole lines would be one more than the method needs.

    Parameters
    ----------
    config : :class:`MatcherConfig`
    line_below : bool

    Members
    -------
    i : In(stream.Signature(PixelPair()))
    o : Out(stream.Signature(ColumnWord()))
    error : Out(1)
    """
    PLUS_DEPTH = 32

    def __init__(self, config: MatcherConfig, *, line_below=False):
        self.config = config
        self.line_below = line_below
        super().__init__({
            "i": In(stream.Signature(PixelPair())),
            "o": Out(stream.Signature(ColumnWord())),
            "error": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        max_width = self.config.max_width

        # Plus Line FIFO.
        m.submodules.plus_fifo = fifo = SyncFIFOBuffered(width=self.i.p.shape().size, depth=self.PLUS_DEPTH)
        m.submodules.plus_register = plus_register = StreamRegister(PixelPair())
        come, head = plus_register.o, plus_register.o.p
        m.d.comb += [
            fifo.w_data.eq(self.i.p), fifo.w_en.eq(self.i.valid), self.i.ready.eq(fifo.w_rdy),
            plus_register.i.payload.eq(fifo.r_data), plus_register.i.valid.eq(fifo.r_rdy), fifo.r_en.eq(plus_register.i.ready),
        ]

        # Line and Minus Line memories: read a column, a cycle later write it back moved down by one line.
        pair = data.StructLayout({"left": PIXEL_BITS, "right": PIXEL_BITS})
        m.submodules.line_memory = line_memory = Memory(shape=pair, depth=max_width, init=[])
        m.submodules.minus_memory = minus_memory = Memory(shape=pair, depth=max_width, init=[])
        line_read = line_memory.read_port()
        line_write = line_memory.write_port()
        minus_read = minus_memory.read_port()
        minus_write = minus_memory.write_port()

        # What is being issued to the memories in this cycle.
        x        = Signal(range(max_width))
        width    = Signal(range(max_width))  # of this frame, less one
        row_zero = Signal()                  # the first line: stored, nothing to give yet
        row_one  = Signal()                  # the line after it: there is no line above the one that leaves
        issue    = Signal()
        plus     = Signal(pair)
        flush    = Signal()
        below    = Signal()

        # The column that comes out of the memories.
        held       = Signal()
        held_shown = Signal()
        held_x     = Signal.like(x, reset_less=True)
        held_plus  = Signal(pair, reset_less=True)
        held_flush = Signal(reset_less=True)
        held_below = Signal(reset_less=True)
        held_top   = Signal(reset_less=True)
        held_last  = Signal(reset_less=True)
        leave      = Signal()
        m.submodules.column = column_register = StreamRegister(ColumnWord())
        wiring.connect(m, column_register.o, wiring.flipped(self.o))
        given = column_register.i
        m.d.comb += leave.eq(held & (given.ready | ~held_shown))

        # A line starts only when the one before it is written back: lines of one pixel read what was just written.
        can_issue = Signal()
        m.d.comb += can_issue.eq(~held | (leave & (x != 0)))

        with m.If(issue):
            m.d.sync += [
                held.eq(1), held_shown.eq(~row_zero | flush), held_x.eq(x), held_plus.eq(plus), held_flush.eq(flush), held_below.eq(below),
                held_top.eq(row_one), held_last.eq(x == width),
            ]
        with m.Elif(leave):
            m.d.sync += held.eq(0)

        m.d.comb += [
            line_read.addr.eq(x), line_read.en.eq(issue),
            minus_read.addr.eq(x), minus_read.en.eq(issue),
            line_write.addr.eq(held_x), line_write.en.eq(leave), line_write.data.eq(held_plus),
            minus_write.addr.eq(held_x), minus_write.en.eq(leave), minus_write.data.eq(line_read.data),
            given.valid.eq(held & held_shown),
            given.p.first.eq(held_top & (held_x == 0)),
            given.p.last.eq(held_last),
            given.p.end.eq(held_last & (held_below if self.line_below else held_flush)),
            given.p.below.eq(held_below),
        ]
        for column, side in ((given.p.left, "left"), (given.p.right, "right")):
            m.d.comb += [
                column.line.eq(line_read.data[side]),
                column.minus.eq(Mux(held_top, line_read.data[side], minus_read.data[side])),
                column.plus.eq(Mux(held_flush, line_read.data[side], held_plus[side])),
            ]

        # Control. `expected` distinguishes pixels that follow a good frame without `first` from the rest of a ragged one.
        expected = Signal(init=1)
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
                        m.next = "last line"
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
                                m.next = "last line"
                        with m.Elif(x == max_width - 1):
                            m.d.comb += self.error.eq(1)
                            m.next = "between frames"
                    with m.Elif(x == width):
                        m.d.sync += [x.eq(0), row_one.eq(0)]
                        with m.If(~closes):
                            m.d.comb += self.error.eq(1)
                            m.next = "last line"
                        with m.Elif(head.end):
                            m.d.sync += expected.eq(1)
                            m.next = "last line"
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
                        m.d.sync += [x.eq(0), row_one.eq(0)]
                        m.next = "last line"

            with m.State("last line"):
                m.d.comb += flush.eq(1)
                with m.If(can_issue):
                    m.d.comb += issue.eq(1)
                    m.d.sync += x.eq(x + 1)
                    with m.If(x == width):
                        m.d.sync += [x.eq(0), row_one.eq(0)]
                        m.next = "line below" if self.line_below else "between frames"

            if self.line_below:
                with m.State("line below"):
                    m.d.comb += [flush.eq(1), below.eq(1)]
                    with m.If(can_issue):
                        m.d.comb += issue.eq(1)
                        m.d.sync += x.eq(x + 1)
                        with m.If(x == width):
                            m.d.sync += x.eq(0)
                            m.next = "between frames"
        return m


class EdataMemory(wiring.Component):
    """The words of one line, between BEC and GC: gives up the word of the line above as it takes the one of this line.

    The golden model is :func:`golden.lines.edata_memory`.

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

    def __init__(self, shape, max_width):
        self.shape = shape
        self.max_width = max_width
        super().__init__({
            "column": In(range(max_width)),
            "exchange": In(1),
            "write": In(1),
            "i": In(shape),
            "o": Out(shape),
        })

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = memory = Memory(shape=self.shape, depth=self.max_width, init=[])
        read = memory.read_port()
        write = memory.write_port()
        m.d.comb += [
            read.addr.eq(self.column), read.en.eq(self.exchange), self.o.eq(read.data),
            write.addr.eq(self.column), write.en.eq(self.exchange & self.write), write.data.eq(self.i),
        ]
        return m
