"""PGM, PPM and PFM: numbers as they are in the file.

Pillow reads these formats too, but it scales 16-bit samples to 0..65535, clips those above the file's greatest value, cuts colours to
8 bits, and takes a surplus blank of a header for data.
"""

import math
import re
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ..errors import UserError


__all__ = ["MAGICS", "read_netpbm"]


MAGICS = (b"P2", b"P3", b"P5", b"P6", b"Pf", b"PF")
_COLOURS = (b"P3", b"P6", b"PF")
_TEXT = (b"P2", b"P3")

# A word of a header, after white space and comments.
_WORD = re.compile(rb"(?:\s|#[^\r\n]*[\r\n])+([^\s#]+)")


def read_netpbm(data: bytes, path: Path) -> tuple[NDArray[Any], int | None]:
    """The numbers of a PGM, PPM or PFM file, and the greatest that its header allows.

    A header may end with CR LF, or with blanks before its line's end, and white space may follow the numbers.

    Parameters
    ----------
    data : bytes
        The file, which begins with one of :data:`MAGICS`.
    path : path
        Its name, for messages.

    Returns
    -------
    numbers : (H, W) or (H, W, 3) ndarray
        uint8 or uint16, unscaled; float32 from PFM, whose scale decides the byte order and is not applied.
    greatest : int or None
        ``1..65535``; ``None`` from PFM. :class:`UserError` if a number is above it, if numbers are missing or surplus, or if the header
        is damaged.
    """
    magic, at = data[:2], 2
    words = []
    for name in ("width", "height", "scale" if magic in (b"Pf", b"PF") else "greatest value"):
        match = _WORD.match(data, at)
        if match is None:
            raise UserError(f"{path} has no {name} in its header; check the file")
        words.append(match[1])
        at = match.end()
    width, height = (_whole(word, path, name) for word, name in zip(words, ("width", "height")))
    shape = (height, width, 3) if magic in _COLOURS else (height, width)
    limit = Image.MAX_IMAGE_PIXELS
    if limit is not None and width * height > limit:
        raise UserError(f"{path} has more than {limit} pixels; reduce it")
    if magic in (b"Pf", b"PF"):
        order = "<f4" if _scale(words[2], path) < 0 else ">f4"
        lines = np.frombuffer(_body(data, at, math.prod(shape) * 4, path), order).reshape(shape)
        return lines[::-1].astype(np.float32), None  # the bottom line is the first
    greatest = _whole(words[2], path, "greatest value", 65535)
    if magic in _TEXT:
        numbers = _words(data[at:], math.prod(shape), path)
    else:
        kind = np.dtype(">u2" if greatest > 255 else "u1")
        numbers = np.frombuffer(_body(data, at, math.prod(shape) * kind.itemsize, path), kind)
    if numbers.max() > greatest:
        raise UserError(f"{path} holds the number {numbers.max()}, above {greatest}, the greatest that its header allows; "
                        "correct the header or the file")
    return numbers.reshape(shape).astype(np.uint16 if greatest > 255 else np.uint8), greatest


def _whole(word: bytes, path: Path, name: str, limit: int | None = None) -> int:
    """A whole number of a header, from 1."""
    text = word.decode("ascii", "replace")[:20]
    if re.fullmatch(r"\d+", text, re.ASCII) is None or int(text) < 1 or (limit is not None and int(text) > limit):
        above = f"from 1 to {limit}" if limit else "above 0"
        raise UserError(f"{path} has the {name} {text} in its header, which is not a whole number {above}; check the file")
    return int(text)


def _scale(word: bytes, path: Path) -> float:
    """The scale of a PFM header, which is negative if the numbers are little-endian."""
    text = word.decode("ascii", "replace")[:20]
    try:
        scale = float(text)
    except ValueError:
        scale = 0.0
    if scale == 0 or not math.isfinite(scale):
        raise UserError(f"{path} has the scale {text} in its header; write -1 if its numbers are little-endian, else 1")
    return scale


def _body(data: bytes, at: int, size: int, path: Path) -> bytes:
    """The ``size`` bytes after a header whose last word ends at ``at``.

    One character of white space separates them. More of it is the header's if it ends that line, and if the numbers are complete without.
    """
    start = at + 1
    line_end = re.compile(rb"[ \t\r]+\n").match(data, at)
    if line_end and len(data) - line_end.end() >= size:
        start = line_end.end()
    found = len(data) - start
    if found < size:
        raise UserError(f"{path} ends after {max(found, 0)} bytes of its numbers, but its header says {size}; the file is cut off")
    if data[start + size:].strip():
        raise UserError(f"{path} is longer than its header says, by {found - size} bytes; correct the header or the file")
    return data[start:start + size]


def _words(text: bytes, count: int, path: Path) -> NDArray[np.int64]:
    """Numbers of a file of text, without its comments."""
    words = re.sub(rb"#[^\r\n]*", b"", text).split()
    if len(words) != count:
        raise UserError(f"{path} holds {len(words)} numbers, but its header says {count}; correct the header or the file")
    wrong = [word for word in words if not re.fullmatch(rb"\d{1,9}", word)]
    if wrong:
        raise UserError(f"{path} holds {wrong[0][:20].decode('ascii', 'replace')!r} where a whole number is expected; check the file")
    return np.array(words, dtype=np.int64)
