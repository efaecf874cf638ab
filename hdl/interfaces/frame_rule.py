"""From a stream with the marks of a bus to pixel pairs: the size of frames is that of the registers."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS
from golden.video.frame_rule import Closes, Fault

from ..matcher.stream import PixelPair


__all__ = ["FrameRule", "ReceivedPixel"]


class ReceivedPixel(data.StructLayout):
    """A pixel of both pictures, grey levels; ``first`` of its frame; ``closes``: the last of its line, or of its frame, see
    :class:`golden.video.frame_rule.Closes`.
    """
    def __init__(self):
        super().__init__({"left": PIXEL_BITS, "right": PIXEL_BITS, "first": 1, "closes": 1})


class FrameRule(wiring.Component):
    """Gives pixels the flags of :class:`PixelPair` by counting, and compares the marks of the stream with them.

    Golden: :func:`golden.video.frame_rule.received`, of what the line store makes of the stream at ``o``.

    A frame that contradicts the size is cut, see there; the next one is whole. Its last lines are output at once, as ``end`` is set at the
    faulty pixel, unless it is a start of a frame within one that tells of the fault.

    The size takes effect between two frames. Between them ``i`` waits while ``hold`` is set, from the cycle on in which ``idle`` is.

    Timing: combinational from ``i`` to ``o``; ``i.ready`` depends on ``o.ready``, and not on ``i``.

    Parameters
    ----------
    max_width, max_height : int
    closes : Closes
        What the stream marks.

    Members
    -------
    i : In(stream.Signature(ReceivedPixel()))
    o : Out(stream.Signature(PixelPair()))
    width, height : In
        Of a frame, at least 1; may change in a cycle in which ``idle`` is set.
    hold : In(1)
        No frame is to start.
    idle : Out(1)
        No frame is in progress, and none starts: ``hold`` is in effect.
    fault : Out(Fault)
        Other than ``NONE`` for one cycle at a time.
    """
    def __init__(self, max_width: int, max_height: int, closes: Closes):
        self.closes = closes
        super().__init__({
            "i": In(stream.Signature(ReceivedPixel())),
            "o": Out(stream.Signature(PixelPair())),
            "width": In(range(max_width + 1)),
            "height": In(range(max_height + 1)),
            "hold": In(1),
            "idle": Out(1),
            "fault": Out(Fault),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        word = self.i.p
        column   = Signal(len(self.width))  # of the next pixel of the frame in progress
        line     = Signal(len(self.height))
        inside   = Signal()         # a frame is in progress
        dropping = Signal(init=1)   # the rest of a frame is dropped; after reset that of one that was in progress
        holding  = Signal()

        # A pixel that is offered stays offered: `hold` waits until it was accepted.
        m.d.comb += [self.o.valid.eq(self.i.valid & (inside | word.first) & ~holding), self.i.ready.eq(self.o.ready & ~holding)]
        starts_held = Signal()
        m.d.comb += holding.eq(starts_held & ~inside)
        m.d.sync += starts_held.eq(self.hold & ~(self.o.valid & ~self.o.ready))
        m.d.comb += self.idle.eq(holding)

        x = Mux(word.first, 0, column)
        y = Mux(word.first, 0, line)
        line_ends   = Signal()
        frame_ends  = Signal()
        wrong       = Signal()
        m.d.comb += [
            line_ends.eq(x + 1 == self.width),
            frame_ends.eq(line_ends & (y + 1 == self.height)),
            wrong.eq(word.closes != (line_ends if self.closes is Closes.LINE else frame_ends)),
        ]
        # The width of a frame is that of its first line: where that is short, no end is sent, and the line store drops it.
        later = y != 0
        m.d.comb += [
            self.o.p.left.eq(word.left), self.o.p.right.eq(word.right), self.o.p.first.eq(word.first),
            self.o.p.last.eq(line_ends | (wrong & later)),
            self.o.p.end.eq(frame_ends | (wrong & (line_ends | later))),
        ]

        with m.If(self.i.valid & self.i.ready):
            with m.If(inside | word.first):
                m.d.sync += [
                    inside.eq(~wrong & ~frame_ends), dropping.eq(wrong),
                    column.eq(Mux(line_ends, 0, x + 1)), line.eq(y + line_ends),
                ]
                with m.If(inside & word.first):
                    m.d.comb += self.fault.eq(Fault.EARLY_START)
                with m.Elif(wrong):
                    m.d.comb += self.fault.eq(Mux(word.closes, Fault.EARLY_END, Fault.LATE_END))
            with m.Else():
                m.d.sync += dropping.eq(1)
                with m.If(~dropping):
                    m.d.comb += self.fault.eq(Fault.LATE_START)
        return m
