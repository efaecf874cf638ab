"""OpenCV's block matching and semi-global matching, the usual baselines."""

import contextlib
from collections.abc import Iterator
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...matcher.refine import fill


__all__ = ["SCALE", "block_matching", "semi_global_matching"]


SCALE = 16  # units of OpenCV's disparities a pixel
STEP = 16   # OpenCV's number of disparities is a multiple of this

# Parameters of both. The speckle filter and the left-right check are those of OpenCV's example `stereo_match`.
CHECK = 1             # largest difference of left and right view, pixels
SPECKLE = (100, 32)   # least area, pixels, and most variation within
UNIQUENESS = 10       # percent by which the best cost must beat the second
PREFILTER_CAP = 31

# Sides of the blocks, pixels: of 5, 9, 15, 21 and of 3, 5, 7 those with the fewest bad pixels on the four pairs.
BLOCK = 5
SEMI_GLOBAL_BLOCK = 3


@contextlib.contextmanager
def _one_thread() -> Iterator[None]:
    """Within the block OpenCV computes in the calling thread, so that its time can be compared."""
    import cv2  # here, because only the rivals need it

    before = cv2.getNumThreads()
    cv2.setNumThreads(1)
    try:
        yield
    finally:
        cv2.setNumThreads(before)


def _filled(matcher: Any, left: NDArray[np.uint8], right: NDArray[np.uint8], count: int) -> NDArray[np.float64]:
    """Disparities of a matcher, pixels; invalid ones are filled as ours are."""
    # OpenCV leaves out the first `count` columns, and StereoBM the lines whose blocks leave the picture. Edge replication provides
    # them: measured on the four pairs, that reduces bad pixels by 2.1 points for StereoBM and by 1.8 for StereoSGBM, because our fill
    # would extend too far.
    rows = BLOCK // 2
    pair = (np.pad(side, ((rows, rows), (count, 0)), mode="edge") for side in (left, right))
    with _one_thread():
        found = matcher.compute(*pair)[rows:-rows, count:].astype(np.int32)
    return np.maximum(fill(found, found >= 0), 0) / SCALE  # a line without a valid pixel gets disparity 0


def _count(labels: int) -> int:
    """The least number of disparities that OpenCV accepts and that covers ``labels``."""
    return -(-labels // STEP) * STEP


def block_matching(left: NDArray[np.uint8], right: NDArray[np.uint8], labels: int) -> NDArray[np.float64]:
    """Disparities of ``StereoBM``, pixels, with four fraction bits.

    Blocks of 5x5 pixels, Sobel prefilter capped at 31, texture threshold 10, uniqueness 10 %, left-right difference at most 1, speckles
    below 100 pixels removed. Invalid pixels are filled by :func:`golden.matcher.refine.fill`.

    Parameters
    ----------
    left, right : (H, W) uint8 ndarray
        Grey levels.
    labels : int
        Number of disparities; rounded up to a multiple of 16, as OpenCV requires.

    Returns
    -------
    (H, W) float64 ndarray
    """
    import cv2

    matcher = cv2.StereoBM.create(_count(labels), BLOCK)
    matcher.setPreFilterCap(PREFILTER_CAP)
    matcher.setTextureThreshold(10)
    matcher.setUniquenessRatio(UNIQUENESS)
    matcher.setSpeckleWindowSize(SPECKLE[0])
    matcher.setSpeckleRange(SPECKLE[1])
    matcher.setDisp12MaxDiff(CHECK)
    return _filled(matcher, left, right, _count(labels))


def semi_global_matching(left: NDArray[np.uint8], right: NDArray[np.uint8], labels: int) -> NDArray[np.float64]:
    """Disparities of ``StereoSGBM`` over all eight paths (``MODE_HH``), pixels, with four fraction bits.

    Blocks of 3x3 pixels, ``P1 = 8 * 3**2`` and ``P2 = 32 * 3**2`` as OpenCV's manual recommends for one channel; otherwise, and in
    parameters and result, as :func:`block_matching`, without a texture threshold.
    """
    import cv2

    area = SEMI_GLOBAL_BLOCK**2
    matcher = cv2.StereoSGBM.create(0, _count(labels), SEMI_GLOBAL_BLOCK, 8 * area, 32 * area, CHECK, PREFILTER_CAP, UNIQUENESS, *SPECKLE,
                                    cv2.STEREO_SGBM_MODE_HH)
    return _filled(matcher, left, right, _count(labels))
