"""The method :class:`golden.config.Recursive` on a pair of pictures."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...config import MatcherConfig, Recursive
from ..confidence import confidence
from ..fused import FusedMatch
from ..refine import check, right_view
from ..sub_pixel import sub_pixel_labels
from ..support import fused_cost, support_sizes
from .arms import graded_arms, support_means
from .border_fill import border_fill
from .line_below import line_below
from .neighbours import from_above, from_below
from .spread import spread
from .weighted_median import weighted_median


__all__ = ["Stages", "match", "recursion", "stages"]


@dataclass(frozen=True)
class Stages:
    """Results of the method's stages up to the fill.

    Parameters
    ----------
    costs : (H, W, D) int16 ndarray
        ``A``, whose least label is the pixel's.
    support_size : (H, W) integer ndarray
        Pixels of the supports.
    right : (H, W + lead) int32 ndarray
        Labels of the right view.
    passed : (H, W) bool ndarray
        Whether the check passed; true everywhere if it is off.
    found : (H, W) int32 ndarray
        Labels before the fill, times ``config.method.disparity_scale``.
    """
    costs: NDArray[Any]
    support_size: NDArray[Any]
    right: NDArray[Any]
    passed: NDArray[np.bool_]
    found: NDArray[Any]


def recursion(own, left, method: Recursive):
    """Costs ``A`` of every pixel and label: its own with what is carried from above and below, averaged over its support.

    ``W = V + (above_share * t >> 3) + (below_share * low >> 3)``, ``A = (rec * sum of W over the support >> 10) + (t >> 3)``; floors.

    Parameters
    ----------
    own : (H, W, D) int16 ndarray
        ``V``, of :func:`golden.matcher.recursive.line_below.line_below`.
    left : (H, W) integer ndarray
        Grey levels.

    Returns
    -------
    (H, W, D) int16 ndarray
        At most :attr:`golden.config.Recursive.data_max`.
    """
    propagation, shift = method.propagation, method.propagation.SHARE_BITS
    left = np.asarray(left)
    left_arm, right_arm = graded_arms(left, method.arms)
    result = np.empty(own.shape, dtype=np.int16)
    for y, line in enumerate(own):
        joined = line
        above = None
        if y > 0:
            above = from_above(spread(result[y - 1], propagation), left[y], left[y - 1], method)
            joined = joined + (propagation.above_share * above >> shift)
        if propagation.from_below and y + 1 < len(own):
            low = from_below(own[y + 1], left_arm[y + 1], right_arm[y + 1], left[y], left[y + 1], method)
            joined = joined + (propagation.below_share * low >> shift)
        result[y] = support_means(joined, left_arm[y], right_arm[y])
        if above is not None:
            result[y] += above >> shift
    return result


def stages(left, right, config: MatcherConfig) -> Stages:
    """Costs, labels, check and sub-pixel labels: all stages before the fill. Parameters as of :func:`match`."""
    method = config.method_as(Recursive)
    own = line_below(fused_cost(left, right, config), left, method.line_below)
    costs = recursion(own, left, method)
    labels = np.argmin(costs, axis=-1).astype(np.int32)
    from_right = right_view(costs, config)
    passed = check(labels, from_right, config) if method.refinement.check else np.ones(labels.shape, dtype=bool)
    found = sub_pixel_labels(costs, labels, passed) if method.refinement.sub_pixel else labels
    return Stages(costs, support_sizes(*graded_arms(left, method.arms)), from_right, passed, found)


def match(left, right, config: MatcherConfig) -> FusedMatch:
    """Disparities of a rectified pair by the method :class:`golden.config.Recursive`.

    Parameters
    ----------
    left, right : (H, W) integer ndarray
        Grey levels ``0..255``.
    """
    found = stages(left, right, config)
    refinement, scale = config.method_as(Recursive).refinement, config.method.disparity_scale
    filled = border_fill(found.found, found.passed, config.labels, scale) if refinement.fill else found.found
    result = weighted_median(filled, found.passed, left) if refinement.median else filled
    sure = confidence(result, filled, found.passed, found.support_size, scale)
    return FusedMatch(result + config.minimum * scale, found.passed, sure, scale)
