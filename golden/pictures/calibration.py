"""Calibration of a rectified pair."""

import math
from collections.abc import Sequence
from dataclasses import dataclass

from ..errors import UserError


__all__ = ["CENTRE_PIXELS", "Calibration", "Matrix", "check_rectified", "from_projections"]


Matrix = Sequence[float]

# What may differ between two cameras that are rectified: part of a focal length, pixels of a principal point. Files are rounded.
_FOCAL_PART = 0.001
CENTRE_PIXELS = 0.5


@dataclass(frozen=True)
class Calibration:
    """Parameters of a rectified pair of cameras from which depth is computed.

    Parameters
    ----------
    focal : float
        Focal length of both, pixels.
    baseline : float
        Distance between them, in any unit of length, which is the unit of depth.
    offset : float
        Pixels that are added to a disparity before depth is computed: distance of the principal points (Middlebury's ``doffs``).
    centre : (float, float) or None
        Principal point of the left picture, x and y in pixels; ``None``: the middle of the picture.
    size : (int, int) or None
        Width and height of the pictures it applies to, pixels; ``None``: any.
    millimetres : float or None
        Millimetres in the unit of ``baseline``; ``None``: not known.
    focal_y : float or None
        Vertical focal length, pixels, where it differs; ``None``: ``focal``.
    """
    focal: float
    baseline: float
    offset: float = 0.0
    centre: tuple[float, float] | None = None
    size: tuple[int, int] | None = None
    millimetres: float | None = None
    focal_y: float | None = None

    def __post_init__(self) -> None:
        for name in ("focal", "baseline", "focal_y"):
            value = getattr(self, name)
            if value is not None and not (math.isfinite(value) and value > 0):
                raise ValueError(f"{name} must be a number above 0, not {value:g}")
        if not math.isfinite(self.offset):
            raise ValueError(f"offset must be a number, not {self.offset:g}")


def check_rectified(left: Matrix, right: Matrix, names: tuple[str, str]) -> None:
    """:class:`UserError` unless two projection matrices, as of :func:`from_projections`, are those of a rectified pair of cameras."""
    for matrix, name in ((left, names[0]), (right, names[1])):
        if len(matrix) != 12 or not all(map(math.isfinite, matrix)):
            raise UserError(f"{name} is not a matrix of 3x4 numbers; correct it")
        if matrix[1] or matrix[4] or [*matrix[8:11]] != [0, 0, 1] or matrix[0] <= 0 or matrix[5] <= 0:
            raise UserError(f"{name} is not the projection of a rectified camera, [fx 0 cx tx; 0 fy cy 0; 0 0 1 0], with focal lengths "
                            "above 0; rectify the pair, and give the calibration after that")
    for what, at, limit in (("fx", 0, _FOCAL_PART * left[0]), ("fy", 5, _FOCAL_PART * left[5]), ("cy", 6, CENTRE_PIXELS)):
        if abs(left[at] - right[at]) > limit:
            raise UserError(f"{names[0]} has the {what} {left[at]:g} and {names[1]} has {right[at]:g}; those of a rectified pair are "
                            "equal: rectify it, and give the calibration after that")


def from_projections(left: Matrix, right: Matrix, names: tuple[str, str], size: tuple[int, int] | None = None,
                     millimetres: float | None = None) -> Calibration:
    """The calibration of two cameras from their projection matrices ``[fx 0 cx tx; 0 fy cy ty; 0 0 1 tz]``, row by row.

    The baseline is the difference of their ``tx / fx``.

    Parameters
    ----------
    left, right : sequence of 12 floats
    names : (str, str)
        What they are called, for messages.
    size, millimetres
        As of :class:`Calibration`.

    Returns
    -------
    Calibration
        :class:`UserError` if the cameras are not rectified, or are not side by side, the left one on the left.
    """
    check_rectified(left, right, names)
    baseline = left[3] / left[0] - right[3] / right[0]
    apart = abs(left[7] / left[5] - right[7] / right[5])
    if apart > abs(baseline):
        raise UserError(f"{names[0]} and {names[1]} are one above the other; turn the pictures and the calibration by 90 degrees")
    if baseline <= 0:
        raise UserError(f"{names[1]} has a baseline of {baseline:g} to the right of {names[0]}, which is not above 0; "
                        "give the right camera's matrix as the right one")
    return Calibration(left[0], baseline, right[2] - left[2], (left[2], left[6]), size, millimetres, left[5])
