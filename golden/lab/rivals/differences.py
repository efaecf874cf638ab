"""Differences of grey levels, which most rivals start from."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...matcher.cost import sub_pixel_buffers


__all__ = ["absolute_differences", "outside_candidates"]


def outside_candidates(width: int, labels: int) -> NDArray[np.bool_]:
    """Candidates whose right pixel is outside the picture: (W, D), true where ``d > x``."""
    return np.arange(labels) > np.arange(width)[:, None]


def absolute_differences(left: NDArray[Any], right: NDArray[Any], labels: int) -> NDArray[np.int32]:
    """``|left(x) - right(x - d)|`` of every pixel and label.

    Parameters
    ----------
    left, right : (H, W) integer ndarray
        Grey levels ``0..255``.
    labels : int
        Number of labels ``D``.

    Returns
    -------
    (H, W, D) int32 ndarray
        Where ``d > x``, see :func:`outside_candidates`, edge replication: the first pixel of the right line.

    Examples
    --------
    >>> absolute_differences(np.array([[9, 5]]), np.array([[5, 1]]), 2).tolist()
    [[[4, 4], [4, 0]]]
    """
    left, right = np.asarray(left, dtype=np.int32), np.asarray(right, dtype=np.int32)
    result = np.empty((*left.shape, labels), dtype=np.int32)
    for y, line in enumerate(right):
        np.abs(left[y, :, None] - sub_pixel_buffers(line, labels), out=result[y])
    return result
