"""Cameras from views of a chessboard."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import UserError
from .rectified import Rectified, check_places, rectification
from .views import Board, View, opencv


__all__ = ["LEAST_VIEWS", "MOST_DY", "MOST_RMS", "OUTLIER", "Solution", "solve"]


LEAST_VIEWS = 8
MOST_RMS = 0.5      # pixels
MOST_DY = 0.3       # pixels, mean
OUTLIER = 3         # a view is dropped whose |dy| is over so many times the median

# Where the optimization ends: steps, or change of the parameters.
_END = (3, 200, 1e-7)

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Solution:
    """Calibrated cameras.

    Parameters
    ----------
    rectified : Rectified
        The cameras, and how they are rectified.
    rms : float
        Root mean square of the distance from every corner to where the cameras see it, pixels.
    kept, dropped : list of View
    """
    rectified: Rectified
    rms: float
    kept: list[View]
    dropped: list[View]


def _stereo(views: Sequence[View], board: Board, size: tuple[int, int], intrinsics: Sequence[Floats] | None) -> tuple[Rectified, float]:
    cv2 = opencv()
    points = [board.points] * len(views)
    sides = [[each.left for each in views], [each.right for each in views]]
    # A third radial coefficient, or a rational model, is worth nothing on boards that do not reach the corners, and is wild there.
    flags = cv2.CALIB_FIX_K3
    try:
        if intrinsics is None:
            lenses = [each for side in sides
                      for each in cv2.calibrateCamera(points, side, size, None, None, flags=flags, criteria=_END)[1:3]]
            flags |= cv2.CALIB_USE_INTRINSIC_GUESS
        else:
            lenses, flags = [each.copy() for each in intrinsics], cv2.CALIB_FIX_INTRINSIC
        rms, *cameras = cv2.stereoCalibrate(points, *sides, *lenses, size, flags=flags, criteria=_END)
    except cv2.error as error:
        raise UserError(f"the cameras cannot be computed from these views ({error.err}); show the board at different angles and distances, "
                        "and in all parts of the picture") from None
    return rectification(size, *cameras[:6]), float(rms)


def solve(views: Sequence[View], board: Board, size: tuple[int, int], intrinsics: Sequence[Floats] | None = None) -> Solution:
    """The cameras that see these views.

    Views whose mean ``|dy|`` after rectification is over three times the median are dropped, and the cameras computed again.

    Parameters
    ----------
    views : sequence of View
    board : Board
    size : (int, int)
        Width and height of the pictures, pixels.
    intrinsics : sequence of ndarray or None
        Matrix and distortion of the left and of the right camera, to be kept; ``None``: they are computed.

    Returns
    -------
    Solution
        :class:`UserError` if less than :data:`LEAST_VIEWS` are usable, or the result is not good enough: an rms over :data:`MOST_RMS`, a
        mean ``|dy|`` over :data:`MOST_DY`, cameras that are exchanged or one above the other.
    """
    kept, dropped = list(views), list[View]()
    while True:
        _check_count(kept, dropped)
        rectified, rms = _stereo(kept, board, size, intrinsics)
        errors = [float(np.abs(rectified.corner_dy(each.left, each.right)).mean()) for each in kept]
        worst = [each for each, error in zip(kept, errors) if error > OUTLIER * np.median(errors)]
        if not worst:
            break
        dropped += worst
        kept = [each for each in kept if each not in worst]
    check_places(rectified)
    mean = float(np.mean(errors))
    if rms > MOST_RMS:
        raise UserError(f"the corners are off by {rms:.2f} pixels (rms), and {MOST_RMS} is allowed, and {mean:.2f} lines apart after "
                        "rectification; take sharp pictures of a flat board that stands still, and check --board")
    if mean > MOST_DY:
        raise UserError(f"the corners of the rectified pictures are {mean:.2f} lines apart on average, and {MOST_DY} is allowed; take both "
                        "pictures of a pair at the same time, with cameras that are fixed to each other")
    return Solution(rectified, rms, kept, dropped)


def _check_count(kept: Sequence[View], dropped: Sequence[View]) -> None:
    if len(kept) < LEAST_VIEWS:
        lost = f", after {', '.join(each.name for each in dropped)} were dropped as outliers" if dropped else ""
        raise UserError(f"{len(kept)} views can be used{lost}, and {LEAST_VIEWS} are needed at least; take more pictures of the whole "
                        "board, each at another angle and place")
