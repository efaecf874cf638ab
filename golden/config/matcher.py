"""The parameters of the matcher: the vocabulary that golden model, gateware, benches and builds share."""

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from typing import ClassVar


__all__ = ["Arithmetic", "Cost", "Engine", "FUSED_1", "FUSED_2", "FUSED_3", "FusedParameters", "IN_USE_BITS", "MINIMUM_BITS",
           "MatcherConfig", "PIXEL_BITS", "PIXEL_MAX", "Refinement", "WEIGHT_BITS", "WEIGHT_MAX"]


PIXEL_BITS = 8
PIXEL_MAX = 2**PIXEL_BITS - 1

# Weights u1, u2, u3. The thesis's optimum is 15, 10, 5 and its sweep (figure 34) stays below 50; six bits hold that.
WEIGHT_BITS = 6
WEIGHT_MAX = 2**WEIGHT_BITS - 1

# Labels in use: up to 256.
IN_USE_BITS = 9

# Least disparity: up to 255.
MINIMUM_BITS = 8


def _check(parameters: object, limits: Mapping[str, range]) -> None:
    """:class:`ValueError` unless each named attribute is a whole number within its limits."""
    for name, allowed in limits.items():
        value = getattr(parameters, name)
        if not isinstance(value, int) or value not in allowed:
            odd = "odd " if allowed.step == 2 else ""
            raise ValueError(f"{name} must be {'an ' if odd else 'a '}{odd}whole number from {allowed[0]} to {allowed[-1]}, not {value!r}")


class Cost(enum.StrEnum):
    """What a label costs at a pixel, hence which method.

    ``THESIS``: the matching cost ``E`` of equation (2-12).
    ``FUSED``: ``E`` fused with a census distance, summed over a support along the line; check, fill and median follow the rule.
    ``LINEAR`` arithmetic only.
    """
    THESIS = "thesis"
    FUSED = "fused"


class Arithmetic(enum.StrEnum):
    """Number formats of cost and smoothness.

    ``FLOAT``: equations (2-3) .. (2-15) in float64; golden model only.
    ``THESIS``: sub-pixels halved with floor, smoothness ``(256*k*u - k*u*dI) >> 8`` (floor).
    ``LINEAR``: sub-pixels are sums (costs double, exact); an integer slope for each neighbour, ``(2*u*(256 - dI) << q) >> 8``
    (floor), energy ``(E << q) + slope*k`` (exact, hence linear in ``k``).
    """
    FLOAT = "float"
    THESIS = "thesis"
    LINEAR = "linear"


class Engine(enum.StrEnum):
    """How the gateware computes the disparity rule; the result is the same.

    ``SEQUENTIAL``: as the thesis does, several cycles a pixel; ``THESIS`` and ``LINEAR``, up to 128 labels.
    ``STREAMING``: one pixel a cycle; ``LINEAR`` only, up to 256 labels.
    """
    SEQUENTIAL = "sequential"
    STREAMING = "streaming"


