"""Maps from floating-point ones: control points by least squares over all pixels."""

import dataclasses

import numpy as np
from numpy.typing import NDArray

from .lines import row_bounds
from .maps import CELL, GAIN_ONE, SUB_PIXEL, RectifyMap, grid, identity


__all__ = ["control_points", "fit_map"]


Floats = NDArray[np.float64]


def _weights(size: int, points: int) -> Floats:
    """Weight of every control point at every pixel, along one axis: (size, points)."""
    pixel = np.arange(size)
    cell, part = pixel // CELL, pixel % CELL / CELL
    result = np.zeros((size, points))
    result[pixel, cell], result[pixel, cell + 1] = 1 - part, part
    return result


def _fitted(values: Floats, points: int) -> Floats:
    """Control points along the first axis."""
    weights = _weights(len(values), points)
    used = int(weights.any(axis=0).sum())     # the last one has no weight where the size is a multiple of the cell's and one
    result = np.empty((points, values.shape[1]))
    result[:used] = np.linalg.lstsq(weights[:, :used], values, rcond=None)[0]
    result[used:] = result[used - 1]
    return result


def control_points(values: Floats) -> Floats:
    """Control points whose bilinear interpolation is nearest to a value at every pixel, in the sum of squares.

    Parameters
    ----------
    values : (H, W) float ndarray

    Returns
    -------
    (rows, columns) float64 ndarray
        Of the shape that :func:`golden.rig.maps.grid` tells.
    """
    # A product of two bases: first along the lines, then along the columns, is the least-squares solution of both.
    height, width = values.shape
    rows, columns = grid(width, height)
    return _fitted(_fitted(np.asarray(values, dtype=np.float64), rows).T, columns).T


def fit_map(x: Floats, y: Floats, gain: Floats | None = None) -> RectifyMap:
    """The map nearest to a floating-point one, with its row bounds.

    Parameters
    ----------
    x, y : (H, W) float ndarray
        From where every pixel is taken, pixels, as of OpenCV's ``initUndistortRectifyMap``.
    gain : (H, W) float ndarray or None
        Factor of its grey level; ``None``: 1 everywhere.

    Returns
    -------
    RectifyMap
        Displacements rounded to 1/32 pixel, gains to 1/128; :class:`ValueError` if one is beyond the limits of a map.
    """
    height, width = np.shape(x)
    dx, dy = (np.rint(SUB_PIXEL * control_points(source - at)).astype(np.int64)
              for source, at in ((x, np.arange(width)), (y, np.arange(height)[:, None])))
    plain = identity(width, height)
    gains = plain.gain if gain is None else np.rint(GAIN_ONE * control_points(gain)).astype(np.int64)
    whole = dataclasses.replace(plain, dx=dx, dy=dy, gain=gains)
    return dataclasses.replace(whole, bounds=row_bounds(whole))
