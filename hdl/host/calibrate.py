"""`console calibrate`: a calibration of the cameras that the chip receives, guided pair by pair, and loaded into the chip."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from golden.calibrate.pairs import Files, Found
from golden.calibrate.results import calibrate as write_calibration
from golden.calibrate.solve import LEAST_VIEWS
from golden.calibrate.views import Board, Corners, find_corners, opencv, read_board
from golden.errors import UserError
from golden.files import check_folder, output_folder
from golden.notes import note
from golden.pictures.images import read_picture, write_picture
from golden.rig.files import RIG_NAME

from .chip import Chip
from .load_map import check_rectifiers, load_rig


__all__ = ["DEFAULT_PAIRS", "PAIRS", "Grab", "Session", "calibrate", "check_calibration"]


#: Good pairs that are taken by default, and how many may be asked for.
DEFAULT_PAIRS = 13
PAIRS = range(LEAST_VIEWS, 100)

#: Regions of a picture, along a line and down a column.
REGIONS = 3

# A board whose corners are less far, on average, from where they were in an earlier pair, as a part of the picture's width, is there still.
_SAME_PLACE = 1 / 100

Picture = NDArray[np.uint8]

#: Takes a pair of pictures as the cameras send them: left, right, (H, W) uint8 each.
Grab = Callable[[], tuple[Picture, Picture]]


def check_calibration(board: str, square: float, output: Path) -> Board:
    """The board, before anything is taken; :class:`UserError` if it is none, OpenCV is not installed, or the folder cannot be used."""
    result = read_board(board, square)
    opencv()
    check_folder(output)
    if (output / RIG_NAME).exists():
        raise UserError(f"{output} has a calibration already, whose pictures would be used again; load it with rectify, or choose another "
                        "--output")
    return result


class Session:
    """Pairs of pictures taken so far, in a folder, with the corners found in them.

    Parameters
    ----------
    folder : Path
        Pictures are ``left01.png``, ``right01.png`` and so on. Pairs that it has already are taken first.
    board : Board
    size : (int, int)
        Width and height of the pictures, pixels.
    wanted : int
        Good pairs to be taken.

    Attributes
    ----------
    found : Found
    covered : (2, REGIONS, REGIONS) bool ndarray
        Regions of the left and of the right picture in which a corner was found in a good pair.
    """
    def __init__(self, folder: Path, board: Board, size: tuple[int, int], wanted: int):
        self.folder, self.board, self.size, self.wanted = folder, board, size, wanted
        self.found = Found(size)
        self.covered = np.zeros((2, REGIONS, REGIONS), dtype=bool)
        self.number = 0     # of the last pair in the folder
        lefts = sorted(folder.glob("left[0-9]*.png"))
        kept = [self._files(path.stem.removeprefix("left")) for path in lefts if path.stem.removeprefix("left").isdecimal()]
        kept = [pair for pair in kept if pair[1].exists()]
        if kept:
            note(f"{folder} has {len(kept)} pairs of an earlier run, which are used; remove them if the cameras were moved since")
        for pair in kept:
            self.number = max(self.number, int(pair[0].stem.removeprefix("left")))
            print(self._consider(pair, read_picture(pair[0]), read_picture(pair[1]), write=False))

    @property
    def complete(self) -> bool:
        """Whether enough good pairs were taken, with corners in all regions."""
        return len(self.found.views) >= self.wanted and bool(self.covered.all())

    def take(self, left: Picture, right: Picture) -> str:
        """Take a pair, and tell what it is good for.

        Parameters
        ----------
        left, right : (H, W) uint8 ndarray
        """
        return self._consider(self._files(f"{self.number + 1:02}"), left, right, write=True)

    def _files(self, number: str) -> Files:
        return self.folder / f"left{number}.png", self.folder / f"right{number}.png"

    def _consider(self, pair: Files, left: Picture, right: Picture, write: bool) -> str:
        for path, picture in zip(pair, (left, right)):
            if picture.shape[::-1] != self.size:
                raise UserError(f"{path.name} has {picture.shape[1]}x{picture.shape[0]} pixels and the chip's pictures have "
                                f"{self.size[0]}x{self.size[1]}; choose another --output")
        corners = find_corners(left, self.board), find_corners(right, self.board)
        name = f"{pair[0].name} and {pair[1].name}"
        before = self._same_place(*corners)
        if before is not None:
            return f"{name}: the board is where it was in {before}, and the pair is not used; move or turn it"
        if write:
            with output_folder(self.folder):
                for path, picture in zip(pair, (left, right)):
                    write_picture(path, picture)
            self.number += 1
        view = self.found.add(pair, *corners)
        if view is None:
            sides = [side for side, each in zip(("left", "right"), corners) if each is None]
            return f"{name}: no corners in the {' and the '.join(sides)} picture; show the whole board to both cameras, and hold it still"
        for side, each in enumerate((view.left, view.right)):
            column, line = (np.clip(each[:, axis] * REGIONS // self.size[axis], 0, REGIONS - 1).astype(int) for axis in (0, 1))
            self.covered[side, line, column] = True
        return f"{name}: corners in both, {len(self.found.views)} of {self.wanted} good pairs\n{self.regions()}"

    def _same_place(self, left: Corners | None, right: Corners | None) -> str | None:
        """The name of a good pair in which the board was in the same place."""
        if left is None or right is None:
            return None
        for each in self.found.views:
            # In either order: see `golden.calibrate.views.view`.
            apart = min(float(np.abs(each.left - side).mean()) for side in (left, left[::-1]))
            if apart < _SAME_PLACE * self.size[0]:
                return each.name
        return None

    def regions(self) -> str:
        """Which regions have had corners, of both pictures, as text: ``#`` with, ``.`` without."""
        rows = [" ".join("#" if region else "." for region in row) for row in np.concatenate(self.covered, axis=1)]
        return "\n".join(["  left    right", *(f"  {row[:2 * REGIONS - 1]}   {row[2 * REGIONS:]}" for row in rows)])


