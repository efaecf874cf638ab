"""Refinement of labels: right view, left-right check, fill, median. Each is independent of the others."""

import numpy as np
from numpy.lib.stride_tricks import as_strided, sliding_window_view

from ..config import MatcherConfig


__all__ = ["check", "check_plain", "fill", "fill_plain", "median", "median_plain", "right_view", "right_view_plain"]


def right_view(cost, config: MatcherConfig):
    """Labels of the right picture: ``r(x_r)`` is the ``d`` of least ``V(x_r + minimum + d, y, d)`` over the columns that exist.

    The smaller label on a tie; 0 where no column exists. With a negative least disparity the right picture is wider by ``config.lead``
    columns, as :func:`golden.matcher.cost.aligned` continues it.

    Parameters
    ----------
    cost : (H, W, D) uint8, or 16-bit ndarray of numbers below 32,767
        Fused cost ``V``, of :func:`golden.matcher.vertical.vertical_support`; without vertical support ``C`` itself.

    Returns
    -------
    (H, W + lead) int32 ndarray
        Labels ``0 .. D-1``.

    Examples
    --------
    >>> right_view(np.array([[[5, 9], [4, 4], [7, 6]]], dtype=np.uint8), MatcherConfig(labels=2)).tolist()
    [[1, 0, 0]]
    """
    height, width, labels = cost.shape
    lead, columns = config.lead, width + config.lead
    result = np.empty((height, columns), dtype=np.int32)
    # Columns that do not exist never win: those to the right have the greatest labels of their diagonal, so they lose a tie at 255; those
    # to the left would not, and so need a greater number than any cost.
    bytes_do = cost.dtype == np.uint8 and not lead
    line = np.full((columns + max(config.minimum, 0) + labels, labels), *((255, np.uint8) if bytes_do else (2**15 - 1, np.int16)))
    diagonals = as_strided(
        line[max(config.minimum, 0):], (columns, labels), (line.strides[0], line.strides[0] + line.strides[1]), writeable=False)
    for y in range(height):
        line[lead:columns] = cost[y]
        result[y] = np.argmin(diagonals, axis=-1)
    return result


def check(labels, right, config: MatcherConfig):
    """Left-right check: a pixel passes if its match lies in the picture and the right view there is within ``tolerance`` of its label.

    Parameters
    ----------
    labels : (H, W) integer ndarray
        Of the left picture.
    right : (H, W + lead) integer ndarray
        Of the right picture, of :func:`right_view`.

    Returns
    -------
    (H, W) bool ndarray
    """
    tolerance = config.refined.refinement.tolerance
    matched = np.arange(labels.shape[1]) - labels - config.minimum
    seen = np.take_along_axis(right, np.maximum(matched, 0), axis=1)
    return (matched >= 0) & (np.abs(seen - labels) <= tolerance)


def fill(labels, passed):
    """Labels where the check passed, and elsewhere the smaller of the nearest passing labels to the left and to the right on the line.

    The one that exists if only one does; on a line without any, labels are kept.

    Parameters
    ----------
    labels : (H, W) integer ndarray
    passed : (H, W) bool ndarray

    Returns
    -------
    (H, W) ndarray

    Examples
    --------
    >>> fill(np.array([[9, 4, 8, 8, 3, 7]]), np.array([[0, 1, 0, 0, 1, 0]], dtype=bool)).tolist()
    [[4, 4, 3, 3, 3, 3]]
    """
    width = labels.shape[1]
    column = np.arange(width)
    before = np.maximum.accumulate(np.where(passed, column, -1), axis=1)
    after = np.minimum.accumulate(np.where(passed, column, width)[:, ::-1], axis=1)[:, ::-1]
    nothing = np.iinfo(labels.dtype).max
    from_left = np.where(before >= 0, np.take_along_axis(labels, np.maximum(before, 0), axis=1), nothing)
    from_right = np.where(after < width, np.take_along_axis(labels, np.minimum(after, width - 1), axis=1), nothing)
    return np.where(passed.any(axis=1, keepdims=True), np.minimum(from_left, from_right), labels)


def median(labels, size):
    """Median of the window of ``size`` x ``size`` around every pixel, with edge replication.

    Parameters
    ----------
    labels : (H, W) integer ndarray
    size : int
        Odd, pixels.

    Returns
    -------
    (H, W) ndarray

    Examples
    --------
    >>> median(np.array([[1, 1, 9], [1, 9, 9], [1, 1, 1]]), 3).tolist()
    [[1, 1, 9], [1, 1, 9], [1, 1, 1]]
    """
    windows = sliding_window_view(np.pad(labels, size // 2, mode="edge"), (size, size)).reshape(*labels.shape, size * size)
    return np.partition(windows, size * size // 2, axis=-1)[..., size * size // 2]


def right_view_plain(cost, config: MatcherConfig):
    """:func:`right_view`, pixel by pixel: for reading, and to test the fast version against."""
    height, width, labels = cost.shape
    result = np.zeros((height, width + config.lead), dtype=np.int32)
    for y in range(height):
        for x in range(width + config.lead):
            candidates = [(int(cost[y, x + config.minimum + d, d]), d) for d in range(labels) if 0 <= x + config.minimum + d < width]
            if candidates:
                result[y, x] = min(candidates)[1]
    return result


def check_plain(labels, right, config: MatcherConfig):
    """:func:`check`, pixel by pixel."""
    height, width = labels.shape
    tolerance = config.refined.refinement.tolerance
    result = np.zeros((height, width), dtype=bool)
    for y in range(height):
        for x in range(width):
            matched = x - int(labels[y, x]) - config.minimum
            result[y, x] = matched >= 0 and abs(int(right[y, matched]) - int(labels[y, x])) <= tolerance
    return result


def fill_plain(labels, passed):
    """:func:`fill`, pixel by pixel."""
    result = labels.copy()
    for y, x in np.argwhere(~passed):
        before, after = np.flatnonzero(passed[y, :x]), x + np.flatnonzero(passed[y, x:])
        nearest = [labels[y, side] for side in (*before[-1:], *after[:1])]
        result[y, x] = min(nearest, default=labels[y, x])
    return result


def median_plain(labels, size):
    """:func:`median`, pixel by pixel."""
    height, width = labels.shape
    steps = range(-(size // 2), size // 2 + 1)
    return np.array([[
        sorted(labels[min(max(y + dy, 0), height - 1), min(max(x + dx, 0), width - 1)] for dy in steps for dx in steps)[size * size // 2]
        for x in range(width)] for y in range(height)])
