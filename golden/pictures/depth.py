"""Depth from disparity, equation (1-1), and its point cloud."""

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..files import atomic
from ..notes import note
from .calibration import Calibration
from .images import write_picture


__all__ = ["DEPTH_SUFFIXES", "depth", "millimetres", "points", "write_depth"]


DEPTH_SUFFIXES = (".npy", ".pfm", ".ply", ".png")

DEPTH_MAX = 65535  # millimetres in a .png

_POINT = np.dtype([("position", "<f4", 3), ("colour", "u1", 3)])


def depth(disparity: NDArray[Any], calibration: Calibration) -> NDArray[np.float64]:
    """Depth ``z = focal * baseline / (disparity + offset)``, equation (1-1).

    Parameters
    ----------
    disparity : (H, W) ndarray
        Pixels.
    calibration : Calibration

    Returns
    -------
    (H, W) float64 ndarray
        In the unit of the baseline; ``inf`` where the disparity plus the offset is not above 0.

    Examples
    --------
    >>> depth(np.array([[0, 1, 4]]), Calibration(focal=800, baseline=0.1)).tolist()
    [[inf, 80.0, 20.0]]
    """
    apart = np.asarray(disparity, dtype=np.float64) + calibration.offset
    result = np.full(apart.shape, np.inf)
    np.divide(calibration.focal * calibration.baseline, apart, out=result, where=apart > 0)
    return result


def points(z: NDArray[np.float64], left: NDArray[np.uint8], calibration: Calibration) -> tuple[NDArray[np.float64], NDArray[np.uint8]]:
    """Points of the pixels of finite depth, in the left camera's coordinates: x to the right, y downward, z forward.

    Parameters
    ----------
    z : (H, W) ndarray
        Of :func:`depth`.
    left : (H, W) uint8 ndarray
        Grey levels.
    calibration : Calibration

    Returns
    -------
    positions : (N, 3) float64 ndarray
        In the unit of the baseline.
    levels : (N,) uint8 ndarray

    Examples
    --------
    >>> calibration = Calibration(focal=10, baseline=1, centre=(1, 0))
    >>> points(np.array([[5.0, np.inf, 20.0]]), np.array([[7, 8, 9]], dtype=np.uint8), calibration)[0].tolist()
    [[-0.5, 0.0, 5.0], [2.0, 0.0, 20.0]]
    """
    height, width = z.shape
    cx, cy = calibration.centre or ((width - 1) / 2, (height - 1) / 2)
    y, x = np.nonzero(np.isfinite(z))
    near, focal_y = z[y, x], calibration.focal_y or calibration.focal
    return np.stack([(x - cx) * near / calibration.focal, (y - cy) * near / focal_y, near], axis=-1), left[y, x]


def millimetres(z: NDArray[np.float64], calibration: Calibration) -> tuple[NDArray[np.uint16], int]:
    """Depth in whole millimetres, rounded half up.

    Parameters
    ----------
    z : (H, W) ndarray
        Of :func:`depth`.
    calibration : Calibration
        With ``millimetres``.

    Returns
    -------
    levels : (H, W) uint16 ndarray
        ``1..65535``; 0 where there is no depth, or one beyond 65535 mm.
    far : int
        Number of pixels of finite depth beyond that.

    Examples
    --------
    >>> calibration = Calibration(focal=800, baseline=0.1, millimetres=1000)
    >>> millimetres(np.array([[np.inf, 80.0, 0.0015]]), calibration)
    (array([[0, 0, 2]], dtype=uint16), 1)
    """
    if calibration.millimetres is None:
        raise ValueError("the unit of the baseline is not known")
    rounded = np.floor(z * calibration.millimetres + 0.5)
    far = rounded > DEPTH_MAX
    levels = np.where(far, 0, np.maximum(rounded, 1)).astype(np.uint16)
    return levels, int(np.count_nonzero(far & np.isfinite(z)))


def write_depth(path: str | os.PathLike[str], z: NDArray[np.float64], left: NDArray[np.uint8], calibration: Calibration) -> None:
    """Write depth, whole or not at all; the suffix decides the format (:data:`DEPTH_SUFFIXES`).

    ``.npy`` and ``.pfm`` hold float32 (H, W), ``inf`` where there is no depth; ``.ply`` (binary) holds the coloured points of
    :func:`points`. ``.png`` holds :func:`millimetres`, and a note tells how many pixels are too far for it.
    """
    if Path(path).suffix.lower() == ".png":
        whole, far = millimetres(z, calibration)
        if far:
            note(f"{far} pixels are farther than {DEPTH_MAX} mm, which {path} cannot hold: they have no depth there, as 0; .pfm holds them")
        write_picture(path, whole)
        return
    if Path(path).suffix.lower() != ".ply":
        write_picture(path, z.astype(np.float32))
        return
    positions, levels = points(z, left, calibration)
    cloud = np.empty(len(positions), dtype=_POINT)
    cloud["position"], cloud["colour"] = positions, levels[:, None]
    properties = [f"property float {name}" for name in "xyz"] + [f"property uchar {name}" for name in ("red", "green", "blue")]
    header = ["ply", "format binary_little_endian 1.0", f"element vertex {len(cloud)}", *properties, "end_header", ""]
    with atomic(path) as file:
        file.write("\n".join(header).encode("ascii"))
        file.write(cloud.tobytes())
