"""The costs of the line below in a pixel's own."""

import numpy as np

from ...config import RECURSIVE_1, LineBelow


__all__ = ["line_below", "line_below_plain"]


def line_below(cost, left, parameters: LineBelow = RECURSIVE_1.line_below):
    """Costs ``V = own_share * C(y) + lower_share * C(y + 1)``.

    The pixel's own cost takes the place of the lower one on the last line, and where the pixel below differs by more than
    ``lower_threshold`` grey levels.

    Parameters
    ----------
    cost : (H, W, D) uint8 ndarray
        Of :func:`golden.matcher.support.fused_cost`.
    left : (H, W) integer ndarray
        Grey levels.

    Returns
    -------
    (H, W, D) int16 ndarray
        At most :attr:`golden.config.Recursive.own_max`.

    Examples
    --------
    >>> line_below(np.array([[[2]], [[15]]], dtype=np.uint8), np.array([[9], [9]])).ravel().tolist()
    [70, 135]
    """
    left = np.asarray(left, dtype=np.int16)
    alike = np.abs(np.diff(left, axis=0)) <= parameters.lower_threshold
    result = cost * np.int16(parameters.own_share)
    lower = parameters.lower_share * cost.astype(np.int16)
    result[:-1] += np.where(alike[..., None], lower[1:], lower[:-1])
    result[-1] += lower[-1]
    return result


def line_below_plain(cost, left, parameters: LineBelow = RECURSIVE_1.line_below):
    """:func:`line_below`, pixel by pixel: for reading, and to test the fast version against."""
    height, width, labels = cost.shape
    result = np.zeros(cost.shape, dtype=np.int16)
    for y in range(height):
        for x in range(width):
            below = y + 1 if y + 1 < height and abs(int(left[y + 1, x]) - int(left[y, x])) <= parameters.lower_threshold else y
            for d in range(labels):
                result[y, x, d] = parameters.own_share * int(cost[y, x, d]) + parameters.lower_share * int(cost[below, x, d])
    return result
