"""Arithmetic of BEC: sub-pixels, their buffers, cost energies and Edata."""

from typing import Any

from amaranth import *
from amaranth.hdl import ShapeLike
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Member, Out

from golden.config import IN_USE_BITS, PIXEL_BITS, Arithmetic, MatcherConfig

from ..stream import FLAGS, ColumnWord, copy_flags


__all__ = ["BuffersWord", "CostEnergy", "CostWord", "Edata", "EdataWord", "SubPixelBuffers", "SubPixelWord", "SubPixels"]


class SubPixelSet(data.StructLayout):
    """A pixel and the sub-pixels above, below and to its left: grey levels (THESIS) or half grey levels (LINEAR)."""
    PARTS = ("pixel", "above", "below", "left")

    def __init__(self, config: MatcherConfig):
        super().__init__({part: range(config.matching_cost.sub_pixel_max + 1) for part in self.PARTS})


# Fields that the arithmetic passes on. `beyond` marks the column one past the line: padding, which completes the pixel before it.
_PASSED = {"pixel": PIXEL_BITS, "upper": PIXEL_BITS, "beyond": 1, **FLAGS}


def _copy_passed(target: data.View, source: data.View) -> list[Any]:
    return [target[name].eq(source[name]) for name in _PASSED]


class SubPixelWord(data.StructLayout):
    """Sub-pixels of both pictures at one ``x``; the left pixel and the one above it in grey levels."""
    def __init__(self, config: MatcherConfig):
        super().__init__({"left": SubPixelSet(config), "right": SubPixelSet(config), **_PASSED})


class BuffersWord(data.StructLayout):
    """Sub-pixels of the left picture at ``x`` and of the right one at ``x - d`` for every ``d``; ``inside``: ``d <= x``, in use."""
    def __init__(self, config: MatcherConfig):
        super().__init__({
            "left": SubPixelSet(config),
            "right": data.ArrayLayout(SubPixelSet(config), config.labels),
            "inside": config.labels,
            **_PASSED,
        })


class CostWord(data.StructLayout):
    """For every label the four differences of a column, as :class:`SubPixelSet` names them."""
    def __init__(self, config: MatcherConfig):
        super().__init__({
            "cost": data.ArrayLayout(SubPixelSet(config), config.labels),
            "inside": config.labels,
            **_PASSED,
        })


class EdataWord(data.StructLayout):
    """The matching cost of every label."""
    def __init__(self, config: MatcherConfig):
        super().__init__({
            "cost": data.ArrayLayout(config.matching_cost.bits, config.labels),
            "pixel": PIXEL_BITS,
            "upper": PIXEL_BITS,
            **FLAGS,
        })


class _Stage(wiring.Component):
    """A pipeline stage: accepts a word whenever its output is accepted or empty."""
    def __init__(self, config: MatcherConfig, i: ShapeLike, o: ShapeLike, **plain: Member):
        self.config = config
        super().__init__({"i": In(stream.Signature(i)), "o": Out(stream.Signature(o)), **plain})


class SubPixels(_Stage):
    """Sub-pixels of a line, equations (2-3) .. (2-6) (thesis figure 20); the golden model is :func:`golden.matcher.cost.sub_pixels`.

    The sub-pixel to the right of ``x`` is the one to the left of ``x + 1``. So a line of ``W`` columns gives ``W + 1`` words: the last,
    marked ``beyond``, repeats the last pixel.

    Width: THESIS halves the sum of two pixels with floor, as the thesis's shift does; LINEAR keeps the sum (9 bits), and doubles the
    pixel itself. Nothing else is rounded.

    Timing: latency :attr:`LATENCY` cycle; a word a cycle; ``i.ready`` depends combinationally on ``o.ready``.

    Members
    -------
    i : In(stream.Signature(ColumnWord()))
    o : Out(stream.Signature(SubPixelWord(config)))
    """
    LATENCY = 1

    def __init__(self, config: MatcherConfig):
        super().__init__(config, ColumnWord(), SubPixelWord(config))

    def elaborate(self, platform: object) -> Module:
        m = Module()
        halve = self.config.method.arithmetic is Arithmetic.THESIS
        before = Signal(ColumnWord())   # the column at x - 1
        beyond = Signal()               # the next word is the one past the line
        start  = Signal(init=1)         # the next column is the first of its line
        advance = Signal()
        m.d.comb += [advance.eq(~self.o.valid | self.o.ready), self.i.ready.eq(advance & ~beyond)]

        now = Signal(ColumnWord())
        m.d.comb += now.eq(Mux(beyond, before, self.i.p))
        with m.If(advance):
            m.d.sync += self.o.valid.eq(self.i.valid | beyond)
            with m.If(self.i.valid | beyond):
                m.d.sync += [
                    before.eq(now), beyond.eq(~beyond & now.last), start.eq(beyond),
                    self.o.p.pixel.eq(now.left.line), self.o.p.upper.eq(now.left.minus), self.o.p.beyond.eq(beyond),
                    *copy_flags(self.o.p, now),
                ]
                for side in ("left", "right"):
                    column, parts = now[side], self.o.p[side]
                    left = Mux(start, column.line, before[side].line)
                    for part, other in (("pixel", column.line), ("above", column.minus), ("below", column.plus), ("left", left)):
                        total = column.line + other
                        m.d.sync += parts[part].eq(total >> 1 if halve else total)
        return m


