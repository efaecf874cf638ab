"""Vertical support: costs of the pixels above and below join a pixel's own."""

import numpy as np

from ..config import FUSED_1, Vertical


__all__ = ["alike", "vertical_support", "vertical_support_plain"]


def alike(left, params: Vertical = FUSED_1.vertical):
    """Whether the pixel above, and the one below, is in the picture and differs by at most ``params.vertical_threshold``.

    Parameters
    ----------
    left : (H, W) integer ndarray
        Grey levels.

    Returns
    -------
    above, below : (H, W) bool ndarray

    Examples
    --------
    >>> [flags.ravel().tolist() for flags in alike(np.array([[10], [20], [31]]))]
    [[False, True, False], [True, False, False]]
    """
    near = np.abs(np.diff(np.asarray(left, dtype=np.int16), axis=0)) <= params.vertical_threshold
    edge = np.zeros((1, near.shape[1]), dtype=bool)
    return np.concatenate([edge, near]), np.concatenate([near, edge])


def vertical_support(cost, left, params: Vertical = FUSED_1.vertical):
    """Costs joined with those of the lines above and below: ``V = C_above + 2*C + C_below``.

    A neighbour that is not :func:`alike` is replaced by the pixel itself: every ``V`` is made of four shares. With
    ``params.vertical_lines`` 0 the costs as they are.

    Parameters
    ----------
    cost : (H, W, D) uint8 ndarray
        Of :func:`golden.matcher.support.fused_cost`.
    left : (H, W) integer ndarray
        Grey levels.

    Returns
    -------
    (H, W, D) uint8 ndarray
        At most ``joined_max`` of the method.

    Examples
    --------
    >>> params = Vertical(vertical_lines=1)
    >>> vertical_support(np.array([[[9]], [[5]], [[2]]], dtype=np.uint8), np.array([[10], [20], [31]]), params).ravel().tolist()
    [32, 24, 8]
    """
    if not params.vertical_lines:
        return cost
    above, below = alike(left, params)
    result = np.empty_like(cost)
    for y in range(len(cost)):
        own = cost[y]
        up = np.where(above[y, :, None], cost[max(y - 1, 0)], own)
        down = np.where(below[y, :, None], cost[min(y + 1, len(cost) - 1)], own)
        result[y] = up + 2 * own + down  # exact: joined_max is within 8 bits
    return result


def vertical_support_plain(cost, left, params: Vertical = FUSED_1.vertical):
    """:func:`vertical_support`, pixel by pixel: for reading, and to test the fast version against."""
    height, width, labels = cost.shape
    grey, costs = np.asarray(left).tolist(), cost.tolist()

    def joined(x, y, d):
        own = costs[y][x][d]
        if not params.vertical_lines:
            return own
        total = 2 * own
        for other in (y - 1, y + 1):
            like = 0 <= other < height and abs(grey[other][x] - grey[y][x]) <= params.vertical_threshold
            total += costs[other][x][d] if like else own
        return total

    return np.array([[[joined(x, y, d) for d in range(labels)] for x in range(width)] for y in range(height)], dtype=np.uint8)
