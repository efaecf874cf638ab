"""The fill of pixels that failed the check, with the slope of the surface at a line's left border."""

import numpy as np

from ..refine import fill


__all__ = ["BORDER_SPAN", "LEAST_SPAN", "border_fill", "border_fill_plain", "border_slope"]


#: Columns from a line's first passing pixel that its slope is measured over, at most and at least.
BORDER_SPAN = 32
LEAST_SPAN = 16

#: Fraction bits of a slope.
SLOPE_BITS = 10


def border_slope(labels, passed, scale=1):
    """The surface at the left border of a line: its first passing pixel ``x0`` and its slope there.

    ``x1`` is the last passing pixel within 32 columns of ``x0`` that is reached by steps of at most one label from passing pixel to passing
    pixel. The slope is ``s = (f(x0) - f(x1)) * (1024 // (x1 - x0))`` if that are at least 16 columns, else 0.

    Parameters
    ----------
    labels, passed : (W,) ndarray
        Of a line with at least one passing pixel.
    scale : int
        Units of a label.

    Returns
    -------
    x0, s : int
    """
    columns = np.flatnonzero(passed)
    first = last = int(columns[0])
    for column in columns[1:]:
        if column - first > BORDER_SPAN or abs(int(labels[column]) - int(labels[last])) > scale:
            break
        last = int(column)
    span = last - first
    return first, (int(labels[first]) - int(labels[last])) * ((1 << SLOPE_BITS) // span) if span >= LEAST_SPAN else 0


def border_fill(labels, passed, count, scale=1):
    """Labels where the check passed, and elsewhere those of :func:`golden.matcher.refine.fill`; left of a line's first passing pixel the
    surface goes on: ``clip(f(x0) + ((s (x0 - x) + 512) >> 10), 0, D - 1)``.

    Parameters
    ----------
    labels : (H, W) integer ndarray
        In units of ``1 / scale`` label.
    passed : (H, W) bool ndarray
    count : int
        Number of labels ``D``.
    scale : int

    Returns
    -------
    (H, W) ndarray
    """
    result = fill(labels, passed)
    for y in np.flatnonzero(passed.any(axis=1) & ~passed[:, 0]):
        first, slope = border_slope(labels[y], passed[y], scale)
        if slope:
            steps = first - np.arange(first)
            result[y, :first] = np.clip(int(labels[y, first]) + ((slope * steps + (1 << SLOPE_BITS - 1)) >> SLOPE_BITS),
                                        0, (count - 1) * scale)
    return result


def border_fill_plain(labels, passed, count, scale=1):
    """:func:`border_fill`, pixel by pixel: for reading, and to test the fast version against."""
    height, width = labels.shape
    result = labels.copy()
    for y in range(height):
        passing = [x for x in range(width) if passed[y, x]]
        if not passing:
            continue
        x0 = x1 = passing[0]
        for x in passing[1:]:
            if x - x0 > 32 or abs(int(labels[y, x]) - int(labels[y, x1])) > scale:
                break
            x1 = x
        s = (int(labels[y, x0]) - int(labels[y, x1])) * (1024 // (x1 - x0)) if x1 - x0 >= 16 else 0
        for x in range(width):
            if passed[y, x]:
                continue
            if x < x0:
                value = int(labels[y, x0]) + ((s * (x0 - x) + 512) >> 10)
                result[y, x] = min(max(value, 0), (count - 1) * scale)
            else:
                before, after = [n for n in passing if n < x], [n for n in passing if n > x]
                result[y, x] = min(labels[y, side] for side in (*before[-1:], *after[:1]))
    return result
