"""The asynchronous FIFO of a camera, which loses frames whole or not at all."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from ..parts.queue import AsyncQueue
from .words import CameraWord


__all__ = ["CameraFifo"]


class CameraFifo(wiring.Component):
    """Words of a camera from its own domain, where nothing can wait, to ``sync``, where everything may.

    A frame that finds the FIFO full is cut: what came of it stands, a ``drop`` word follows as soon as there is room, the rest is not
    taken. A frame that begins while that word still waits, or with the FIFO full, is not taken at all. A frame in progress is cut too when
    ``cut`` is high, or the camera's domain is reset. So each ``first`` word that leaves is followed by the rest of its frame or by a
    ``drop`` word, and by nothing else. A frame passes while it comes. Golden: the frames themselves.

    A reset of the camera's domain empties the FIFO, and must last four cycles of either domain. A frame that was all in there is not
    counted.

    Timing: a word is offered 4 to 5 cycles of ``sync`` after it came. One word a cycle. ``sync`` must be at least half as fast as the
    camera's bytes.

    Memory: ``depth * 12`` bits, a block RAM of 512 words. How long a stall that rides out: :meth:`.CameraInput.stall_cycles`.

    Parameters
    ----------
    domain : str
        The camera's clock domain.
    depth : int
        Words, a power of two, at least 8.

    Members
    -------
    i : In(CameraWord())
    strobe : In(1)
        In ``domain``: ``i`` is a word. Frames begin with ``first`` and close with ``end`` or ``drop``.
    overflow : Out(1)
        In ``domain``, one cycle: a frame is lost to a full FIFO.
    skipped : Out(1)
        In ``domain``, one cycle: it had not begun yet, and no ``drop`` word tells of it.
    cut : In(1)
        In ``sync``: end the frame in progress.
    o : Out(stream.Signature(CameraWord()))
        In ``sync``.
    dropped : Out(1)
        In ``sync``, one cycle: a ``drop`` word is on its way.
    """
    def __init__(self, domain: str, depth: int):
        self.check_depth(depth)
        self.domain = domain
        self.depth = depth
        super().__init__({
            "i": In(CameraWord()),
            "strobe": In(1),
            "overflow": Out(1),
            "skipped": Out(1),
            "cut": In(1),
            "o": Out(stream.Signature(CameraWord())),
            "dropped": Out(1),
        })

    @staticmethod
    def check_depth(depth: int) -> None:
        """Raise :class:`ValueError` unless there can be a FIFO of ``depth``."""
        if depth < 8 or depth & depth - 1:
            raise ValueError(f"the FIFO of a camera must hold a power of two of words, at least 8, not {depth!r}")

    def elaborate(self, platform):
        m = Module()
        # Unbuffered: the output register below is its buffer, and `emptied` is seen although the consumer stalls.
        m.submodules.queue = queue = AsyncQueue(CameraWord(), self.depth, i_domain=self.domain, buffered=False)
        domain = m.d[self.domain]

        # The camera's side.
        put     = queue.i.p
        passing = Signal()      # the frame in progress, or the last one, is taken
        owed    = Signal()      # a `drop` word waits for room
        m.d.comb += put.eq(self.i)
        with m.If(self.strobe & self.i.first):
            with m.If(queue.i.ready & ~owed):
                m.d.comb += queue.i.valid.eq(1)
                domain += passing.eq(1)
            with m.Else():
                m.d.comb += [self.overflow.eq(1), self.skipped.eq(1)]
                domain += passing.eq(0)
        with m.Elif(self.strobe & passing):
            m.d.comb += [queue.i.valid.eq(1), self.overflow.eq(~queue.i.ready)]
            domain += [owed.eq(~queue.i.ready), passing.eq(queue.i.ready)]
        with m.Elif(owed):
            m.d.comb += [put.eq(CameraWord().const({"drop": 1})), queue.i.valid.eq(1)]
            domain += owed.eq(~queue.i.ready)

        # The consumer's side.
        word   = queue.o.p
        inside = Signal()       # a frame has begun
        ending = Signal()       # it is to be cut
        with m.If((self.cut | queue.emptied) & inside):
            m.d.sync += ending.eq(1)
        with m.If(self.o.ready | ~self.o.valid):
            m.d.sync += [self.o.valid.eq(0), self.o.p.eq(word)]
            with m.If(ending):
                m.d.comb += self.dropped.eq(1)
                m.d.sync += [self.o.valid.eq(1), self.o.p.eq(CameraWord().const({"drop": 1})), inside.eq(0), ending.eq(0)]
            with m.Else():
                m.d.comb += queue.o.ready.eq(1)
                with m.If(queue.o.valid & (word.first | inside)):
                    m.d.comb += self.dropped.eq(word.drop)
                    m.d.sync += [self.o.valid.eq(1), inside.eq(~word.end & ~word.drop)]
        return m
