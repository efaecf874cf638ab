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

# Parameters of both, those of OpenCV's example `stereo_match`.
CHECK = 1             # largest difference of left and right view, pixels
UNIQUENESS = 10       # percent by which the best cost must beat the second

# StereoBM: the rest of that example, and of the blocks of 5, 9, 15, 21 pixels those with the fewest bad pixels on the four pairs.
BLOCK = 5
SPECKLE = (100, 32)   # least area, pixels, and most variation within
PREFILTER_CAP = 31

# StereoSGBM: what has the fewest bad pixels on fourteen sets of Middlebury 2005 and 2006, docs/compare.md; the four pairs were not looked
# at. P1 and P2 are what OpenCV's manual recommends for one channel.
SEMI_GLOBAL_MODE = "STEREO_SGBM_MODE_HH4"
SEMI_GLOBAL_BLOCK = 3
SEMI_GLOBAL_SPECKLE = (100, 1)
SEMI_GLOBAL_PREFILTER_CAP = 15


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
    # would extend too far. StereoSGBM's last columns are mostly wrong, so there are some more on the right: another 0.2.
    more = BLOCK // 2
    pair = (np.pad(side, ((more, more), (count, more)), mode="edge") for side in (left, right))
    with _one_thread():
        found = matcher.compute(*pair)[more:-more, count:-more].astype(np.int32)
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
    """Disparities of ``StereoSGBM`` over four paths through the whole picture (``MODE_HH4``), pixels, with four fraction bits.

    Blocks of 3x3 pixels, ``P1 = 8 * 3**2`` and ``P2 = 32 * 3**2``, Sobel prefilter capped at 15, uniqueness 10 %, left-right difference at
    most 1, speckles below 100 pixels and more than a pixel off removed; parameters, result and fill as of :func:`block_matching`.
    """
    import cv2

    area = SEMI_GLOBAL_BLOCK**2
    matcher = cv2.StereoSGBM.create(0, _count(labels), SEMI_GLOBAL_BLOCK, 8 * area, 32 * area, CHECK, SEMI_GLOBAL_PREFILTER_CAP, UNIQUENESS,
                                    *SEMI_GLOBAL_SPECKLE, getattr(cv2, SEMI_GLOBAL_MODE))
    return _filled(matcher, left, right, _count(labels))
