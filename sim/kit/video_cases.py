"""Payloads of the video system's streams, from pictures."""

import numpy as np


__all__ = ["camera_words", "plane_words", "shown_words"]


def _flags(height, width, rows):
    """``(y, x, flags)`` for lines in the order of ``rows``."""
    for number, y in enumerate(rows):
        for x in range(width):
            last = x == width - 1
            yield y, x, {"first": int(number == x == 0), "last": int(last), "end": int(last and number == height - 1)}


def camera_words(picture):
    """Payloads of :class:`hdl.video.words.CameraWord`: the even lines, then the odd ones."""
    picture = np.asarray(picture).tolist()
    height, width = len(picture), len(picture[0])
    rows = [*range(0, height, 2), *range(1, height, 2)]
    return [{"luma": picture[y][x], "drop": 0, **flags} for y, x, flags in _flags(height, width, rows)]


def plane_words(picture):
    """Payloads of :class:`hdl.video.words.PlanePixel`."""
    picture = np.asarray(picture).tolist()
    return [{"value": picture[y][x], **flags} for y, x, flags in _flags(len(picture), len(picture[0]), range(len(picture)))]


def shown_words(disparity, left):
    """Payloads of :class:`hdl.video.words.ShownPixel`."""
    disparity, left = np.asarray(disparity).tolist(), np.asarray(left).tolist()
    height, width = len(left), len(left[0])
    return [{"disparity": disparity[y][x], "left": left[y][x], "first": flags["first"], "last": flags["last"]}
            for y, x, flags in _flags(height, width, range(height))]
