"""The matcher: pixel pairs in, disparities out."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import WEIGHT_BITS, MatcherConfig

from .bec import Bec
from .lines import LineStore
from .sequential import SequentialEngine
from .stream import DisparityWord, PixelPair


__all__ = ["Matcher"]


class Matcher(wiring.Component):
    """Disparities of a rectified pair by the one-pass rule (thesis figure 17); the golden model is :func:`golden.labelling.match`.

    The picture's size is learned from the flags of its pixels; any height, any width up to ``max_width``, a new one each frame. The last
    lines of a frame leave without waiting for the next frame. What a ragged frame does is told at :class:`hdl.lines.LineStore`.

    Timing: a pixel each :attr:`clocks_per_pixel` cycles. A disparity leaves two lines after its pixel came, less than
    :attr:`latency_clocks` cycles later.

    Members
    -------
    i : In(stream.Signature(PixelPair()))
    o : Out(stream.Signature(DisparityWord(config)))
    u1, u2, u3 : In(WEIGHT_BITS), initially those of ``config``
        Weights of the left, upper and lower neighbour, grey levels a pixel. Sampled as a frame's first pixel reaches the engine: hold them
        from the frame's first pixel to its first disparity.
    error : Out(1)
        A ragged frame came; stays up until ``clear``.
    clear : In(1)
    """
    def __init__(self, config: MatcherConfig):
        self.config = config
        self.line_store = LineStore(config)
        self.bec = Bec(config)
        self.engine = SequentialEngine(config)
        super().__init__({
            "i": In(stream.Signature(PixelPair())),
            "o": Out(stream.Signature(DisparityWord(config))),
            "u1": In(WEIGHT_BITS, init=config.u1),
            "u2": In(WEIGHT_BITS, init=config.u2),
            "u3": In(WEIGHT_BITS, init=config.u3),
            "error": Out(1),
            "clear": In(1),
        })

    @property
    def clocks_per_pixel(self):
        """Cycles a pixel inside a line."""
        return self.engine.clocks_per_pixel

    def elaborate(self, platform):
        m = Module()
        m.submodules.line_store = self.line_store
        m.submodules.bec = self.bec
        m.submodules.engine = self.engine
        wiring.connect(m, wiring.flipped(self.i), self.line_store.i)
        wiring.connect(m, self.line_store.o, self.bec.i)
        wiring.connect(m, self.bec.o, self.engine.i)
        wiring.connect(m, self.engine.o, wiring.flipped(self.o))
        m.d.comb += [self.engine.u1.eq(self.u1), self.engine.u2.eq(self.u2), self.engine.u3.eq(self.u3)]

        with m.If(self.line_store.error):
            m.d.sync += self.error.eq(1)
        with m.Elif(self.clear):
            m.d.sync += self.error.eq(0)
        return m
