"""Masks of a pair where the benchmark gives none: which pixels are visible in both pictures, and which are at discontinuities."""

from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray


__all__ = ["AGREEMENT", "JUMP", "NEAR", "computed_masks", "right_truth", "visible"]


AGREEMENT = 1   # greatest difference of the two truths at a visible pixel, pixels
JUMP = 2        # least step of the truth from a pixel to the next that is a discontinuity, pixels
NEAR = 4        # pixels within this of a discontinuity count, in lines and in columns

Truth = NDArray[np.float64]
Mask = NDArray[np.bool_]


def computed_masks(truth: Truth, right: Truth | None = None) -> dict[str, Mask]:
    """The masks of :data:`golden.pictures.dataset.MASKS`, from the truth alone.

    Parameters
    ----------
    truth : (H, W) float64 ndarray
        Disparities of the left picture, pixels; ``inf`` where unknown.
    right : (H, W) float64 ndarray or None
        Those of the right picture; ``None``: that of :func:`right_truth`.

    Returns
    -------
    dict of str to (H, W) bool ndarray
        ``all``: the truth is known. ``nonocc``: and it is :func:`visible` in both pictures, by a median of 3x3 pixels. ``disc``: and a
        discontinuity is within :data:`NEAR` pixels: a step of :data:`JUMP` between neighbours of known truth, or an occluded pixel.
    """
    known = np.isfinite(truth)
    seen = visible(truth, right_truth(truth) if right is None else right)
    nonocc = known & (_windows(seen, 3).sum(axis=(-2, -1)) > 4)
    return {"nonocc": nonocc, "all": known, "disc": nonocc & _windows(_jumps(truth) | (known & ~nonocc), 2 * NEAR + 1).any(axis=(-2, -1))}


def visible(truth: Truth, right: Truth) -> Mask:
    """Left pixels of known truth whose match is in the picture and has a truth there that agrees with theirs.

    Both are rounded to pixels, half up, and agree if they differ by at most :data:`AGREEMENT`.
    """
    known = np.isfinite(truth)
    column = np.arange(truth.shape[1]) - _rounded(truth)
    there = np.take_along_axis(right, np.clip(column, 0, truth.shape[1] - 1), axis=1)
    inside = known & (column >= 0) & (column < truth.shape[1]) & np.isfinite(there)
    return inside & (np.abs(_rounded(there) - _rounded(truth)) <= AGREEMENT)


def right_truth(truth: Truth) -> Truth:
    """Truth of the right picture as far as the left one tells it: of the pixels that match there, the disparity of the nearest.

    Examples
    --------
    >>> right_truth(np.array([[0.0, 0.0, 2.0, np.inf]])).tolist()
    [[2.0, 0.0, inf, inf]]
    """
    result = np.full_like(truth, -np.inf)
    line, column = np.nonzero(np.isfinite(truth))
    at = column - _rounded(truth)[line, column]
    inside = (at >= 0) & (at < truth.shape[1])
    np.maximum.at(result, (line[inside], at[inside]), truth[line, column][inside])
    return np.where(np.isfinite(result), result, np.inf)


def _rounded(truth: Truth) -> NDArray[np.int64]:
    """Whole pixels, half up; 0 where unknown."""
    return np.floor(np.where(np.isfinite(truth), truth, 0) + 0.5).astype(np.int64)


def _jumps(truth: Truth) -> Mask:
    """Pixels on both sides of a step of the truth."""
    result = np.zeros(truth.shape, dtype=bool)
    values = np.where(np.isfinite(truth), truth, np.nan)
    for axis in (0, 1):
        step = np.abs(np.diff(values, axis=axis)) >= JUMP
        before, after = ([(0, 0), (0, 0)], [(0, 0), (0, 0)])
        before[axis], after[axis] = (0, 1), (1, 0)
        result |= np.pad(step, before) | np.pad(step, after)
    return result


def _windows(array: Mask, size: int) -> NDArray[Any]:
    """The ``size`` x ``size`` pixels around every one, with edge replication: two further axes."""
    return sliding_window_view(np.pad(array, size // 2, mode="edge"), (size, size))
