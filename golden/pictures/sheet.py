"""Sheets that show results: disparities, truth and errors in colours, side by side."""

import io
import os
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ..files import atomic
from .metrics import bad_pixels


__all__ = ["SHEET_SUFFIXES", "Strip", "error_map", "save_figure", "small", "write_comparison", "write_judged", "write_sheet"]


SHEET_SUFFIXES = (".png", ".svg", ".pdf")

COLOURS = 96  # of a small PNG

# Grey levels and colours of an error map.
GOOD, UNCOUNTED, BAD, UNKNOWN = (235, 235, 235), (160, 160, 160), (200, 30, 30), (60, 60, 60)

Colours = NDArray[np.uint8]


def _unit(colour: tuple[int, int, int]) -> tuple[float, float, float]:
    """A colour of bytes as Matplotlib has it."""
    red, green, blue = colour
    return red / 255, green / 255, blue / 255


def error_map(disparity: NDArray[Any], truth: NDArray[Any], mask: NDArray[np.bool_], threshold: float = 1.0) -> Colours:
    """Errors as colours: bad pixels red, good ones light, pixels outside the mask grey, unknown truth dark.

    Parameters
    ----------
    disparity, truth : (H, W) ndarray
        Pixels; a truth that is not finite is unknown.
    mask : (H, W) bool ndarray
        Pixels that count.
    threshold : float
        Pixels, as in :func:`golden.pictures.metrics.bad_pixels`.

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


def save_figure(path: str | os.PathLike[str], figure: Any, colours: int | None = None) -> None:
    """Write a figure of matplotlib, whole or not at all; the suffix decides the format (:data:`SHEET_SUFFIXES`).

    ``colours`` reduces a PNG to so many, see :func:`small`.
    """
    suffix = Path(path).suffix.lower()
    buffer = io.BytesIO()
    figure.savefig(buffer, format=suffix[1:])
    data = buffer.getvalue()
    with atomic(path) as file:
        file.write(small(data, colours) if colours and suffix == ".png" else data)


def write_sheet(path: str | os.PathLike[str], left: NDArray[np.uint8], disparity: NDArray[Any], limits: tuple[int, int],
                truth: tuple[NDArray[np.float64], NDArray[np.bool_]] | None = None, threshold: float = 1.0) -> None:
    """Write the left picture and its disparities side by side; below them, if given, the truth and the errors.

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
        Of :func:`golden.pictures.truth.read_truth`.
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
    save_figure(path, figure)


def write_judged(path: str | os.PathLike[str], title: str, left: NDArray[np.uint8], disparities: dict[str, NDArray[Any]],
                 truth: tuple[NDArray[np.float64], NDArray[np.bool_]], limits: tuple[int, int], threshold: float = 1.0) -> None:
    """Write a sheet that judges methods: left picture and ground truth, then each method's disparities and below them its errors.

    Parameters
    ----------
    path : path
        The suffix decides the format (:data:`SHEET_SUFFIXES`).
    title : str
        Of the whole sheet.
    left : (H, W) uint8 ndarray
        Grey levels.
    disparities : dict of str to (H, W) ndarray
        Pixels, by the titles of the methods.
    truth : ((H, W) float64 ndarray, (H, W) bool ndarray)
        Pixels, not finite where unknown; and which pixels count.
    limits : (int, int)
        Least and greatest disparity of the one colour scale, pixels.
    threshold : float
        Pixels; a greater error is bad.
    """
    from matplotlib import colormaps  # here, because it takes longer to load than all the rest
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine
    from matplotlib.patches import Patch

    colours = colormaps["viridis"].with_extremes(bad=_unit(UNKNOWN))
    columns = 1 + len(disparities)
    width = 4.2  # of a panel, inches
    height = width * left.shape[0] / left.shape[1] + 0.3
    figure = Figure(figsize=(columns * width + 0.9, 2 * height + 0.8), dpi=100, layout=ConstrainedLayoutEngine(hspace=0.01, wspace=0.01))
    figure.suptitle(title, fontsize=15)
    all_axes = above, below = figure.subplots(2, columns, squeeze=False)

    def show(axes: Any, title: str, picture: NDArray[Any], **scale: Any) -> Any:
        axes.set_title(title, fontsize=12.5)
        axes.set_axis_off()
        return axes.imshow(picture, interpolation="nearest", **scale)

    scale = {"cmap": colours, "vmin": limits[0], "vmax": limits[1]}
    show(above[0], "left picture", left, cmap="gray", vmin=0, vmax=255)
    image = show(below[0], "ground truth", np.ma.masked_invalid(truth[0]), **scale)
    for top, bottom, (name, disparity) in zip(above[1:], below[1:], disparities.items(), strict=True):
        show(top, name, disparity, **scale)
        bad = bad_pixels(disparity, *truth, threshold)
        show(bottom, f"{bad:.1f} % of the pixels are off by more than {threshold:g}", error_map(disparity, *truth, threshold))
    figure.colorbar(image, ax=all_axes, label="disparity, pixels", pad=0.01, aspect=28, shrink=0.8)
    classes = {GOOD: f"within {threshold:g} pixel of the truth", BAD: f"off by more than {threshold:g} pixel", UNKNOWN: "truth unknown"}
    if not truth[1][np.isfinite(truth[0])].all():
        classes[UNCOUNTED] = "not counted"
    patches = [Patch(facecolor=_unit(colour), edgecolor="black", linewidth=0.5, label=text) for colour, text in classes.items()]
    figure.legend(handles=patches, loc="outside lower center", ncols=len(patches), frameon=False, fontsize=12)
    save_figure(path, figure, colours=256)


