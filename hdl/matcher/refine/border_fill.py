"""The fill of pixels that failed the check, with the slope of the surface at a line's left border."""

from typing import ClassVar

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig
from golden.matcher.recursive.border_fill import BORDER_SPAN, LEAST_SPAN, SLOPE_BITS

from ...parts.delay import SkidRegister, StreamRegister, data_register
from ...parts.queue import Queue
from ..stage import Stage
from ..stream import LabelWord
from .fill import Fill


__all__ = ["BorderFill", "BorderSlope", "Surface"]


class Surface(data.StructLayout):
    """The surface at the left border of a line: its ``slope`` a column, and its ``rise`` from the first passing pixel to the column 0.

    In :data:`golden.matcher.recursive.border_fill.SLOPE_BITS` fractions of a label's unit; both 0 without a slope.
    """
    def __init__(self, config: MatcherConfig):
        steepest, rise = steepest_slope(config), greatest_rise(config)
        super().__init__({"slope": signed(steepest.bit_length() + 1), "rise": signed(max(rise.bit_length(), SLOPE_BITS) + 1)})


def steepest_slope(config: MatcherConfig) -> int:
    """Largest slope: a step of one label from column to column, of all labels at most."""
    scale = config.method.disparity_scale
    return max(scale * min(span, config.labels - 1) * ((1 << SLOPE_BITS) // span) for span in range(LEAST_SPAN, BORDER_SPAN + 1))


def greatest_rise(config: MatcherConfig) -> int:
    """Largest rise to the column 0, from the first passing pixel of the longest line."""
    return steepest_slope(config) * max(config.max_width - 1 - LEAST_SPAN, 0)


class BorderSlope(wiring.Component):
    """The surface at the left border of every line. Golden: :func:`golden.matcher.recursive.border_fill.border_slope`.

    Timing: a pixel a cycle, with any pauses; ``o`` is valid for a cycle, :attr:`LATENCY` cycles after a line's last pixel.

    Arithmetic: two multipliers, used once a line.

    Parameters
    ----------
    config : :class:`MatcherConfig`

    Members
    -------
    i : In(LabelWord(config)), valid : In(1)
    enable : In(1)
        Off: there is no slope. Sampled as the word marked ``first`` is valid.
    o : Out(Surface(config)), done : Out(1)
    """
    LATENCY = 6

    def __init__(self, config: MatcherConfig):
        self.config = config
        super().__init__({
            "i": In(LabelWord(config)),
            "valid": In(1),
            "enable": In(1),
            "o": Out(Surface(config)),
            "done": Out(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        scale  = config.method.disparity_scale
        pixel  = data.StructLayout({"passed": 1, "last": 1, "enable": 1})

        # The step from the passing pixel before, whichever line that was on.
        greatest = (config.labels - 1) * scale
        before   = Signal.like(self.i.label, reset_less=True)
        step     = Signal(range(-greatest, greatest + 1), reset_less=True)
        stepped  = Signal(pixel, reset_less=True)
        s1_valid = Signal()
        m.d.sync += [s1_valid.eq(self.valid), step.eq(self.i.label - before)]
        with m.If(self.valid):
            m.d.sync += [stepped.passed.eq(self.i.passed), stepped.last.eq(self.i.last)]
            with m.If(self.i.first):
                m.d.sync += stepped.enable.eq(self.enable)
            with m.If(self.i.passed):
                m.d.sync += before.eq(self.i.label)

        small    = Signal(range(-scale, scale + 1), reset_less=True)
        is_small = Signal(reset_less=True)
        now      = Signal(pixel, reset_less=True)
        s2_valid = Signal()
        m.d.sync += [small.eq(step), is_small.eq((step >= -scale) & (step <= scale)), now.eq(stepped), s2_valid.eq(s1_valid)]

        # How far the surface reaches, and how much it falls on the way. Up to the first passing pixel all of it starts anew.
        fall_max = min(config.labels - 1, BORDER_SPAN) * scale
        starts   = Signal(init=1)                       # the pixel is the first of its line
        seen     = Signal()                             # a pixel of the line passed
        goes_on  = Signal(reset_less=True)
        x0       = Signal(range(config.max_width), reset_less=True)
        away     = Signal(range(BORDER_SPAN + 2), reset_less=True)  # columns from x0 to this pixel; saturates
        span     = Signal(range(BORDER_SPAN + 1), reset_less=True)
        fall     = Signal(range(-fall_max, fall_max + 1), reset_less=True)
        enabled  = Signal(reset_less=True)
        s3_done  = Signal()
        m.d.sync += s3_done.eq(s2_valid & now.last)
        with m.If(s2_valid):
            m.d.sync += [starts.eq(now.last), seen.eq(~now.last & (seen | now.passed)), enabled.eq(now.enable)]
            with m.If(~seen):
                m.d.sync += [x0.eq(Mux(starts, 0, x0 + 1)), goes_on.eq(1), away.eq(1), fall.eq(0)]
            with m.Else():
                with m.If(away <= BORDER_SPAN):
                    m.d.sync += away.eq(away + 1)
                with m.If(now.passed):
                    with m.If(goes_on & is_small & (away <= BORDER_SPAN)):
                        m.d.sync += [span.eq(away), fall.eq(fall - small)]
                    with m.Else():
                        m.d.sync += goes_on.eq(0)

        # A table divides by the span. Registers on both sides of the multipliers, whose blocks include them.
        reciprocal = Signal(range((1 << SLOPE_BITS) // LEAST_SPAN + 1), reset_less=True)
        factor     = Signal.like(fall, reset_less=True)
        column     = [Signal.like(x0, name=f"column_{n}", reset_less=True) for n in range(2)]
        slope      = Signal(self.o.slope.shape(), name="slope_now", reset_less=True)
        done       = Signal(2)
        m.d.sync += [factor.eq(fall), slope.eq(factor * reciprocal), Cat(done, self.done).eq(Cat(s3_done, done)), reciprocal.eq(0)]
        m.d.sync += [later.eq(earlier) for later, earlier in zip(column, [x0, *column])]
        with m.Switch(span):
            for columns in range(LEAST_SPAN, BORDER_SPAN + 1):
                with m.Case(columns):
                    m.d.sync += reciprocal.eq(Mux(enabled, (1 << SLOPE_BITS) // columns, 0))
        word = data_register(m, self.o)
        m.d.sync += [word.slope.eq(slope), word.rise.eq(slope * column[-1])]
        return m


class BorderFill(Stage):
    """Replaces the labels of pixels that failed the check as :class:`Fill` does, but left of a line's first passing pixel the surface goes
    on with its slope.

    Golden: :func:`golden.matcher.recursive.border_fill.border_fill`.

    Frames as of :class:`Fill`; labels are at most ``labels - 1`` pixels.

    Timing: as :class:`Fill`. ``i.ready`` is low, too, while :attr:`LINES` complete lines wait, and depends on registers only.

    Memory: that of :class:`Fill`, and a :class:`Surface` for each of :attr:`LINES` lines.

    Parameters
    ----------
    config : :class:`MatcherConfig`
        With a method that refines its labels.

    Members
    -------
    i : In(stream.Signature(LabelWord(config)))
    o : Out(stream.Signature(LabelWord(config)))
    enable : In(1)
        Off: labels are unchanged, at the same latency. Sampled as the word marked ``first`` is accepted.
    """
    name = "fill"
    settings: ClassVar = Fill.settings
    lines = Fill.lines
    line_clocks = Fill.line_clocks
    LINES = 16          # more lines of one pixel than are in flight if nothing stalls
    OUTPUT_CLOCKS = 3 + SkidRegister.LATENCY

    def __init__(self, config: MatcherConfig):
        self.config = config
        self.slope = BorderSlope(config)
        # A line's surface is behind its queue and the register there when its first pixel is.
        self.fill = Fill(config, pause=BorderSlope.LATENCY + Queue.LATENCY + StreamRegister.LATENCY - (Fill.SETTLING + 2))
        super().__init__({
            "i": In(stream.Signature(LabelWord(config))),
            "o": Out(stream.Signature(LabelWord(config))),
            "enable": In(1),
        })

    @property
    def latency(self) -> int:
        """Cycles beyond a line from a pixel to its result, if no earlier line is queued."""
        return self.fill.latency + self.OUTPUT_CLOCKS

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        m.submodules.fill, m.submodules.slope = fill, slope = self.fill, self.slope
        m.submodules.surfaces = surfaces = Queue(Surface(config), self.LINES)
        m.submodules.surface_head = surface_head = StreamRegister(Surface(config))
        wiring.connect(m, surfaces.o, surface_head.i)
        surface = surface_head.o
        accepted = Signal()
        room     = Signal(init=1)
        m.d.comb += [
            accepted.eq(self.i.valid & self.i.ready), self.i.ready.eq(fill.i.ready & room),
            fill.i.payload.eq(self.i.payload), fill.i.valid.eq(self.i.valid & room), fill.enable.eq(self.enable),
            slope.i.eq(self.i.payload), slope.valid.eq(accepted), slope.enable.eq(self.enable),
            surfaces.i.payload.eq(slope.o), surfaces.i.valid.eq(slope.done),
        ]

        # The median's `ready` ends here: it would lead through both fills to their queues.
        m.submodules.output = output = SkidRegister(LabelWord(config))
        wiring.connect(m, output.o, wiring.flipped(self.o))

        # Pixels are output as their surface is known: no other condition is needed.
        advance = Signal()
        moved   = Signal()
        pixel   = fill.o.p
        m.d.comb += [
            advance.eq(~output.i.valid | output.i.ready), moved.eq(fill.o.valid & advance), fill.o.ready.eq(advance),
            surface.ready.eq(moved & pixel.last),
        ]
        lines = Signal(range(self.LINES + 1))  # accepted to the end, not yet output
        more  = Signal.like(lines)
        m.d.comb += more.eq(lines + (accepted & self.i.p.last) - surface.ready)
        m.d.sync += [lines.eq(more), room.eq(more != self.LINES)]

        # The height of the surface above the first passing pixel, which has the label of those to its left.
        starts = Signal(init=1)
        seen   = Signal()
        height = Signal.like(surface.p.rise, reset_less=True)
        with m.If(moved):
            m.d.sync += [
                starts.eq(pixel.last), seen.eq(~pixel.last & (seen | pixel.passed)),
                height.eq(Mux(starts, surface.p.rise, height - surface.p.slope)),
            ]

        # Its label, rounded, in one carry chain: the bit below the lowest one generates the carry.
        greatest  = (config.labels - 1) * config.method.disparity_scale
        limit     = (greatest_rise(config) >> SLOPE_BITS) + 1
        words     = [Signal(LabelWord(config), name=f"word_{n}", reset_less=True) for n in range(2)]
        valid     = Signal(2)
        is_border = Signal(2, reset_less=True)
        label     = Signal(range(-limit, greatest + limit + 1), reset_less=True)
        word      = Signal(LabelWord(config), reset_less=True)
        o_valid   = Signal()
        whole     = height[SLOPE_BITS:].as_signed()
        m.d.comb += [output.i.valid.eq(o_valid), output.i.payload.eq(word)]
        with m.If(advance):
            m.d.sync += [
                Cat(valid, o_valid).eq(Cat(moved, valid)), is_border.eq(Cat(~(seen | pixel.passed), is_border)),
                words[0].eq(pixel), words[1].eq(words[0]), word.eq(words[1]),
                label.eq((Cat(Const(1, 1), words[0].label, Const(0, 1)).as_signed() + Cat(height[SLOPE_BITS - 1], whole).as_signed()) >> 1),
            ]
            with m.If(is_border[-1]):
                m.d.sync += word.label.eq(Mux(label < 0, 0, Mux(label > greatest, greatest, label)))
        return m
