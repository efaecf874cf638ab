"""Pictures and disparities in files, through Pillow and NumPy."""

import os
import struct
import warnings
import zlib
from pathlib import Path
from tokenize import TokenError
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageOps, UnidentifiedImageError

from ..config import PIXEL_MAX, MatcherConfig
from ..errors import UserError
from ..files import atomic
from .text import read_text, write_text


__all__ = ["LABEL_SUFFIXES", "PICTURE_SUFFIXES", "colour_map", "grey", "read_colours", "read_disparity", "read_pair", "read_picture",
           "write_labels", "write_picture"]


LABEL_SUFFIXES = (".npy", ".png", ".pgm", ".pfm", ".txt")  # not JPEG, which changes the labels
PICTURE_SUFFIXES = (*LABEL_SUFFIXES, ".ppm", ".jpg", ".jpeg")

# Exceptions of Pillow's and NumPy's decoders on damaged files.
DAMAGED = OSError, ValueError, SyntaxError, TypeError, EOFError, IndexError, OverflowError, struct.error, zlib.error, TokenError

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


def _open(path: StrPath) -> NDArray[Any]:
    """The numbers in a picture file, unscaled: (H, W), or (H, W, 3) for colours; uint8, uint16 or, from PFM and NPY, any type."""
    path = Path(path)
    if path.is_dir():
        raise UserError(f"{path} is a folder; give the name of a picture in it")
    try:
        if path.suffix.lower() == ".npy":
            with path.open("rb") as file:
                return np.lib.format.read_array(file, allow_pickle=False)
        if path.suffix.lower() == ".txt":
            pictures = read_text(path)
            if len(pictures) > 1:
                raise UserError(f"{path} holds {len(pictures)} pictures where one is expected; split it")
            return pictures[0]
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of metadata that do not matter here
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            with Image.open(path, formats=("PNG", "PPM", "JPEG")) as picture:
                return _levels(ImageOps.exif_transpose(picture), path)
    except UserError:
        raise
    except FileNotFoundError:
        raise UserError(f"{path} does not exist; give the name of a picture") from None
    except (Image.DecompressionBombError, Image.DecompressionBombWarning):
        raise UserError(f"{path} has more than {Image.MAX_IMAGE_PIXELS} pixels; reduce it") from None
    except UnidentifiedImageError:
        raise UserError(f"{path} is not a PNG, JPEG, PGM, PPM, grey PFM, NPY or text picture; convert it to one of these") from None
    except DAMAGED as error:
        raise UserError(f"{path} cannot be read as a picture: {error}; check the file") from error


def _levels(picture: Image.Image, path: Path) -> NDArray[Any]:
    """The numbers of an opened picture: see :func:`_open`."""
    if picture.mode in ("LA", "PA", "RGBA") or "transparency" in picture.info:
        picture = picture.convert("RGBA")
        if picture.getchannel("A").getextrema() != (255, 255):
            raise UserError(f"{path} has transparent pixels, whose grey level is not defined; flatten it first")
    match picture.mode:
        case "1":
            return np.asarray(picture.convert("L"))
        case "P" | "RGBA":
            return np.asarray(picture.convert("RGB"))
        case "L" | "RGB" | "F":
            return np.asarray(picture)
        case "I;16" | "I":  # 16-bit PNG; 16-bit PGM, which Pillow scales to 0..65535
            return np.asarray(picture).astype(np.uint16)
    raise UserError(f"{path} is a picture of mode {picture.mode}; convert it to grey levels or RGB")


def read_picture(path: StrPath) -> Levels:
    """Grey levels of a picture file.

    PNG, PGM/PPM, JPEG and PFM are recognised by their content, NPY and text pictures by the suffix ``.npy``, ``.txt``. Colours are
    converted by :func:`grey`. 16-bit grey levels are scaled (65535 becomes 255, rounded half up). An alpha channel must be opaque.
    Floating-point files (PFM, NPY) have no defined white level, so nothing is scaled: their values must be whole numbers from 0 to 255.

    Returns
    -------
    (H, W) uint8 ndarray
        ``0..255``. :class:`UserError` if the file is missing or not such a picture.
    """
    levels = read_colours(path)
    return grey(levels) if levels.ndim == 3 else levels


def read_colours(path: StrPath) -> Levels:
    """:func:`read_picture` without conversion of colours: (H, W) or (H, W, 3) uint8, as in the file."""
    levels = _open(path)
    if levels.ndim not in (2, 3) or (levels.ndim == 3 and levels.shape[2] != 3) or levels.size == 0:
        raise UserError(f"{path} holds an array of shape {levels.shape}; a picture is (height, width) or (height, width, 3)")
    if levels.dtype == np.uint16 and Path(path).suffix.lower() != ".npy":
        levels = (levels.astype(np.int32) + 128) // 257
    if levels.dtype != np.uint8:
        # The comparisons are such that a NaN fails.
        if levels.dtype.kind not in "iuf" or not np.all((levels >= 0) & (levels <= PIXEL_MAX) & (levels == np.floor(levels))):
            raise UserError(f"{path} holds {levels.dtype} values, not all of which are whole numbers from 0 to 255; "
                            "scale it to 8-bit grey levels")
        levels = levels.astype(np.uint8)
    return levels


def read_pair(left: StrPath, right: StrPath) -> tuple[Levels, Levels]:
    """Grey levels of a rectified pair: (H, W) uint8 each, of the same size and at most the greatest width of a matcher."""
    pair = read_picture(left), read_picture(right)
    sizes = [f"{picture.shape[1]}x{picture.shape[0]}" for picture in pair]
    if sizes[0] != sizes[1]:
        raise UserError(f"the pictures differ in size: {left} has {sizes[0]} pixels, {right} has {sizes[1]}; give a rectified pair")
    if pair[0].shape[1] not in MatcherConfig.WIDTHS:
        raise UserError(f"the pictures are {pair[0].shape[1]} pixels wide, more than the {MatcherConfig.WIDTHS[-1]} that are supported; "
                        "reduce or crop them")
    return pair


def write_picture(path: StrPath, picture: NDArray[Any]) -> None:
    """Write a picture, whole or not at all; the suffix decides the format (:data:`PICTURE_SUFFIXES`).

    Parameters
    ----------
    path : path
        ``.npy`` stores the array unchanged; ``.pfm`` takes (H, W) numbers and stores float32; ``.txt`` and ``.pgm`` take (H, W) uint8;
        ``.ppm`` takes (H, W, 3) uint8; ``.png`` and ``.jpg`` take both.
    picture : (H, W) or (H, W, 3) ndarray
    """
    picture = np.asarray(picture)
    suffix = Path(path).suffix.lower()
    if suffix not in PICTURE_SUFFIXES:
        raise UserError(f"{path} has the suffix {suffix or '(none)'}; a picture's is one of {', '.join(PICTURE_SUFFIXES)}")
    if suffix == ".pfm":
        picture = picture.astype(np.float32)
    elif suffix != ".npy" and picture.dtype != np.uint8:
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
    values = _open(path)
    if values.ndim != 2 or values.dtype.kind not in "iuf":
        raise UserError(f"{path} holds an array of shape {values.shape} and type {values.dtype}; "
                        "a disparity picture is (height, width) numbers")
    values = values.astype(np.float64)
    unknown = values == 0 if suffix == ".png" else ~np.isfinite(values)
    return np.where(unknown, np.inf, values / scale)


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
