"""The numbers in picture files, unscaled, through Pillow and NumPy."""

import os
import struct
import warnings
import zlib
from pathlib import Path
from tokenize import TokenError
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageOps, UnidentifiedImageError

from ..errors import UserError
from .netpbm import MAGICS, read_netpbm
from .text import read_text


__all__ = ["Samples", "read_samples"]


BYTE_WHITE = 255
WORD_WHITE = 65535

_TIFF = (b"II*\0", b"MM\0*")

# Its tags: bits of each sample, and what 0 means.
_BITS, _PHOTOMETRIC = 258, 262

# Exceptions of Pillow's and NumPy's decoders on damaged files.
DAMAGED = OSError, ValueError, SyntaxError, TypeError, EOFError, IndexError, OverflowError, struct.error, zlib.error, TokenError


class Samples(NamedTuple):
    """What is in a picture file.

    Parameters
    ----------
    numbers : (H, W) or (H, W, 3) ndarray
        uint8 or uint16; from PFM, TIFF and NPY any type. An NPY file may have any shape.
    white : int or None
        The number that is white: 255 of bytes, the greatest value of a PGM or PPM, ``2**bits - 1`` of a TIFF. ``None`` if the file has 16
        bits, of which a camera may use fewer. Numbers without a defined white (PFM, NPY, wide TIFF) have 255: they are not scaled.
    """
    numbers: NDArray[Any]
    white: int | None


def read_samples(path: str | os.PathLike[str]) -> Samples:
    """The samples of a picture file.

    PNG, PGM, PPM, PFM, TIFF and JPEG are recognised by their content, NPY and text pictures by the suffix ``.npy``, ``.txt``.
    :class:`UserError` if the file is missing, damaged, not such a picture or one that Pillow would change: with transparent pixels, with
    colours of 16 bits, or with several pictures.
    """
    path = Path(path)
    if path.is_dir():
        raise UserError(f"{path} is a folder; give the name of a picture in it")
    try:
        if path.suffix.lower() == ".npy":
            with path.open("rb") as file:
                return Samples(np.lib.format.read_array(file, allow_pickle=False), BYTE_WHITE)
        if path.suffix.lower() == ".txt":
            pictures = read_text(path)
            if len(pictures) > 1:
                raise UserError(f"{path} holds {len(pictures)} pictures where one is expected; split it")
            return Samples(pictures[0], BYTE_WHITE)
        with path.open("rb") as file:
            if file.read(2) in MAGICS:
                file.seek(0)
                numbers, greatest = read_netpbm(file.read(), path)
                return Samples(numbers, None if greatest == WORD_WHITE else greatest or BYTE_WHITE)
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")  # of metadata that do not matter here
            warnings.simplefilter("error", Image.DecompressionBombWarning)
            with Image.open(path, formats=("PNG", "PPM", "JPEG", "TIFF")) as picture:
                return _samples(picture, path)
    except UserError:
        raise
    except FileNotFoundError:
        raise UserError(f"{path} does not exist; give the name of a picture") from None
    except (Image.DecompressionBombError, Image.DecompressionBombWarning):
        raise UserError(f"{path} has more than {Image.MAX_IMAGE_PIXELS} pixels; reduce it") from None
    except UnidentifiedImageError:
        with path.open("rb") as file:
            if file.read(4) in _TIFF:
                raise UserError(f"{path} is a TIFF of a kind that Pillow cannot read, such as one with packed samples of 10 or 14 bits; "
                                "store it with 8 or 16 bits") from None
        raise UserError(f"{path} is not a PNG, JPEG, TIFF, PGM, PPM, PFM, NPY or text picture; convert it to one of these") from None
    except DAMAGED as error:
        raise UserError(f"{path} cannot be read as a picture: {error}; check the file") from error


def _samples(picture: Image.Image, path: Path) -> Samples:
    """The samples of an opened picture."""
    form, tags = picture.format, dict(getattr(picture, "tag_v2", {}))
    if form == "TIFF" and getattr(picture, "n_frames", 1) > 1:
        raise UserError(f"{path} holds {picture.n_frames} pictures where one is expected; split it")  # type: ignore[attr-defined]
    bits = int(max(tags.get(_BITS, (8,)))) if form == "TIFF" else _png_bits(path) if form == "PNG" else 8
    if bits > 8 and (len(picture.getbands()) > 1 or "transparency" in picture.info):
        raise UserError(f"{path} has colours or transparency of {bits} bits, which Pillow cuts to 8; "
                        "convert it to grey levels of 16 bits, or to 8 bits")
    if bits > 8 and tags.get(_PHOTOMETRIC) == 0:
        raise UserError(f"{path} has grey levels of {bits} bits in which 0 is white; invert it so that 0 is black")
    picture = ImageOps.exif_transpose(picture)
    if picture.mode in ("LA", "PA", "RGBA") or "transparency" in picture.info:
        picture = picture.convert("RGBA")
        if picture.getchannel("A").getextrema() != (255, 255):
            raise UserError(f"{path} has transparent pixels, whose grey level is not defined; flatten it first")
    match picture.mode:
        case "1":
            return Samples(np.asarray(picture.convert("L")), BYTE_WHITE)
        case "P" | "RGBA":
            return Samples(np.asarray(picture.convert("RGB")), BYTE_WHITE)
        case "L" | "RGB" | "F":
            return Samples(np.asarray(picture), BYTE_WHITE)
        case "I;16" | "I;16B":
            return Samples(np.asarray(picture).astype(np.uint16), None if bits == 16 else 2**bits - 1)
        case "I" if form == "TIFF":
            return Samples(np.asarray(picture), BYTE_WHITE)
        case "I":  # what some versions of Pillow make of a 16-bit PNG
            return Samples(np.asarray(picture).astype(np.uint16), None)
    raise UserError(f"{path} is a picture of mode {picture.mode}; convert it to grey levels or RGB")


def _png_bits(path: Path) -> int:
    """Bits of a sample of a PNG, from its header: Pillow does not tell that it has cut colours."""
    with path.open("rb") as file:
        return file.read(25)[24]
