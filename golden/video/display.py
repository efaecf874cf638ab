"""The picture on the monitor, made of a disparity picture and the left picture."""

import enum
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..config import PIXEL_MAX
from .formats import DisplayFormat


__all__ = ["DisplayMode", "colour_table", "grey_level", "monitor_picture", "placement"]

Levels = NDArray[np.uint8]


class DisplayMode(enum.StrEnum):
    """Which picture is shown; :attr:`code` counts in this order.

    ``DISPARITY``: disparities; nearer is brighter.
    ``LEFT``: the left picture.
    ``BOTH``: disparities and, to the right of them, the left picture: every second pixel of every second line, from the first on.
    """
    DISPARITY = "disparity"
    LEFT = "left"
    BOTH = "both"

    @property
    def code(self) -> int:
        """Encoding of the mode in the gateware."""
        return list(DisplayMode).index(self)


def grey_level(disparity: NDArray[Any], labels: int) -> NDArray[np.int64]:
    """Grey levels of disparities, ``255 * d // (labels - 1)``: nearer is brighter, the farthest is black, the nearest white.

    Parameters
    ----------
    disparity : integer ndarray
        Pixels, ``0 .. labels - 1``.
    labels : int
        Number of disparities, at least 2.

    Examples
    --------
    >>> grey_level(np.array([0, 1, 40, 78, 79]), 80).tolist()
    [0, 3, 129, 251, 255]
    """
    disparity = np.asarray(disparity, dtype=np.int64)
    if disparity.size and not 0 <= disparity.min() <= disparity.max() < labels:
        raise ValueError(f"disparities from {disparity.min()} to {disparity.max()} are not within 0 .. {labels - 1}")
    levels: NDArray[np.int64] = PIXEL_MAX * disparity // (labels - 1)
    return levels


def colour_table() -> Levels:
    """The colour of each grey level, (256, 3): matplotlib's *turbo*, from dark blue (far) to dark red (near).

    Examples
    --------
    >>> colour_table()[[0, 128, 255]].tolist()
    [[48, 18, 59], [164, 252, 59], [122, 4, 2]]
    """
    from matplotlib import colormaps  # here, because matplotlib is slow to import

    colours: Levels = colormaps["turbo"](np.arange(PIXEL_MAX + 1), bytes=True)
    return colours[:, :3]


def placement(display: DisplayFormat, width: int, height: int, mode: DisplayMode | str) -> tuple[range, range]:
    """Columns and lines of the active area that a picture covers.

    It is centred; of an odd number of black columns the greater half is to the right, of an odd number of black lines it is below. In
    mode ``both`` it consists of two pictures of ``width // 2`` columns and ``height // 2`` lines.

    Parameters
    ----------
    display : DisplayFormat
    width, height : int
        Of the picture, in pixels. :class:`ValueError` if it does not fit the display, or is smaller than 2x2.
    mode : DisplayMode

    Examples
    --------
    >>> from golden.video.formats import DISPLAYS
    >>> placement(DISPLAYS["1024x768"], 720, 576, "disparity")
    (range(152, 872), range(96, 672))
    >>> placement(DISPLAYS["1024x768"], 720, 576, "both")
    (range(152, 872), range(240, 528))
    """
    if not (2 <= width <= display.width and 2 <= height <= display.height):
        raise ValueError(f"a picture of {width}x{height} pixels cannot be shown on a display of {display.width}x{display.height}; "
                         "choose one from 2x2 pixels to the display's size")
    if DisplayMode(mode) is DisplayMode.BOTH:
        width, height = 2 * (width // 2), height // 2
    left, top = (display.width - width) // 2, (display.height - height) // 2
    return range(left, left + width), range(top, top + height)


def monitor_picture(disparity: NDArray[Any], left: NDArray[Any], display: DisplayFormat, mode: DisplayMode | str, colour: bool,
                    labels: int) -> Levels:
    """The whole active area of the monitor: the picture where :func:`placement` puts it, black around it.

    Parameters
    ----------
    disparity : (H, W) integer ndarray
        Pixels, ``0 .. labels - 1``.
    left : (H, W) integer ndarray
        Grey levels, ``0..255``.
    display : DisplayFormat
    mode : DisplayMode
    colour : bool
        Disparities by :func:`colour_table` instead of grey; the left picture is always grey.
    labels : int
        Number of disparities.

    Returns
    -------
    (display.height, display.width, 3) uint8 ndarray
        Red, green, blue.
    """
    disparity, left = np.asarray(disparity), np.asarray(left)
    if disparity.ndim != 2 or disparity.shape != left.shape:
        raise ValueError(f"disparities of shape {disparity.shape} and a left picture of shape {left.shape} are not of one size")
    height, width = disparity.shape
    columns, lines = placement(display, width, height, mode)
    levels = grey_level(disparity, labels)
    picture = colour_table()[levels] if colour else np.stack([levels] * 3, axis=-1)
    grey = np.stack([left] * 3, axis=-1)
    match DisplayMode(mode):
        case DisplayMode.LEFT:
            picture = grey
        case DisplayMode.BOTH:
            picture = np.hstack([whole[:height // 2 * 2:2, :width // 2 * 2:2] for whole in (picture, grey)])
    screen = np.zeros((display.height, display.width, 3), dtype=np.uint8)
    screen[lines.start:lines.stop, columns.start:columns.stop] = picture
    return screen
