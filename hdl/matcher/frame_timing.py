"""Adapter from frame timing signals to a stream of pixels."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS

from ..parts.queue import Queue
from .stream import PixelPair


__all__ = ["FrameTiming"]


class FrameTiming(wiring.Component):
    """Pixels under frame valid, line valid and pixel valid (thesis figure 18) as a stream.

    A pixel is one cycle with all three signals high. Line valid falls between lines, frame valid between frames. Golden: the picture
    itself.

    There is no back-pressure to the camera. A frame that begins while the FIFO still holds pixels is dropped whole; a frame that fills
    the FIFO is dropped from that pixel on, and is then a ragged frame to the matcher, which recovers at the next one. ``dropped`` counts
    both.

    Timing: a pixel is output 2 cycles after the next one, or after frame valid falls: only then is known whether it is the last. Frame
    valid must be low for 3 cycles at least, for the last pixel to leave before the next frame begins.

    Memory: ``depth * 19`` bits.

    Parameters
    ----------
    depth : int
        Pixels that the FIFO holds: how far the camera may be ahead of the matcher.

    Members
    -------
    frame_valid, line_valid, pixel_valid : In(1)
    left, right : In(8)
        Grey levels.
    o : Out(stream.Signature(PixelPair()))
    dropped : Out(16)
        Frames dropped, whole or in part; saturates.
    """
    def __init__(self, depth: int = 1024):
        if depth < 4:
            raise ValueError(f"the FIFO of the frame timing adapter must hold at least 4 pixels, not {depth!r}")
        self.depth = depth
        super().__init__({
            "frame_valid": In(1),
            "line_valid": In(1),
            "pixel_valid": In(1),
            "left": In(PIXEL_BITS),
            "right": In(PIXEL_BITS),
            "o": Out(stream.Signature(PixelPair())),
            "dropped": Out(16),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.fifo = fifo = Queue(PixelPair(), self.depth)
        wiring.connect(m, fifo.o, wiring.flipped(self.o))

        pixel = Signal()
        m.d.comb += pixel.eq(self.frame_valid & self.line_valid & self.pixel_valid)

        holding  = Signal()                 # `held` is a pixel, whose flags depend on the next cycle
        held     = Signal(PixelPair(), reset_less=True)
        start    = Signal(init=1)           # the next pixel is the first of its frame
        dropping = Signal(init=1)           # the rest of this frame is not sent; after reset, that of a frame in progress
        push     = Signal()
        word     = Signal(PixelPair())
        m.d.comb += [
            push.eq(holding & (pixel | ~self.frame_valid)),
            word.eq(held), fifo.i.payload.eq(word), fifo.i.valid.eq(push),
        ]
        # A line that ends in this cycle ends no later than the frame.
        with m.If(~self.frame_valid):
            m.d.comb += [word.last.eq(1), word.end.eq(1)]
            m.d.sync += [start.eq(1), dropping.eq(0), holding.eq(0)]
        with m.If(holding & ~self.line_valid):
            m.d.sync += held.last.eq(1)

        drop = Signal()
        with m.If(pixel):
            m.d.sync += start.eq(0)
            with m.If(start & (fifo.level != 0)):
                m.d.comb += drop.eq(1)
            with m.Elif(~dropping):
                m.d.sync += [holding.eq(1), held.left.eq(self.left), held.right.eq(self.right)]
                m.d.sync += [held.first.eq(start), held.last.eq(0), held.end.eq(0)]
        with m.If(push & ~fifo.i.ready):
            m.d.comb += drop.eq(1)
        with m.If(drop):
            m.d.sync += holding.eq(0)
            m.d.sync += dropping.eq(self.frame_valid)
            with m.If(~self.dropped.all()):
                m.d.sync += self.dropped.eq(self.dropped + 1)
        return m
