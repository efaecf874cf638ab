"""A left picture with its disparities to the right of it, on a monitor of a board that holds one pair."""

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from .display import Levels, colour_table, grey_level
from .formats import DisplayFormat


__all__ = ["Layout", "layout", "side_by_side"]


class Layout(NamedTuple):
    """Every ``step``-th pixel of every ``step``-th line is shown, in these ``columns`` and ``lines`` of the active area; left picture and
    disparities have a half of the columns each.
    """
    step: int
    columns: range
    lines: range

    @property
    def width(self) -> int:
        """Columns of either picture."""
        return len(self.columns) // 2


def layout(display: DisplayFormat, width: int, height: int) -> Layout:
    """Where pictures of ``width`` x ``height`` pixels are shown: as large as they fit, in the middle; of an odd rest, more to the right and
    below.

    Raises
    ------
    ValueError
        If not even a pixel of them can be shown.

    Examples
    --------
    >>> from golden.video.formats import VGA
    >>> layout(VGA, 320, 240)
    Layout(step=1, columns=range(0, 640), lines=range(120, 360))
    >>> layout(VGA, 384, 288)
    Layout(step=2, columns=range(128, 512), lines=range(168, 312))
    """
    step = 1
    while 2 * (width // step) > display.width or height // step > display.height:
        step += 1
    if not (width // step and height // step):
        raise ValueError(f"pictures of {width}x{height} pixels cannot be shown on a display of {display.width}x{display.height}; choose a "
                         "size whose sides differ less")
    columns, lines = 2 * (width // step), height // step
    left, top = (display.width - columns) // 2, (display.height - lines) // 2
    return Layout(step, range(left, left + columns), range(top, top + lines))


def side_by_side(left: NDArray[Any], label: NDArray[Any], known: NDArray[np.bool_], display: DisplayFormat, labels: int) -> Levels:
    """The whole active area of the monitor: left picture, disparities in the colours of :func:`golden.video.display.colour_table`, black
    around them.

    Parameters
    ----------
    left : (H, W) integer ndarray
        Grey levels, ``0..255``.
    label : (H, W) integer ndarray
        Labels, ``0 .. labels - 1``.
    known : (H, W) bool ndarray
        Where there is none, it is black.
    display : DisplayFormat
    labels : int
        Number of labels, at least 2.

    Returns
    -------
    (display.height, display.width, 3) uint8 ndarray
        Red, green, blue.
    """
    height, width = left.shape
    place = layout(display, width, height)
    shown = (slice(None, height // place.step * place.step, place.step), slice(None, place.width * place.step, place.step))
    grey = np.stack([left[shown]] * 3, axis=-1)
    colours = colour_table()[grey_level(label[shown], labels)] * known[shown][..., np.newaxis]
    screen = np.zeros((display.height, display.width, 3), dtype=np.uint8)
    screen[place.lines.start:place.lines.stop, place.columns.start:place.columns.stop] = np.hstack([grey, colours])
    return screen
