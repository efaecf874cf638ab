"""Lines that a rectifier must hold: row bounds of a map, and whether gateware can run it."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from .maps import CELL, CELL_BITS, RectifyMap, grid
from .rectify import sources


__all__ = ["DEFAULT_LINES", "LINES", "check_lines", "check_rows", "first_rows", "lines_needed", "row_bounds"]


#: Lines that a rectifier may be built with.
LINES = (22, 34, 44, 56, 68)
DEFAULT_LINES = 34

Rows = NDArray[np.int64]


def first_rows(bounds: Rows, height: int) -> Rows:
    """The first row of the camera's picture that any line from ``y`` on reads, as the row bounds tell it: ``F``.

    ``F(y) = y + ((B[j] << 5) + (B[j + 1] - B[j]) fy >> 5)`` with ``j = y >> 5`` and ``fy = y & 31``.

    Returns
    -------
    (H,) int64 ndarray
        Rows; may be outside the picture.
    """
    y = np.arange(height)
    j, fraction = y >> CELL_BITS, y & (CELL - 1)
    result: Rows = y + (((bounds[j] << CELL_BITS) + (bounds[j + 1] - bounds[j]) * fraction) >> CELL_BITS)
    return result


def _read_rows(which: RectifyMap) -> tuple[Rows, Rows]:
    """Of every line the first row that it or a later one reads, and the last row that it reads."""
    _, sy = sources(which)
    upper = sy >> CELL_BITS
    first = np.minimum.accumulate(upper.min(axis=1)[::-1])[::-1]
    return first, np.minimum(upper.max(axis=1) + 1, which.height - 1)


def row_bounds(which: RectifyMap) -> Rows:
    """The row bounds of a map from its displacements, as great as they can be one by one; those that it has are not read."""
    first, _ = _read_rows(which)
    rows, _ = grid(which.width, which.height)
    room = first - np.arange(which.height)
    # Cell by cell the least room holds at both ends.
    cells = [int(room[j * CELL:(j + 1) * CELL].min()) for j in range(rows - 1)]
    bounds = np.array([min(cells[max(j - 1, 0):j + 1]) for j in range(rows)])
    # Then as much more at each control point as both cells beside it, and F, which must not fall, allow.
    for step in (16, 8, 4, 2, 1):
        for j in range(rows):
            while True:
                bounds[j] += step
                rising = first_rows(bounds, which.height)
                if bounds[j] > which.height or (rising > first).any() or (np.diff(rising) < 0).any():
                    bounds[j] -= step
                    break
    return bounds


def check_rows(which: RectifyMap) -> None:
    """:class:`ValueError` unless the row bounds of a map keep every row until the last line that reads it."""
    rows = first_rows(which.bounds, which.height)
    falls = np.flatnonzero(np.diff(rows) < 0)
    if falls.size:
        y = int(falls[0])
        raise ValueError(f"the row bounds of this map fall from {rows[y]} to {rows[y + 1]} after line {y}, and must never fall; "
                         "calibrate again")
    first, _ = _read_rows(which)
    late = np.flatnonzero(rows > first)
    if late.size:
        y = int(late[0])
        raise ValueError(f"the row bounds of this map free the rows before {rows[y]} at line {y}, but row {first[y]} is still to be read; "
                         "calibrate again")


def lines_needed(maps: Sequence[RectifyMap]) -> int:
    """Lines that each rectifier must hold for maps whose pictures arrive line by line together, those of both cameras as a rule.

    A row arrives in all of them at once, and only when the row that it replaces is free in all. A line is output only once the row below it
    has arrived, whatever it reads: until then it may be the last one.

    Examples
    --------
    >>> from .maps import identity
    >>> lines_needed([identity(720, 576)])
    2
    """
    height = maps[0].height
    below = np.minimum(np.arange(height) + 1, height - 1)
    last = np.max([below, *(_read_rows(which)[1] for which in maps)], axis=0)
    first = np.min([first_rows(which.bounds, height) for which in maps], axis=0)
    return int((last - first).max()) + 1


def check_lines(maps: Sequence[RectifyMap], lines: int) -> None:
    """:class:`ValueError` unless rectifiers that hold so many lines can run these maps together."""
    for which in maps:
        check_rows(which)
    needed = lines_needed(maps)
    if needed > lines:
        larger = next((each for each in LINES if each >= needed), None)
        remedy = f", or build with --rectify-lines {larger}" if larger else f"; gateware can be built with {LINES[-1]} at most"
        raise ValueError(f"this map needs {needed} lines and the gateware holds {lines}: level the cameras{remedy}")
