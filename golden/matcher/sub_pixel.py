"""Sub-pixel disparity: where between two labels the support sums would be least."""

from fractions import Fraction

import numpy as np


__all__ = ["FRACTION_BITS", "SUB_PIXEL_SCALE", "fraction", "fraction_plain", "neighbouring_sums", "sub_pixel_labels"]


# Unsigned, three fraction bits. With them a label lies within 1/2 .. D - 3/2: the whole bits are those of a label.
FRACTION_BITS = 3
SUB_PIXEL_SCALE = 1 << FRACTION_BITS


def neighbouring_sums(sums, labels):
    """Support sums of the label before, of the label itself and of the label after; at the ends the label repeats itself.

    Parameters
    ----------
    sums : (H, W, D) integer ndarray
        Of :func:`golden.matcher.support.support_sums`.
    labels : (H, W) integer ndarray

    Returns
    -------
    before, centre, after : (H, W) ndarray
    """
    near = np.clip(labels[..., None] + np.arange(-1, 2), 0, sums.shape[-1] - 1)
    return tuple(np.moveaxis(np.take_along_axis(sums, near, axis=-1), -1, 0))


def fraction(before, centre, after):
    """Equiangular interpolation: eighths of a pixel from a label to the least of two lines of equal and opposite slope through its sums.

    The lines meet ``|before - after| / (2 * m)`` pixels from the label, ``m = max(before, after) - centre``, on the side of the smaller
    sum. Rounded half away from the label and held within half a pixel, this is the number of ``j = 1 .. 4`` with
    ``8 * |before - after| >= (2 * j - 1) * m``: four comparisons with ``m, 3m, 5m, 7m`` and no division. Where ``m`` is not positive
    (the rule may hold a pixel on the summit of its sums) the result is 0.

    Parameters
    ----------
    before, centre, after : (...) integer ndarray
        Support sums, of :func:`neighbouring_sums`.

    Returns
    -------
    (...) int32 ndarray
        Eighths of a pixel, ``-4 .. 4``.

    Examples
    --------
    >>> fraction(np.array([9, 20, 7, 30]), np.array([1, 4, 1, 8]), np.array([9, 12, 9, 8])).tolist()
    [0, 2, -1, 4]
    """
    before, centre, after = (np.asarray(part, dtype=np.int32) for part in (before, centre, after))
    m = np.maximum(before, after) - centre
    apart = 8 * np.abs(before - after)
    steps = sum((apart >= odd * m).astype(np.int32) for odd in (1, 3, 5, 7))
    return np.where(m > 0, np.where(before < after, -steps, steps), 0)


def sub_pixel_labels(sums, labels, passed):
    """Labels with three fraction bits; a whole number at the first and at the last label, and where the check failed.

    Parameters
    ----------
    sums : (H, W, D) integer ndarray
    labels : (H, W) integer ndarray
        Of the rule, before the fill.
    passed : (H, W) bool ndarray
        Of :func:`golden.matcher.refine.check`.

    Returns
    -------
    (H, W) int32 ndarray
        Eighths of a pixel.
    """
    inside = passed & (labels > 0) & (labels < sums.shape[-1] - 1)
    return SUB_PIXEL_SCALE * labels + np.where(inside, fraction(*neighbouring_sums(sums, labels)), 0)


def fraction_plain(before, centre, after):
    """:func:`fraction` of one pixel by division, exact: for reading, and to test the comparisons against."""
    m = max(before, after) - centre
    if m <= 0:
        return 0
    offset = min(Fraction(abs(before - after), 2 * m), Fraction(1, 2))
    steps = int(SUB_PIXEL_SCALE * offset + Fraction(1, 2))
    return -steps if before < after else steps
