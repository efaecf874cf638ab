"""The parameters of the matcher: the vocabulary that golden model, gateware, benches and builds share."""

import enum
from dataclasses import dataclass


__all__ = ["Arithmetic", "Engine", "IN_USE_BITS", "MatcherConfig", "PIXEL_BITS", "PIXEL_MAX", "WEIGHT_BITS", "WEIGHT_MAX"]


PIXEL_BITS = 8
PIXEL_MAX = 2**PIXEL_BITS - 1

# Weights u1, u2, u3. The thesis's optimum is 15, 10, 5 and its sweep (figure 34) stays below 50; six bits hold that.
WEIGHT_BITS = 6
WEIGHT_MAX = 2**WEIGHT_BITS - 1

# Labels in use: up to 256.
IN_USE_BITS = 9


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
class MatcherConfig:
    """Size and arithmetic of a matcher.

    Parameters
    ----------
    disparities : int
        Number of labels ``D``; disparities are ``0 .. D-1`` pixels.
    arithmetic : Arithmetic
        Number formats.
    fraction_bits : int
        Fraction bits ``q`` of the slopes; read by ``LINEAR`` only.
    u1, u2, u3 : int
        Weights of the left, upper and lower neighbour, in grey levels a pixel of disparity. Build-time defaults of the gateware's inputs.
    in_use : int or None
        Labels in use, ``0 .. in_use - 1``: those above cost what a candidate outside the picture does. ``None``: all. Build-time default
        of the gateware's input.
    max_width : int
        Longest line, in pixels, that the gateware's memories hold.
    engine : Engine
        Which gateware.
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

    DISPARITIES = range(2, 257)
    SEQUENTIAL_DISPARITIES = range(2, 129)
    FRACTION_BITS = range(0, 5)
    WIDTHS = range(1, 4097)

    def __post_init__(self):
        for name, value, limits in (
            ("disparities", self.disparities, self.DISPARITIES),
            ("fraction_bits", self.fraction_bits, self.FRACTION_BITS),
            ("max_width", self.max_width, self.WIDTHS),
            ("u1", self.u1, range(WEIGHT_MAX + 1)),
            ("u2", self.u2, range(WEIGHT_MAX + 1)),
            ("u3", self.u3, range(WEIGHT_MAX + 1)),
        ):
            if not isinstance(value, int) or value not in limits:
                raise ValueError(f"{name} must be a whole number from {limits[0]} to {limits[-1]}, not {value!r}")
        if self.in_use is not None and (not isinstance(self.in_use, int) or not 1 <= self.in_use <= self.disparities):
            raise ValueError(f"in_use must be a whole number from 1 to disparities, {self.disparities}, not {self.in_use!r}")
        object.__setattr__(self, "arithmetic", Arithmetic(self.arithmetic))
        object.__setattr__(self, "engine", Engine(self.engine))
        if self.engine is Engine.STREAMING and self.arithmetic is not Arithmetic.LINEAR:
            raise ValueError(f"engine streaming computes the arithmetic linear only, not {self.arithmetic}")

    @property
    def weights(self):
        """``(u1, u2, u3)``."""
        return self.u1, self.u2, self.u3

    @property
    def labels_in_use(self) -> int:
        """Number of labels that may be chosen freely."""
        return self.disparities if self.in_use is None else self.in_use

    @property
    def energy_shift(self):
        """Fraction bits of the integer energies: the matching cost enters them as ``E << energy_shift``."""
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
        return 2 * WEIGHT_MAX << self.fraction_bits

    @property
    def smooth_max(self):
        """Largest smoothness term: the labels ``0`` and ``D-1`` side by side in equal pixels."""
        per_label = self.slope_max if self.arithmetic is Arithmetic.LINEAR else WEIGHT_MAX
        return per_label * (self.disparities - 1)

    @property
    def energy_max(self):
        """Largest energy that the rule compares."""
        return (self.cost_outside << self.energy_shift) + 3 * self.smooth_max

    @property
    def energy_bits(self) -> int:
        """Bits of an energy."""
        return self.energy_max.bit_length()
