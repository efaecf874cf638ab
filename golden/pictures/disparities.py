"""Disparities in files: ground truth, and what a matcher gives."""

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import UserError
from ..notes import note
from .images import write_picture
from .samples import WORD_WHITE, read_samples


__all__ = ["LABEL_SUFFIXES", "TRUTH_SUFFIXES", "check_disparity_output", "read_disparity", "write_disparity", "write_labels"]


LABEL_SUFFIXES = (".npy", ".png", ".pgm", ".pfm", ".txt")  # not JPEG, which changes the labels
TRUTH_SUFFIXES = (".png", ".pgm", ".ppm", ".tif", ".tiff", ".pfm", ".npy")
WIDE_SUFFIXES = (".npy", ".pfm")  # what holds more than bytes

BYTE_MAX = 255

StrPath = str | os.PathLike[str]


def write_labels(path: StrPath, labels: NDArray[Any]) -> None:
    """Write disparities unscaled; the suffix decides the format (:data:`LABEL_SUFFIXES`).

    Parameters
    ----------
    path : path
        ``.npy`` keeps the type of the array; ``.png``, ``.pgm`` and ``.txt`` store bytes; ``.pfm`` stores float32.
    labels : (H, W) integer ndarray
        Pixels, ``0..255``.
    """
    labels = np.asarray(labels)
    if labels.ndim != 2 or labels.dtype.kind not in "iu" or not np.all((labels >= 0) & (labels <= BYTE_MAX)):
        raise ValueError(f"labels are (H, W) whole numbers from 0 to {BYTE_MAX}, not {labels.shape} {labels.dtype}")
    if Path(path).suffix.lower() not in LABEL_SUFFIXES:
        raise UserError(f"{path} has the suffix {Path(path).suffix or '(none)'}; that of labels is one of {', '.join(LABEL_SUFFIXES)}")
    write_picture(path, labels if Path(path).suffix.lower() == ".npy" else labels.astype(np.uint8))


def check_disparity_output(path: StrPath, least: int, greatest: int, fractions: bool, png_scale: int | None) -> None:
    """:class:`UserError` unless :func:`write_disparity` can write disparities ``least .. greatest`` there; for use before computing."""
    suffix, other = Path(path).suffix.lower(), f"choose one of {', '.join(WIDE_SUFFIXES)} for --output"
    if png_scale is not None:
        if suffix != ".png":
            raise UserError(f"--png-scale {png_scale} is for a .png, and {path} is none; leave it out or choose a .png for --output")
        if not 1 <= png_scale <= WORD_WHITE:
            raise UserError(f"--png-scale must be a whole number from 1 to {WORD_WHITE}, not {png_scale}; KITTI's is 256")
        if greatest * png_scale > WORD_WHITE:
            raise UserError(f"{path} holds numbers up to {WORD_WHITE}, but --png-scale {png_scale} and --disparities reach "
                            f"{greatest * png_scale}; choose a --png-scale up to {WORD_WHITE // greatest}")
    elif suffix not in WIDE_SUFFIXES:
        if fractions:
            raise UserError(f"{path} holds whole numbers only, but --sub-pixel gives fractions; {other}, or a .png with --png-scale")
        if greatest > BYTE_MAX:
            raise UserError(f"{path} holds disparities up to {BYTE_MAX}, but --minimum and --disparities reach {greatest}; {other}")
    if suffix not in WIDE_SUFFIXES and least < 0:
        raise UserError(f"{path} holds no disparity below 0, but --minimum is {least}; {other}")


def write_disparity(path: StrPath, disparity: NDArray[Any], least: int, greatest: int, png_scale: int | None = None) -> None:
    """Write disparities; the suffix decides the format, and the range decides the type, whatever the picture holds of it.

    Parameters
    ----------
    path : path
        One of :data:`LABEL_SUFFIXES`. ``.npy`` holds uint8, uint16 or int16, or float32 for fractions; ``.pfm`` float32; ``.png``,
        ``.pgm`` and ``.txt`` bytes.
    disparity : (H, W) ndarray
        Pixels; whole numbers, or fractions if the type is floating-point.
    least, greatest : int
        Range of the disparities, pixels; it must have passed :func:`check_disparity_output`.
    png_scale : int or None
        A ``.png`` holds ``disparity * png_scale`` with 16 bits, rounded half up; 0 would mean unknown, so disparity 0 is 1 there. That is
        KITTI's format, with 256.
    """
    disparity = np.asarray(disparity)
    if png_scale is not None:
        write_picture(path, np.maximum(np.floor(disparity * float(png_scale) + 0.5), 1).astype(np.uint16))
    elif disparity.dtype.kind == "f":
        write_picture(path, disparity.astype(np.float32))  # exact
    elif least < 0:
        write_picture(path, disparity.astype(np.int16))
    elif greatest > BYTE_MAX:
        write_picture(path, disparity.astype(np.uint16))
    else:
        write_labels(path, disparity.astype(np.uint8))


def read_disparity(path: StrPath, scale: float = 1.0, unknown: float | None = None) -> NDArray[np.float64]:
    """Ground truth of a disparity picture: its numbers divided by ``scale``.

    Parameters
    ----------
    path : path
        One of :data:`TRUTH_SUFFIXES`: whole numbers of 8 or 16 bits in ``.png``, ``.pgm`` or ``.tif``, where 0 is unknown; or ``.pfm``,
        ``.npy`` and floating-point ``.tif``, where 0 is a disparity. Grey levels may be stored as RGB or with a palette.
    scale : float
        File units a pixel of disparity.
    unknown : float or None
        The number that marks unknown disparities, in file units, instead of 0. Numbers that are not finite are always unknown.

    Returns
    -------
    (H, W) float64 ndarray
        Pixels; ``inf`` where unknown.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in TRUTH_SUFFIXES:
        raise UserError(f"{path} has the suffix {suffix or '(none)'}; that of a disparity picture is one of {', '.join(TRUTH_SUFFIXES)}")
    values = read_samples(path).numbers
    if values.ndim == 3 and values.shape[2] == 3:
        if (values != values[..., :1]).any():
            raise UserError(f"{path} holds colours, which are no disparities; give the file with the numbers")
        values = values[..., 0]
    if values.ndim != 2 or values.dtype.kind not in "iuf" or values.size == 0:
        raise UserError(f"{path} holds an array of shape {values.shape} and type {values.dtype}; "
                        "a disparity picture is (height, width) numbers")
    mark = 0.0 if unknown is None and suffix != ".npy" and values.dtype.kind in "iu" else unknown
    missing = ~np.isfinite(values)
    if mark is not None:
        with np.errstate(over="ignore"):
            marked = values == float(mark)  # a Python float is rounded as the file's numbers are: -0.1 of 32 bits is not that of 64
        if unknown is not None and np.isfinite(unknown) and not marked.any():
            note(f"no number in {path} is {unknown:.9g}, which marks unknown disparities")
        missing |= marked
    return np.where(missing, np.inf, values.astype(np.float64) / scale)