@dataclass(frozen=True)
class FusedParameters:
    """Parameters of the cost ``FUSED`` and of the refinement behind it; the defaults are the set :data:`FUSED_1`.

    Parameters
    ----------
    truncation : int
        Largest matching cost ``E`` that counts, half grey levels, ``0..1023``.
    cost_factor, census_weight, cost_shift : int
        ``C = (cost_factor * min(E, truncation) + census_weight * H) >> cost_shift`` (floor); ``0..15``, ``0..127``, ``0..7``.
    cost_outside : int
        ``C`` of a candidate whose right pixel lies outside the picture, ``0..255``.
    census_rows, census_columns : int
        Window of the census, pixels; odd, up to 7 and 9.
    arm_threshold : int
        Grey levels by which a pixel of the support may differ from its centre, ``0..255``.
    reach : int
        Longest arm of the support, pixels, ``0..31``.
    u1, u2, u3 : int
        Weights of the neighbours, ``2**-energy_shift`` of a unit of ``C`` a pixel of disparity, ``0..63``; defaults of inputs.
    energy_shift : int
        Fraction bits of the weights: a support sum ``S`` enters the energy as ``S << energy_shift``; ``0..4``.
    tolerance : int
        Largest difference of left and right view that passes the check, pixels, ``0..7``.
    median : int
        Side of the median's window, pixels; 3 or 5.
    vertical : int
        Lines above and below a pixel whose costs join its own before they are summed over the support, 0 or 1.
    vertical_threshold : int
        Grey levels by which the pixel above, or below, may differ for that, ``0..255``.
    """
    truncation: int = 156
    cost_factor: int = 4
    census_weight: int = 47
    cost_shift: int = 4
    cost_outside: int = 30
    census_rows: int = 5
    census_columns: int = 7
    arm_threshold: int = 10
    reach: int = 16
    u1: int = 17
    u2: int = 30
    u3: int = 22
    energy_shift: int = 3
    tolerance: int = 1
    median: int = 5
    vertical: int = 0
    vertical_threshold: int = 10

    COST_MAX: ClassVar[int] = 255  # eight bits a cost, in memories and between labels
    LIMITS: ClassVar[Mapping[str, range]] = {
        "truncation": range(1024), "cost_factor": range(16), "census_weight": range(128), "cost_shift": range(8),
        "cost_outside": range(COST_MAX + 1), "census_rows": range(1, 8, 2), "census_columns": range(1, 10, 2),
        "arm_threshold": range(PIXEL_MAX + 1), "reach": range(32), "u1": range(WEIGHT_MAX + 1), "u2": range(WEIGHT_MAX + 1),
        "u3": range(WEIGHT_MAX + 1), "energy_shift": range(5), "tolerance": range(8), "median": range(3, 6, 2),
        "vertical": range(2), "vertical_threshold": range(PIXEL_MAX + 1),
    }

    def __post_init__(self) -> None:
        _check(self, self.LIMITS)
        if self.joined_max > self.COST_MAX:
            what = "the fused cost of three lines" if self.vertical else "the fused cost"
            raise ValueError(f"{what} reaches {self.joined_max}, more than the {self.COST_MAX} that its 8 bits hold; "
                             "choose a smaller truncation, cost_factor or census_weight, or a greater cost_shift")

    @property
    def neighbours(self) -> int:
        """Bits of a census, hence the largest Hamming distance ``H``: the pixels of the window but the centre."""
        return self.census_rows * self.census_columns - 1

    @property
    def cost_max(self) -> int:
        """Largest fused cost ``C``."""
        inside = self.cost_factor * self.truncation + self.census_weight * self.neighbours >> self.cost_shift
        return max(inside, self.cost_outside)

    @property
    def joined_max(self) -> int:
        """Largest cost ``V`` with those of the lines above and below: of four shares."""
        return self.cost_max * 4 if self.vertical else self.cost_max

    @property
    def support_max(self) -> int:
        """Most pixels ``n`` of a support."""
        return 2 * self.reach + 1

    @property
    def sum_max(self) -> int:
        """Largest support sum ``S``."""
        return self.support_max * self.joined_max

    @property
    def slope_max(self) -> int:
        """Largest slope of a smoothness term: ``dI = 0``, the greatest weight and the widest support."""
        return self.support_max * WEIGHT_MAX


FUSED_1 = FusedParameters()  # the named default fused-1

# The named set fused-2, found by golden tune from costs of four bits: two lines of them are kept for the vertical support.
FUSED_2 = FusedParameters(
    truncation=142, cost_factor=2, census_weight=55, cost_shift=7, cost_outside=3, census_columns=5, arm_threshold=14, reach=29,
    u1=10, u2=23, u3=19, energy_shift=4, vertical=1, vertical_threshold=30)

# The named set fused-3, found likewise: costs of four bits without vertical support, the least gateware. A support sum has nine bits, so
# four of them fill a memory block's word.
FUSED_3 = FusedParameters(
    truncation=194, cost_factor=2, cost_shift=7, cost_outside=2, arm_threshold=16, u1=6, u2=11, u3=9, energy_shift=4)


@dataclass(frozen=True)
class Refinement:
    """Which stages follow the rule; cost ``FUSED`` only. A stage that is off hands its input on.

    Parameters
    ----------
    check : bool
        Left-right check; off, every pixel passes.
    fill : bool
        Pixels that fail the check take a disparity from their line.
    median : bool
        Median of the disparities.
    sub_pixel : bool
        Disparities get three fraction bits between check and fill.
    """
    check: bool = True
    fill: bool = True
    median: bool = True
    sub_pixel: bool = False