class SubPixelBuffers(_Stage):
    """Buffers that pass the right picture's sub-pixels from disparity to disparity (thesis figure 21).

    Label ``d + 1`` compares at ``x + 1`` the sub-pixels that label ``d`` compared at ``x``: each is computed once. The golden model is
    :func:`golden.matcher.cost.sub_pixel_buffers`. Labels that are not in use count as outside the picture.

    Timing: latency :attr:`LATENCY` cycle; a word a cycle; ``i.ready`` depends combinationally on ``o.ready``.

    Members
    -------
    i : In(stream.Signature(SubPixelWord(config)))
    o : Out(stream.Signature(BuffersWord(config)))
    in_use : In(IN_USE_BITS)
        Labels in use; sampled with the first word of a frame.
    """
    LATENCY = 1

    def __init__(self, config: MatcherConfig):
        super().__init__(config, SubPixelWord(config), BuffersWord(config), in_use=In(IN_USE_BITS))

    def elaborate(self, platform: object) -> Module:
        m = Module()
        labels = self.config.labels
        start = Signal(init=1)
        reached = Signal(labels, reset_less=True)  # d <= x
        in_use  = Signal(labels, reset_less=True)
        m.d.comb += self.i.ready.eq(~self.o.valid | self.o.ready)
        with m.If(self.i.ready):
            m.d.sync += self.o.valid.eq(self.i.valid)
        with m.If(self.i.ready & self.i.valid):
            m.d.sync += [start.eq(self.i.p.beyond), self.o.p.left.eq(self.i.p.left), *_copy_passed(self.o.p, self.i.p)]
            m.d.sync += [self.o.p.right[0].eq(self.i.p.right), *(self.o.p.right[d].eq(self.o.p.right[d - 1]) for d in range(1, labels))]
            m.d.sync += reached.eq(Mux(start, 1, Cat(Const(1, 1), reached)))
            with m.If(self.i.p.first):
                m.d.sync += in_use.eq(Cat(self.in_use > d for d in range(labels)))
        m.d.comb += self.o.p.inside.eq(reached & in_use)
        return m


class CostEnergy(_Stage):
    """Differences of pixel and sub-pixels for every label, equations (2-7) .. (2-11) (thesis figure 22).

    The golden model is :func:`golden.matcher.cost.cost_energy`. Width: a difference needs no more bits than what it compares.

    Timing: latency :attr:`LATENCY` cycle; a word a cycle; ``i.ready`` depends combinationally on ``o.ready``.

    Members
    -------
    i : In(stream.Signature(BuffersWord(config)))
    o : Out(stream.Signature(CostWord(config)))
    """
    LATENCY = 1

    def __init__(self, config: MatcherConfig):
        super().__init__(config, BuffersWord(config), CostWord(config))

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.d.comb += self.i.ready.eq(~self.o.valid | self.o.ready)
        with m.If(self.i.ready):
            m.d.sync += [self.o.valid.eq(self.i.valid), self.o.p.inside.eq(self.i.p.inside), *_copy_passed(self.o.p, self.i.p)]
            for d in range(self.config.labels):
                for part in SubPixelSet.PARTS:
                    left, right = self.i.p.left[part], self.i.p.right[d][part]
                    m.d.sync += self.o.p.cost[d][part].eq(Mux(left > right, left - right, right - left))
        return m


class Edata(_Stage):
    """Matching cost of every label, equation (2-12) (thesis figure 23); the golden model is :func:`golden.matcher.cost.edata`.

    Four differences are those of the pixel's word, the fifth is the ``left`` one of the next word. A label whose right pixel lies
    outside the picture has the greatest cost that the width holds (:attr:`golden.config.MatchingCost.outside`).

    Width: exact; a cost is at most ``config.matching_cost.inside_max``.

    Timing: latency :attr:`LATENCY` cycles, as a pixel is output one cycle after its successor was accepted; a word a cycle;
    ``i.ready`` depends combinationally on ``o.ready``.

    Members
    -------
    i : In(stream.Signature(CostWord(config)))
    o : Out(stream.Signature(EdataWord(config)))
    """
    LATENCY = 2

    def __init__(self, config: MatcherConfig):
        super().__init__(config, CostWord(config), EdataWord(config))

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        partial       = Signal(EdataWord(config), reset_less=True)  # a pixel without its fifth difference
        partial_valid = Signal()
        inside        = Signal(config.labels, reset_less=True)

        m.d.comb += self.i.ready.eq(~partial_valid | ~self.o.valid | self.o.ready)
        with m.If(self.o.ready):
            m.d.sync += self.o.valid.eq(0)
        with m.If(self.i.ready & self.i.valid):
            m.d.sync += [partial_valid.eq(~self.i.p.beyond), inside.eq(self.i.p.inside)]
            m.d.sync += [partial.pixel.eq(self.i.p.pixel), partial.upper.eq(self.i.p.upper), *copy_flags(partial, self.i.p)]
            for d, cost in enumerate(self.i.p.cost):
                m.d.sync += partial.cost[d].eq((cost.pixel + cost.above) + (cost.below + cost.left))
            with m.If(partial_valid):
                m.d.sync += [self.o.valid.eq(1), self.o.p.pixel.eq(partial.pixel), self.o.p.upper.eq(partial.upper)]
                m.d.sync += copy_flags(self.o.p, partial)
                for d, cost in enumerate(self.i.p.cost):
                    m.d.sync += self.o.p.cost[d].eq(Mux(inside[d], partial.cost[d] + cost.left, config.matching_cost.outside))
        return m
