"""Parameters of the toy method, and what follows from them."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import ClassVar

from golden.config import PIXEL_MAX, WEIGHT_MAX, Arithmetic, Engine, Weights
from golden.config.limits import weight_settings


_WEIGHTS = Weights(20, 10, 5)


@dataclass(frozen=True)
class Toy:
    """Absolute difference of two pixels; weights in quarters of a grey level."""
    weights: Weights = _WEIGHTS

    name = "toy"
    ABOUT = "absolute differences"
    SWITCHES: ClassVar[Mapping[str, str]] = {}
    arithmetic = Arithmetic.LINEAR
    engines = (Engine.STREAMING,)
    energy_shift = 2
    energy_scale = 4
    data_max = PIXEL_MAX
    slope_shift = 0
    slope_max = smooth_step_max = WEIGHT_MAX
    disparity_scale = 1

    def result_fields(self, labels, minimum):
        return {"disparity": (labels - 1).bit_length()}

    def settings(self, minimum):
        return weight_settings(self.weights, "quarters of a grey level")

    def with_settings(self, values):
        return replace(self, weights=Weights(**{name: values.get(name, value) for name, value in self.weights._asdict().items()}))

    def about(self):
        return asdict(self)