@dataclass(frozen=True)
class Strip:
    """A row of a comparison.

    Parameters
    ----------
    name : str
    left : (H, W) uint8 ndarray
        Grey levels.
    disparities : dict of str to (H, W) ndarray
        Pixels, by their titles; black where not finite.
    limits : (int, int)
        Least and greatest disparity of the colour scale, pixels.
    """
    name: str
    left: NDArray[np.uint8]
    disparities: dict[str, NDArray[Any]]
    limits: tuple[int, int]


def write_comparison(path: str | os.PathLike[str], strips: Sequence[Strip]) -> None:
    """Write a row of pictures for every strip: the left picture, and all its disparities in the same colours.

    Parameters
    ----------
    path : path
        The suffix decides the format (:data:`SHEET_SUFFIXES`).
    strips : sequence of Strip
        All with the same number of disparity pictures.
    """
    from matplotlib import colormaps  # here, because it takes longer to load than all the rest
    from matplotlib.figure import Figure
    from matplotlib.layout_engine import ConstrainedLayoutEngine

    colours = colormaps["viridis"].with_extremes(bad="black")
    columns = 1 + len(strips[0].disparities)
    width = 2.1  # of a panel, inches
    heights = [width * strip.left.shape[0] / strip.left.shape[1] + 0.25 for strip in strips]
    layout = ConstrainedLayoutEngine(w_pad=0.02, h_pad=0.02, wspace=0, hspace=0)
    figure = Figure(figsize=(columns * width, sum(heights)), dpi=110, layout=layout)
    all_axes = figure.subplots(len(strips), columns, squeeze=False, gridspec_kw={"height_ratios": heights})
    for row, strip in zip(all_axes, strips, strict=True):
        row[0].imshow(strip.left, cmap="gray", vmin=0, vmax=255)
        for axes, picture in zip(row[1:], strip.disparities.values(), strict=True):
            axes.imshow(np.ma.masked_invalid(picture), cmap=colours, vmin=strip.limits[0], vmax=strip.limits[1])
        for axes, title in zip(row, (strip.name, *strip.disparities), strict=True):
            axes.set_title(title, fontsize=8, pad=3)
            axes.set_axis_off()
    save_figure(path, figure, COLOURS)


def small(png: bytes, colours: int = COLOURS) -> bytes:
    """A PNG reduced to few colours: a fraction of the bytes, with little visible loss."""
    with Image.open(io.BytesIO(png)) as picture:
        few = picture.convert("RGB").quantize(colours, method=Image.Quantize.MEDIANCUT, dither=Image.Dither.NONE)
    buffer = io.BytesIO()
    few.save(buffer, format="PNG", optimize=True)
    return min(buffer.getvalue(), png, key=len)
