"""Pairs of picture files that show a chessboard."""

from collections.abc import Sequence
from dataclasses import dataclass, field
from pathlib import Path

from ..cli import progress
from ..errors import UserError
from ..notes import note
from ..pictures.images import read_picture
from .solve import LEAST_VIEWS
from .views import Board, Corners, View, find_corners, names, view


__all__ = ["Files", "Found", "pair_up", "read_views"]


Files = tuple[Path, Path]   # of the left and of the right picture


def pair_up(paths: Sequence[Path], least: int = LEAST_VIEWS) -> list[Files]:
    """Pairs of files, of which the first half are the left camera's; :class:`UserError` unless there are ``least`` pairs."""
    half, odd = divmod(len(paths), 2)
    if odd or half < least:
        raise UserError(f"{len(paths)} pictures are given, and {least} of the left camera are needed at least, followed by as many "
                        "of the right one; take more")
    return list(zip(paths[:half], paths[half:]))


@dataclass
class Found:
    """Views of a board that were found in pairs of pictures.

    Parameters
    ----------
    size : (int, int)
        Width and height of all pictures, pixels.
    views : list of View
        Pairs in both of which corners are found.
    files : dict of str to (path, path)
        Those of each view, by its name.
    without : list of path
        Pictures without corners.
    left_out : int
        Pairs of which at least one is without.
    """
    size: tuple[int, int]
    views: list[View] = field(default_factory=list)
    files: dict[str, Files] = field(default_factory=dict)
    without: list[Path] = field(default_factory=list)
    left_out: int = 0

    def add(self, pair: Files, left: Corners | None, right: Corners | None) -> View | None:
        """Add the pair of files in whose pictures these corners were found; the view, if there are corners in both."""
        self.without += [path for path, corners in zip(pair, (left, right)) if corners is None]
        if left is None or right is None:
            self.left_out += 1
            return None
        each = view(f"{pair[0].name} and {pair[1].name}", left, right)
        self.views.append(each)
        self.files[each.name] = pair
        return each


def read_views(pairs: Sequence[Files], board: Board) -> Found:
    """Views of a board in pairs of pictures; a note names those without.

    :class:`UserError` if corners are found in no pair, or the pictures differ in size.
    """
    first: tuple[Path, tuple[int, ...]] | None = None
    found: Found | None = None
    with progress() as bar:
        for pair in bar.track(pairs, description="corners"):
            corners = []
            for path in pair:
                picture = read_picture(path)
                first = first or (path, picture.shape)
                if picture.shape != first[1]:
                    raise UserError(f"{path} has {picture.shape[1]}x{picture.shape[0]} pixels and {first[0]} has "
                                    f"{first[1][1]}x{first[1][0]}; take all pictures at one size")
                found = found or Found((picture.shape[1], picture.shape[0]))
                corners.append(find_corners(picture, board))
            if found:
                found.add(pair, corners[0], corners[1])
    if not found:
        raise AssertionError("there are pairs")
    if not found.views:
        raise UserError(f"the corners of a {board.columns}x{board.rows} board are found in no pair, not in {names(found.without)}; check "
                        "--board, and take sharp pictures of the whole board")
    if found.without:
        note(f"no corners of a {board.columns}x{board.rows} board in {names(found.without)}: {found.left_out} pairs are left out")
    return found
