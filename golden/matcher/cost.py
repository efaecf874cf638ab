"""Matching cost: sub-pixels (2-3 .. 2-6), differences and their sum (2-7 .. 2-12), local disparity."""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ..config import Arithmetic, MatcherConfig


__all__ = ["aligned", "cost_energy", "edata", "local_disparity", "matching_cost", "outside", "sub_pixel_buffers", "sub_pixels"]


def aligned(left, right, minimum, lead=None):
    """Both pictures with label 0 of a pixel at the same ``x``: the right one shifted to the right by the least disparity.

    Below 0 it would lose its first columns, which greater labels need. So both pictures are wider by ``lead`` columns: the left one is
    shifted to the right by them, the right one continued. Edges are replicated; the last ``minimum`` columns of the right picture, which
    no pixel matches, are lost if ``minimum`` is above 0.

    Parameters
    ----------
    left, right : (H, W) ndarray
        Grey levels.
    minimum : int
        Pixels.
    lead : int
        Columns, at least ``-minimum``; the least number by default.

    Returns
    -------
    left, right : (H, W + lead) ndarray

    Examples
    --------
    >>> [side.tolist() for side in aligned(np.array([[1, 2, 3, 4]]), np.array([[5, 6, 7, 8]]), 2)]
    [[[1, 2, 3, 4]], [[5, 5, 5, 6]]]
    >>> [side.tolist() for side in aligned(np.array([[1, 2, 3, 4]]), np.array([[5, 6, 7, 8]]), -2)]
    [[[1, 1, 1, 2, 3, 4]], [[5, 6, 7, 8, 8, 8]]]
    """
    left, right = np.asarray(left), np.asarray(right)
    lead = max(-minimum, 0) if lead is None else lead
    column = np.arange(right.shape[1] + lead) - lead
    return left[:, np.maximum(column, 0)], right[:, np.clip(column - minimum, 0, right.shape[1] - 1)]


def outside(width, config: MatcherConfig):
    """Which candidates have their right pixel outside the picture, those of a disparity greater than ``x``, or are not in use.

    Beyond its right edge, which negative disparities reach, the right picture is continued by replication: such candidates are inside.

    Returns
    -------
    (W, D) bool ndarray
    """
    label = np.arange(config.labels)
    return (label + config.minimum > np.arange(width)[:, None]) | (label >= config.labels_in_use)


def sub_pixels(picture, config: MatcherConfig):
    """A pixel with the sub-pixels above, below and to its left, equations (2-3) .. (2-5).

    ``LINEAR`` keeps the sums, hence doubles the pixel itself; ``THESIS`` halves with floor; ``FLOAT`` halves exactly.
    The edges of the picture are replicated. The sub-pixel to the right of ``x`` (2-6) is the one to the
    left of ``x+1``; column ``W`` of the result holds the last one.

    Parameters
    ----------
    picture : (H, W) integer ndarray
        Grey levels.

    Returns
    -------
    pixel, above, below, left : (H, W + 1) ndarray
        Grey levels (``LINEAR``: half grey levels); float64 for ``FLOAT``, else int16.

    Examples
    --------
    >>> [part.tolist() for part in sub_pixels(np.array([[3, 4], [6, 8]]), MatcherConfig(labels=2))]
    [[[3, 4, 4], [6, 8, 8]], [[3, 4, 4], [4, 6, 6]], [[4, 6, 6], [6, 8, 8]], [[3, 3, 4], [6, 7, 8]]]
    """
    exact = config.method.arithmetic is Arithmetic.FLOAT
    padded = np.pad(np.asarray(picture, dtype=np.float64 if exact else np.int16), ((1, 1), (1, 1)), mode="edge")
    centre, minus, plus, before = padded[1:-1, 1:], padded[:-2, 1:], padded[2:, 1:], padded[1:-1, :-1]
    sums = centre + centre, centre + minus, centre + plus, centre + before
    match config.method.arithmetic:
        case Arithmetic.FLOAT:
            return tuple(part * 0.5 for part in sums)
        case Arithmetic.THESIS:
            return tuple(part >> 1 for part in sums)
        case Arithmetic.LINEAR:
            return sums


def sub_pixel_buffers(line, labels):
    """The right picture's parts for every label: ``line(x - d)``; the first pixel where ``x - d`` is outside.

    Parameters
    ----------
    line : (W,) ndarray
        One line of one part of :func:`sub_pixels`.
    labels : int
        Number of labels ``D``.

    Returns
    -------
    (W, D) ndarray
        A read-only view.

    Examples
    --------
    >>> sub_pixel_buffers(np.array([5, 6, 7]), 2).tolist()
    [[5, 5], [6, 5], [7, 6]]
    """
    # A window on the reversed line is contiguous in d.
    return sliding_window_view(np.pad(line[::-1], (0, labels - 1), mode="edge"), labels)[::-1]


def cost_energy(left, right):
    """Differences of a pixel and of its sub-pixels, equations (2-7) .. (2-11).

    Parameters
    ----------
    left, right : sequences of ndarray
        Of :func:`sub_pixels`; shapes must broadcast.

    Returns
    -------
    list of ndarray
        Absolute differences, in the same order.
    """
    return [np.abs(l - r) for l, r in zip(left, right, strict=True)]


def edata(costs):
    """The sum (2-12) of a line of costs; ``cost(x+0.5)`` at ``x`` is ``cost(x-0.5)`` at ``x+1``.

    Parameters
    ----------
    costs : four (W + 1, D) ndarrays
        Of pixel, above, below and left, of :func:`cost_energy`.

    Returns
    -------
    (W, D) ndarray
    """
    pixel, above, below, left = costs
    return (pixel + above + below + left)[:-1] + left[1:]


def matching_cost(left, right, config: MatcherConfig):
    """Matching cost ``E(x, y, d)`` of every pixel and label, equation (2-12).

    Parameters
    ----------
    left, right : (H, W) integer ndarray
        Grey levels ``0..255``; ``left[y, x]`` matches ``right[y, x - d]``, where ``d`` is the label plus ``config.minimum``.

    Returns
    -------
    (H, W, D) ndarray
        Grey levels (``LINEAR``: half grey levels), at most ``inside_max`` of :class:`golden.config.MatchingCost`; its ``outside`` where
        ``d > x`` or ``d`` is not in use.
        int16, or float64 for ``FLOAT``.
    """
    height, width = np.shape(left)
    labels = config.labels
    left_parts, right_parts = (sub_pixels(side, config) for side in aligned(left, right, config.minimum))
    beyond = outside(width, config)
    cost = np.empty((height, width, labels), dtype=left_parts[0].dtype)
    for y in range(height):
        windows = [sub_pixel_buffers(part[y], labels) for part in right_parts]
        cost[y] = edata(cost_energy([part[y, :, None] for part in left_parts], windows))[config.lead:]
        cost[y][beyond] = config.matching_cost.outside
    return cost


def local_disparity(cost):
    """Local disparity ``b(x, y)``: the ``d`` of least cost, the smaller on a tie.

    Parameters
    ----------
    cost : (..., D) ndarray

    Returns
    -------
    (...) intp ndarray
        Pixels.
    """
    return np.argmin(cost, axis=-1)
