"""What the line memories hold: the three lines around a pixel, and the costs of the line above."""

import numpy as np


__all__ = ["edata_memory", "line_store"]


def line_store(picture):
    """The pixels at ``(x, y-1)``, ``(x, y)``, ``(x, y+1)`` of every pixel; lines outside the picture repeat the nearest.

    Parameters
    ----------
    picture : (H, W) integer ndarray
        Grey levels.

    Returns
    -------
    (H, W, 3) ndarray
        Grey levels: minus line, line, plus line.

    Examples
    --------
    >>> line_store(np.array([[1], [2], [3]]))[:, 0].tolist()
    [[1, 1, 2], [1, 2, 3], [2, 3, 3]]
    """
    padded = np.pad(picture, ((1, 1), (0, 0)), mode="edge")
    return np.stack([padded[:-2], padded[1:-1], padded[2:]], axis=-1)


def edata_memory(words):
    """Words of a picture one line later: line ``y`` of the result is line ``y-1`` of ``words``; line 0 is not defined.

    Parameters
    ----------
    words : (H, W, ...) ndarray

    Returns
    -------
    (H - 1, W, ...) ndarray
        Lines ``1 .. H-1``.
    """
    return np.asarray(words)[:-1]
