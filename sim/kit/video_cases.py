"""Payloads of the video system's streams, from pictures."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray


__all__ = ["camera_words", "plane_words", "shown_words"]


def _flags(height: int, width: int, rows: Sequence[int]):
    """``(y, x, flags)`` for lines in the order of ``rows``."""
    for number, y in enumerate(rows):
        for x in range(width):
            last = x == width - 1
            yield y, x, {"first": int(number == x == 0), "last": int(last), "end": int(last and number == height - 1)}


def camera_words(picture: NDArray[Any]) -> list[dict[str, int]]:
    """Payloads of :class:`hdl.video.words.CameraWord`: the even lines, then the odd ones."""
    grey = np.asarray(picture).tolist()
    height, width = len(grey), len(grey[0])
    rows = [*range(0, height, 2), *range(1, height, 2)]
    return [{"luma": grey[y][x], "drop": 0, **flags} for y, x, flags in _flags(height, width, rows)]


def plane_words(picture: NDArray[Any]) -> list[dict[str, int]]:
    """Payloads of :class:`hdl.video.words.PlanePixel`."""
    values = np.asarray(picture).tolist()
    return [{"value": values[y][x], **flags} for y, x, flags in _flags(len(values), len(values[0]), range(len(values)))]


def shown_words(disparity: NDArray[Any], left: NDArray[Any]) -> list[dict[str, int]]:
    """Payloads of :class:`hdl.video.words.ShownPixel`."""
    labels, grey = np.asarray(disparity).tolist(), np.asarray(left).tolist()
    height, width = len(grey), len(grey[0])
    return [{"disparity": labels[y][x], "left": grey[y][x], "first": flags["first"], "last": flags["last"]}
            for y, x, flags in _flags(height, width, range(height))]
