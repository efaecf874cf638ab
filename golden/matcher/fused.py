"""The method :class:`golden.config.Fused`: the disparity rule on support sums of the fused cost, then the refinement."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..config import Fused, MatcherConfig
from .confidence import confidence
from .labelling import scan, slopes
from .refine import check, fill, median, right_view
from .sub_pixel import sub_pixel_labels
from .support import arms, fused_cost, support_sizes, support_sums
from .vertical import vertical_support


__all__ = ["FusedMatch", "Stages", "labelling", "labelling_plain", "match", "stages"]


@dataclass(frozen=True)
class FusedMatch:
    """Result of the method for every pixel.

    Parameters
    ----------
    disparity : (H, W) int32 ndarray
        Pixels times ``scale``, ``config.minimum .. config.minimum + D-1`` pixels.
    passed : (H, W) bool ndarray
        Whether the left-right check passed, before the fill.
    confidence : (H, W) uint8 ndarray
        ``0..15``, of :func:`golden.matcher.confidence.confidence`.
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


def labelling(sums, support_size, left, config: MatcherConfig):
    """Label of every pixel by the rule: the ``d`` of least ``(S << energy_shift) + w1*|d - f_left| + w2*|d - f_up| + w3*|d - b_low|``.

    ``w`` is the slope of :func:`golden.matcher.smooth.slope` times the size of the pixel's support; ``b`` is the label of least ``S``. The
    smaller label wins a tie.

    Parameters
    ----------
    sums : (H, W, D) integer ndarray
        Support sums ``S``, of :func:`golden.matcher.support.support_sums`.
    support_size : (H, W) integer ndarray
        Pixels, of :func:`golden.matcher.support.support_sizes`.
    left : (H, W) integer ndarray
        Grey levels.

    Returns
    -------
    (H, W) int32 ndarray
        Labels ``0 .. D-1``.
    """
    weights = slopes(left, config) * np.asarray(support_size, dtype=np.int32)
    return scan(sums, np.argmin(sums, axis=-1), weights, config.rule.energy_scale)


@dataclass(frozen=True)
class Stages:
    """Results of the method's stages up to the fill.

    Parameters
    ----------
    sums : (H, W, D) int16 ndarray
        Support sums ``S``.
    support_size : (H, W) integer ndarray
        Pixels of the supports.
    right : (H, W) int32 ndarray
        Labels of the right view.
    passed : (H, W) bool ndarray
        Whether the check passed; true everywhere if it is off.
    found : (H, W) int32 ndarray
        Labels before the fill, times ``config.method.disparity_scale``.
    """
    sums: NDArray[Any]
    support_size: NDArray[Any]
    right: NDArray[Any]
    passed: NDArray[np.bool_]
    found: NDArray[Any]


def stages(left, right, config: MatcherConfig) -> Stages:
    """Cost, support, rule, check and sub-pixel labels: all stages before the fill. Parameters as of :func:`match`."""
    method = config.method_as(Fused)
    left_arm, right_arm = arms(left, method.arms)
    sizes = support_sizes(left_arm, right_arm)
    cost = vertical_support(fused_cost(left, right, config), left, method.vertical)
    sums = support_sums(cost, left_arm, right_arm)
    labels = labelling(sums, sizes, left, config)
    from_right = right_view(cost, config)
    passed = check(labels, from_right, config) if method.refinement.check else np.ones(labels.shape, dtype=bool)
    return Stages(sums, sizes, from_right, passed, sub_pixel_labels(sums, labels, passed) if method.refinement.sub_pixel else labels)


def match(left, right, config: MatcherConfig) -> FusedMatch:
    """Disparities of a rectified pair by the method :class:`golden.config.Fused`.

    Parameters
    ----------
    left, right : (H, W) integer ndarray
        Grey levels ``0..255``.
    """
    found = stages(left, right, config)
    refinement, scale = config.method_as(Fused).refinement, config.method.disparity_scale
    filled = fill(found.found, found.passed) if refinement.fill else found.found
    result = median(filled, refinement.median_size) if refinement.median else filled
    sure = confidence(result, filled, found.passed, found.support_size, scale)
    return FusedMatch(result + config.minimum * scale, found.passed, sure, scale)


def labelling_plain(sums, support_size, left, config: MatcherConfig):
    """:func:`labelling`, pixel by pixel: the rule for reading."""
    height, width, labels = sums.shape
    u1, u2, u3 = config.rule.weights
    local = np.argmin(sums, axis=-1).tolist()
    grey = np.asarray(left).tolist()
    result = [[0] * width for _ in range(height)]
    for y in range(height):
        for x in range(width):
            def weight(u, other, y=y, x=x):
                return int(support_size[y, x]) * (u * (256 - abs(grey[y][x] - other)) >> 8)

            # (label of the neighbour, slope); a neighbour outside the picture has no term.
            neighbours = []
            if x > 0:
                neighbours.append((result[y][x - 1], weight(u1, grey[y][x - 1])))
            if y > 0:
                neighbours.append((result[y - 1][x], weight(u2, grey[y - 1][x])))
            if y < height - 1:
                neighbours.append((local[y + 1][x], weight(u3, grey[y + 1][x])))
            energy = [int(sums[y, x, d]) * config.rule.energy_scale + sum(w * abs(d - f) for f, w in neighbours) for d in range(labels)]
            result[y][x] = energy.index(min(energy))
    return np.array(result, dtype=np.int32)
