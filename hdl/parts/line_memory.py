"""A line of words in as few memory blocks as its length allows."""

from amaranth import *
from amaranth.hdl import ShapeLike
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from .delay import NO_COLLISION, data_register


__all__ = ["BLOCK_SHAPES", "LineMemory"]


#: Words and bits of a block of 9,216 bits, in its shapes, the widest last.
BLOCK_SHAPES = ((8192, 1), (4096, 2), (2048, 4), (1024, 9), (512, 18), (256, 36))


def blocks_of(depth: int, width: int) -> int:
    """Memory blocks of a memory all of whose blocks are as deep as it is, at most 8,192 words.

    Examples
    --------
    >>> blocks_of(720, 72), blocks_of(512, 72) + blocks_of(208, 72)
    (8, 6)
    """
    return min(-(-width // bits) for words, bits in BLOCK_SHAPES if words >= depth) if depth else 0


class LineMemory(wiring.Component):
    """A memory with a read and a write port, both always in use, which is made of two where that takes fewer blocks.

    A word is never read in the cycle in which it is written.

    Timing: ``o`` :attr:`LATENCY` cycles after ``address``; a word written can be read from the next cycle on. There is a register behind
    every block, which is the block's own, and another behind the selection.

    Memory: ``depth`` words.

    Members
    -------
    address : In(range(depth)), o : Out(shape)
    write : In(1), column : In(range(depth)), i : In(shape)
    """
    LATENCY = 3

    def __init__(self, shape: ShapeLike, depth: int):
        self.shape = shape
        self.depth = depth
        super().__init__({
            "address": In(range(depth)), "o": Out(shape), "write": In(1), "column": In(range(depth)), "i": In(shape),
        })

    @property
    def split(self) -> int:
        """Words of the first memory: all of them if a second one would not spare a block."""
        width = Shape.cast(self.shape).width
        return min((self.depth, *(words for words, _ in BLOCK_SHAPES if words < self.depth)),
                   key=lambda words: blocks_of(words, width) + blocks_of(self.depth - words, width))

    def elaborate(self, platform: object) -> Module:
        m = Module()
        split, read = self.split, []
        for start, size in ((0, split), (split, self.depth - split)):
            if not size:
                continue
            m.submodules[f"words_{start}"] = memory = Memory(shape=self.shape, depth=size, init=[], attrs=NO_COLLISION)
            read_port, write_port = memory.read_port(), memory.write_port()
            here = self.column >= start if start else self.column < size if size < self.depth else 1
            word = Signal(self.shape, name=f"word_{start}", reset_less=True)
            m.d.comb += [
                read_port.addr.eq(self.address - start if start else self.address), read_port.en.eq(1),
                write_port.addr.eq(self.column - start if start else self.column), write_port.data.eq(self.i),
                write_port.en.eq(self.write & here),
            ]
            m.d.sync += word.eq(read_port.data)
            read.append(word)
        upper = Signal(2)  # the word addressed is in the second memory
        m.d.sync += upper.eq(Cat(self.address >= split, upper))
        m.d.sync += data_register(m, self.o).eq(Mux(upper[1], read[-1], read[0]))
        return m
