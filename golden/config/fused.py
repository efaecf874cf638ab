"""The method ``Fused``: the matching cost fused with a census, summed over supports, labelled by the disparity rule, then refined."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar

from .limits import PIXEL_MAX, WEIGHT_MAX, Setting, Weights, check_limits, weight_settings
from .refinement import RefinedLabels, Refinement


__all__ = ["FUSED_1", "FUSED_2", "FUSED_3", "Arms", "Fused", "FusedCost", "Vertical"]


@dataclass(frozen=True)
class FusedCost:
    """The cost ``C = (cost_factor * min(E, truncation) + census_weight * H) >> cost_shift`` (floor) of a candidate.

    Parameters
    ----------
    truncation : int
        Largest matching cost ``E`` that counts, half grey levels, ``0..1023``.
    cost_factor, census_weight, cost_shift : int
        ``0..15``, ``0..127``, ``0..7``.
    cost_outside : int
        ``C`` of a candidate whose right pixel lies outside the picture, ``0..255``.
    census_rows, census_columns : int
        Window of the census, pixels; odd, up to 7 and 9.
    """
    truncation: int = 156
    cost_factor: int = 4
    census_weight: int = 47
    cost_shift: int = 4
    cost_outside: int = 30
    census_rows: int = 5
    census_columns: int = 7

    MAX: ClassVar[int] = 255  # eight bits a cost, in memories and between labels
    LIMITS: ClassVar[Mapping[str, range]] = {
        "truncation": range(1024), "cost_factor": range(16), "census_weight": range(128), "cost_shift": range(8),
        "cost_outside": range(MAX + 1), "census_rows": range(1, 8, 2), "census_columns": range(1, 10, 2),
    }

    def __post_init__(self) -> None:
        check_limits(asdict(self), self.LIMITS)

    @property
    def neighbours(self) -> int:
        """Bits of a census, hence the largest Hamming distance ``H``: the pixels of the window but the centre."""
        return self.census_rows * self.census_columns - 1

    @property
    def darker_by(self) -> int:
        """Grey levels by which a neighbour is darker than the centre at most without a bit in the census."""
        return 0

    @property
    def inside_max(self) -> int:
        """Largest cost of a candidate inside the picture, whatever its bits hold."""
        return self.cost_factor * self.truncation + self.census_weight * self.neighbours >> self.cost_shift

    @property
    def maximum(self) -> int:
        """Largest cost ``C``."""
        return max(self.inside_max, self.cost_outside)

    @property
    def cap(self) -> int:
        """Greater costs inside the picture are reduced to this one: none is."""
        return self.inside_max


@dataclass(frozen=True)
class Arms:
    """The support of a pixel on its scanline.

    Parameters
    ----------
    arm_threshold : int
        Grey levels by which a pixel of the support may differ from its centre, ``0..255``.
    reach : int
        Longest arm, pixels, ``0..31``.
    """
    arm_threshold: int = 10
    reach: int = 16

    LIMITS: ClassVar[Mapping[str, range]] = {"arm_threshold": range(PIXEL_MAX + 1), "reach": range(32)}

    def __post_init__(self) -> None:
        check_limits(asdict(self), self.LIMITS)

    @property
    def support_max(self) -> int:
        """Most pixels of a support."""
        return 2 * self.reach + 1


@dataclass(frozen=True)
class Vertical:
    """Costs of the lines above and below that join a pixel's before they are summed over the support.

    Parameters
    ----------
    vertical_lines : int
        Lines on either side, 0 or 1.
    vertical_threshold : int
        Grey levels by which the pixel above, or below, may differ for that, ``0..255``.
    """
    vertical_lines: int = 0
    vertical_threshold: int = 10

    LIMITS: ClassVar[Mapping[str, range]] = {"vertical_lines": range(2), "vertical_threshold": range(PIXEL_MAX + 1)}

    def __post_init__(self) -> None:
        check_limits(asdict(self), self.LIMITS)

    def __bool__(self) -> bool:
        return bool(self.vertical_lines)


@dataclass(frozen=True)
class Fused(RefinedLabels):
    """Parameters of the method; the defaults are the set :data:`FUSED_1`.

    Parameters
    ----------
    cost : FusedCost
    arms : Arms
    vertical : Vertical
    weights : Weights
        ``2**-energy_shift`` of a unit of ``C`` a pixel of disparity.
    energy_shift : int
        Fraction bits of the weights: a support sum ``S`` enters the energy as ``S << energy_shift``; ``0..4``.
    refinement : Refinement
    """
    cost: FusedCost = FusedCost()
    arms: Arms = Arms()
    vertical: Vertical = Vertical()
    weights: Weights = Weights(17, 30, 22)
    energy_shift: int = 3
    refinement: Refinement = Refinement()

    name: ClassVar[str] = "fused"
    ABOUT: ClassVar[str] = "its cost fused with a census and summed over a support, disparities refined"
    #: Limits of the parameters that are numbers, whichever part holds them.
    LIMITS: ClassVar[Mapping[str, range]] = {
        **FusedCost.LIMITS, **Arms.LIMITS, **Vertical.LIMITS, **dict.fromkeys(Weights._fields, range(WEIGHT_MAX + 1)),
        "energy_shift": range(5), **Refinement.LIMITS,
    }

    def __post_init__(self) -> None:
        object.__setattr__(self, "weights", Weights(*self.weights))
        self.weights.check()
        check_limits({"energy_shift": self.energy_shift}, {"energy_shift": self.LIMITS["energy_shift"]})
        if self.joined_max > FusedCost.MAX:
            what = "the fused cost of three lines" if self.vertical else "the fused cost"
            raise ValueError(f"{what} reaches {self.joined_max}, more than the {FusedCost.MAX} that its 8 bits hold; "
                             "choose a smaller truncation, cost_factor or census_weight, or a greater cost_shift")

    @property
    def view_max(self) -> int:
        """Largest cost that the right view compares."""
        return self.joined_max

    @property
    def census_above(self) -> bool:
        """Whether the pixel two lines above comes with a census."""
        return bool(self.vertical)

    @property
    def joined_max(self) -> int:
        """Largest cost ``V`` with those of the lines above and below: of four shares."""
        return self.cost.maximum * 4 if self.vertical else self.cost.maximum

    @property
    def data_max(self) -> int:
        """Largest data term: the sum ``S`` over the widest support."""
        return self.arms.support_max * self.joined_max

    @property
    def energy_scale(self) -> int:
        """Factor of a support sum in the energy."""
        return 1 << self.energy_shift

    @property
    def slope_max(self) -> int:
        """Largest slope of a smoothness term: ``dI = 0``, the greatest weight and the widest support."""
        return self.arms.support_max * WEIGHT_MAX

    @property
    def slope_shift(self) -> int:
        """A slope is ``(u*(256 - dI)) >> 8``, for each pixel of the support."""
        return 0

    @property
    def smooth_step_max(self) -> int:
        """Largest smoothness term between labels that differ by one, in equal pixels."""
        return self.slope_max

    def settings(self, minimum: int) -> Mapping[str, Setting]:
        """The weights, the least disparity, and the switches of the refinement."""
        return {**weight_settings(self.weights, "fractions of the fused cost a pixel"), **self.refinement_settings(minimum)}

    def with_settings(self, values: Mapping[str, int]) -> "Fused":
        """The method with those weights and switches; the least disparity is not the method's."""
        weights = Weights(**{name: values.get(name, value) for name, value in self.weights._asdict().items()})
        return replace(self, weights=weights, refinement=self.refinement_with(values))

    def about(self) -> Mapping[str, Any]:
        """All parameters for reports."""
        return {**asdict(self), "weights": self.weights._asdict()}


FUSED_1 = Fused()  # the named default fused-1

# The named set fused-2, found by golden tune from costs of four bits: two lines of them are kept for the vertical support.
FUSED_2 = Fused(
    FusedCost(truncation=142, cost_factor=2, census_weight=55, cost_shift=7, cost_outside=3, census_columns=5),
    Arms(arm_threshold=14, reach=29), Vertical(vertical_lines=1, vertical_threshold=30), Weights(10, 23, 19), energy_shift=4)

# The named set fused-3, found likewise: costs of four bits without vertical support, the least gateware. A support sum has nine bits, so
# four of them fill a memory block's word.
FUSED_3 = Fused(
    FusedCost(truncation=194, cost_factor=2, cost_shift=7, cost_outside=2), Arms(arm_threshold=16), weights=Weights(6, 11, 9),
    energy_shift=4)
