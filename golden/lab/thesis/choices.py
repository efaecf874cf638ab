"""What the thesis leaves open: borders, roundings, ties. Variants of the method for each choice."""

import dataclasses
import itertools
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...config import Arithmetic, MatcherConfig, OnePass, changed
from ...matcher.cost import local_disparity, matching_cost
from ...matcher.labelling import scan, slopes
from ...matcher.smooth import slope
from ...pictures.images import grey


__all__ = ["BORDERS", "GREYS", "Choice", "all_choices", "bordered_cost", "disparities", "grey_levels"]


# Cost of a candidate outside the right picture: more than any other (ours); the cost with edge replication; or that against grey level 0.
BORDERS = ("ours", "edge", "zero")

# How a colour becomes a grey level: rounded half up as MATLAB's rgb2gray does (ours), with floor, or as the mean of the three.
GREYS = ("rgb2gray", "floor", "mean")

# Number formats: exact (ours, for the thesis's MATLAB); with smoothness over 256 in place of 255; with sub-pixels that are floored, as the
# thesis's FPGA has them, and exact smoothness over 255 or 256; all of its FPGA; our gateware's with 3 and with 0 fraction bits.
FORMATS = ("float", "float/256", "floor", "floor/256", "thesis", "linear", "linear q=0")

# Of every format, the arithmetic of its sub-pixels and that of its smoothness.
_ARITHMETIC = {
    "float": (Arithmetic.FLOAT, Arithmetic.FLOAT), "float/256": (Arithmetic.FLOAT, Arithmetic.THESIS),
    "floor": (Arithmetic.THESIS, Arithmetic.FLOAT), "floor/256": (Arithmetic.THESIS, Arithmetic.THESIS),
    "thesis": (Arithmetic.THESIS, Arithmetic.THESIS), "linear": (Arithmetic.LINEAR, Arithmetic.LINEAR),
    "linear q=0": (Arithmetic.LINEAR, Arithmetic.LINEAR),
}


@dataclass(frozen=True)
class Choice:
    """One way to read the thesis.

    Parameters
    ----------
    border : str
        One of :data:`BORDERS`.
    levels : str
        One of :data:`GREYS`.
    numbers : str
        One of :data:`FORMATS`.
    outside : bool
        Whether a neighbour outside the picture counts as one of disparity 0 and the pixel's grey level; otherwise (ours) it adds nothing.
    last : bool
        Whether the greater disparity wins a tie; otherwise (ours) the smaller.
    """
    border: str = "ours"
    levels: str = "rgb2gray"
    numbers: str = "float"
    outside: bool = False
    last: bool = False

    def __str__(self) -> str:
        ties, neighbour = ("greater" if self.last else "smaller"), ("disparity 0" if self.outside else "nothing")
        return f"{self.numbers}, grey by {self.levels}, border {self.border}, neighbour outside {neighbour}, {ties} on a tie"


def all_choices() -> Iterator[Choice]:
    """All combinations."""
    for values in itertools.product(BORDERS, GREYS, FORMATS, (False, True), (False, True)):
        yield Choice(*values)


def grey_levels(rgb: NDArray[np.uint8], levels: str) -> NDArray[np.uint8]:
    """Grey levels of a colour picture by one of :data:`GREYS`; grey pictures are unchanged.

    Examples
    --------
    >>> [grey_levels(np.array([[[10, 10, 15]]], dtype=np.uint8), how).item() for how in GREYS]
    [11, 10, 12]
    """
    if rgb.ndim == 2:
        return rgb
    if levels == "rgb2gray":
        return grey(rgb)
    parts = rgb.astype(np.int32)
    total: NDArray[np.int32] = parts @ np.array([2989, 5870, 1140]) // 10000 if levels == "floor" else (2 * parts.sum(axis=-1) + 3) // 6
    return total.astype(np.uint8)


def bordered_cost(left: NDArray[Any], right: NDArray[Any], config: MatcherConfig, border: str) -> NDArray[Any]:
    """Matching cost of :func:`golden.matcher.cost.matching_cost`, with one of :data:`BORDERS`."""
    if border == "ours":
        cost: NDArray[Any] = matching_cost(left, right, config)
        return cost
    # Wide enough that every candidate is within the padded picture.
    margin = config.labels
    how: Any = {"edge": {"mode": "edge"}, "zero": {"mode": "constant"}}[border]
    padded = [np.pad(side, ((1, 1), (margin, 1)), **how) for side in (left, right)]
    whole: NDArray[Any] = matching_cost(padded[0], padded[1], config)
    return whole[1:-1, margin:-1]


def disparities(left: NDArray[Any], right: NDArray[Any], config: MatcherConfig, choice: Choice) -> NDArray[Any]:
    """Disparities by the thesis's method as one choice reads it.

    Parameters
    ----------
    left, right : (H, W) or (H, W, 3) uint8 ndarray
        Grey levels or colours.
    config : MatcherConfig
        Number of disparities and weights; ``choice`` says the arithmetic.
    choice : Choice

    Returns
    -------
    (H, W) int32 ndarray
        Pixels.
    """
    left, right = (grey_levels(side, choice.levels) for side in (left, right))
    pixels, smoothness = _ARITHMETIC[choice.numbers]
    # Without a floor after it, smoothness in 256ths is what the thesis's arithmetic has before its shift.
    exact = smoothness is Arithmetic.FLOAT or choice.numbers.endswith("/256")
    def counted_in(arithmetic: Arithmetic) -> MatcherConfig:
        fraction_bits = 0 if choice.numbers == "linear q=0" else OnePass.fraction_bits
        return dataclasses.replace(config, method=changed(config.method_as(OnePass), arithmetic=arithmetic, fraction_bits=fraction_bits))

    cost = bordered_cost(left, right, counted_in(pixels), choice.border)
    config = counted_in(smoothness)
    local = np.argmin(cost[..., ::-1], axis=-1) if choice.last else local_disparity(cost)
    shift = 8 if smoothness is Arithmetic.THESIS and not exact else 0
    scale = 256 if choice.numbers.endswith("/256") else config.rule.energy_scale
    weights = slopes(left, config).astype(np.float64 if exact else np.int32)
    energy = cost.astype(weights.dtype) * scale
    if choice.outside:
        ramp = np.arange(config.labels)
        edges: tuple[Any, ...] = (np.s_[:, 0], np.s_[0], np.s_[-1])  # left, upper, lower
        for at, weight in zip(edges, config.rule.weights, strict=True):
            term = ramp * slope(0, weight, config)
            energy[at] += term >> shift if shift else term
    if not choice.last:
        return scan(energy, local, weights, shift=shift)
    # With the labels in reverse order the first of equals is the greatest.
    return config.labels - 1 - scan(np.ascontiguousarray(energy[..., ::-1]), local, weights, shift=shift)
