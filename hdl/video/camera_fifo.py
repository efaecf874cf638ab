"""The asynchronous FIFO of a camera, which drops whole frames."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from ..parts.queue import AsyncQueue
from .words import CameraWord


__all__ = ["CameraFifo"]


class CameraFifo(wiring.Component):
    """Takes the words of a camera from its domain, which has no back-pressure, to ``sync``, which has.

    When the FIFO is full, the frame in progress is cut: words already accepted remain, a ``drop`` word follows as soon as there is space,
    and the rest is discarded. A frame that begins while that word waits, or with the FIFO full, is discarded whole. A frame in progress is
    also cut when ``cut`` is high, or the camera's domain is reset. So each ``first`` word at ``o`` is followed by the rest of its frame or
    by a ``drop`` word. Frames are not stored: a word passes as soon as it arrives. Golden: the frames themselves.

    A reset of the camera's domain empties the FIFO, and must last four cycles of either domain. A frame that was entirely in the FIFO then
    is not counted as dropped.

    Timing: latency 4 to 5 cycles of ``sync``. One word a cycle. ``sync`` must be at least half as fast as the camera's bytes.

    Memory: ``depth * 12`` bits; 512 words are one block RAM. The longest stall without loss: :meth:`.CameraInput.stall_cycles`.

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
        In ``domain``, one cycle: that frame is discarded whole, without a ``drop`` word.
    cut : In(1)
        In ``sync``: cut the frame in progress.
    o : Out(stream.Signature(CameraWord()))
        In ``sync``.
    dropped : Out(1)
        In ``sync``, one cycle: a ``drop`` word is offered from the next cycle on.
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
        """Raise :class:`ValueError` unless ``depth`` is valid."""
        if depth < 8 or depth & depth - 1:
            raise ValueError(f"the FIFO of a camera must hold a power of two of words, at least 8, not {depth!r}")

    def elaborate(self, platform: object) -> Module:
        m = Module()
        # Unbuffered: the output register below is its buffer, and `emptied` is seen although the consumer stalls.
        m.submodules.queue = queue = AsyncQueue(CameraWord(), self.depth, i_domain=self.domain, buffered=False)
        domain = m.d[self.domain]

        # The camera's side. The queue's rule that an offer holds is not kept: without space a word is lost.
        accepting = Signal()    # the frame in progress, or the last one, is accepted
        drop_due  = Signal()    # a `drop` word waits for space
        m.d.comb += queue.i.p.eq(self.i)
        with m.If(self.strobe & self.i.first):
            with m.If(queue.i.ready & ~drop_due):
                m.d.comb += queue.i.valid.eq(1)
                domain += accepting.eq(1)
            with m.Else():
                m.d.comb += [self.overflow.eq(1), self.skipped.eq(1)]
                domain += accepting.eq(0)
        with m.Elif(self.strobe & accepting):
            m.d.comb += [queue.i.valid.eq(1), self.overflow.eq(~queue.i.ready)]
            domain += [drop_due.eq(~queue.i.ready), accepting.eq(queue.i.ready)]
        with m.Elif(drop_due):
            m.d.comb += [queue.i.p.eq(CameraWord().const({"drop": 1})), queue.i.valid.eq(1)]
            domain += drop_due.eq(~queue.i.ready)

        # The consumer's side.
        word     = queue.o.p
        in_frame = Signal()     # a frame has begun
        cutting  = Signal()     # it is to be cut
        with m.If((self.cut | queue.emptied) & in_frame):
            m.d.sync += cutting.eq(1)
        with m.If(self.o.ready | ~self.o.valid):
            m.d.sync += [self.o.valid.eq(0), self.o.p.eq(word)]
            with m.If(cutting):
                m.d.comb += self.dropped.eq(1)
                m.d.sync += [self.o.valid.eq(1), self.o.p.eq(CameraWord().const({"drop": 1})), in_frame.eq(0), cutting.eq(0)]
            with m.Else():
                m.d.comb += queue.o.ready.eq(1)
                with m.If(queue.o.valid & (word.first | in_frame)):
                    m.d.comb += self.dropped.eq(word.drop)
                    m.d.sync += [self.o.valid.eq(1), in_frame.eq(~word.end & ~word.drop)]
        return m
