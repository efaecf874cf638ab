"""Pictures for looking at a result: errors in colours, and all of it side by side."""

import io
import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .files import atomic


__all__ = ["SHEET_SUFFIXES", "error_map", "write_sheet"]


SHEET_SUFFIXES = (".png", ".svg", ".pdf")

# Grey levels and colours of an error map.
GOOD, UNCOUNTED, BAD, UNKNOWN = (235, 235, 235), (160, 160, 160), (200, 30, 30), (60, 60, 60)

Colours = NDArray[np.uint8]


def error_map(disparity: NDArray[Any], truth: NDArray[Any], mask: NDArray[np.bool_], threshold: float = 1.0) -> Colours:
    """Where a disparity picture is bad: red; good is light, what the mask leaves out is grey, unknown truth is dark.

    Parameters
    ----------
    disparity, truth : (H, W) ndarray
        Pixels; a truth that is not finite is unknown.
    mask : (H, W) bool ndarray
        Pixels that count.
    threshold : float
        Pixels, as in :func:`golden.metrics.bad_pixels`.

    Returns
    -------
    (H, W, 3) uint8 ndarray

    Examples
    --------
    >>> error_map(np.array([[1, 5, 1, 5]]), np.array([[1, 1, np.inf, 1]]), np.array([[True, True, True, False]])).tolist()
    [[[235, 235, 235], [200, 30, 30], [60, 60, 60], [160, 160, 160]]]
    """
    known = np.isfinite(truth)
    bad = np.abs(np.where(known, truth, 0) - disparity) > threshold
    result = np.empty((*known.shape, 3), dtype=np.uint8)
    result[:] = GOOD
    result[bad] = BAD
    result[~mask] = UNCOUNTED
    result[~known] = UNKNOWN
    return result


def write_sheet(path: str | os.PathLike[str], left: NDArray[np.uint8], disparity: NDArray[Any], limits: tuple[int, int],
                truth: tuple[NDArray[np.float64], NDArray[np.bool_]] | None = None, threshold: float = 1.0) -> None:
    """Write the left picture and its disparities side by side, and with a truth that and where the disparities are bad below them.

    Parameters
    ----------
    path : path
        The suffix decides the format (:data:`SHEET_SUFFIXES`).
    left : (H, W) uint8 ndarray
        Grey levels.
    disparity : (H, W) ndarray
        Pixels.
    limits : (int, int)
        Least and greatest disparity of the colour scale, pixels.
    truth : ((H, W) float64 ndarray, (H, W) bool ndarray) or None
        Of :func:`golden.truth.read_truth`.
    threshold : float
        Pixels; a greater error is bad.
    """
    from matplotlib import colormaps  # here, because it takes longer to load than all the rest
    from matplotlib.figure import Figure

    height, width = left.shape
    colours = colormaps["viridis"].with_extremes(bad="black")
    panels: list[tuple[str, Any]] = [("left picture", left), ("disparity", disparity)]
    if truth is not None:
        errors = error_map(disparity, *truth, threshold)
        panels += [("ground truth, black is unknown", np.ma.masked_invalid(truth[0])),
                   (f"red: off by more than {threshold:g} pixel", errors)]
    rows = len(panels) // 2
    # A panel is a third more than 4 inches wide, colour bar and gaps included.
    figure = Figure(figsize=(10, rows * (4.4 * height / width + 0.5)), dpi=110, layout="constrained")
    all_axes = figure.subplots(rows, 2, squeeze=False)
    scale: Any = None
    for axes, (title, picture) in zip(all_axes.flat, panels, strict=True):
        if picture is left:
            axes.imshow(picture, cmap="gray", vmin=0, vmax=255)
        elif picture.ndim == 3:
            axes.imshow(picture, interpolation="nearest")
        else:
            scale = axes.imshow(picture, cmap=colours, vmin=limits[0], vmax=limits[1], interpolation="nearest")
        axes.set_title(title)
        axes.set_axis_off()
    figure.colorbar(scale, ax=all_axes, label="disparity, pixels", shrink=0.8)
    buffer = io.BytesIO()
    figure.savefig(buffer, format=Path(path).suffix.lower()[1:])
    with atomic(path) as file:
        file.write(buffer.getvalue())
