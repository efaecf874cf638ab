"""Text pictures, which simulators read with ``$readmemh`` and write with ``$fwrite``.

A comment line ``// WIDTH HEIGHT``, then a line for each picture row: bytes as two hexadecimal digits, wider words as more digits,
separated by spaces. A file holds one picture or several.
"""

import os
import re
from collections.abc import Iterable
from pathlib import Path
from typing import Any, BinaryIO

import numpy as np
from numpy.typing import NDArray

from ..errors import UserError
from ..files import atomic


__all__ = ["read_text", "write_text"]


_HEADER = re.compile(r"// ([0-9]+) ([0-9]+)")


def write_text(file: str | os.PathLike[str] | BinaryIO, pictures: Iterable[NDArray[Any]]) -> None:
    """Write pictures as text.

    Parameters
    ----------
    file : path or binary file
        A path is written whole or not at all.
    pictures : iterable of (H, W) integer ndarray
        Bytes, ``0..255``.

    Examples
    --------
    >>> import sys
    >>> write_text(sys.stdout.buffer, [np.array([[0, 10, 255]])])  # doctest: +SKIP
    // 3 1
    00 0a ff
    """
    lines = []
    for picture in pictures:
        picture = np.asarray(picture)
        if picture.ndim != 2 or picture.size == 0 or picture.dtype.kind not in "iu" or picture.min() < 0 or picture.max() > 255:
            raise ValueError(f"a text picture is (H, W) whole numbers from 0 to 255, not {picture.shape} {picture.dtype}")
        height, width = picture.shape
        lines.append(f"// {width} {height}")
        lines += [row.tobytes().hex(" ") for row in picture.astype(np.uint8)]
    text = "".join(f"{line}\n" for line in lines).encode("ascii")
    if isinstance(file, (str, os.PathLike)):
        with atomic(file) as stream:
            stream.write(text)
    else:
        file.write(text)


def read_text(path: str | os.PathLike[str], digits: int = 2) -> list[NDArray[Any]]:
    """Read all pictures of a text file.

    Parameters
    ----------
    digits : int
        Hexadecimal digits a word, even, up to 8.

    Returns
    -------
    list of (H, W) ndarray
        At least one; uint8, or uint32 of wider words. :class:`UserError` if a header is missing, a row is missing, surplus or ragged, or
        a word is not ``digits`` lower-case hexadecimal digits (a simulator writes unknown bits as ``x``).
    """
    row_form = re.compile(f"[0-9a-f]{{{digits}}}( [0-9a-f]{{{digits}}})*")
    digits_text = {2: "bytes of two", 4: "words of four", 6: "words of six", 8: "words of eight"}[digits]
    try:
        lines = Path(path).read_text(encoding="ascii").splitlines()
    except UnicodeDecodeError:
        raise UserError(f"{path} is not a text picture: it holds bytes that are not ASCII; give one that starts with "
                        "'// WIDTH HEIGHT'") from None
    except OSError as error:
        raise UserError(f"cannot read {path}: {error.strerror}; give the name of a text picture") from error
    pictures: list[NDArray[Any]] = []
    at = 0
    while at < len(lines):
        header = _HEADER.fullmatch(lines[at])
        if header is None:
            raise UserError(f"{path} line {at + 1} is {lines[at][:40]!r} where a picture must start; expected '// WIDTH HEIGHT'")
        width, height = int(header[1]), int(header[2])
        if width == 0 or height == 0:
            raise UserError(f"{path} line {at + 1} gives the size {width}x{height}; a picture has at least 1x1 pixels")
        rows = lines[at + 1:at + 1 + height]
        for number, row in enumerate(rows, at + 2):
            if row_form.fullmatch(row) is None:
                raise UserError(f"{path} line {number} is {row[:40]!r}; expected {width} {digits_text} lower-case hexadecimal digits")
            if (length := (len(row) + 1) // (digits + 1)) != width:
                raise UserError(f"{path} line {number} holds {length} bytes; expected {width}, the width in the header")
        if len(rows) != height:
            raise UserError(f"{path} ends after {len(rows)} rows of its picture {len(pictures) + 1}; expected {height}")
        parts = np.frombuffer(bytes.fromhex("".join(rows)), dtype=np.uint8).reshape(height, width, digits // 2)
        if digits == 2:
            pictures.append(parts[..., 0].copy())
        else:
            weights = 1 << 8 * np.arange(digits // 2 - 1, -1, -1, dtype=np.uint32)
            pictures.append((parts * weights).sum(axis=-1, dtype=np.uint32))
        at += 1 + height
    if not pictures:
        raise UserError(f"{path} is empty; a text picture starts with '// WIDTH HEIGHT'")
    return pictures
