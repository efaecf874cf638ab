"""Stereo pairs with ground truth: the four of the Middlebury benchmark, and the one that ships with scikit-image."""

import argparse
import os
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import UserError
from .disparities import read_disparity
from .images import grey, read_pair, read_picture


__all__ = ["MASKS", "PAIRS", "StereoPair", "add_data_option", "data_folder", "load_pair", "load_pairs", "motorcycle", "read_mask",
           "same_size"]


# Name: (number of disparities, units of the disparity picture a pixel), both given by the benchmark.
PAIRS = {"tsukuba": (16, 16), "venus": (20, 8), "teddy": (60, 4), "cones": (60, 4)}
MASKS = ("nonocc", "all", "disc")


@dataclass(frozen=True)
class StereoPair:
    """A rectified pair with its ground truth.

    Parameters
    ----------
    name : str
    left, right : (H, W) uint8 ndarray
        Grey levels; ``left[y, x]`` matches ``right[y, x - d]``.
    truth : (H, W) float64 ndarray
        Disparities of the left picture, pixels; ``inf`` where unknown.
    masks : dict of str to (H, W) bool ndarray
        Pixels that count, by the name of the figure.
    disparities : int
        Number of labels that covers the truth.
    """
    name: str
    left: NDArray[np.uint8]
    right: NDArray[np.uint8]
    truth: NDArray[np.float64]
    masks: dict[str, NDArray[np.bool_]]
    disparities: int


def add_data_option(parser: argparse.ArgumentParser, option: str = "--data", sets: bool = False, several: bool = False) -> None:
    """Add ``--data``, or an option of another name, for :func:`data_folder`.

    ``sets``: the command takes other sets, too; ``several``: from any number of folders.
    """
    others = ", or of other sets, see docs/data.md" if sets else ""
    parser.add_argument(option, type=Path, metavar="DIR", nargs="+" if several else None,
                        help=f"{'folders' if several else 'folder'} of {', '.join(PAIRS)}{others} "
                             "(default: $STEREO_DATA, else ../shared/data/middlebury)")


def data_folder(data: str | os.PathLike[str] | None = None) -> Path:
    """The folder of the Middlebury pairs: ``data``, else ``$STEREO_DATA``, else ``../shared/data/middlebury`` from the repository's root.

    :class:`UserError` if it does not exist.
    """
    default = Path(__file__).resolve().parents[3] / "shared" / "data" / "middlebury"
    folder = Path(data or os.environ.get("STEREO_DATA") or default)
    if not folder.is_dir():
        raise UserError(f"the data folder {folder} does not exist; name the one that holds {', '.join(PAIRS)} with --data or STEREO_DATA")
    return folder


def load_pair(folder: str | os.PathLike[str], name: str) -> StereoPair:
    """One pair of the Middlebury benchmark, version 2.

    Parameters
    ----------
    folder : path
        Of :func:`data_folder`. Its folder ``name`` holds ``left.png``, ``right.png``, ``disp_left.png`` (0 is unknown) and a mask
        for each of :data:`MASKS`, in which 255 counts.
    name : str
        One of :data:`PAIRS`.
    """
    disparities, scale = PAIRS[name]
    files = Path(folder) / name
    left, right = read_pair(files / "left.png", files / "right.png")
    truth = read_disparity(files / "disp_left.png", scale)
    same_size(files / "disp_left.png", truth, left)
    return StereoPair(name, left, right, truth, {mask: read_mask(files / f"{mask}.png", left) for mask in MASKS}, disparities)


def load_pairs(data: str | os.PathLike[str] | None = None, names: Iterable[str] | None = None) -> list[StereoPair]:
    """Pairs of the benchmark by their names, all by default, from the folder of :func:`data_folder`."""
    folder = data_folder(data)
    return [load_pair(folder, name) for name in (PAIRS if names is None else names)]


def read_mask(path: str | os.PathLike[str], left: NDArray[np.uint8]) -> NDArray[np.bool_]:
    """A mask of the size of the left picture: the pixels that are 255."""
    mask: NDArray[np.bool_] = read_picture(path) == 255
    same_size(path, mask, left)
    return mask


def same_size(path: str | os.PathLike[str], array: NDArray[Any], left: NDArray[np.uint8]) -> None:
    """:class:`UserError` unless what was read from ``path`` has the size of the left picture."""
    if array.shape != left.shape:
        raise UserError(f"{path} and its left picture differ in size: {array.shape} and {left.shape}; restore the data folder")


def _blocks(picture: NDArray[Any], factor: int) -> NDArray[Any]:
    """The pixels of every ``factor x factor`` block on the last axis; a remainder at the right and at the bottom is cut off."""
    height, width = (size // factor for size in picture.shape)
    blocks = picture[:height * factor, :width * factor].reshape(height, factor, width, factor)
    return blocks.swapaxes(1, 2).reshape(height, width, factor * factor)


def _reduce_levels(picture: NDArray[np.uint8], factor: int) -> NDArray[np.uint8]:
    """Mean of every block, rounded half up."""
    area = factor * factor
    total: NDArray[np.int64] = _blocks(picture, factor).sum(axis=-1, dtype=np.int64)
    return ((2 * total + area) // (2 * area)).astype(np.uint8)


def _reduce_truth(truth: NDArray[np.floating], factor: int) -> NDArray[np.float64]:
    """Lower median of the known disparities of every block, in reduced pixels; ``inf`` where fewer than half are known.

    A median, not a mean: at the boundary of a near and a far object it is one of their disparities, where the mean would be neither.
    """
    blocks = np.sort(_blocks(truth, factor).astype(np.float64), axis=-1)  # inf is sorted to the end
    known = np.isfinite(blocks).sum(axis=-1)
    median = np.take_along_axis(blocks, (np.maximum(known, 1) - 1)[..., None] // 2, axis=-1)[..., 0]
    return np.where(2 * known >= factor * factor, median / factor, np.inf)


def motorcycle(factor: int = 4, max_width: int = 180, max_height: int = 120) -> StereoPair:
    """The Motorcycle pair (Middlebury 2014) that ships with scikit-image, reduced so that its simulation is short.

    Parameters
    ----------
    factor : int
        The pair of 741x500 pixels is divided by this: grey levels by the mean of every block, disparities by the median.
    max_width, max_height : int
        Pixels; larger pictures are cropped around the centre, at the same columns in both, so disparities do not change.

    Returns
    -------
    StereoPair
        With one mask, ``"known"``.
    """
    try:
        from skimage.data import stereo_motorcycle  # here, because only the demonstration needs it
    except ImportError as error:
        raise UserError("the Motorcycle pair is part of scikit-image, which is not installed; install it or give LEFT and RIGHT") from error
    left, right, truth = stereo_motorcycle()
    height, width = truth.shape[0] // factor, truth.shape[1] // factor
    x, y = max(0, width - max_width) // 2, max(0, height - max_height) // 2
    crop = slice(y, y + min(height, max_height)), slice(x, x + min(width, max_width))
    left, right = (_reduce_levels(grey(side), factor)[crop] for side in (left, right))
    truth = _reduce_truth(truth, factor)[crop]
    known = np.isfinite(truth)
    return StereoPair("motorcycle", left, right, truth, {"known": known}, int(np.ceil(truth[known].max())) + 1)
