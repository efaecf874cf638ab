"""Costs from the line above and from the line below."""

import numpy as np

from ...config import RECURSIVE_1, Recursive
from .arms import support_means, support_means_plain
from .spread import gates, spread, spread_plain


__all__ = ["from_above", "from_above_plain", "from_below", "from_below_plain"]


def from_above(carried, line, above, parameters: Recursive = RECURSIVE_1):
    """Costs from above, ``t = (2 min(Q(x), g) + min(Q(x - fan), g') + min(Q(x + fan), g'')) >> 2``, floor.

    ``Q`` of the line above; its columns are clamped to the picture. Each gate is that of the pixel's difference to the pixel above at the
    column of its ``Q``.

    Parameters
    ----------
    carried : (W, D) integer ndarray
        ``Q``, of :func:`golden.matcher.recursive.spread.spread`.
    line, above : (W,) integer ndarray
        Grey levels of the line and of the one above.

    Returns
    -------
    (W, D) integer ndarray
        ``0 .. spread_jump``.
    """
    width, fan = len(carried), parameters.propagation.fan
    result = np.zeros_like(carried)
    for offset, count in ((0, 2), (-fan, 1), (fan, 1)):
        column = np.clip(np.arange(width) + offset, 0, width - 1)
        part = np.minimum(carried[column], gates(line, np.asarray(above)[column], parameters.propagation)[:, None].astype(carried.dtype))
        part *= count
        result += part
    return result >> 2


def from_below(cost, left_arm, right_arm, line, below, parameters: Recursive = RECURSIVE_1):
    """Costs from below, ``low = min(Q(mean of V over the support of the pixel below), g)``.

    Parameters
    ----------
    cost : (W, D) integer ndarray
        ``V`` of the line below, of :func:`golden.matcher.recursive.line_below.line_below`.
    left_arm, right_arm : (W,) integer ndarray
        Arms of the line below.
    line, below : (W,) integer ndarray
        Grey levels of the line and of the one below.

    Returns
    -------
    (W, D) integer ndarray
        ``0 .. spread_jump``.
    """
    carried = spread(support_means(cost, left_arm, right_arm), parameters.propagation)
    return np.minimum(carried, gates(line, below, parameters.propagation)[:, None])


def from_above_plain(carried, line, above, parameters: Recursive = RECURSIVE_1):
    """:func:`from_above`, pixel by pixel: for reading, and to test the fast version against."""
    width, labels = np.shape(carried)
    gate, fan = parameters.propagation.gate, parameters.propagation.fan
    result = np.zeros((width, labels), dtype=int)
    for x in range(width):
        columns = [x, x, max(x - fan, 0), min(x + fan, width - 1)]
        for d in range(labels):
            result[x, d] = sum(min(int(carried[c][d]), gate[abs(int(line[x]) - int(above[c]))]) for c in columns) >> 2
    return result


def from_below_plain(cost, left_arm, right_arm, line, below, parameters: Recursive = RECURSIVE_1):
    """:func:`from_below`, pixel by pixel."""
    means = support_means_plain(cost, left_arm, right_arm).tolist()
    gate = parameters.propagation.gate
    return np.array([[min(value, gate[abs(int(line[x]) - int(below[x]))]) for value in spread_plain(mean, parameters.propagation)]
                     for x, mean in enumerate(means)])
