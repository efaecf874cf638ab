"""Slopes of a pixel, and the cones that they make over the labels."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, WEIGHT_BITS, MatcherConfig

from ...parts.arithmetic import add_with_carry, multiply
from ...parts.delay import Delay, data_register
from .label_array import DownWave, UpWave, vertex_rise


__all__ = ["Cones", "Neighbours"]


class Neighbours(data.StructLayout):
    """A pixel and its neighbours: grey levels, whether they are inside the picture, and the labels of the upper and the lower one.

    ``size``: pixels of its support, where there are supports.
    """
    def __init__(self, config: MatcherConfig, size_max: int = 0):
        size = {"size": range(size_max + 1)} if size_max else {}
        super().__init__({
            "pixel": PIXEL_BITS,
            "left": PIXEL_BITS, "upper": PIXEL_BITS, "lower": PIXEL_BITS,
            "has_left": 1, "has_upper": 1, "has_lower": 1,
            "upper_label": range(config.labels), "lower_label": range(config.labels), **size,
        })


class Cones(wiring.Component):
    """Slopes ``w = (u*(256 - dI) << slope_shift) >> 8`` (floor) of the three smoothness terms, and the waves that start with them.

    Where there are supports (``size_max`` above 0) a slope is multiplied by the support's size.

    ``up`` starts the cones ``w2*|d - f_up| + w3*|d - b_low| - w1*d + smooth_max`` at label 0, ``down`` the ramp ``2*w1*d`` at label
    ``D - 1``. The golden models are :func:`golden.matcher.smooth.slope` and :func:`golden.matcher.smooth.cones`. A neighbour outside the
    picture has slope 0.

    Width: exact but for the slopes' floor. Multipliers: none; products are sums of shifted rows.

    Timing: latency :meth:`latency_of` cycles, a pixel a cycle.

    Members
    -------
    i : In(Neighbours(config, size_max))
    weights : In(ArrayLayout(WEIGHT_BITS, 3))
        ``u1, u2, u3``.
    up : Out(UpWave(config))
    down : Out(DownWave(config))
    """
    def __init__(self, config: MatcherConfig, size_max: int = 0):
        self.config = config
        self.size_max = size_max
        super().__init__({
            "i": In(Neighbours(config, size_max)),
            "weights": In(data.ArrayLayout(WEIGHT_BITS, 3)),
            "up": Out(UpWave(config)),
            "down": Out(DownWave(config)),
        })

    @staticmethod
    def latency_of(config: MatcherConfig, size_max: int = 0) -> int:
        """Cycles from neighbours to waves: slope, product, sums, steps, the vertices at the first labels."""
        label_bits = (config.labels - 1).bit_length()
        return Cones.slope_latency_of(size_max) + max((label_bits - 1).bit_length(), 1) + 3

    @staticmethod
    def slope_latency_of(size_max: int) -> int:
        """Cycles from neighbours to slopes: difference, likeness, product, slope, and the product with the size."""
        times_size = max((size_max.bit_length() - 1).bit_length(), 1) if size_max else 0
        return 2 + (WEIGHT_BITS - 1).bit_length() + 1 + times_size

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        labels = config.labels
        slope_shape = range(config.rule.slope_max + 1)

        # Likeness 256 - |dI|, 0 without a neighbour; slope.
        if self.size_max:
            m.submodules.size = size = Delay(len(self.i.size), self.slope_latency_of(0))
            m.d.comb += size.i.eq(self.i.size)
        slopes = []
        m.submodules.weights_delay = weights = Delay(self.weights.shape(), 2)
        m.d.comb += weights.i.eq(self.weights)
        for name, weight, neighbour in zip(("w1", "w2", "w3"), weights.o, ("left", "upper", "lower"), strict=True):
            pixel, grey = self.i.pixel, self.i[neighbour]
            difference = Signal(signed(PIXEL_BITS + 1), name=f"difference_{neighbour}", reset_less=True)
            present    = Signal(name=f"present_{neighbour}", reset_less=True)
            likeness   = Signal(range(257), name=f"likeness_{neighbour}", reset_less=True)
            m.d.sync += [difference.eq(pixel - grey), present.eq(self.i[f"has_{neighbour}"])]
            # -|v| is v itself, or ~v + 1.
            positive = ~difference[-1]
            complement = difference ^ positive.replicate(PIXEL_BITS + 1)
            m.d.sync += likeness.eq(Mux(present, add_with_carry(complement, Const(256, PIXEL_BITS + 1), positive)[:PIXEL_BITS + 1], 0))
            product, _ = multiply(m, f"product_{name}", likeness, weight)
            if self.size_max:
                each = Signal(WEIGHT_BITS, name=f"{name}_each", reset_less=True)
                m.d.sync += each.eq((product << config.rule.slope_shift) >> 8)
                slope = multiply(m, name, each, size.o)[0][:config.rule.slope_max.bit_length()]
            else:
                slope = Signal(slope_shape, name=name, reset_less=True)
                m.d.sync += slope.eq((product << config.rule.slope_shift) >> 8)
            slopes.append(slope)
        w1, w2, w3 = slopes

        # A pixel without an upper neighbour has a flat upper cone; its vertex must still not depend on an unwritten word.
        vertices = data.StructLayout({"upper": range(labels), "lower": range(labels)})
        m.submodules.vertices = at_slopes = Delay(vertices, self.slope_latency_of(self.size_max))
        m.d.comb += [at_slopes.i.upper.eq(Mux(self.i.has_upper, self.i.upper_label, 0)), at_slopes.i.lower.eq(self.i.lower_label)]

        # The cones at label 0.
        upper, lower = at_slopes.o.upper, at_slopes.o.lower
        cone_upper, cone_latency = multiply(m, "cone_upper", w2, upper)
        cone_lower, _ = multiply(m, "cone_lower", w3, lower)
        aligned = data.StructLayout({"low": range(labels), "high": range(labels), "upper_first": 1, "lower_first": 1,
                                     "w1": slope_shape, "w2": slope_shape, "w3": slope_shape})
        m.submodules.alignment = at_cones = Delay(aligned, cone_latency)
        m.d.comb += [
            at_cones.i.upper_first.eq(upper < lower), at_cones.i.lower_first.eq(lower < upper),
            at_cones.i.low.eq(Mux(upper < lower, upper, lower)), at_cones.i.high.eq(Mux(upper < lower, lower, upper)),
            at_cones.i.w1.eq(w1), at_cones.i.w2.eq(w2), at_cones.i.w3.eq(w3),
        ]

        # Sums. Vertices that coincide are one, with the slopes of both.
        later     = at_cones.o
        vertex    = Signal(data.StructLayout({"low": range(labels), "high": range(labels)}), reset_less=True)
        cone      = Signal(range(2 * config.smooth_max + 1), reset_less=True)
        both      = Signal(range(2 * config.rule.slope_max + 1), reset_less=True)
        low_rise  = Signal.like(both, reset_less=True)
        high_rise = Signal(slope_shape, reset_less=True)
        slope     = Signal(slope_shape, reset_less=True)
        negative  = Signal(range(-config.rule.slope_max, 1), reset_less=True)
        m.d.sync += [
            vertex.low.eq(later.low), vertex.high.eq(later.high), cone.eq(cone_upper + cone_lower),
            both.eq(later.w2 + later.w3), slope.eq(later.w1), negative.eq(-later.w1),
            low_rise.eq(Mux(later.lower_first, 0, later.w2) + Mux(later.upper_first, 0, later.w3)),
            high_rise.eq(Mux(later.upper_first, later.w3, later.w2)),
        ]

        # Steps; `rise` is that at label 0.
        steps = Signal(UpWave(config), reset_less=True)
        m.submodules.down_step = down_step = Delay(self.down.step.shape(), 2)
        first  = Signal(data.StructLayout({"low": 1, "high": 1}), reset_less=True)  # label 1 is a vertex
        m.d.sync += [
            steps.cone.eq(cone + config.smooth_max), steps.low.eq(vertex.low), steps.high.eq(vertex.high),
            steps.step.eq(negative - both), steps.rise.eq(Mux(vertex.low == 0, low_rise, 0)),
            steps.low_rise.eq(low_rise), steps.high_rise.eq(high_rise), first.low.eq(vertex.low == 1), first.high.eq(vertex.high == 1),
            steps.at_low.eq(vertex.low == 2 if labels > 2 else 0), steps.at_high.eq(vertex.high == 2 if labels > 2 else 0),
        ]
        m.d.comb += [down_step.i.eq(slope << 1), self.down.step.eq(down_step.o)]

        # The step from label 0, and its rise at label 1. The upper vertex is at label 0 only where both are.
        up = data_register(m, self.up)
        m.d.sync += [up.eq(steps), up.step.eq(steps.step + (steps.rise << 1)), up.rise.eq(vertex_rise(steps, first.low, first.high))]

        # The ramp at label D-1.
        ramp, ramp_latency = multiply(m, "ramp", w1, Const(2 * (labels - 1)))
        m.submodules.ramp = at_top = Delay(self.down.ramp.shape(), cone_latency + 3 - ramp_latency)
        m.d.comb += [at_top.i.eq(ramp), self.down.ramp.eq(at_top.o)]
        assert self.slope_latency_of(self.size_max) + cone_latency + 3 == self.latency_of(config, self.size_max)
        return m
