"""Disparities in files: ground truth, and labels."""

import os
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import UserError
from .images import write_picture
from .samples import read_samples


__all__ = ["LABEL_SUFFIXES", "read_disparity", "write_labels"]


LABEL_SUFFIXES = (".npy", ".png", ".pgm", ".pfm", ".txt")  # not JPEG, which changes the labels

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
    if labels.ndim != 2 or labels.dtype.kind not in "iu" or not np.all((labels >= 0) & (labels <= 255)):
        raise ValueError(f"labels are (H, W) whole numbers from 0 to 255, not {labels.shape} {labels.dtype}")
    if Path(path).suffix.lower() not in LABEL_SUFFIXES:
        raise UserError(f"{path} has the suffix {Path(path).suffix or '(none)'}; that of labels is one of {', '.join(LABEL_SUFFIXES)}")
    write_picture(path, labels if Path(path).suffix.lower() == ".npy" else labels.astype(np.uint8))


def read_disparity(path: StrPath, scale: float = 1.0) -> NDArray[np.float64]:
    """Ground truth of a disparity picture: its numbers divided by ``scale``.

    Parameters
    ----------
    path : path
        ``.png`` (8 or 16 bits, grey; 0 is unknown), ``.pfm`` or ``.npy`` (0 is a disparity; values that are not finite are unknown).
    scale : float
        File units a pixel of disparity.

    Returns
    -------
    (H, W) float64 ndarray
        Pixels; ``inf`` where unknown.
    """
    suffix = Path(path).suffix.lower()
    if suffix not in (".png", ".pfm", ".npy"):
        raise UserError(f"{path} has the suffix {suffix or '(none)'}; that of a disparity picture is one of .png, .pfm, .npy")
    values = read_samples(path).numbers
    if values.ndim != 2 or values.dtype.kind not in "iuf":
        raise UserError(f"{path} holds an array of shape {values.shape} and type {values.dtype}; "
                        "a disparity picture is (height, width) numbers")
    values = values.astype(np.float64)
    unknown = values == 0 if suffix == ".png" else ~np.isfinite(values)
    return np.where(unknown, np.inf, values / scale)
