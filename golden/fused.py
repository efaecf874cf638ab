"""The second method: the disparity rule on support sums of the fused cost, and what follows it."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .confidence import confidence
from .config import Cost, MatcherConfig
from .labelling import scan, slopes
from .refine import check, fill, median, right_view
from .sub_pixel import SUB_PIXEL_SCALE, sub_pixel_labels
from .support import arms, fused_cost, support_sizes, support_sums


__all__ = ["Fused", "labelling", "labelling_plain", "match"]


@dataclass(frozen=True)
class Fused:
    """What the method gives for every pixel.

    Parameters
    ----------
    disparity : (H, W) int32 ndarray
        Pixels times ``scale``, ``config.minimum .. config.minimum + D-1`` pixels.
    passed : (H, W) bool ndarray
        Whether the left-right check passed, before the fill.
    confidence : (H, W) uint8 ndarray
        ``0..15``, of :func:`golden.confidence.confidence`.
    scale : int
        1, or 8 with sub-pixel disparities: three fraction bits.
    """
    disparity: NDArray[Any]
    passed: NDArray[np.bool_]
    confidence: NDArray[np.uint8]
    scale: int = 1

    @property
    def pixels(self) -> NDArray[Any]:
        """Disparities in pixels: whole numbers as they are, or float64, which holds eighths exactly."""
        return self.disparity if self.scale == 1 else self.disparity / self.scale


def labelling(sums, n, left, config: MatcherConfig):
    """Label of every pixel by the rule: the ``d`` of least ``(S << energy_shift) + w1*|d - f_left| + w2*|d - f_up| + w3*|d - b_low|``.

    ``w`` is the slope of :func:`golden.smooth.slope` times the pixel's own ``n``; ``b`` is the label of least ``S``, the smaller on a
    tie, as everywhere.

    Parameters
    ----------
    sums : (H, W, D) integer ndarray
        Support sums ``S``, of :func:`golden.support.support_sums`.
    n : (H, W) integer ndarray
        Pixels of the support, of :func:`golden.support.support_sizes`.
    left : (H, W) integer ndarray
        Grey levels.

    Returns
    -------
    (H, W) int32 ndarray
        Labels ``0 .. D-1``.
    """
    return scan(sums, np.argmin(sums, axis=-1), slopes(left, config) * np.asarray(n, dtype=np.int32), config.energy_scale)


def match(left, right, config: MatcherConfig) -> Fused:
    """Disparities of a rectified pair by the second method.

    Parameters
    ----------
    left, right : (H, W) integer ndarray
        Grey levels ``0..255``.
    """
    if config.cost is not Cost.FUSED:
        raise ValueError(f"this is the matcher of the cost fused, not {config.cost}; take golden.labelling.match")
    l, r = arms(left, config.fused)
    n = support_sizes(l, r)
    cost = fused_cost(left, right, config)
    sums = support_sums(cost, l, r)
    labels = labelling(sums, n, left, config)

    stages = config.refinement
    scale = SUB_PIXEL_SCALE if stages.sub_pixel else 1
    passed = check(labels, right_view(cost, config), config) if stages.check else np.ones(labels.shape, dtype=bool)
    found = sub_pixel_labels(sums, labels, passed) if stages.sub_pixel else labels
    filled = fill(found, passed) if stages.fill else found
    result = median(filled, config.fused.median) if stages.median else filled
    return Fused(result + config.minimum * scale, passed, confidence(result, filled, passed, n, scale), scale)


def labelling_plain(sums, n, left, config: MatcherConfig):
    """:func:`labelling`, pixel by pixel: the rule for reading."""
    height, width, labels = sums.shape
    u1, u2, u3 = config.weights
    local = np.argmin(sums, axis=-1).tolist()
    grey = np.asarray(left).tolist()
    result = [[0] * width for _ in range(height)]
    for y in range(height):
        for x in range(width):
            def slope(u, other, y=y, x=x):
                return int(n[y, x]) * (u * (256 - abs(grey[y][x] - other)) >> 8)

            # (label of the neighbour, slope); a neighbour outside the picture adds nothing.
            neighbours = []
            if x > 0:
                neighbours.append((result[y][x - 1], slope(u1, grey[y][x - 1])))
            if y > 0:
                neighbours.append((result[y - 1][x], slope(u2, grey[y - 1][x])))
            if y < height - 1:
                neighbours.append((local[y + 1][x], slope(u3, grey[y + 1][x])))
            energy = [(int(sums[y, x, d]) << config.fused.energy_shift) + sum(w * abs(d - f) for f, w in neighbours) for d in range(labels)]
            result[y][x] = energy.index(min(energy))
    return np.array(result, dtype=np.int32)
