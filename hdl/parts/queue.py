"""FIFOs as streams: a word in, the same words out, in order."""

from amaranth import *
from amaranth.hdl import ShapeLike
from amaranth.lib import stream, wiring
from amaranth.lib.fifo import AsyncFIFO, AsyncFIFOBuffered, SyncFIFOBuffered
from amaranth.lib.wiring import In, Out


__all__ = ["AsyncQueue", "Queue"]


class Queue(wiring.Component):
    """FIFO within one clock domain.

    Golden: the words that were accepted, in order. Nothing is lost or repeated; ``o.payload`` holds until it is taken. A reset empties
    the queue: to empty it at any time, wrap it in ``ResetInserter``.

    Timing: latency 2 cycles, 1 with a depth of 1. Rate one word a cycle from a depth of 3 on, a word every second cycle below. No path
    leads from an input to an output combinationally: ``i.ready`` depends on how full the queue is, not on ``o.ready``.

    Memory: ``depth - 1`` words in block RAM, read synchronously, and one word in its output register. A depth of 1 is a register.

    Parameters
    ----------
    shape : shape-like
        Payload of both streams.
    depth : int
        Words that are accepted while ``o`` stalls, from 1 on. All of them only once the first has reached the output register, in the
        cycle after it was accepted: until then the queue is full with one less.

    Members
    -------
    i : In(stream.Signature(shape))
    o : Out(stream.Signature(shape))
    level : Out(range(depth + 1))
        Words accepted and not yet taken; a word counts from the cycle after it was accepted.
    """
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
        m.submodules.fifo = fifo = SyncFIFOBuffered(width=Shape.cast(self.i.p.shape()).width, depth=self.depth)
        _connect(m, self, fifo)
        m.d.comb += self.level.eq(fifo.level)
        return m


class AsyncQueue(wiring.Component):
    """FIFO from one clock domain to another.

    Golden: the words that were accepted, in order. A reset of ``i_domain`` empties the queue and must last four cycles of either domain;
    a reset of ``o_domain`` alone loses the word in the output register at most.

    Timing: a word is offered 2 to 3 cycles of ``o_domain`` after it was accepted, a cycle later if ``buffered``. Rate one word a cycle of
    the slower clock. Synchronisers take the pointers across in Gray code: their bits must not be apart by a period of the faster clock,
    all other paths between the domains are false ones.

    Memory: ``depth`` words in block RAM, read synchronously, and one word in an output register if ``buffered``.

    Parameters
    ----------
    shape : shape-like
        Payload of both streams.
    depth : int
        Words of the memory, a power of two, at least 8: with fewer the pointers' way across would cost rate.
    i_domain, o_domain : str
        Clock domains of ``i`` and of all other members.
    buffered : bool
        With an output register, for a memory that is slow to give its word; ``emptied`` then waits for ``o`` to be taken.

    Members
    -------
    i : In(stream.Signature(shape))
        In ``i_domain``.
    o : Out(stream.Signature(shape))
        In ``o_domain``.
    level : Out(range(depth + 1)), with one more if ``buffered``
        Words that ``o_domain`` knows to be in the queue; if ``buffered``, those of the cycle before.
    emptied : Out(1)
        A reset of ``i_domain`` has emptied the queue; for at least a cycle.
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
