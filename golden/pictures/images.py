"""Pictures in files: grey levels and colours of 8 bits."""

import os
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ..config import MatcherConfig
from ..errors import UserError
from ..files import atomic
from .samples import read_samples
from .text import write_text
from .white import levels, note_few_levels, whites


__all__ = ["PICTURE_SUFFIXES", "colour_map", "grey", "read_colours", "read_pair", "read_picture", "write_picture"]


PICTURE_SUFFIXES = (".npy", ".png", ".pgm", ".pfm", ".txt", ".ppm", ".jpg", ".jpeg")

Levels = NDArray[np.uint8]
StrPath = str | os.PathLike[str]


def grey(rgb: NDArray[Any]) -> Levels:
    """Grey levels of colours, ``0.2989 R + 0.5870 G + 0.1140 B`` rounded half up (MATLAB's ``rgb2gray``).

    Parameters
    ----------
    rgb : (..., 3) integer ndarray
        ``0..255``.

    Returns
    -------
    (...) uint8 ndarray

    Examples
    --------
    >>> grey(np.array([[255, 0, 0], [0, 255, 0], [0, 0, 255], [255, 255, 255]])).tolist()
    [76, 150, 29, 255]
    """
    red, green, blue = np.moveaxis(np.asarray(rgb, dtype=np.int32), -1, 0)
    # Ten-thousandths as integers: in floating point a sum of exactly one half may round either way.
    levels: NDArray[np.int32] = (2989 * red + 5870 * green + 1140 * blue + 5000) // 10000
    return levels.astype(np.uint8)


def read_picture(path: StrPath) -> Levels:
    """Grey levels of a picture file.

    PNG, PGM/PPM, TIFF, JPEG and PFM are recognised by their content, NPY and text pictures by the suffix ``.npy``, ``.txt``. Numbers are
    scaled so that white (:func:`golden.pictures.white.whites`) becomes 255, rounded half up; colours are then converted by :func:`grey`.
    An alpha channel must be opaque. Floating-point files (PFM, TIFF) and NPY have no defined white, so nothing is scaled: their values
    must be whole numbers from 0 to 255.

    Returns
    -------
    (H, W) uint8 ndarray
        ``0..255``. :class:`UserError` if the file is missing or not such a picture.
    """
    return _grey(read_colours(path))


def read_colours(path: StrPath) -> Levels:
    """:func:`read_picture` without conversion of colours: (H, W) or (H, W, 3) uint8, as in the file."""
    return _read([path])[0]


def _read(paths: Sequence[StrPath], white: int | None = None) -> list[Levels]:
    """Pictures of one scene, of the same white."""
    pictures = [read_samples(path) for path in paths]
    for path, (numbers, _) in zip(paths, pictures):
        if numbers.ndim not in (2, 3) or (numbers.ndim == 3 and numbers.shape[2] != 3) or numbers.size == 0:
            raise UserError(f"{path} holds an array of shape {numbers.shape}; a picture is (height, width) or (height, width, 3)")
    taken = whites(pictures, paths, white)
    result = [levels(each.numbers, own, path) for each, own, path in zip(pictures, taken, paths)]
    note_few_levels(pictures, paths, taken)
    return result


def _grey(picture: Levels) -> Levels:
    return grey(picture) if picture.ndim == 3 else picture


def read_pair(left: StrPath, right: StrPath, white: int | None = None) -> tuple[Levels, Levels]:
    """Grey levels of a rectified pair: (H, W) uint8 each, of the same size and at most the greatest width of a matcher.

    Parameters
    ----------
    left, right : path
        As of :func:`read_picture`. Of 16-bit files one white is taken for both, from both.
    white : int or None
        The number that is white in both, ``1..65535``; ``None``: see :func:`golden.pictures.white.whites`. :class:`UserError` if a number
        is above it.
    """
    first, second = (_grey(side) for side in _read([left, right], white))
    sizes = [f"{picture.shape[1]}x{picture.shape[0]}" for picture in (first, second)]
    if sizes[0] != sizes[1]:
        raise UserError(f"the pictures differ in size: {left} has {sizes[0]} pixels, {right} has {sizes[1]}; give a rectified pair")
    if first.shape[1] not in MatcherConfig.WIDTHS:
        raise UserError(f"the pictures are {first.shape[1]} pixels wide, more than the {MatcherConfig.WIDTHS[-1]} that are supported; "
                        "reduce or crop them")
    return first, second


def write_picture(path: StrPath, picture: NDArray[Any]) -> None:
    """Write a picture, whole or not at all; the suffix decides the format (:data:`PICTURE_SUFFIXES`).

    Parameters
    ----------
    path : path
        ``.npy`` stores the array unchanged; ``.pfm`` takes (H, W) numbers and stores float32; ``.txt`` and ``.pgm`` take (H, W) uint8;
        ``.ppm`` takes (H, W, 3) uint8; ``.png`` and ``.jpg`` take both, and ``.png`` takes (H, W) uint16.
    picture : (H, W) or (H, W, 3) ndarray
    """
    picture = np.asarray(picture)
    suffix = Path(path).suffix.lower()
    if suffix not in PICTURE_SUFFIXES:
        raise UserError(f"{path} has the suffix {suffix or '(none)'}; a picture's is one of {', '.join(PICTURE_SUFFIXES)}")
    if suffix == ".pfm":
        picture = picture.astype(np.float32)
    elif suffix != ".npy" and picture.dtype != np.uint8 and not (suffix == ".png" and picture.dtype == np.uint16 and picture.ndim == 2):
        raise ValueError(f"a {suffix} picture is uint8, not {picture.dtype}")
    if (suffix in (".pgm", ".pfm", ".txt") and picture.ndim != 2) or (suffix == ".ppm" and picture.ndim != 3):
        raise ValueError(f"an array of shape {picture.shape} cannot become a {suffix} picture")
    if suffix == ".txt":
        write_text(path, [picture])
        return
    with atomic(path) as file:
        if suffix == ".npy":
            np.lib.format.write_array(file, picture, allow_pickle=False)
        else:
            formats = {".png": "PNG", ".pgm": "PPM", ".ppm": "PPM", ".pfm": "PPM", ".jpg": "JPEG", ".jpeg": "JPEG"}
            Image.fromarray(picture).save(file, format=formats[suffix])


def colour_map(labels: NDArray[Any], disparities: int) -> Levels:
    """Disparities as colours: matplotlib's perceptually uniform *viridis*, nearer is brighter.

    Parameters
    ----------
    labels : (H, W) integer ndarray
        Pixels, ``0 .. disparities - 1``.
    disparities : int
        Number of labels, at least 2; a label's colour depends on this number only.

    Returns
    -------
    (H, W, 3) uint8 ndarray

    Examples
    --------
    >>> colour_map(np.array([[0, 15]]), 16).tolist()
    [[[68, 1, 84], [253, 231, 36]]]
    """
    from matplotlib import colormaps  # here, because it takes longer to load than all the rest

    labels = np.asarray(labels)
    if labels.size and not 0 <= labels.min() <= labels.max() < disparities:
        raise ValueError(f"labels from {labels.min()} to {labels.max()} are not within 0 .. {disparities - 1}")
    colours: Levels = colormaps["viridis"](labels / (disparities - 1), bytes=True)
    return colours[..., :3]
