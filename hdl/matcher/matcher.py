"""The matcher: pixel pairs in, disparities out."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import Arithmetic, Engine, Fused, MatcherConfig

from .census import CensusStage
from .lines import LineStore
from .refine.fill import Fill
from .refine.median import Median
from .sequential.bec import Bec
from .sequential.engine import SequentialEngine
from .settings import held_settings, setting_ports
from .shift import RightShift
from .stream import DisparityWord, PixelPair
from .streaming.engine import StreamingEngine


__all__ = ["Matcher"]


class Matcher(wiring.Component):
    """Disparities of a rectified pair by the one-pass rule (thesis figure 17), by either method.

    The golden models are :func:`golden.matcher.labelling.match`, and with the cost ``FUSED`` :func:`golden.matcher.fused.match`.

    The picture's size is learned from the flags of its pixels; any height, any width up to ``max_width``, a new one each frame. The last
    lines of a frame leave without waiting for the next frame. What a ragged frame does is told at :class:`hdl.matcher.lines.LineStore`.

    Timing: a pixel each :attr:`clocks_per_pixel` cycles. A disparity leaves :attr:`latency_lines` lines and at most :attr:`latency_clocks`
    cycles after its pixel came, if pixels are offered and disparities taken without a pause, lines are no shorter than
    :attr:`full_rate_width`, and the matcher was empty as the frame began: a frame close behind another waits for that one's last lines.

    Members
    -------
    i : In(stream.Signature(PixelPair()))
    o : Out(stream.Signature(DisparityWord(config)))
    u1, u2, u3, in_use and more with the cost ``FUSED``, apply_settings : In
        Settings, see :func:`hdl.matcher.settings.setting_ports`. ``apply_settings`` takes them; until its first pulse those of ``config``
        are in
        force. More labels in use than there are, are as many as there are. Each block samples what concerns it as the first pixel of a
        frame reaches it. Set them between frames: before the first pixel of a frame is sent, they hold for all of it; once its first
        disparity has come out, they hold from the next one on.
    error : Out(1)
        A ragged frame came; stays up until ``clear``.
    clear : In(1)
    """
    def __init__(self, config: MatcherConfig):
        if config.method.arithmetic is Arithmetic.FLOAT:
            raise ValueError("the arithmetic float has no gateware; choose thesis or linear")
        self.fused = isinstance(config.method, Fused)
        if config.minimum and "minimum" not in config.settings:
            raise ValueError(f"the method {config.method.name} has gateware for the least disparity 0 only, not {config.minimum}")
        self.config = config
        self.streaming = config.engine is Engine.STREAMING
        # The fused cost, in front of the engine and behind it.
        self.shift_stage = RightShift(config) if self.fused else None
        self.census_stage = CensusStage(config) if self.fused else None
        self.fill_stage = Fill(config) if self.fused else None
        self.median_stage = Median(config) if self.fused else None
        self.line_store = LineStore(config, lines_below=self.lines_below, rows=self.census_stage.rows if self.census_stage else 3)
        self.bec = None if self.streaming else Bec(config)
        self.engine = StreamingEngine(config) if self.streaming else SequentialEngine(config)
        super().__init__({
            "i": In(stream.Signature(PixelPair())),
            "o": Out(stream.Signature(DisparityWord(config))),
            **setting_ports(config),
            "error": Out(1),
            "clear": In(1),
        })

    @property
    def lines_below(self):
        """Lines that follow a picture so that its last one is labelled; one more if the costs below a pixel count."""
        return (2 if isinstance(self.config.method, Fused) and self.config.method.vertical else 1) if self.streaming else 0

    @property
    def clocks_per_pixel(self):
        """Cycles a pixel inside a line."""
        return self.engine.clocks_per_pixel

    @property
    def latency_lines(self):
        """Lines from a pixel to its disparity: the window's below it, the one whose local disparities it needs, the refinement's."""
        return self.line_store.rows // 2 + max(self.lines_below, 1) + (self.fill_stage.LINES + self.median_stage.LINES if self.fused else 0)

    @property
    def line_clocks(self):
        """Cycles that a line takes beyond its pixels, whichever stage takes the most."""
        return max(2, self.config.method_as(Fused).cost.census_columns // 2) if self.fused else 2

    def frame_clocks(self, width, height):
        """Cycles from one frame's first disparity to the next one's, if pixels are offered and disparities taken without a pause.

        A bound that is reached but for a few cycles a line, less closely by lines shorter than :attr:`full_rate_width`. The lines that
        arrive before the first can be labelled take their time too.
        """
        if self.streaming:
            # One line more than the picture has comes below it, two with vertical support, and as many lines as the window has below a
            # pixel; those with a line above them wait for its disparities.
            flush = self.engine.source.flush_waves
            line = width + self.line_clocks + (flush if width < self.config.labels else 0)
            return (self.line_store.rows // 2 + 1 + self.lines_below) * line + flush + (height - 1) * max(line, self.engine.round_trip + 4)
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
        """Bound of a disparity's latency beyond :attr:`latency_lines` lines of ``clocks_per_pixel`` a pixel, in cycles.

        What waits in the Plus Line FIFO and in BEC's five stages goes at the pace of the loop; each of three line starts costs BEC's
        and the feeder's pipelines once more, and a frame's first line waits for the look-up tables.
        """
        if self.streaming:
            around = 0
            if self.fused:
                around = RightShift.LATENCY + self.census_stage.latency + self.fill_stage.latency + self.median_stage.latency
            # Every line that it waits for begins some cycles late, and a few at the ends.
            return LineStore.PLUS_DEPTH + self.engine.latency + (self.latency_lines + 4) * (self.line_clocks + 1) + around
        waiting = (LineStore.PLUS_DEPTH + 8) * self.clocks_per_pixel
        return waiting + 3 * (self.bec.latency + 2 * self.clocks_per_pixel)

    def elaborate(self, platform):
        m = Module()
        blocks = {"shift": self.shift_stage, "line_store": self.line_store, "bec": self.bec, "census": self.census_stage,
                  "engine": self.engine, "fill": self.fill_stage, "median": self.median_stage}
        chain = {name: block for name, block in blocks.items() if block is not None}
        source = wiring.flipped(self.i)
        for name, block in chain.items():
            m.submodules[name] = block
            wiring.connect(m, source, block.i)
            source = block.o
        wiring.connect(m, source, wiring.flipped(self.o))

        settings = held_settings(m, self, self.config)
        for name, value in settings.items():
            enabled = chain.get(name)
            if enabled is not None:
                m.d.comb += enabled.enable.eq(value)  # a stage of the refinement, under the name of its switch
        for block in chain.values():
            m.d.comb += [getattr(block, name).eq(value) for name, value in settings.items() if name in block.signature.members]

        with m.If(self.line_store.error):
            m.d.sync += self.error.eq(1)
        with m.Elif(self.clear):
            m.d.sync += self.error.eq(0)
        return m
