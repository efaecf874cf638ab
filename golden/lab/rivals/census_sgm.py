"""Semi-global matching of a census over eight paths (Hirschmüller, PAMI 30, 2008), plain: a strong rival that needs no library."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...config import FUSED_1, MatcherConfig
from ...matcher.census import census, hamming
from ...matcher.refine import check, fill, median, right_view


__all__ = ["costs", "disparities", "path_sums", "penalties"]


# Of a grid, the values with the fewest bad pixels on fourteen sets of Middlebury 2005 and 2006; the four pairs and other sets were not
# looked at. A penalty P2 that does not fall with the grey difference has 13.60 there at best, this one 12.37.
P1 = 16             # for a step of one label
P2_SUM = 640        # P2, for any other step, is P2_SUM // (P2_OFFSET + dI), ...
P2_OFFSET = 8
P2_LEAST = 16       # ... but at least this
COST_OUTSIDE = 8    # of a candidate outside the picture
MEDIAN = 3          # side of the window, pixels

Costs = NDArray[np.uint16]


def costs(left: NDArray[Any], right: NDArray[Any], labels: int) -> Costs:
    """Hamming distances of the censuses of 5x7 pixels, 0 .. 34: (H, W, D); :data:`COST_OUTSIDE` where ``d > x``."""
    height, width = left.shape
    here, there = census(left), census(right)
    result = np.full((height, width, labels), COST_OUTSIDE, dtype=np.uint16)
    for d in range(min(labels, width)):
        result[:, d:, d] = hamming(here[:, d:], there[:, :width - d])
    return result


def penalties(grey: NDArray[Any], before: NDArray[Any]) -> Costs:
    """P2 of a step of the path from the pixels ``before`` to the pixels ``grey``, grey levels."""
    change = np.abs(grey.astype(np.int32) - before.astype(np.int32))
    return np.maximum(P2_SUM // (P2_OFFSET + change), P2_LEAST).astype(np.uint16)


def path_sums(cost: Costs, grey: NDArray[Any]) -> Costs:
    """Sum over the eight paths of the costs of each pixel and label.

    Along a path ``L(p, d) = C(p, d) + min(L(q, d), L(q, d - 1) + P1, L(q, d + 1) + P1, min L(q) + P2) - min L(q)``, with ``q`` the pixel
    before ``p``; ``L = C`` where the path enters the picture.

    Parameters
    ----------
    cost : (H, W, D) uint16 ndarray
    grey : (H, W) integer ndarray
        The left picture, grey levels, for :func:`penalties`.

    Returns
    -------
    (H, W, D) uint16 ndarray
    """
    total = np.zeros_like(cost)
    for turn in (1, -1):
        _add_columns(cost[:, ::turn], grey[:, ::turn], total[:, ::turn])
        for shift in (-1, 0, 1):
            _add_lines(cost[::turn], grey[::turn], total[::turn], shift)
    return total


def _add_columns(cost: Costs, grey: NDArray[Any], total: Costs) -> None:
    """Add the path along the lines, from the first column to the last."""
    before = cost[:, 0]
    total[:, 0] += before
    for x in range(1, cost.shape[1]):
        before = _step(cost[:, x], before, penalties(grey[:, x], grey[:, x - 1]))
        total[:, x] += before


def _add_lines(cost: Costs, grey: NDArray[Any], total: Costs, shift: int) -> None:
    """Add the path from line to line that moves by ``shift`` columns a line."""
    before = cost[0]
    total[0] += before
    width = cost.shape[1]
    to, since = (slice(max(0, way), width + min(0, way)) for way in (shift, -shift))
    for y in range(1, cost.shape[0]):
        here = cost[y].copy()
        here[to] = _step(cost[y, to], before[since], penalties(grey[y, to], grey[y - 1, since]))
        total[y] += here
        before = here


def _step(cost: Costs, before: Costs, p2: Costs) -> Costs:
    """Costs of a path at some pixels (N, D), from those at the pixels before them and P2 (N)."""
    least = before.min(axis=-1, keepdims=True)
    best = np.minimum(before, least + p2[:, None])
    np.minimum(best[:, 1:], before[:, :-1] + P1, out=best[:, 1:])
    np.minimum(best[:, :-1], before[:, 1:] + P1, out=best[:, :-1])
    best -= least
    best += cost
    return best


def disparities(left: NDArray[Any], right: NDArray[Any], labels: int) -> NDArray[np.int32]:
    """Disparities of least :func:`path_sums`, checked, filled and smoothed by a median of 3x3 as ours are (:mod:`golden.matcher.refine`).

    Parameters
    ----------
    left, right : (H, W) integer ndarray
        Grey levels ``0..255``.
    labels : int
        Number of disparities ``D``.

    Returns
    -------
    (H, W) int32 ndarray
        Pixels.
    """
    total = path_sums(costs(left, right, labels), left)
    config = MatcherConfig(labels, method=FUSED_1)  # the check reads its tolerance, a label
    found = np.argmin(total, axis=-1).astype(np.int32)
    result: NDArray[np.int32] = median(fill(found, check(found, right_view(total, config), config)), MEDIAN)
    return result
