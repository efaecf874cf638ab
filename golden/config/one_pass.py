"""The thesis's method: the matching cost of five differences, labelled by the disparity rule."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar

from .limits import PIXEL_MAX, WEIGHT_MAX, Arithmetic, Engine, MatchingCost, Setting, Weights, check_limits, weight_settings


__all__ = ["OnePass"]


@dataclass(frozen=True)
class OnePass:
    """Parameters of the thesis's method.

    Parameters
    ----------
    arithmetic : Arithmetic
        Number formats.
    fraction_bits : int
        Fraction bits ``q`` of the slopes, ``0..4``; read by ``LINEAR`` only.
    weights : Weights
        Grey levels a pixel of disparity.
    """
    arithmetic: Arithmetic = Arithmetic.THESIS
    fraction_bits: int = 3
    weights: Weights = Weights(15, 10, 5)

    name: ClassVar[str] = "thesis"
    ABOUT: ClassVar[str] = "one pass of the disparity rule on the matching cost"
    SWITCHES: ClassVar[Mapping[str, str]] = {}
    FRACTION_BITS: ClassVar[range] = range(0, 5)

    def __post_init__(self) -> None:
        object.__setattr__(self, "arithmetic", Arithmetic(self.arithmetic))
        object.__setattr__(self, "weights", Weights(*self.weights))
        check_limits({"fraction_bits": self.fraction_bits}, {"fraction_bits": self.FRACTION_BITS})
        self.weights.check()

    @property
    def engines(self) -> tuple[Engine, ...]:
        """``THESIS`` needs the multipliers of the sequential engine; ``FLOAT`` is named with it, and refused where gateware is made."""
        return (Engine.SEQUENTIAL, Engine.STREAMING) if self.arithmetic is Arithmetic.LINEAR else (Engine.SEQUENTIAL,)

    @property
    def energy_shift(self) -> int:
        """Fraction bits of the integer energies."""
        return self.fraction_bits if self.arithmetic is Arithmetic.LINEAR else 0

    @property
    def energy_scale(self) -> int:
        """Factor of the matching cost in the energy.

        ``FLOAT`` computes 255 times the energy of (2-15): every term is then a multiple of one half, float64 holds it exactly and
        ties are ties. With ``dI / 255`` rounded, ties fall either way: measured, bad pixels move by up to 0.03 points.
        """
        return PIXEL_MAX if self.arithmetic is Arithmetic.FLOAT else 1 << self.energy_shift

    @property
    def data_max(self) -> int:
        """Largest data term: the cost of a candidate outside the picture."""
        return MatchingCost(self.arithmetic).outside

    @property
    def slope_max(self) -> int:
        """Largest slope of a smoothness term (``LINEAR``): ``dI = 0`` and the greatest weight."""
        return 2 * WEIGHT_MAX << self.fraction_bits

    @property
    def slope_shift(self) -> int:
        """A slope is ``(2*u*(256 - dI) << q) >> 8``."""
        return self.fraction_bits + 1

    @property
    def smooth_step_max(self) -> int:
        """Largest smoothness term between labels that differ by one, in equal pixels."""
        return self.slope_max if self.arithmetic is Arithmetic.LINEAR else WEIGHT_MAX

    @property
    def disparity_scale(self) -> int:
        """Disparities are whole pixels."""
        return 1

    def result_fields(self, labels: int, minimum: int) -> Mapping[str, int]:
        """Fields of a result, and their bits: the gateware has the least disparity 0 only."""
        return {"disparity": (labels - 1).bit_length()}

    def settings(self, minimum: int) -> Mapping[str, Setting]:
        """The weights."""
        return weight_settings(self.weights, "grey levels a pixel")

    def with_settings(self, values: Mapping[str, int]) -> "OnePass":
        """The method with those weights."""
        return replace(self, weights=Weights(**{name: values.get(name, value) for name, value in self.weights._asdict().items()}))

    def about(self) -> Mapping[str, Any]:
        """All parameters for reports."""
        return {**asdict(self), "weights": self.weights._asdict()}
