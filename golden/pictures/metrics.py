"""Errors of a disparity picture against the ground truth."""

from typing import Any

import numpy as np
from numpy.typing import NDArray


__all__ = ["bad_pixels"]


def bad_pixels(disparity: NDArray[Any], truth: NDArray[Any], mask: NDArray[np.bool_], threshold: float = 1.0) -> float:
    """Percentage of bad pixels, equation (4-1): those with ``abs(disparity - truth) > threshold``.

    Parameters
    ----------
    disparity : (H, W) ndarray
        Pixels.
    truth : (H, W) ndarray
        Pixels; not finite where unknown: such a pixel does not count, even if the mask includes it.
    mask : (H, W) bool ndarray
        Pixels that count.
    threshold : float
        Pixels. An error of exactly this size is not bad.

    Returns
    -------
    float
        ``0..100``.

    Examples
    --------
    >>> bad_pixels(np.array([3, 3, 3, 3]), np.array([3, 4, 4.25, np.inf]), np.ones(4, bool))
    33.33333333333333
    """
    disparity, truth, mask = np.asarray(disparity), np.asarray(truth), np.asarray(mask)
    if not disparity.shape == truth.shape == mask.shape:
        raise ValueError(f"sizes differ: disparity {disparity.shape}, truth {truth.shape}, mask {mask.shape}")
    if mask.dtype != bool:  # an integer mask would pick pixels by their number
        raise ValueError(f"the mask must be bool, not {mask.dtype}")
    counted = mask & np.isfinite(truth)
    if not counted.any():
        raise ValueError("no pixel is both in the mask and of known disparity: the percentage is not defined")
    # float64 holds labels and truths (multiples of 1/256 at the finest) exactly, so the comparison is exact.
    error = np.abs(disparity[counted].astype(np.float64) - truth[counted])
    return float(100 * np.count_nonzero(error > threshold) / error.size)
