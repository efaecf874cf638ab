"""The method ``Recursive``: costs carried from line to line, summed over supports, refined along borders and by a weighted median."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar

from .fused import FusedCost
from .limits import PIXEL_MAX, MatchingCost, Setting, check_limits
from .refinement import RefinedLabels, Refinement


__all__ = ["RECURSIVE_1", "RECURSIVE_2", "GradedArms", "LineBelow", "Propagation", "Recursive", "RecursiveCost",
           "WeightedRefinement"]


@dataclass(frozen=True)
class RecursiveCost(FusedCost):
    """The cost ``C`` of :class:`FusedCost`, at most ``cost_limit``, with a census that is blind to small differences.

    Parameters
    ----------
    cost_limit : int
        Largest cost ``C``, ``1..255``.
    census_threshold : int
        A bit of the census is set where the neighbour is darker than the centre by more than this, grey levels, ``0..7``. A setting.
    """
    truncation: int = 174
    cost_factor: int = 2
    census_weight: int = 55
    cost_shift: int = 7
    cost_outside: int = 5
    cost_limit: int = 15
    census_threshold: int = 0

    LIMITS: ClassVar[Mapping[str, range]] = {**FusedCost.LIMITS, "cost_limit": range(1, FusedCost.MAX + 1), "census_threshold": range(8)}

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.cost_outside > self.cost_limit:
            raise ValueError(f"cost_outside must be at most cost_limit, {self.cost_limit}, not {self.cost_outside}")

    @property
    def darker_by(self) -> int:
        """Grey levels by which a neighbour is darker than the centre at most without a bit in the census."""
        return self.census_threshold

    @property
    def maximum(self) -> int:
        """Largest cost ``C``."""
        return max(min(self.inside_max, self.cost_limit), self.cost_outside)

    @property
    def cap(self) -> int:
        """Greater costs inside the picture are reduced to this one."""
        return self.cost_limit


@dataclass(frozen=True)
class LineBelow:
    """The costs of the line below in a pixel's own: ``V = own_share * C(y) + lower_share * C(y + 1)``.

    Parameters
    ----------
    own_share, lower_share : int
        ``1..7``, ``0..7``.
    lower_threshold : int
        Grey levels by which the pixel below may differ; else the pixel's own cost takes its place; ``0..255``.
    """
    own_share: int = 5
    lower_share: int = 4
    lower_threshold: int = 26

    LIMITS: ClassVar[Mapping[str, range]] = {"own_share": range(1, 8), "lower_share": range(8), "lower_threshold": range(PIXEL_MAX + 1)}

    def __post_init__(self) -> None:
        check_limits(asdict(self), self.LIMITS)


@dataclass(frozen=True)
class GradedArms:
    """The support of a pixel on its scanline: steps are taken while the pixel stepped on is like the centre and like the one before.

    Parameters
    ----------
    near_threshold, far_threshold : int
        Grey levels by which a pixel may differ from the centre, up to step ``far_step - 1`` and from step ``far_step`` on. Settings.
    step_threshold : int
        Grey levels by which it may differ from the pixel stepped from. A setting.
    far_step : int
        ``1..32``.
    reach : int
        Longest arm, pixels, ``0..31``.
    """
    near_threshold: int = 7
    far_threshold: int = 4
    step_threshold: int = 6
    far_step: int = 5
    reach: int = 16

    LIMITS: ClassVar[Mapping[str, range]] = {
        **dict.fromkeys(("near_threshold", "far_threshold", "step_threshold"), range(PIXEL_MAX + 1)),
        "far_step": range(1, 33), "reach": range(32),
    }
    #: Fraction bits of a reciprocal.
    RECIPROCAL_BITS: ClassVar[int] = 10

    def __post_init__(self) -> None:
        check_limits(asdict(self), self.LIMITS)

    @property
    def support_max(self) -> int:
        """Most pixels of a support."""
        return 2 * self.reach + 1


@dataclass(frozen=True)
class Propagation:
    """What a line's costs take from the lines above and below.

    Parameters
    ----------
    spread_step, spread_jump : int
        Cost of a neighbouring label, and of any other one, in the costs that are carried on; ``1..127``.
    gate_numerator, gate_offset, gate_floor : int
        Costs carried over a difference of ``dI`` grey levels are at most ``max(gate_floor, gate_numerator // (gate_offset + dI))``.
        Settings.
    fan : int
        Columns to the left and to the right at which the line above is looked at too, pixels, ``3..31``.
    above_share, below_share : int
        Eighths of the costs from above and from below that join a pixel's own, ``0..15``. Settings.
    from_below : bool
        Whether costs come from below.
    """
    spread_step: int = 8
    spread_jump: int = 78
    gate_numerator: int = 312
    gate_offset: int = 4
    gate_floor: int = 10
    fan: int = 8
    above_share: int = 10
    below_share: int = 4
    from_below: bool = False

    #: Fraction bits of the shares.
    SHARE_BITS: ClassVar[int] = 3
    SHARE_MAX: ClassVar[int] = 15
    LIMITS: ClassVar[Mapping[str, range]] = {
        "spread_step": range(1, 128), "spread_jump": range(1, 128), "gate_numerator": range(1, 1 << 12), "gate_offset": range(1, 256),
        "gate_floor": range(128), "fan": range(3, 32), "above_share": range(SHARE_MAX + 1), "below_share": range(SHARE_MAX + 1),
    }

    def __post_init__(self) -> None:
        check_limits(asdict(self), self.LIMITS)

    @property
    def gate(self) -> tuple[int, ...]:
        """The gate by the difference of grey levels, ``0..255``; at most ``spread_jump``, the greatest cost carried."""
        return tuple(min(max(self.gate_floor, self.gate_numerator // (self.gate_offset + difference)), self.spread_jump)
                     for difference in range(PIXEL_MAX + 1))


@dataclass(frozen=True)
class WeightedRefinement(Refinement):
    """The stages of :class:`Refinement`, with a weighted median of 7x7 pixels, and a fill that goes on with the slope
    at the left border."""
    median_size: int = 7

    LIMITS: ClassVar[Mapping[str, range]] = {**Refinement.LIMITS, "median_size": range(7, 8, 2)}
    USES_GREY: ClassVar[bool] = True


@dataclass(frozen=True)
class Recursive(RefinedLabels):
    """Parameters of the method; the defaults are the set :data:`RECURSIVE_1`.

    Parameters
    ----------
    cost : RecursiveCost
    line_below : LineBelow
    arms : GradedArms
    propagation : Propagation
    refinement : WeightedRefinement
    soft_multipliers : bool
        Whether the gateware multiplies by reciprocals in logic; else in multipliers of the device.
    """
    cost: RecursiveCost = RecursiveCost()
    line_below: LineBelow = LineBelow()
    arms: GradedArms = GradedArms()
    propagation: Propagation = Propagation()
    refinement: WeightedRefinement = WeightedRefinement()
    soft_multipliers: bool = False

    name: ClassVar[str] = "recursive"
    ABOUT: ClassVar[str] = "costs carried from line to line and averaged over a support, disparities refined with the grey levels"
    #: Limits of the parameters that are numbers, whichever part holds them.
    LIMITS: ClassVar[Mapping[str, range]] = {
        **RecursiveCost.LIMITS, **LineBelow.LIMITS, **GradedArms.LIMITS, **Propagation.LIMITS, **WeightedRefinement.LIMITS,
    }
    #: Parameters that are settings of the gateware, and their descriptions and units.
    SETTINGS: ClassVar[Mapping[str, tuple[str, str]]] = {
        "census_threshold": ("least difference of grey levels that the census sees, less one", "grey levels"),
        "near_threshold": ("difference of a support's near pixels from its centre", "grey levels"),
        "far_threshold": ("difference of a support's far pixels from its centre", "grey levels"),
        "step_threshold": ("difference of a support's pixel from the one before it", "grey levels"),
        "above_share": ("share of the costs from above", "eighths"),
        "below_share": ("share of the costs from below", "eighths"),
        "gate_numerator": ("gates of carried costs: this over offset and difference", "grey levels"),
        "gate_offset": ("gates: added to the difference of grey levels", "grey levels"),
        "gate_floor": ("gates: the least", "costs"),
    }

    @property
    def matching_cost(self) -> MatchingCost:
        """Widths of the matching cost that is fused."""
        return MatchingCost(self.arithmetic)

    @property
    def view_max(self) -> int:
        """Largest cost that the right view compares."""
        return self.data_max

    @property
    def census_above(self) -> bool:
        """Whether the pixel two lines above comes with a census."""
        return self.propagation.from_below

    @property
    def own_max(self) -> int:
        """Largest ``V``: a pixel's cost with that of the line below."""
        return (self.line_below.own_share + self.line_below.lower_share) * self.cost.maximum

    @property
    def carried_max(self) -> int:
        """Largest cost ``Q`` that is carried to another line."""
        return self.propagation.spread_jump

    @property
    def joined_max(self) -> int:
        """Largest ``W``: ``V`` with the greatest shares of the costs from above and below."""
        lines = 1 + self.propagation.from_below
        return self.own_max + lines * (Propagation.SHARE_MAX * self.carried_max >> Propagation.SHARE_BITS)

    @property
    def data_max(self) -> int:
        """Largest ``A``: the mean of ``W`` over the support, and an eighth of the cost from above."""
        return self.joined_max + (self.carried_max >> Propagation.SHARE_BITS)

    def _parameters(self) -> dict[str, int]:
        """Values of :attr:`SETTINGS`."""
        parts = {**asdict(self.cost), **asdict(self.arms), **asdict(self.propagation)}
        return {name: parts[name] for name in self.SETTINGS if name != "below_share" or self.propagation.from_below}

    def settings(self, minimum: int) -> Mapping[str, Setting]:
        """Thresholds and shares, the least disparity, and the switches of the refinement."""
        numbers = {name: Setting(self.LIMITS[name][-1], value, self.SETTINGS[name][0], self.LIMITS[name][0], self.SETTINGS[name][1])
                   for name, value in self._parameters().items()}
        return {**numbers, **self.refinement_settings(minimum)}

    def with_settings(self, values: Mapping[str, int]) -> "Recursive":
        """The method with those thresholds, shares and switches; the least disparity is not the method's."""
        parts = {part: {name: values[name] for name in asdict(getattr(self, part)) if name in values and name in self.SETTINGS}
                 for part in ("cost", "arms", "propagation")}
        return replace(self, refinement=self.refinement_with(values),
                       **{part: replace(getattr(self, part), **given) for part, given in parts.items()})

    def about(self) -> Mapping[str, Any]:
        """All parameters for reports."""
        return asdict(self)


RECURSIVE_1 = Recursive()  # without costs from below: much smaller

RECURSIVE_2 = Recursive(propagation=Propagation(from_below=True))
