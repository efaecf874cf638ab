"""FIFOs as streams, within a clock domain and between two."""

from amaranth import *
from amaranth.hdl import ShapeLike
from amaranth.lib import stream, wiring
from amaranth.lib.fifo import AsyncFIFO, AsyncFIFOBuffered, SyncFIFOBuffered
from amaranth.lib.wiring import In, Out

from .delay import NO_COLLISION


__all__ = ["AsyncQueue", "Queue"]


class Queue(wiring.Component):
    """FIFO within one clock domain.

    Golden: the words that were accepted, in order. Nothing is lost or repeated; ``o.payload`` holds until it is accepted. A reset empties
    the queue: to empty it at any time, wrap it in ``ResetInserter``.

    Timing: latency 2 cycles, 1 with a depth of 1. Rate one word a cycle from a depth of 3 on, a word every second cycle below. There is no
    combinational path from an input to an output: ``i.ready`` depends on the level, not on ``o.ready``.

    Memory: ``depth - 1`` words in block RAM, read synchronously, and one word in its output register. A depth of 1 is a register.

    Parameters
    ----------
    shape : shape-like
        Payload of both streams.
    depth : int
        Words that the queue holds, at least 1. ``i.ready`` is high while ``level`` is below ``depth``; with a depth of 2 it is low in the
        cycle after a word enters the empty queue too.

    Members
    -------
    i : In(stream.Signature(shape))
    o : Out(stream.Signature(shape))
    level : Out(range(depth + 1))
        Words in the queue; a word counts from the cycle after ``i`` accepted it to the one in which ``o`` is accepted.
    """
    LATENCY = 2  # from a depth of 2 on

    def __init__(self, shape: ShapeLike, depth: int):
        if depth < 1:
            raise ValueError(f"a queue must hold at least 1 word, not {depth!r}")
        self.depth = depth
        super().__init__({
            "i": In(stream.Signature(shape)),
            "o": Out(stream.Signature(shape)),
            "level": Out(range(depth + 1)),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.fifo = fifo = _MarkedFIFO(width=Shape.cast(self.i.p.shape()).width, depth=self.depth)
        _connect(m, self, fifo)
        m.d.comb += self.level.eq(fifo.level)
        return m


class _MarkedFIFO(SyncFIFOBuffered):
    """The library's FIFO; its memory needs no bypass: it is not read while it is empty and not written while it is full."""
    def elaborate(self, platform: object) -> Module:
        m = super().elaborate(platform)
        if self.depth > 1:
            m.submodules.storage.attrs.update(NO_COLLISION)
        return m


class AsyncQueue(wiring.Component):
    """FIFO from one clock domain to another.

    Golden: the words that were accepted, in order. A reset of ``i_domain`` empties the queue and must last four cycles of either domain;
    a reset of ``o_domain`` alone loses the word in the output register at most.

    Timing: a word is offered 2 to 3 cycles of ``o_domain`` after it was accepted, a cycle later if ``buffered``. Rate one word a cycle of
    the slower clock. The pointers cross in Gray code: the skew between their bits must be below a period of the faster clock. All other
    paths between the domains are false paths.

    Memory: ``depth`` words in block RAM, read synchronously, and one word in an output register if ``buffered``.

    Parameters
    ----------
    shape : shape-like
        Payload of both streams.
    depth : int
        Words of the memory, a power of two, at least 8: with fewer the latency of the pointers' crossing would cost rate.
    i_domain, o_domain : str
        Clock domains of ``i`` and of all other members.
    buffered : bool
        Adds an output register, which takes the memory's read access out of the path that follows; ``emptied`` then waits while ``o``
        stalls.

    Members
    -------
    i : In(stream.Signature(shape))
        In ``i_domain``.
    o : Out(stream.Signature(shape))
        In ``o_domain``.
    level : Out(range(depth + 1)), with one more if ``buffered``
        Words in the queue as ``o_domain`` sees them; if ``buffered``, a cycle late.
    emptied : Out(1)
        A reset of ``i_domain`` has emptied the queue; high for at least a cycle.
    """
    def __init__(self, shape: ShapeLike, depth: int, *, i_domain: str = "sync", o_domain: str = "sync", buffered: bool = True):
        if depth < 8 or depth & (depth - 1):
            raise ValueError(f"a queue between clocks must hold a power of two of words, at least 8, not {depth!r}")
        self.depth = depth
        self.i_domain = i_domain
        self.o_domain = o_domain
        self.buffered = buffered
        super().__init__({
            "i": In(stream.Signature(shape)),
            "o": Out(stream.Signature(shape)),
            "level": Out(range(depth + buffered + 1)),
            "emptied": Out(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        kind = AsyncFIFOBuffered if self.buffered else AsyncFIFO
        m.submodules.fifo = fifo = kind(width=Shape.cast(self.i.p.shape()).width, depth=self.depth + self.buffered,
                                        w_domain=self.i_domain, r_domain=self.o_domain)
        _connect(m, self, fifo)
        m.d.comb += [self.level.eq(fifo.r_level), self.emptied.eq(fifo.r_rst)]
        return m


def _connect(m: Module, queue, fifo) -> None:
    wiring.connect(m, wiring.flipped(queue.i), fifo.w_stream)
    wiring.connect(m, fifo.r_stream, wiring.flipped(queue.o))