def _collect(session: Session, grab: Grab) -> None:
    """Take pairs until they are enough, or the user ends it; :class:`UserError` if they are too few then."""
    print(f"show the whole board to both cameras, turned and in another part of the picture each time, and hold it still: {session.wanted} "
          "good pairs; . marks regions still without corners, Ctrl-C ends")
    try:
        while not session.complete:
            print(session.take(*grab()), flush=True)
            if len(session.found.views) >= session.wanted and not session.complete:
                print("show the board where the regions are without corners, or press Ctrl-C to calibrate with these pairs", flush=True)
    except KeyboardInterrupt:
        count = len(session.found.views)
        if count < LEAST_VIEWS:
            raise UserError(f"{count} good pairs were taken, and {LEAST_VIEWS} are needed to calibrate; run this again to go on with those "
                            f"in {session.folder}") from None
        note(f"ended after {count} good pairs")


def calibrate(chip: Chip, grab: Grab, board: Board, output: Path, pairs: int = DEFAULT_PAIRS) -> str:
    """Take pairs of a chessboard, calibrate, and load the maps into the chip.

    Parameters
    ----------
    chip : Chip
    grab : function
        Takes a pair.
    board : Board
    output : Path
        Folder of the pictures and of all that ``golden calibrate`` writes.
    pairs : int
        Good pairs, at least; one of :data:`PAIRS`.

    Returns
    -------
    str
        What is in use, in a line. :class:`UserError` if the chip has no rectifiers, fewer than the least number of pairs are good when the
        user ends it, or as :func:`golden.calibrate.results.calibrate` and :func:`hdl.host.load_map.load_rig` raise it.
    """
    lines = check_rectifiers(chip)
    session = Session(output, board, (chip.read("width"), chip.read("height")), pairs)
    _collect(session, grab)
    return load_rig(chip, write_calibration(session.found, board, output, lines))
