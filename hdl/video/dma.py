"""Between streams of pixels and bursts of words: the parts that writers and readers of pictures share."""

from amaranth import *
from amaranth.hdl import ResetInserter
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS
from golden.video.memory_map import MemoryMap

from ..matcher.stream import FLAGS
from ..parts.queue import Queue
from .words import ADDRESS_BITS, WORD_BYTES


__all__ = ["LineBurst", "LineScan", "PixelPacker", "PixelUnpacker", "PlanePair", "WordFifo", "line_number"]


def line_number(memory_map, plane, buffer):
    """The number of a plane's first line in memory, for a buffer that a signal tells."""
    value = Signal(range(memory_map.total_words // memory_map.pitch))
    choice = C(memory_map.line(plane, 0), value.shape())
    for number in range(1, memory_map.buffers):
        choice = Mux(buffer == number, memory_map.line(plane, number), choice)
    return choice


class LineBurst(data.StructLayout):
    """A burst within a line; ``last``: it ends the line."""
    def __init__(self, burst):
        super().__init__({"address": ADDRESS_BITS, "length": range(burst + 1), "last": 1})


class LineScan(wiring.Component):
    """The bursts of a picture, line by line: as many of ``burst`` words as a line has, and one with the rest.

    Golden: :meth:`golden.video.memory_map.MemoryMap.base` + ``y * pitch + n``. Lines are given from top to bottom, or, ``interlaced``,
    first
    the even ones and then the odd ones. An address is two numbers side by side: line ``base + y``, and the word within the line.

    Timing: the burst after ``advance`` stands in the next cycle. ``start`` may come at any time, and begins anew.

    Parameters
    ----------
    memory_map : :class:`golden.video.memory_map.MemoryMap`
    burst : int
        Words, a power of two: a burst then lies within one row of the memory.
    interlaced : bool
        Takes an even number of lines.

    Members
    -------
    start : In(1)
    base : In
        Number of the picture's first line in memory; ``o`` depends on it combinationally.
    advance : In(1)
        The burst is asked for: show the next one.
    active : Out(1)
        A burst is shown; low after the last one.
    o : Out(LineBurst(burst))
    """
    def __init__(self, memory_map: MemoryMap, *, burst, interlaced=False):
        self.check(memory_map, burst, interlaced)
        self.memory_map = memory_map
        self.burst = burst
        self.interlaced = interlaced
        super().__init__({
            "start": In(1),
            "base": In(range(memory_map.total_words // memory_map.pitch)),
            "advance": In(1),
            "active": Out(1),
            "o": Out(LineBurst(burst)),
        })

    @staticmethod
    def check(memory_map, burst, interlaced=False):
        """``ValueError`` if there is no such scan."""
        if burst < 1 or burst & (burst - 1):
            raise ValueError(f"a burst must be a power of two of words, not {burst!r}")
        if interlaced and memory_map.height % 2:
            raise ValueError(f"an interlaced picture must have an even number of lines, not {memory_map.height!r}")

    def elaborate(self, platform):
        m = Module()
        memory_map = self.memory_map
        first_of_last = (memory_map.line_words - 1) // self.burst * self.burst

        column = Signal(range(memory_map.pitch), reset_less=True)
        row    = Signal(range(memory_map.height), reset_less=True)
        m.d.comb += [
            self.o.last.eq(column == first_of_last),
            self.o.length.eq(Mux(self.o.last, memory_map.line_words - first_of_last, self.burst)),
            self.o.address.eq(Cat(column, self.base + row)),
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


class WordFifo(wiring.Component):
    """A queue of memory words in block RAM that can be emptied at once, and that tells how full it ever was.

    Timing: a word can leave 2 cycles after it came. Memory: ``(depth - 1) * 128`` bits, and a register.

    Parameters
    ----------
    depth : int
        Words.

    Members
    -------
    i, o : In(stream.Signature(128)), Out(stream.Signature(128))
        While ``level`` is below ``depth`` and at most one word a cycle has come since the queue was empty, ``i.ready`` is high.
    clear : In(1)
        The queue is empty in the next cycle; a word that comes in this one is lost.
    level : Out(range(depth + 1))
        Words in the queue.
    fill : Out(range(depth + 1))
        Greatest ``level`` since ``clear_fill``.
    clear_fill : In(1)
    """
    def __init__(self, depth):
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

    def elaborate(self, platform):
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
    """Sixteen pixels to a word, the first in the lowest byte; a line's last word leaves with what it has.

    The rest of a line's last word is what was there before. Timing: a pixel a cycle; a word is offered in the cycle after its last
    pixel. ``i.ready`` depends combinationally on ``o.ready``.

    Members
    -------
    i : In(stream.Signature({"value": 8, "last": 1}))
    o : Out(stream.Signature(128))
    clear : In(1)
        Forget the word under way and the one offered.
    """
    def __init__(self):
        super().__init__({
            "i": In(stream.Signature(data.StructLayout({"value": PIXEL_BITS, "last": 1}))),
            "o": Out(stream.Signature(8 * WORD_BYTES)),
            "clear": In(1),
        })

    def elaborate(self, platform):
        m = Module()
        word  = Signal(data.ArrayLayout(PIXEL_BITS, WORD_BYTES), reset_less=True)
        place = Signal(range(WORD_BYTES))
        m.d.comb += [self.i.ready.eq(~self.o.valid | self.o.ready), self.o.payload.eq(word)]
        with m.If(self.i.ready):
            m.d.sync += self.o.valid.eq(0)
            with m.If(self.i.valid):
                m.d.sync += [word[place].eq(self.i.p.value), place.eq(Mux(self.i.p.last, 0, place + 1))]
                m.d.sync += self.o.valid.eq(self.i.p.last | (place == WORD_BYTES - 1))
        with m.If(self.clear):
            m.d.sync += [place.eq(0), self.o.valid.eq(0)]
        return m


class PlanePair(data.StructLayout):
    """The pixels of two planes at the same place."""
    def __init__(self):
        super().__init__({"pixels": data.ArrayLayout(PIXEL_BITS, 2), **FLAGS})


class PixelUnpacker(wiring.Component):
    """Words of two planes to pixels with flags: the reverse of :class:`PixelPacker`, for pictures of a size that is known.

    Timing: latency 1 cycle, a pixel a cycle. ``o.valid`` does not depend on ``o.ready``.

    Parameters
    ----------
    memory_map : :class:`golden.video.memory_map.MemoryMap`
        Tells the size of the pictures.

    Members
    -------
    i : In(stream.Signature(128)).array(2)
        Both are taken at once.
    o : Out(stream.Signature(PlanePair()))
    clear : In(1)
        The next pixel is the first of a picture. One that is offered, or comes to be offered now, stays until it is taken.
    """
    def __init__(self, memory_map: MemoryMap):
        self.memory_map = memory_map
        super().__init__({
            "i": In(stream.Signature(8 * WORD_BYTES)).array(2),
            "o": Out(stream.Signature(PlanePair())),
            "clear": In(1),
        })

    def elaborate(self, platform):
        m = Module()
        x = Signal(range(self.memory_map.width))
        y = Signal(range(self.memory_map.height))
        last = Signal()
        low  = Signal()
        move = Signal()
        m.d.comb += [
            last.eq(x == self.memory_map.width - 1),
            low.eq(y == self.memory_map.height - 1),
            move.eq(self.i[0].valid & self.i[1].valid & (~self.o.valid | self.o.ready)),
        ]
        place = x[:(WORD_BYTES - 1).bit_length()]
        for side in self.i:
            m.d.comb += side.ready.eq(move & (last | (place == WORD_BYTES - 1)))
        with m.If(self.o.ready):
            m.d.sync += self.o.valid.eq(0)
        with m.If(move):
            m.d.sync += [self.o.valid.eq(1), x.eq(Mux(last, 0, x + 1))]
            m.d.sync += [pixel.eq(side.payload.word_select(place, PIXEL_BITS)) for pixel, side in zip(self.o.p.pixels, self.i)]
            m.d.sync += [self.o.p.first.eq((x == 0) & (y == 0)), self.o.p.last.eq(last), self.o.p.end.eq(last & low)]
            with m.If(last):
                m.d.sync += y.eq(Mux(low, 0, y + 1))
        with m.If(self.clear):
            m.d.sync += [x.eq(0), y.eq(0)]
        return m
