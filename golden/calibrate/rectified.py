"""Rectification of calibrated cameras: floating-point maps, those of the gateware, and where corners are found after either."""

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ..errors import UserError
from ..rig.files import Rig
from ..rig.fit import fit_map
from ..rig.lines import check_lines
from ..rig.maps import SUB_PIXEL, RectifyMap, displacement
from ..rig.rectify import ROW_OFFSETS
from .views import Corners, opencv


__all__ = ["Maps", "Rectified", "check_places", "corners_after", "make_rig", "rectification", "rig_dy"]


Floats = NDArray[np.float64]
Maps = tuple[Floats, Floats]

# Steps of the search for the pixel that is taken from a given place; each one reduces the error by the map's slope, some hundredths.
_STEPS = 25


@dataclass(frozen=True)
class Rectified:
    """Two cameras, and the rotations and projections that rectify their pictures, as OpenCV has them.

    Parameters
    ----------
    size : (int, int)
        Width and height of the pictures, pixels.
    matrices, distortions : two of (3, 3) and (N,) float ndarray
        Of the left and the right camera.
    rotation, translation : (3, 3), (3, 1) float ndarray
        From the left camera's coordinates to the right one's, millimetres.
    turns, projections : two of (3, 3) and (3, 4) float ndarray
        Of the left and the right camera.
    """
    size: tuple[int, int]
    matrices: tuple[Floats, Floats]
    distortions: tuple[Floats, Floats]
    rotation: Floats
    translation: Floats
    turns: tuple[Floats, Floats]
    projections: tuple[Floats, Floats]

    @property
    def baseline(self) -> float:
        """Millimetres."""
        return float(np.linalg.norm(self.translation))

    @property
    def focal(self) -> float:
        """Of both rectified cameras, pixels."""
        return float(self.projections[0][0, 0])

    def maps(self, camera: int) -> Maps:
        """From where each pixel of the rectified picture of camera 0, the left one, or 1 is taken: x and y, (H, W) float, pixels."""
        cv2 = opencv()
        x, y = cv2.initUndistortRectifyMap(self.matrices[camera], self.distortions[camera], self.turns[camera],
                                           self.projections[camera][:, :3], self.size, cv2.CV_32FC1)
        return np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64)

    def remapped(self, picture: NDArray[np.uint8], camera: int) -> NDArray[np.uint8]:
        """A picture of camera 0 or 1 as OpenCV rectifies it, bilinear; the edge is replicated."""
        cv2 = opencv()
        x, y = (each.astype(np.float32) for each in self.maps(camera))
        return np.asarray(cv2.remap(picture, x, y, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE), dtype=np.uint8)

    def corners(self, camera: int, corners: Corners) -> Floats:
        """Where corners of a camera's picture are in the rectified one: (N, 2)."""
        cv2 = opencv()
        found = cv2.undistortPoints(corners.reshape(-1, 1, 2).astype(np.float64), self.matrices[camera], self.distortions[camera],
                                    None, self.turns[camera], self.projections[camera], (3, 100, 1e-9))
        return np.asarray(found, dtype=np.float64).reshape(-1, 2)

    def corner_dy(self, left: Corners, right: Corners) -> Floats:
        """Lines between corresponding corners after rectification in floating point: (N,)."""
        result: Floats = self.corners(0, left)[:, 1] - self.corners(1, right)[:, 1]
        return result


def rectification(size: tuple[int, int], left_matrix: Floats, left_distortion: Floats, right_matrix: Floats, right_distortion: Floats,
                  rotation: Floats, translation: Floats) -> Rectified:
    """Cameras with the rotations and projections that OpenCV finds for them: no pixel without a source, principal points that are equal."""
    cv2 = opencv()
    try:
        left_turn, right_turn, left_projection, right_projection, *_ = cv2.stereoRectify(
            left_matrix, left_distortion, right_matrix, right_distortion, size, rotation, translation, flags=cv2.CALIB_ZERO_DISPARITY,
            alpha=0)
    except cv2.error as error:
        raise UserError(f"cameras with this calibration cannot be rectified ({error.err}); calibrate them again") from None
    projections = left_projection, right_projection
    if not all(np.isfinite(each).all() and each[0, 0] > 0 for each in projections):
        raise UserError("cameras with this calibration cannot be rectified, no part of the pictures is seen by both; calibrate them again")
    return Rectified(size, (left_matrix, right_matrix), (left_distortion.ravel(), right_distortion.ravel()), rotation,
                     translation.reshape(3, 1), (left_turn, right_turn), projections)


def check_places(rectified: Rectified) -> None:
    """:class:`UserError` unless the right camera is to the right of the left one."""
    x, y, _ = rectified.translation.ravel().tolist()
    if abs(y) > abs(x):
        raise UserError(f"the cameras are one above the other, {abs(y):.1f} mm apart; turn the pictures of both by 90 degrees")
    if x > 0:
        raise UserError(f"the cameras are exchanged: the second one is {x:.1f} mm to the left of the first; give the left camera first")


def make_rig(left: Maps, right: Maps, lines: int, gains: tuple[Floats, Floats] | None = None) -> Rig:
    """The rig of both cameras' floating-point maps.

    The reader moves the right picture's rows only where the rectifiers hold too few lines without: rows at its edge get lost.

    Parameters
    ----------
    left, right : (x, y)
        (H, W) float each, as of :meth:`Rectified.maps`.
    lines : int
        Lines that the gateware's rectifiers hold; :class:`UserError` if they are not enough.
    gains : two of (H, W) float ndarray, or None
        Factors of the grey levels.
    """
    first, second = gains or (None, None)
    try:
        rig = Rig(fit_map(*left, first), fit_map(*right, second))
        apart = round(float(np.mean(right[1] - left[1])))
        step = 1 if apart > 0 else -1
        while rig.lines > lines and abs(rig.row_offset) < abs(apart):
            # Each row moved saves a line at most.
            offset = step * min(abs(rig.row_offset) + rig.lines - lines, abs(apart), abs(ROW_OFFSETS[-1]))
            if offset == rig.row_offset:
                break
            rig = dataclasses.replace(rig, right=fit_map(right[0], right[1] - offset, second), row_offset=offset)
        check_lines([rig.left, rig.right], lines)
    except ValueError as error:
        raise UserError(str(error)) from None
    return rig


def corners_after(which: RectifyMap, corners: Corners, row_offset: int = 0) -> Floats:
    """Where corners of a camera's picture are after a rectifier with this map: (N, 2) float.

    The displacement of the whole pixels is exact; between them it is interpolated, and the place searched whose source the corner is.
    """
    dx, dy, _ = displacement(which)
    moved = corners.astype(np.float64) - [0, row_offset]
    place = moved.copy()
    for _ in range(_STEPS):
        x, y = (np.clip(place[:, axis], 0, limit - 1) for axis, limit in ((0, which.width), (1, which.height)))
        i, j = (np.minimum(each.astype(int), limit - 2) for each, limit in ((x, which.width), (y, which.height)))
        across, down = x - i, y - j
        shift = [((1 - down) * ((1 - across) * field[j, i] + across * field[j, i + 1])
                  + down * ((1 - across) * field[j + 1, i] + across * field[j + 1, i + 1])) / SUB_PIXEL for field in (dx, dy)]
        place = moved - np.stack(shift, axis=1)
    return place


def rig_dy(rig: Rig, left: Corners, right: Corners) -> Floats:
    """Lines between corresponding corners after the rectifiers: (N,)."""
    result: Floats = corners_after(rig.left, left)[:, 1] - corners_after(rig.right, right, rig.row_offset)[:, 1]
    return result
