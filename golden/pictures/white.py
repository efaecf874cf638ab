"""White: which number in a picture file becomes the grey level 255."""

import argparse
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..config import PIXEL_MAX
from ..errors import UserError
from ..notes import note
from .samples import WORD_WHITE, Samples


__all__ = ["add_white_option", "check_white", "levels", "note_few_levels", "whites"]


# Which part of the pixels must have more than how many grey levels.
_NEARLY_ALL = 0.99
_FEW = 16


def add_white_option(parser: argparse._ActionsContainer) -> None:
    """Add ``--white``, for :func:`check_white` and :func:`golden.pictures.images.read_pair`."""
    parser.add_argument("--white", type=int, metavar="W", help=(
        f"number in LEFT and RIGHT that is white, 1 to {WORD_WHITE}; 1023 for a 10-bit camera (default: what the file says; of 16-bit "
        "files the least of 255, 511, 1023 .. 65535 that no pixel of the two exceeds)"))


def check_white(options: argparse.Namespace, pictures: bool) -> None:
    """:class:`UserError` if ``--white`` is given and is not possible, or if there are no pictures that it is for."""
    if options.white is None:
        return
    if not 1 <= options.white <= WORD_WHITE:
        raise UserError(f"--white must be a whole number from 1 to {WORD_WHITE}, not {options.white}; give the camera's greatest number")
    if not pictures:
        raise UserError(f"--white {options.white} is for LEFT and RIGHT, which are missing; give them or leave it out")


def whites(pictures: Sequence[Samples], names: Sequence[Any], white: int | None = None) -> list[int]:
    """White of each picture of a set that was taken with like cameras.

    That is ``white`` if given, else what each file says. Files of 16 bits do not say how many of them the camera has: white is then the
    least ``2**b - 1`` with ``b`` from 8 to 16 that no number of any of the pictures exceeds, and a note says so unless it is 65535.

    Parameters
    ----------
    pictures : sequence of Samples
    names : sequence of path
        Names of their files, for messages.
    white : int or None

    Returns
    -------
    list of int
        :class:`UserError` if some are of 16 bits, and others say what is white.
    """
    if white is not None:
        return [white] * len(pictures)
    wide = [each for each in pictures if each.white is None]
    if not wide:
        return [each.white for each in pictures if each.white is not None]
    if len(wide) < len(pictures):
        first, other = names[[each.white for each in pictures].index(None)], next(n for n, each in zip(names, pictures) if each.white)
        raise UserError(f"{first} has 16 bits and {other} has not, so their white is not the same; store both with the "
                        "same number of bits, or give --white if one number is white in both")
    bits = max(PIXEL_MAX.bit_length(), *(int(each.numbers.max(initial=0)).bit_length() for each in wide))
    found: int = 2**bits - 1
    if found != WORD_WHITE:
        told = " and ".join(str(name) for name in names)
        use = "use" if len(names) > 1 else "uses"
        note(f"{told} {use} {bits} of 16 bits: {found} is taken as white (--white {found}); --white {WORD_WHITE} would leave them dark")
    return [found] * len(pictures)


def note_few_levels(pictures: Sequence[Samples], names: Sequence[Any], taken: Sequence[int]) -> None:
    """A note if pictures of more than 8 bits give few grey levels: white is too far above nearly all of their numbers.

    Parameters
    ----------
    pictures : sequence of Samples
    names : sequence of path
        Names of their files.
    taken : sequence of int
        White of each.
    """
    if max(taken) <= PIXEL_MAX:
        return
    parts = [np.percentile(each.numbers, 100 * _NEARLY_ALL) / white for each, white in zip(pictures, taken)]
    if max(parts) * PIXEL_MAX < _FEW:
        note(f"{_NEARLY_ALL:.0%} of the pixels of {' and '.join(map(str, names))} are below {_FEW} of 255 grey levels, because white is "
             f"{max(taken)}; if that of the camera is less, correct the pixels above it and give --white")


def levels(numbers: NDArray[Any], white: int, path: Any) -> NDArray[np.uint8]:
    """Grey levels or colours: ``numbers * 255 / white`` rounded half up, in exact integers.

    Parameters
    ----------
    numbers : ndarray
        Whole numbers from 0 to ``white``, of any type; :class:`UserError` if one is not.
    white : int
        ``1..65535``.
    path : path
        Name of the file, for messages.

    Examples
    --------
    >>> levels(np.array([0, 2, 3, 511, 512, 1023]), 1023, "a.png").tolist()
    [0, 0, 1, 127, 128, 255]
    """
    # The comparisons are such that a NaN fails.
    if numbers.dtype.kind not in "iuf" or not np.all((numbers >= 0) & (numbers <= white) & (numbers == np.floor(numbers))):
        greatest = f", and {numbers.max():g} at most" if numbers.dtype.kind in "iuf" else ""
        raise UserError(f"{path} holds {numbers.dtype} values{greatest}, not all of which are whole numbers from 0 to {white}; "
                        "correct --white where there is one, or scale it to 8-bit grey levels")
    if white == PIXEL_MAX:
        return numbers.astype(np.uint8)
    doubled: NDArray[np.int64] = (2 * PIXEL_MAX * numbers.astype(np.int64) + white) // (2 * white)
    return doubled.astype(np.uint8)
