"""The matcher: pixel pairs in, disparities out."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import IN_USE_BITS, WEIGHT_BITS, Arithmetic, Cost, Engine, MatcherConfig

from .bec import Bec
from .lines import LineStore
from .sequential import SequentialEngine
from .stream import DisparityWord, PixelPair
from .streaming import StreamingEngine


__all__ = ["Matcher"]


class Matcher(wiring.Component):
    """Disparities of a rectified pair by the one-pass rule (thesis figure 17); the golden model is :func:`golden.labelling.match`.

    The picture's size is learned from the flags of its pixels; any height, any width up to ``max_width``, a new one each frame. The last
    lines of a frame leave without waiting for the next frame. What a ragged frame does is told at :class:`hdl.lines.LineStore`.

    Timing: a pixel each :attr:`clocks_per_pixel` cycles. A disparity leaves two lines and at most :attr:`latency_clocks` cycles after its
    pixel came, if pixels are offered and disparities taken without a pause, lines are no shorter than :attr:`full_rate_width`, and the
    matcher was empty as the frame began: a frame close behind another waits for the last two lines of that one.

    Members
    -------
    i : In(stream.Signature(PixelPair()))
    o : Out(stream.Signature(DisparityWord(config)))
    u1, u2, u3 : In(WEIGHT_BITS)
        Weights of the left, upper and lower neighbour, grey levels a pixel.
    in_use : In(IN_USE_BITS)
        Labels in use, ``1 .. D``; more are as many as there are. Those above cost what a candidate outside the picture does.
    set_parameters : In(1)
        Takes ``u1, u2, u3, in_use``; until its first pulse those of ``config`` are in force. BEC and engine sample them as the first pixel
        of a frame reaches them, within about a line after it came. Set them between frames: before the first pixel of a frame is sent,
        they hold for all of it; once its first disparity has come out, they hold from the next one on.
    error : Out(1)
        A ragged frame came; stays up until ``clear``.
    clear : In(1)
    """
    def __init__(self, config: MatcherConfig):
        if config.arithmetic is Arithmetic.FLOAT:
            raise ValueError("the arithmetic float has no gateware; choose thesis or linear")
        if config.cost is not Cost.THESIS or config.minimum:
            raise ValueError(f"the gateware has the cost thesis and the minimum disparity 0, not {config.cost} and {config.minimum}")
        self.config = config
        self.streaming = config.engine is Engine.STREAMING
        self.line_store = LineStore(config, line_below=self.streaming)
        self.bec = None if self.streaming else Bec(config)
        self.engine = StreamingEngine(config) if self.streaming else SequentialEngine(config)
        super().__init__({
            "i": In(stream.Signature(PixelPair())),
            "o": Out(stream.Signature(DisparityWord(config))),
            "u1": In(WEIGHT_BITS),
            "u2": In(WEIGHT_BITS),
            "u3": In(WEIGHT_BITS),
            "in_use": In(IN_USE_BITS),
            "set_parameters": In(1),
            "error": Out(1),
            "clear": In(1),
        })

    @property
    def clocks_per_pixel(self):
        """Cycles a pixel inside a line."""
        return self.engine.clocks_per_pixel

    def frame_clocks(self, width, height):
        """Cycles from one frame's first disparity to the next one's, if pixels are offered and disparities taken without a pause.

        A bound that is reached but for a few cycles a line, less closely by lines shorter than :attr:`full_rate_width`. The line that
        arrives before the first can be labelled takes its time too.
        """
        if self.streaming:
            # Two lines more than the picture has come and go; those with a line above them wait for its disparities.
            return 3 * (width + 2) + (height - 1) * max(width + 2, self.engine.round_trip + 4)
        # The first line fills the Edata memory at BEC's pace, or as the look-up tables are filled; then a line is labelled as the one
        # below it arrives.
        first = max(width * self.bec.clocks_per_pixel, self.engine.fill_clocks + 1)
        return first + height * width * self.clocks_per_pixel + (height + 1) * self.engine.line_clocks

    @property
    def full_rate_width(self):
        """Shortest line, in pixels, that is labelled at :attr:`clocks_per_pixel`; shorter ones take as long."""
        return self.engine.round_trip if self.streaming else 1

    @property
    def latency_clocks(self):
        """Bound of a disparity's latency beyond two lines of ``clocks_per_pixel`` a pixel, in cycles.

        What waits in the Plus Line FIFO and in BEC's five stages goes at the pace of the loop; each of three line starts costs BEC's
        and the feeder's pipelines once more, and a frame's first line waits for the look-up tables.
        """
        if self.streaming:
            return LineStore.PLUS_DEPTH + self.engine.latency + 18
        waiting = (LineStore.PLUS_DEPTH + 8) * self.clocks_per_pixel
        return waiting + 3 * (self.bec.latency + 2 * self.clocks_per_pixel)

    def elaborate(self, platform):
        m = Module()
        m.submodules.line_store = self.line_store
        m.submodules.engine = self.engine
        wiring.connect(m, wiring.flipped(self.i), self.line_store.i)
        if self.streaming:
            wiring.connect(m, self.line_store.o, self.engine.i)
        else:
            m.submodules.bec = self.bec
            wiring.connect(m, self.line_store.o, self.bec.i)
            wiring.connect(m, self.bec.o, self.engine.i)
        wiring.connect(m, self.engine.o, wiring.flipped(self.o))

        config = self.config
        for name, block, default in (("u1", self.engine, config.u1), ("u2", self.engine, config.u2), ("u3", self.engine, config.u3),
                                     ("in_use", self.engine if self.streaming else self.bec, config.labels_in_use)):
            value = Signal.like(getattr(self, name), name=f"{name}_set", init=default)
            with m.If(self.set_parameters):
                m.d.sync += value.eq(getattr(self, name))
            m.d.comb += getattr(block, name).eq(value)

        with m.If(self.line_store.error):
            m.d.sync += self.error.eq(1)
        with m.Elif(self.clear):
            m.d.sync += self.error.eq(0)
        return m
