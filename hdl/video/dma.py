"""Between streams of pixels and bursts of words: blocks that the writers and readers of pictures share."""

from amaranth import *
from amaranth.hdl import ResetInserter
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS
from golden.video.memory_map import MemoryMap, Plane

from ..matcher.stream import FLAGS
from ..parts.queue import Queue
from ..rig.control import ROWS
from .words import ADDRESS_BITS, WORD_BYTES


__all__ = ["LineBurst", "LineScan", "PixelPacker", "PixelUnpacker", "PlanePair", "WordFifo", "line_number"]


def line_number(memory_map: MemoryMap, plane: Plane, buffer: Value) -> Value:
    """Number in memory of a plane's first line, for a buffer given by a signal; combinational."""
    value = Signal(range(memory_map.total_words // memory_map.pitch))
    choice = C(memory_map.line(plane, 0), value.shape())
    for number in range(1, memory_map.buffers_of(plane)):
        choice = Mux(buffer == number, memory_map.line(plane, number), choice)
    return choice


class LineBurst(data.StructLayout):
    """A burst within a line; ``last``: the last one of its line."""
    def __init__(self, burst: int):
        super().__init__({"address": ADDRESS_BITS, "length": range(burst + 1), "last": 1})


class LineScan(wiring.Component):
    """Generates the bursts of a picture, line by line: ``burst`` words each, the last one of a line with the rest.

    Golden: :meth:`golden.video.memory_map.MemoryMap.base` + ``y * pitch + n``. Lines are scanned from top to bottom, or, ``interlaced``,
    first the even ones and then the odd ones. An address is a concatenation: line ``base + y``, and the word within the line. With
    ``moves`` it is line ``y + offset`` of the picture, whose first and last lines are repeated: :func:`golden.rig.rectify.move_rows`.

    Timing: after ``advance`` the next burst is shown in the next cycle. ``start`` may be high at any time, and restarts the scan.

    Parameters
    ----------
    memory_map : :class:`golden.video.memory_map.MemoryMap`
    burst : int
        Words, a power of two: a burst then lies within one row of the memory.
    interlaced : bool
        Needs an even number of lines.
    moves : bool
        There is an ``offset``; ``o`` depends on it combinationally.

    Members
    -------
    start : In(1)
    base : In
        Number of the picture's first line in memory; ``o`` depends on it combinationally.
    offset : In(signed(8))
        Lines, with ``moves``.
    advance : In(1)
        Show the next burst.
    active : Out(1)
        ``o`` is a burst; low after the last one.
    o : Out(LineBurst(burst))
    """
    def __init__(self, memory_map: MemoryMap, *, burst: int, interlaced: bool = False, moves: bool = False):
        self.check(memory_map, burst, interlaced)
        self.memory_map = memory_map
        self.burst = burst
        self.interlaced = interlaced
        self.moves = moves
        super().__init__({
            "start": In(1),
            "base": In(range(memory_map.total_words // memory_map.pitch)),
            **({"offset": In(ROWS)} if moves else {}),
            "advance": In(1),
            "active": Out(1),
            "o": Out(LineBurst(burst)),
        })

    @staticmethod
    def check(memory_map: MemoryMap, burst: int, interlaced: bool = False) -> None:
        """Raise :class:`ValueError` unless the parameters are valid."""
        if burst < 1 or burst & (burst - 1):
            raise ValueError(f"a burst must be a power of two of words, not {burst!r}")
        if interlaced and memory_map.height % 2:
            raise ValueError(f"an interlaced picture must have an even number of lines, not {memory_map.height!r}")

    def elaborate(self, platform: object) -> Module:
        m = Module()
        memory_map = self.memory_map
        first_of_last = (memory_map.line_words - 1) // self.burst * self.burst

        column = Signal(range(memory_map.pitch), reset_less=True)
        row    = Signal(range(memory_map.height), reset_less=True)
        m.d.comb += [
            self.o.last.eq(column == first_of_last),
            self.o.length.eq(Mux(self.o.last, memory_map.line_words - first_of_last, self.burst)),
            self.o.address.eq(Cat(column, self.base + (self._moved(m, row) if self.moves else row))),
        ]
        with m.If(self.advance):
            m.d.sync += column.eq(Mux(self.o.last, 0, column + self.burst))
            with m.If(self.o.last):
                with m.If(row == memory_map.height - 1):
                    m.d.sync += self.active.eq(0)
                if self.interlaced:
                    with m.If(row == memory_map.height - 2):
                        m.d.sync += row.eq(1)
                    with m.Else():
                        m.d.sync += row.eq(row + 2)
                else:
                    m.d.sync += row.eq(row + 1)
        with m.If(self.start):
            m.d.sync += [self.active.eq(1), column.eq(0), row.eq(0)]
        return m

    def _moved(self, m: Module, row: Signal) -> Signal:
        """The line of the picture that is line ``row`` after it was moved."""
        moved  = Signal(signed(max(len(row) + 1, len(self.offset)) + 1))
        result = Signal.like(row)
        m.d.comb += moved.eq(row + self.offset)
        with m.If(moved < 0):
            m.d.comb += result.eq(0)
        with m.Elif(moved >= self.memory_map.height):
            m.d.comb += result.eq(self.memory_map.height - 1)
        with m.Else():
            m.d.comb += result.eq(moved)
        return result


class WordFifo(wiring.Component):
    """FIFO of memory words that can be emptied in a cycle, and that records its highest level.

    Timing: latency 2 cycles, a word a cycle. Memory: ``(depth - 1) * 128`` bits, and a register.

    Parameters
    ----------
    depth : int
        Words.

    Members
    -------
    i, o : In(stream.Signature(128)), Out(stream.Signature(128))
        ``i.ready`` is high while ``level`` is below ``depth``.
    clear : In(1)
        The queue is empty in the next cycle; a word accepted in this one is lost.
    level : Out(range(depth + 1))
        Words in the queue.
    fill : Out(range(depth + 1))
        Highest ``level`` since ``clear_fill``.
    clear_fill : In(1)
    """
    def __init__(self, depth: int):
        if depth < 4:
            raise ValueError(f"a queue of memory words must hold at least 4, not {depth!r}")
        self.depth = depth
        super().__init__({
            "i": In(stream.Signature(8 * WORD_BYTES)),
            "o": Out(stream.Signature(8 * WORD_BYTES)),
            "clear": In(1),
            "level": Out(range(depth + 1)),
            "fill": Out(range(depth + 1)),
            "clear_fill": In(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        queue = Queue(8 * WORD_BYTES, self.depth)
        m.submodules.queue = ResetInserter(self.clear)(queue)
        wiring.connect(m, wiring.flipped(self.i), queue.i)
        wiring.connect(m, queue.o, wiring.flipped(self.o))
        m.d.comb += self.level.eq(queue.level)
        with m.If(self.clear_fill | (self.level > self.fill)):
            m.d.sync += self.fill.eq(self.level)
        return m


class PixelPacker(wiring.Component):
    """Packs sixteen pixels into a word, the first one in the lowest byte; the last word of a line may hold fewer.

    The padding of a line's last word is undefined. Timing: a pixel a cycle; a word is offered in the cycle after its last pixel.
    ``i.ready`` depends combinationally on ``o.ready``.

    Members
    -------
    i : In(stream.Signature({"value": 8, "last": 1}))
    o : Out(stream.Signature(128))
    clear : In(1)
        Discard the incomplete word and the one offered.
    """
    def __init__(self) -> None:
        super().__init__({
            "i": In(stream.Signature(data.StructLayout({"value": PIXEL_BITS, "last": 1}))),
            "o": Out(stream.Signature(8 * WORD_BYTES)),
            "clear": In(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        word  = Signal(data.ArrayLayout(PIXEL_BITS, WORD_BYTES), reset_less=True)
        index = Signal(range(WORD_BYTES))
        m.d.comb += [self.i.ready.eq(~self.o.valid | self.o.ready), self.o.payload.eq(word)]
        with m.If(self.i.ready):
            m.d.sync += self.o.valid.eq(0)
            with m.If(self.i.valid):
                m.d.sync += [word[index].eq(self.i.p.value), index.eq(Mux(self.i.p.last, 0, index + 1))]
                m.d.sync += self.o.valid.eq(self.i.p.last | (index == WORD_BYTES - 1))
        with m.If(self.clear):
            m.d.sync += [index.eq(0), self.o.valid.eq(0)]
        return m


class PlanePair(data.StructLayout):
    """The pixels of two planes at the same coordinates."""
    def __init__(self) -> None:
        super().__init__({"pixels": data.ArrayLayout(PIXEL_BITS, 2), **FLAGS})


class PixelUnpacker(wiring.Component):
    """Unpacks words of two planes into pixels with flags: the reverse of :class:`PixelPacker`, for pictures of a fixed size.

    Timing: latency 1 cycle, a pixel a cycle. ``o.valid`` does not depend on ``o.ready``.

    Parameters
    ----------
    memory_map : :class:`golden.video.memory_map.MemoryMap`
        Gives the size of the pictures.

    Members
    -------
    i : In(stream.Signature(128)).array(2)
        Words of both are accepted in the same cycle.
    o : Out(stream.Signature(PlanePair()))
    clear : In(1)
        The next pixel is the first of a picture. One that is offered, or is registered in this cycle, stays until it is accepted.
    """
    def __init__(self, memory_map: MemoryMap):
        self.memory_map = memory_map
        super().__init__({
            "i": In(stream.Signature(8 * WORD_BYTES)).array(2),
            "o": Out(stream.Signature(PlanePair())),
            "clear": In(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        x = Signal(range(self.memory_map.width))
        y = Signal(range(self.memory_map.height))
        last_column = Signal()
        last_line   = Signal()
        advance     = Signal()
        m.d.comb += [
            last_column.eq(x == self.memory_map.width - 1),
            last_line.eq(y == self.memory_map.height - 1),
            advance.eq(self.i[0].valid & self.i[1].valid & (~self.o.valid | self.o.ready)),
        ]
        index = x[:(WORD_BYTES - 1).bit_length()]
        for side in self.i:
            m.d.comb += side.ready.eq(advance & (last_column | (index == WORD_BYTES - 1)))
        with m.If(self.o.ready):
            m.d.sync += self.o.valid.eq(0)
        with m.If(advance):
            m.d.sync += [self.o.valid.eq(1), x.eq(Mux(last_column, 0, x + 1))]
            m.d.sync += [pixel.eq(side.payload.word_select(index, PIXEL_BITS)) for pixel, side in zip(self.o.p.pixels, self.i)]
            m.d.sync += [
                self.o.p.first.eq((x == 0) & (y == 0)), self.o.p.last.eq(last_column), self.o.p.end.eq(last_column & last_line),
            ]
            with m.If(last_column):
                m.d.sync += y.eq(Mux(last_line, 0, y + 1))
        with m.If(self.clear):
            m.d.sync += [x.eq(0), y.eq(0)]
        return m
