"""Definitions that all methods share: pixels, weights, number formats, engines, settings."""

import enum
from collections.abc import Mapping
from dataclasses import dataclass
from typing import NamedTuple


__all__ = ["IN_USE_BITS", "LEAST_MINIMUM", "MINIMUM_BITS", "PIXEL_BITS", "PIXEL_MAX", "WEIGHT_BITS", "WEIGHT_MAX", "Arithmetic", "Engine",
           "MatchingCost", "Setting", "Weights", "check_limits", "weight_settings"]


PIXEL_BITS = 8
PIXEL_MAX = 2**PIXEL_BITS - 1

# Weights u1, u2, u3. The thesis's optimum is 15, 10, 5 and its sweep (figure 34) stays below 50; six bits hold that.
WEIGHT_BITS = 6
WEIGHT_MAX = 2**WEIGHT_BITS - 1

# Labels in use: up to 256.
IN_USE_BITS = 9

# Least disparity: up to 255.
MINIMUM_BITS = 8

# Least disparity of cameras that converge: a point behind the point of convergence has a negative disparity.
LEAST_MINIMUM = -64


def check_limits(values: Mapping[str, object], limits: Mapping[str, range]) -> None:
    """:class:`ValueError` unless each value is a whole number within the limits of its name."""
    for name, allowed in limits.items():
        value = values[name]
        if not isinstance(value, int) or value not in allowed:
            odd = "odd " if allowed.step == 2 else ""
            raise ValueError(f"{name} must be {'an ' if odd else 'a '}{odd}whole number from {allowed[0]} to {allowed[-1]}, not {value!r}")


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

    ``SEQUENTIAL``: as the thesis does, several cycles a pixel; up to 128 labels.
    ``STREAMING``: one pixel a cycle; ``LINEAR`` arithmetic only, up to 256 labels.
    """
    SEQUENTIAL = "sequential"
    STREAMING = "streaming"


class Weights(NamedTuple):
    """Weights of the left, upper and lower neighbour, ``0..63``; their unit is the method's."""
    u1: int
    u2: int
    u3: int

    def check(self) -> None:
        """:class:`ValueError` unless all are within their bits."""
        check_limits(self._asdict(), dict.fromkeys(self._fields, range(WEIGHT_MAX + 1)))


@dataclass(frozen=True)
class MatchingCost:
    """Widths of the matching cost ``E`` of equation (2-12) in an arithmetic."""
    arithmetic: Arithmetic

    @property
    def sub_pixel_max(self) -> int:
        """Largest sub-pixel: a mean (``FLOAT``, ``THESIS``) or a sum (``LINEAR``) of two grey levels."""
        return 2 * PIXEL_MAX if self.arithmetic is Arithmetic.LINEAR else PIXEL_MAX

    @property
    def inside_max(self) -> int:
        """Largest matching cost of a candidate inside the picture: five differences."""
        return 5 * self.sub_pixel_max

    @property
    def bits(self) -> int:
        """Bits of a matching cost."""
        return self.inside_max.bit_length()

    @property
    def outside(self) -> int:
        """Cost of a candidate whose right pixel lies outside the picture: the greatest that the width holds."""
        return 2**self.bits - 1


@dataclass(frozen=True)
class Setting:
    """A number that the host may change from frame to frame.

    Parameters
    ----------
    maximum : int
        Greatest value; its bit length is the width of the port.
    default : int
        Value until it is set.
    description : str
        One line.
    minimum : int
        Least value.
    unit : str
        Empty for a switch, 0 off and 1 on.
    """
    maximum: int
    default: int
    description: str
    minimum: int = 0
    unit: str = ""

    @property
    def signed(self) -> bool:
        """Whether the port is signed."""
        return self.minimum < 0

    @property
    def bits(self) -> int:
        """Width of the port."""
        return max(self.maximum.bit_length(), (-self.minimum - 1).bit_length() if self.signed else 0) + self.signed


def weight_settings(weights: Weights, unit: str) -> dict[str, Setting]:
    """The weights as settings, by name."""
    return {name: Setting(WEIGHT_MAX, weight, f"weight of the {which} neighbour", unit=unit)
            for (name, weight), which in zip(weights._asdict().items(), ("left", "upper", "lower"), strict=True)}
