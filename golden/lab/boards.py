"""`python -m golden boards`: disparities of real cameras, with the plane of a chessboard as truth."""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw
from rich.table import Table

from ..calibrate.pairs import pair_up, read_views
from ..calibrate.rectified import corners_after
from ..calibrate.views import Board, View, read_board
from ..cli import Parser, progress
from ..config import MatcherConfig
from ..errors import UserError, run_cli
from ..matcher.matcher import disparities
from ..matcher.parameters import NAMED, default_parameters
from ..pictures.images import read_picture
from ..pictures.metrics import bad_pixels
from ..rig.balance import balance
from ..rig.files import Rig, read_rig
from ..tables import print_table


__all__ = ["Plane", "main", "plane"]


ROWS = {"seen": "as the cameras give them", "rectified": "rectified", "balanced": "rectified and balanced"}

STEEP = 15      # grey levels a pixel along the line: less is the inside of a square, which no method can match
MARGIN = 8      # disparities that are searched on either side of the board's

Levels = NDArray[np.uint8]


@dataclass(frozen=True)
class Plane:
    """A board's disparities.

    Parameters
    ----------
    truth : (H, W) float64 ndarray
        Disparities of the board's plane, pixels.
    mask : (H, W) bool ndarray
        Pixels between the board's outer corners.
    least, labels : int
        Disparities to be searched: the board's and :data:`MARGIN` more on either side.
    """
    truth: NDArray[np.float64]
    mask: NDArray[np.bool_]
    least: int
    labels: int


def plane(left: NDArray[Any], right: NDArray[Any], board: Board, size: tuple[int, int]) -> Plane:
    """The plane through corresponding corners, by least squares: disparities of a plane are linear in x and y.

    Parameters
    ----------
    left, right : (N, 2) ndarray
        Corners, pixels.
    board : Board
    size : (int, int)
        Width and height of the pictures.
    """
    columns, last = board.columns, len(left) - 1
    factors = np.linalg.lstsq(np.column_stack([left, np.ones(len(left))]), left[:, 0] - right[:, 0], rcond=None)[0]
    y, x = np.mgrid[:size[1], :size[0]]
    truth = factors[0] * x + factors[1] * y + factors[2]
    drawn = Image.new("1", size)
    outer = [tuple(map(float, left[corner])) for corner in (0, columns - 1, last, last - columns + 1)]
    ImageDraw.Draw(drawn).polygon(outer, fill=1)
    mask = np.asarray(drawn, dtype=bool)
    if not mask.any():
        raise ValueError("the board's corners enclose no pixel")
    least = min(max(int(np.floor(truth[mask].min())) - MARGIN, MatcherConfig.MINIMUMS[0]), MatcherConfig.MINIMUMS[-1])
    labels = int(np.ceil(truth[mask].max())) + MARGIN + 1 - least
    return Plane(truth, mask, least, min(max(labels, MatcherConfig.LABELS[0]), MatcherConfig.LABELS[-1]))


def _inputs(pair: tuple[Levels, Levels], each: View, rig: Rig, board: Board) -> dict[str, tuple[Levels, Levels, Plane]]:
    """What a matcher gets of a pair, and the truth of it, for each of :data:`ROWS`."""
    left, right = rig.rectified(*pair)
    before = plane(each.left, each.right, board, rig.size)
    after = plane(corners_after(rig.left, each.left), corners_after(rig.right, each.right, rig.row_offset), board, rig.size)
    return {"seen": (*pair, before), "rectified": (left, right, after),
            "balanced": (left, balance(left, right, after.least, after.labels), after)}


def parser() -> Parser:
    """The arguments of the command."""
    result = Parser(prog="golden boards", description=(
        "Bad pixels (off by more than 1) of real cameras on a chessboard, whose plane is the truth: as the cameras give them, rectified, "
        f"and balanced. Counted are pixels between the outer corners where the grey level changes by {STEEP} or more along the line."))
    result.add_argument("files", nargs="+", type=Path, metavar="FILE", help="pictures of the left camera, then those of the right one")
    result.add_argument("--rig", type=Path, required=True, metavar="FILE", help="the rig.json of golden calibrate, or its folder")
    result.add_argument("--board", required=True, metavar="9x6", help="inner corners of the chessboard")
    result.add_argument("--methods", nargs="+", choices=NAMED, default=list(NAMED), metavar="NAME", help=(
        f"of {', '.join(NAMED)}, each with its first set of parameters (default: all)"))
    return result


def run(argv: Sequence[str] | None) -> None:
    """The command; :class:`UserError` on bad input."""
    options = parser().parse_args(argv)
    board = read_board(options.board, 1)
    rig = read_rig(options.rig)
    found = read_views(pair_up(options.files, 1), board)
    views, files, size = found.views, found.files, found.size
    if size != rig.size:
        raise UserError(f"the pictures have {size[0]}x{size[1]} pixels and {options.rig} is for {rig.size[0]}x{rig.size[1]}; calibrate at "
                        "the size of the pictures")
    figures: dict[str, dict[str, list[float]]] = {name: {row: [] for row in ROWS} for name in options.methods}
    with progress() as bar:
        task = bar.add_task("", total=len(views) * len(options.methods) * len(ROWS))
        for each in views:
            pair = read_picture(files[each.name][0]), read_picture(files[each.name][1])
            inputs = _inputs(pair, each, rig, board)
            for name in options.methods:
                for row, (left, right, truth) in inputs.items():
                    bar.update(task, description=f"{each.name} {name}")
                    config = MatcherConfig(truth.labels, minimum=truth.least, method=default_parameters(name))
                    steep = np.abs(np.gradient(left.astype(np.float64), axis=1)) >= STEEP
                    figures[name][row].append(bad_pixels(disparities(left, right, config), truth.truth, truth.mask & steep))
                    bar.advance(task)
    table = Table(title=f"Bad pixels on a board, percent, mean of {len(views)} pairs")
    table.add_column("pictures")
    for name in options.methods:
        table.add_column(next(iter(NAMED[name])), justify="right")
    for row, what in ROWS.items():
        table.add_row(what, *(f"{np.mean(figures[name][row]):.2f}" for name in options.methods))
    print_table(table)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is the result."""
    return run_cli(run, argv, "golden boards")
