"""A pair before and after rectification, with epipolar lines."""

from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from .views import Corners


__all__ = ["epipolar_lines"]


_COLOURS = ((230, 60, 60), (240, 160, 30), (220, 220, 60), (70, 200, 90), (70, 190, 230), (110, 110, 250), (210, 90, 220))
_MARK = 4       # pixels from the middle of a mark to its edge
_TITLE = 18     # pixels


def _chosen(corners: NDArray[Any]) -> list[int]:
    """Numbers of corners that are spread over the board's height, one for each colour."""
    order = np.argsort(corners[:, 1])
    return [int(order[place]) for place in np.linspace(0, len(order) - 1, len(_COLOURS)).round().astype(int)]


def _row(pair: tuple[NDArray[np.uint8], NDArray[np.uint8]], corners: tuple[NDArray[Any], NDArray[Any]], numbers: list[int],
         title: str) -> Image.Image:
    height, width = pair[0].shape
    canvas = Image.new("RGB", (2 * width, height + _TITLE), (255, 255, 255))
    for side, picture in enumerate(pair):
        canvas.paste(Image.fromarray(picture), (side * width, _TITLE))
    draw = ImageDraw.Draw(canvas)
    draw.text((4, 3), title, fill=(0, 0, 0))
    for colour, number in zip(_COLOURS, numbers):
        level = _TITLE + float(corners[0][number, 1])
        draw.line([(0, level), (2 * width, level)], fill=colour)
        for side in (0, 1):
            x, y = float(corners[side][number, 0]) + side * width, float(corners[side][number, 1]) + _TITLE
            draw.ellipse([x - _MARK, y - _MARK, x + _MARK, y + _MARK], outline=colour, width=2)
    return canvas


def epipolar_lines(before: tuple[NDArray[np.uint8], NDArray[np.uint8]], after: tuple[NDArray[np.uint8], NDArray[np.uint8]],
                   corners_before: tuple[Corners, Corners], corners_after: tuple[NDArray[Any], NDArray[Any]]) -> NDArray[np.uint8]:
    """A picture of a pair above the same pair rectified: some corners, and the lines through those of the left picture.

    Parameters
    ----------
    before, after : two of (H, W) uint8 ndarray
        Left and right picture.
    corners_before, corners_after : two of (N, 2) ndarray
        The same corners in all of them, pixels.

    Returns
    -------
    (2 H + 36, 2 W, 3) uint8 ndarray
    """
    numbers = _chosen(corners_before[0])
    rows = []
    for name, pair, corners in (("before", before, corners_before), ("after", after, corners_after)):
        apart = np.abs(corners[0][:, 1] - corners[1][:, 1]).mean()
        rows.append(np.asarray(_row(pair, corners, numbers, f"{name}: corners are {apart:.2f} lines apart on average")))
    return np.concatenate(rows)
