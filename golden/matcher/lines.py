"""Contents of the line memories: the lines around a pixel, and the costs of the line above."""

import numpy as np


__all__ = ["edata_memory", "line_store"]


def line_store(picture, rows=3):
    """The pixels at ``(x, y-1)``, ``(x, y)``, ``(x, y+1)`` of every pixel, with edge replication; with more rows as many above
    as below.

    Parameters
    ----------
    picture : (H, W) integer ndarray
        Grey levels.
    rows : int
        Lines of a column, odd.

    Returns
    -------
    (H, W, rows) ndarray
        Grey levels from top to bottom; of three rows: minus line, line, plus line.

    Examples
    --------
    >>> line_store(np.array([[1], [2], [3]])).tolist()
    [[[1, 1, 2]], [[1, 2, 3]], [[2, 3, 3]]]
    >>> line_store(np.array([[1], [2], [3]]), 5).tolist()
    [[[1, 1, 1, 2, 3]], [[1, 1, 2, 3, 3]], [[1, 2, 3, 3, 3]]]
    """
    padded = np.pad(picture, ((rows // 2, rows // 2), (0, 0)), mode="edge")
    return np.stack([padded[row:row + len(picture)] for row in range(rows)], axis=-1)


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
