"""Dynamic programming on every scanline: row *Dynamic Programming* of the thesis's Table 1."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...matcher.refine import fill
from .differences import absolute_differences, outside_candidates


__all__ = ["OCCLUSION", "disparities", "paths"]


# Grey levels for an occluded pixel; of 5, 10, 14, 20 and 30 the one with the fewest bad pixels on the four pairs.
OCCLUSION = 14


def paths(cost: NDArray[Any], occlusion: int) -> tuple[NDArray[np.int64], NDArray[np.bool_]]:
    """Cheapest path of every scanline through matches and occlusions.

    A path visits the columns from left to right; each starts with a move:

    - to a match: the pixel costs ``cost(x, d)`` and the disparity stays;
    - over an occluded pixel of the left picture: it costs ``occlusion`` and the disparity grows by one;
    - over an occluded pixel of the right picture: that costs ``occlusion``, the disparity falls by one and the column stays.

    A candidate whose right pixel is outside the picture is occluded without a change of the disparity. A path starts and ends at any
    disparity. The ordering constraint holds, so a thin near object is lost. On a tie a match is preferred to an occlusion, and the
    smaller disparity is kept.

    Parameters
    ----------
    cost : (H, W, D) integer ndarray
    occlusion : int

    Returns
    -------
    labels : (H, W) int64 ndarray
        Where matched, the disparity.
    matched : (H, W) bool ndarray
    """
    height, width, labels = cost.shape
    label = np.arange(labels)
    outside = outside_candidates(width, labels)
    # For every pixel and disparity at which a path may leave the column: the one at which it entered, and whether it matched there.
    entered = np.empty(cost.shape, dtype=np.int16)
    matches = np.empty(cost.shape, dtype=bool)
    total: NDArray[Any] = np.zeros((height, labels), dtype=np.int64)
    far = np.iinfo(np.int64).max // 2
    for x in range(width):
        match = total + np.where(outside[x], occlusion, cost[:, x])
        grown = np.full_like(total, far)
        grown[:, 1:] = total[:, :-1] + occlusion
        matches[:, x] = match <= grown
        best = np.minimum(match, grown)
        # Right pixels may be skipped after that: the least of best(e) + occlusion * (e - d) over e >= d, as a running minimum.
        ramp = occlusion * label
        down = (best + ramp)[:, ::-1]
        least = np.minimum.accumulate(down, axis=1)
        # Where the minimum was set last; the first of equals is the greater disparity, the last the smaller.
        set_at = np.maximum.accumulate(np.where(down == least, label, 0), axis=1)
        entered[:, x] = labels - 1 - set_at[:, ::-1]
        total = least[:, ::-1] - ramp

    result = np.empty((height, width), dtype=np.int64)
    matched = np.empty((height, width), dtype=bool)
    line = np.arange(height)
    at = np.argmin(total, axis=1)
    for x in range(width - 1, -1, -1):
        at = entered[line, x, at].astype(np.int64)
        result[:, x] = at
        here = matches[line, x, at]
        matched[:, x] = here & ~outside[x, at]
        at = at - ~here
    return result, matched


def disparities(left: NDArray[Any], right: NDArray[Any], labels: int, occlusion: int = OCCLUSION) -> NDArray[np.int64]:
    """Disparities by dynamic programming on every scanline (Cox et al., CVIU 63, 1996; Bobick and Intille, IJCV 33, 1999).

    The cost of a match is the absolute difference of grey levels. Occluded pixels are filled as ours are, by
    :func:`golden.matcher.refine.fill`.

    Parameters
    ----------
    left, right : (H, W) integer ndarray
        Grey levels ``0..255``.
    labels : int
        Number of disparities ``D``.
    occlusion : int
        Grey levels.

    Returns
    -------
    (H, W) int64 ndarray
        Pixels.
    """
    return fill(*paths(absolute_differences(left, right, labels), occlusion))
