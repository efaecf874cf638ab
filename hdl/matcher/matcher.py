"""The matcher: pixel pairs in, disparities out."""

from typing import Any

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Member, Out

from golden.config import Arithmetic, MatcherConfig

from .lines import LineStore
from .methods import compose
from .settings import held_settings, setting_ports
from .stream import DisparityWord, PixelPair


__all__ = ["Matcher", "matcher_ports"]


# Cycles that a line takes beyond its pixels in the line store.
_LINE_STORE_CLOCKS = 1


def matcher_ports(config: MatcherConfig) -> dict[str, Member]:
    """Members of :class:`Matcher`, and of what stands in its place."""
    return {
        "i": In(stream.Signature(PixelPair())),
        "o": Out(stream.Signature(DisparityWord(config))),
        **setting_ports(config),
        "error": Out(1),
        "clear": In(1),
    }


class Matcher(wiring.Component):
    """Disparities of a rectified pair by the one-pass rule (thesis figure 17): a line store and an engine, between a method's stages.

    The golden model is :func:`golden.matcher.matcher.match`.

    Frames may have any height and any width up to ``max_width``, and may differ in size; the flags of their pixels delimit them. The last
    lines of a frame are output without waiting for the next frame. :class:`hdl.matcher.lines.LineStore` states what becomes of a ragged
    frame.

    Timing: a pixel each :attr:`clocks_per_pixel` cycles. A disparity is output :attr:`latency_lines` lines and at most
    :attr:`latency_clocks` cycles after its pixel was accepted, if neither ``i`` nor ``o`` stalls, lines are no shorter than
    :attr:`full_rate_width`, and the matcher was empty as the frame began: a frame close behind another waits for that one's last lines.

    Members
    -------
    i : In(stream.Signature(PixelPair()))
    o : Out(stream.Signature(DisparityWord(config)))
    u1, u2, u3, in_use, further settings of the method, apply_settings : In
        See :func:`hdl.matcher.settings.setting_ports`. A pulse of ``apply_settings`` puts them into force; until the first one those of
        ``config`` are. ``in_use`` above the number of labels means all. Each block samples its settings as the first pixel of a frame
        reaches it. Set before the first pixel of a frame is sent, they hold for all of it; set after its first disparity was output,
        from the next frame on.
    error : Out(1)
        A ragged frame was accepted; set until ``clear``.
    clear : In(1)
    """
    def __init__(self, config: MatcherConfig):
        if config.method.arithmetic is Arithmetic.FLOAT:
            raise ValueError("the arithmetic float has no gateware; choose thesis or linear")
        self.config = config
        self.parts = parts = compose(config)
        self.engine = parts.engine
        rows = max(part.rows for part in (*parts.stages, parts.engine))
        self.line_store = LineStore(config, lines_below=parts.engine.lines_below, rows=rows)
        super().__init__(matcher_ports(config))

    @property
    def clocks_per_pixel(self) -> int:
        """Cycles a pixel inside a line."""
        return self.engine.clocks_per_pixel

    @property
    def latency_lines(self) -> int:
        """Lines from a pixel to its disparity: those of the window below it, those whose costs it needs, those of the stages."""
        return self.line_store.rows // 2 + max(self.engine.lines_below, 1) + sum(stage.lines for stage in self.parts.stages)

    @property
    def line_clocks(self) -> int:
        """Cycles that a line takes beyond its pixels at one pixel a cycle, whichever part takes the most."""
        parts = self.parts
        in_front = _LINE_STORE_CLOCKS + sum(stage.line_clocks for stage in parts.columns)
        lengthened = sum(stage.line_clocks for stage in parts.pixels)
        of_engine = parts.engine.preroll_clocks + max(parts.engine.padding_clocks, in_front)
        return max([lengthened + of_engine, *(stage.line_clocks for stage in parts.labels)])

    def frame_clocks(self, width: int, height: int) -> int:
        """Cycles from one frame's first disparity to the next one's, if neither ``i`` nor ``o`` stalls.

        Exact for frames of two lines or more that are no narrower than :attr:`full_rate_width`, unless the engine waits for a stage behind
        it; otherwise an upper bound.
        """
        stages, engine, lines_above = self.parts.labels, self.engine, self.line_store.rows // 2
        of_stages = [(height + stage.frame_lines) * (width + stage.line_clocks) for stage in stages]
        # Between frames a stage accepts nothing for some lines; the engine gives nothing while the line store fills and below a picture.
        waits = [(stage.frame_lines - lines_above - engine.lines_below) * (width + stage.line_clocks) for stage in stages]
        return max([engine.frame_clocks(width, height, lines_above, self.line_clocks) + max([0, *waits]), *of_stages])

    @property
    def full_rate_width(self) -> int:
        """Shortest line, in pixels, that is labelled at :attr:`clocks_per_pixel`; shorter ones take as long, or so many cycles more."""
        return self.engine.full_rate_width

    @property
    def latency_clocks(self) -> int:
        """Bound of a disparity's latency beyond :attr:`latency_lines` lines of ``clocks_per_pixel`` a pixel, in cycles."""
        return self.engine.latency_clocks(self.latency_lines, self.line_clocks) + sum(stage.latency for stage in self.parts.stages)

    def elaborate(self, platform: object) -> Module:
        m = Module()
        parts = self.parts
        blocks: list[tuple[str, Any]] = [*((stage.name, stage) for stage in parts.pixels), ("line_store", self.line_store),
                  *((stage.name, stage) for stage in parts.columns), ("engine", self.engine),
                  *((stage.name, stage) for stage in parts.labels)]
        source = wiring.flipped(self.i)
        for name, block in blocks:
            m.submodules[name] = block
            wiring.connect(m, source, block.i)
            source = block.o
        wiring.connect(m, source, wiring.flipped(self.o))

        settings = held_settings(m, self, self.config)
        for stage in parts.stages:
            m.d.comb += [getattr(stage, member).eq(settings[name]) for member, name in stage.settings.items()]
        m.d.comb += [getattr(self.engine, name).eq(value) for name, value in settings.items() if name in self.engine.signature.members]

        with m.If(self.line_store.error):
            m.d.sync += self.error.eq(1)
        with m.Elif(self.clear):
            m.d.sync += self.error.eq(0)
        return m
