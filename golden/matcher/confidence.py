"""Confidence of a disparity: four bits, by the votes of its neighbourhood."""

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from ..config import CONFIDENCE_BITS


__all__ = ["CONFIDENCE_MAX", "WINDOW", "confidence", "confidence_plain"]


CONFIDENCE_MAX = 2**CONFIDENCE_BITS - 1

WINDOW = 5  # pixels; the window of the default median: gateware has its labels anyway


def confidence(disparity, filled, passed, support_size, scale=1):
    """Confidence ``(a + p + 2 * g) >> 2``, floor, at most 15: how clearly the neighbourhood voted for the disparity.

    ``a``: pixels of the 5x5 window, the pixel among them, whose label before the median is within one pixel of the disparity; ``p``:
    those of them that passed the check; ``g``: bit length of ``support_size``, for a wide support averages noise away. The edges of the
    picture are replicated.

    Parameters
    ----------
    disparity : (H, W) integer ndarray
        Result of the last stage.
    filled : (H, W) integer ndarray
        Input of the median, in the same units.
    passed : (H, W) bool ndarray
        Of :func:`golden.matcher.refine.check`.
    support_size : (H, W) integer ndarray
        Pixels, ``1..63``, of :func:`golden.matcher.support.support_sizes`.
    scale : int
        Units of the disparity per pixel.

    Returns
    -------
    (H, W) uint8 ndarray
        ``0..15``.
    """
    margin = WINDOW // 2
    labels, votes = (sliding_window_view(np.pad(part, margin, mode="edge"), (WINDOW, WINDOW)) for part in (filled, passed))
    agree = np.abs(labels - np.asarray(disparity)[..., None, None]) <= scale
    a, p = agree.sum(axis=(-2, -1)), (agree & votes).sum(axis=(-2, -1))
    g = np.frexp(np.asarray(support_size, dtype=np.float64))[1]  # exact: the exponent of a whole number is its bit length
    return ((a + p + 2 * g) >> 2).astype(np.uint8)


def confidence_plain(disparity, filled, passed, support_size, scale=1):
    """:func:`confidence`, pixel by pixel: for reading, and to test the fast version against."""
    height, width = np.shape(disparity)
    result = np.zeros((height, width), dtype=np.uint8)
    steps = range(-(WINDOW // 2), WINDOW // 2 + 1)
    for y in range(height):
        for x in range(width):
            window = [(min(max(y + dy, 0), height - 1), min(max(x + dx, 0), width - 1)) for dy in steps for dx in steps]
            agree = [at for at in window if abs(int(filled[at]) - int(disparity[y, x])) <= scale]
            result[y, x] = (len(agree) + sum(bool(passed[at]) for at in agree) + 2 * int(support_size[y, x]).bit_length()) >> 2
    return result
