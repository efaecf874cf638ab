"""Vertical support: the cost of a pixel joined with those of the pixels above and below."""

import numpy as np

from ..config import FUSED_1, Vertical


__all__ = ["alike", "vertical_support", "vertical_support_plain"]


def alike(left, vertical: Vertical = FUSED_1.vertical):
    """Whether the pixel above, and the one below, is in the picture and differs by at most ``vertical.vertical_threshold``.

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
    near = np.abs(np.diff(np.asarray(left, dtype=np.int16), axis=0)) <= vertical.vertical_threshold
    edge = np.zeros((1, near.shape[1]), dtype=bool)
    return np.concatenate([edge, near]), np.concatenate([near, edge])


def vertical_support(cost, left, vertical: Vertical = FUSED_1.vertical):
    """Costs joined with those of the lines above and below: ``V = C_above + 2*C + C_below``.

    A neighbour that is not :func:`alike` is replaced by the pixel itself: every ``V`` is made of four shares. ``cost`` itself if
    ``vertical.vertical_lines`` is 0.

    Parameters
    ----------
    cost : (H, W, D) uint8 ndarray
        Of :func:`golden.matcher.support.fused_cost`.
    left : (H, W) integer ndarray
        Grey levels.

    Returns
    -------
    (H, W, D) uint8 ndarray
        At most :attr:`golden.config.Fused.joined_max`.

    Examples
    --------
    >>> one_line = Vertical(vertical_lines=1)
    >>> vertical_support(np.array([[[9]], [[5]], [[2]]], dtype=np.uint8), np.array([[10], [20], [31]]), one_line).ravel().tolist()
    [32, 24, 8]
    """
    if not vertical.vertical_lines:
        return cost
    above, below = alike(left, vertical)
    result = np.empty_like(cost)
    for y in range(len(cost)):
        centre = cost[y]
        up = np.where(above[y, :, None], cost[max(y - 1, 0)], centre)
        down = np.where(below[y, :, None], cost[min(y + 1, len(cost) - 1)], centre)
        result[y] = up + 2 * centre + down  # exact: joined_max is within 8 bits
    return result


def vertical_support_plain(cost, left, vertical: Vertical = FUSED_1.vertical):
    """:func:`vertical_support`, pixel by pixel: for reading, and to test the fast version against."""
    height, width, labels = cost.shape
    grey, costs = np.asarray(left).tolist(), cost.tolist()

    def joined(x, y, d):
        centre = costs[y][x][d]
        if not vertical.vertical_lines:
            return centre
        total = 2 * centre
        for other in (y - 1, y + 1):
            like = 0 <= other < height and abs(grey[other][x] - grey[y][x]) <= vertical.vertical_threshold
            total += costs[other][x][d] if like else centre
        return total

    return np.array([[[joined(x, y, d) for d in range(labels)] for x in range(width)] for y in range(height)], dtype=np.uint8)
