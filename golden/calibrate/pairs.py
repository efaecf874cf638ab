"""Pairs of picture files that show a chessboard."""

from collections.abc import Sequence
from pathlib import Path

from ..cli import progress
from ..errors import UserError
from ..notes import note
from ..pictures.images import read_picture
from .solve import LEAST_VIEWS
from .views import Board, View, find_corners, names, view


__all__ = ["Files", "pair_up", "read_views"]


Files = tuple[Path, Path]   # of the left and of the right picture


def pair_up(paths: Sequence[Path], least: int = LEAST_VIEWS) -> list[Files]:
    """Pairs of files, of which the first half are the left camera's; :class:`UserError` unless there are ``least`` pairs."""
    half, odd = divmod(len(paths), 2)
    if odd or half < least:
        raise UserError(f"{len(paths)} pictures are given, and {least} of the left camera are needed at least, followed by as many "
                        "of the right one; take more")
    return list(zip(paths[:half], paths[half:]))


def read_views(pairs: Sequence[Files], board: Board) -> tuple[list[View], dict[str, Files], list[Path], tuple[int, int]]:
    """Views of a board in pairs of pictures.

    Returns
    -------
    views : list of View
        Pairs in both of which corners are found; :class:`UserError` if there is none, or the pictures differ in size.
    files : dict of str to (path, path)
        Those of each view, by its name.
    without : list of path
        Pictures without corners, which a note names.
    size : (int, int)
        Width and height of all pictures, pixels.
    """
    views, files, without = list[View](), dict[str, Files](), list[Path]()
    first: tuple[Path, tuple[int, ...]] | None = None
    with progress() as bar:
        for pair in bar.track(pairs, description="corners"):
            found = []
            for path in pair:
                picture = read_picture(path)
                first = first or (path, picture.shape)
                if picture.shape != first[1]:
                    raise UserError(f"{path} has {picture.shape[1]}x{picture.shape[0]} pixels and {first[0]} has "
                                    f"{first[1][1]}x{first[1][0]}; take all pictures at one size")
                corners = find_corners(picture, board)
                found.append(corners)
                if corners is None:
                    without.append(path)
            name = f"{pair[0].name} and {pair[1].name}"
            if found[0] is not None and found[1] is not None:
                views.append(view(name, found[0], found[1]))
                files[name] = pair
    if not views:
        raise UserError(f"the corners of a {board.columns}x{board.rows} board are found in no pair, not in {names(without)}; check "
                        "--board, and take sharp pictures of the whole board")
    if without:
        note(f"no corners of a {board.columns}x{board.rows} board in {names(without)}: {len(pairs) - len(views)} pairs are left out")
    if first is None:
        raise AssertionError("there are pairs")
    return views, files, without, (first[1][1], first[1][0])
