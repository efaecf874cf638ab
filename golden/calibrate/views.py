"""Views of a chessboard: its corners in the pictures of both cameras."""

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import UserError


__all__ = ["Board", "Corners", "View", "find_corners", "opencv", "read_board", "view"]


Corners = NDArray[np.float32]

#: Inner corners that a side of a board may have.
SIDES = range(3, 65)

# Of the classic detector's refinement: half the window, pixels, and its end.
_REFINE_WINDOW = (5, 5)
_REFINE_END = (3, 100, 1e-4)    # after 100 steps, or one of less than that, pixels


def opencv() -> Any:
    """OpenCV; :class:`UserError` if it is not installed."""
    try:
        import cv2  # here, because only calibration needs it
    except ImportError as error:
        raise UserError("calibration needs OpenCV, which is not installed; install the extra lab: pip install -e '.[lab]'") from error
    return cv2


@dataclass(frozen=True)
class Board:
    """A chessboard.

    Parameters
    ----------
    columns, rows : int
        Inner corners a row and a column.
    square : float
        Side of a square, millimetres.
    """
    columns: int
    rows: int
    square: float

    @property
    def points(self) -> NDArray[np.float32]:
        """Its corners, row by row: (N, 3) float32, millimetres; z is 0."""
        result = np.zeros((self.rows * self.columns, 3), dtype=np.float32)
        result[:, :2] = np.mgrid[:self.columns, :self.rows].T.reshape(-1, 2) * self.square
        return result


def read_board(text: str, square: float) -> Board:
    """The board of ``--board 9x6 --square 25``; :class:`UserError` if there is none.

    Examples
    --------
    >>> read_board("9x6", 25)
    Board(columns=9, rows=6, square=25)
    """
    sides = re.fullmatch(r"(\d{1,4})x(\d{1,4})", text)
    if not sides or any(int(each) not in SIDES for each in sides.groups()):
        raise UserError(f"--board is {text}, but must be its inner corners, as in 9x6, from {SIDES[0]} to {SIDES[-1]} each; "
                        "count the corners where four squares meet")
    if not 0.1 <= square <= 10_000:
        raise UserError(f"--square must be the side of a square in millimetres, from 0.1 to 10000, not {square:g}; measure it")
    return Board(int(sides[1]), int(sides[2]), square)


@dataclass(frozen=True)
class View:
    """Corners of the board in a pair of pictures, in the same order.

    Parameters
    ----------
    name : str
        What it is called, for messages.
    left, right : (N, 2) float32 ndarray
        x and y, pixels.
    """
    name: str
    left: Corners
    right: Corners


def find_corners(picture: NDArray[np.uint8], board: Board) -> Corners | None:
    """Corners of the board in a picture, (N, 2) float32; ``None`` if they are not found.

    By OpenCV's sector-based detector, and where it finds none by the classic one, refined.
    """
    cv2 = opencv()
    size = board.columns, board.rows
    found, corners = cv2.findChessboardCornersSB(picture, size, flags=cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY)
    if not found:
        found, corners = cv2.findChessboardCorners(picture, size, flags=cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE)
        if found:
            corners = cv2.cornerSubPix(picture, corners, _REFINE_WINDOW, (-1, -1), _REFINE_END)
    return np.asarray(corners, dtype=np.float32).reshape(-1, 2) if found else None


def view(name: str, left: Corners, right: Corners) -> View:
    """A view of corners whose order may be reversed in one picture: the two detectors begin at different ends of a board."""
    along = [side[-1] - side[0] for side in (left, right)]
    return View(name, left, right[::-1].copy() if along[0] @ along[1] < 0 else right)


def names(paths: Iterable[Path]) -> str:
    """Names of files for a message."""
    return ", ".join(path.name for path in paths)