@dataclass(frozen=True)
class MatcherConfig:
    """Size and arithmetic of a matcher.

    Parameters
    ----------
    disparities : int
        Number of labels ``D``; disparities are ``minimum .. minimum + D-1`` pixels.
    arithmetic : Arithmetic
        Number formats.
    fraction_bits : int
        Fraction bits ``q`` of the slopes; read by ``LINEAR`` only.
    u1, u2, u3 : int
        Weights of the left, upper and lower neighbour, in grey levels a pixel of disparity. Build-time defaults of the gateware's inputs.
        Read by the cost ``THESIS`` only.
    in_use : int or None
        Labels in use, ``0 .. in_use - 1``: those above cost what a candidate outside the picture does. ``None``: all. Build-time default
        of the gateware's input.
    max_width : int
        Longest line, in pixels, that the gateware's memories hold.
    engine : Engine
        Which gateware.
    cost : Cost
        What a label costs; ``FUSED`` asks for the arithmetic ``LINEAR``.
    fused : FusedParameters
        Read by the cost ``FUSED`` only.
    refinement : Refinement
        Stages behind the rule; read by the cost ``FUSED`` only.
    minimum : int
        Least disparity ``m``, pixels: label ``l`` is the disparity ``m + l``.
    """
    disparities: int = 80
    arithmetic: Arithmetic = Arithmetic.THESIS
    fraction_bits: int = 3
    u1: int = 15
    u2: int = 10
    u3: int = 5
    in_use: int | None = None
    max_width: int = 720
    engine: Engine = Engine.SEQUENTIAL
    cost: Cost = Cost.THESIS
    fused: FusedParameters = FUSED_1
    refinement: Refinement = Refinement()
    minimum: int = 0

    DISPARITIES = range(2, 257)
    SEQUENTIAL_DISPARITIES = range(2, 129)
    FRACTION_BITS = range(0, 5)
    WIDTHS = range(1, 4097)
    MINIMUMS = range(2**MINIMUM_BITS)

    def __post_init__(self):
        weight = range(WEIGHT_MAX + 1)
        _check(self, {
            "disparities": self.DISPARITIES, "fraction_bits": self.FRACTION_BITS, "max_width": self.WIDTHS, "minimum": self.MINIMUMS,
            "u1": weight, "u2": weight, "u3": weight,
        })
        if self.in_use is not None:
            _check(self, {"in_use": range(1, self.disparities + 1)})
        object.__setattr__(self, "arithmetic", Arithmetic(self.arithmetic))
        object.__setattr__(self, "engine", Engine(self.engine))
        object.__setattr__(self, "cost", Cost(self.cost))
        if self.engine is Engine.STREAMING and self.arithmetic is not Arithmetic.LINEAR:
            raise ValueError(f"engine streaming computes the arithmetic linear only, not {self.arithmetic}")
        if self.cost is Cost.FUSED and self.arithmetic is not Arithmetic.LINEAR:
            raise ValueError(f"cost fused is made from the arithmetic linear only, not {self.arithmetic}")

    @property
    def weights(self):
        """``(u1, u2, u3)`` of the cost."""
        source = self.fused if self.cost is Cost.FUSED else self
        return source.u1, source.u2, source.u3

    @property
    def labels_in_use(self) -> int:
        """Number of labels that may be chosen freely."""
        return self.disparities if self.in_use is None else self.in_use

    @property
    def energy_shift(self):
        """Fraction bits of the integer energies: the matching cost, or the support sum, enters them shifted left by this."""
        if self.cost is Cost.FUSED:
            return self.fused.energy_shift
        return self.fraction_bits if self.arithmetic is Arithmetic.LINEAR else 0

    @property
    def energy_scale(self):
        """What the matching cost is multiplied by to enter the energy.

        ``FLOAT`` computes 255 times the energy of (2-15): every term is then a multiple of one half, float64 holds it exactly and
        ties are ties. With ``dI / 255`` rounded, ties fall either way: measured, bad pixels move by up to 0.03 points.
        """
        return PIXEL_MAX if self.arithmetic is Arithmetic.FLOAT else 1 << self.energy_shift

    @property
    def sub_pixel_max(self):
        """Largest sub-pixel: a mean (FLOAT, THESIS) or a sum (LINEAR) of two grey levels."""
        return 2 * PIXEL_MAX if self.arithmetic is Arithmetic.LINEAR else PIXEL_MAX

    @property
    def cost_max(self):
        """Largest matching cost of a candidate inside the picture: five differences."""
        return 5 * self.sub_pixel_max

    @property
    def cost_bits(self):
        """Bits of a matching cost."""
        return self.cost_max.bit_length()

    @property
    def cost_outside(self):
        """Cost of a candidate whose right pixel lies outside the picture: the greatest that the width holds."""
        return 2**self.cost_bits - 1

    @property
    def slope_max(self):
        """Largest slope of a smoothness term (LINEAR): ``dI = 0`` and the greatest weight."""
        if self.cost is Cost.FUSED:
            return self.fused.slope_max
        return 2 * WEIGHT_MAX << self.fraction_bits

    @property
    def smooth_max(self):
        """Largest smoothness term: the labels ``0`` and ``D-1`` side by side in equal pixels."""
        per_label = self.slope_max if self.arithmetic is Arithmetic.LINEAR else WEIGHT_MAX
        return per_label * (self.disparities - 1)

    @property
    def data_max(self) -> int:
        """Largest data term of a label, before it is shifted into the energy: a matching cost, or a support sum."""
        return self.fused.sum_max if self.cost is Cost.FUSED else self.cost_outside

    @property
    def vertical(self) -> bool:
        """Whether costs are joined with those of the lines above and below."""
        return self.cost is Cost.FUSED and bool(self.fused.vertical)

    @property
    def data_bits(self) -> int:
        """Bits of a data term."""
        return self.data_max.bit_length()

    @property
    def disparity_scale(self) -> int:
        """Units of a disparity a pixel: 8 with sub-pixel disparities, three fraction bits."""
        return 8 if self.cost is Cost.FUSED and self.refinement.sub_pixel else 1

    @property
    def energy_max(self):
        """Largest energy that the rule compares."""
        return (self.data_max << self.energy_shift) + 3 * self.smooth_max

    @property
    def energy_bits(self) -> int:
        """Bits of an energy."""
        return self.energy_max.bit_length()
