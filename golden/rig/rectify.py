"""Rectification of a camera's picture by a map: fast, and plainly, pixel by pixel."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..config import PIXEL_MAX
from .maps import CELL, CELL_BITS, SUB_PIXEL, RectifyMap, displacement


__all__ = ["ROW_OFFSETS", "move_rows", "rectify", "rectify_plain", "sources"]


#: Lines by which the reader may move one camera's picture.
ROW_OFFSETS = range(-128, 128)


def sources(which: RectifyMap) -> tuple[NDArray[np.int64], NDArray[np.int64]]:
    """From where every pixel is taken: ``x`` and ``y``, (H, W) each, 1/32 pixel, limited to the picture, whose edge is replicated."""
    dx, dy, _ = displacement(which)
    x, y = np.arange(which.width), np.arange(which.height)[:, None]
    return np.clip(SUB_PIXEL * x + dx, 0, SUB_PIXEL * (which.width - 1)), np.clip(SUB_PIXEL * y + dy, 0, SUB_PIXEL * (which.height - 1))


def _checked(picture: Any, which: RectifyMap) -> NDArray[np.int64]:
    picture = np.asarray(picture)
    if picture.shape != (which.height, which.width):
        raise ValueError(f"the map is for pictures of {which.width}x{which.height} pixels, not {'x'.join(map(str, picture.shape[::-1]))}; "
                         "give one of that size, or calibrate at this one")
    return picture.astype(np.int64)


def rectify(picture, which: RectifyMap) -> NDArray[np.uint8]:  # type: ignore[no-untyped-def]
    """The picture that a rectifier gives: bilinear, between grey levels and between control points, times the gain.

    Parameters
    ----------
    picture : (H, W) integer ndarray
        Grey levels ``0..255``.
    which : RectifyMap
        For pictures of this size; :class:`ValueError` otherwise.

    Returns
    -------
    (H, W) uint8 ndarray
        Rounded half up, and limited to 255.
    """
    levels = _checked(picture, which)
    sx, sy = sources(which)
    x, wx = sx >> CELL_BITS, sx & (SUB_PIXEL - 1)
    y, wy = sy >> CELL_BITS, sy & (SUB_PIXEL - 1)
    beside, below = np.minimum(x + 1, which.width - 1), np.minimum(y + 1, which.height - 1)     # with weight 0 where it is beyond the edge

    def along(row: NDArray[np.int64]) -> NDArray[np.int64]:
        first = levels[row, x]
        result: NDArray[np.int64] = (first << CELL_BITS) + (levels[row, beside] - first) * wx
        return result

    upper, lower = along(y), along(below)
    level = ((upper << CELL_BITS) + (lower - upper) * wy + 512) >> 10
    gain = displacement(which)[2]
    return np.minimum(PIXEL_MAX, (level * gain + 256) >> 9).astype(np.uint8)


def _at(points: NDArray[np.int64], x: int, y: int) -> int:
    """The bilinear value of control points at a pixel, times 1024."""
    i, j, fx, fy = x >> CELL_BITS, y >> CELL_BITS, x & (CELL - 1), y & (CELL - 1)
    left, right = ((int(points[j, k]) << 5) + (int(points[j + 1, k]) - int(points[j, k])) * fy for k in (i, i + 1))
    return (left << 5) + (right - left) * fx


def rectify_plain(picture, which: RectifyMap) -> NDArray[np.uint8]:  # type: ignore[no-untyped-def]
    """:func:`rectify` by the formulas of one pixel, for tests and as a definition."""
    levels = _checked(picture, which)
    width, height = which.width, which.height
    result = np.empty((height, width), dtype=np.uint8)
    for y in range(height):
        for x in range(width):
            sx = min(max(32 * x + ((_at(which.dx, x, y) + 512) >> 10), 0), 32 * (width - 1))
            sy = min(max(32 * y + ((_at(which.dy, x, y) + 512) >> 10), 0), 32 * (height - 1))
            x0, wx, y0, wy = sx >> 5, sx & 31, sy >> 5, sy & 31
            x1, y1 = min(x0 + 1, width - 1), min(y0 + 1, height - 1)
            h0, h1 = ((int(levels[row, x0]) << 5) + (int(levels[row, x1]) - int(levels[row, x0])) * wx for row in (y0, y1))
            level = ((h0 << 5) + (h1 - h0) * wy + 512) >> 10
            gain = (_at(which.gain, x, y) + 128) >> 8
            result[y, x] = min(255, (level * gain + 256) >> 9)
    return result


def move_rows(picture, row_offset: int):  # type: ignore[no-untyped-def]
    """A picture as the reader gives it with ``row_offset``: its line ``y`` is line ``y + row_offset`` of the camera's.

    The first and last lines of the camera's picture are repeated beyond it. :class:`ValueError` unless the offset is one of
    :data:`ROW_OFFSETS`.

    Examples
    --------
    >>> move_rows(np.array([[1], [2], [3]]), 2).ravel().tolist(), move_rows(np.array([[1], [2], [3]]), -1).ravel().tolist()
    ([3, 3, 3], [1, 1, 2])
    """
    if row_offset not in ROW_OFFSETS:
        raise ValueError(f"row_offset must be a whole number from {ROW_OFFSETS[0]} to {ROW_OFFSETS[-1]}, not {row_offset!r}")
    height = len(picture)
    return np.asarray(picture)[np.clip(np.arange(height) + row_offset, 0, height - 1)]
