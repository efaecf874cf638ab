"""`python -m golden calibrate`: from pictures of a chessboard to a rig."""

import argparse
import re
from collections.abc import Sequence
from pathlib import Path

from ..cli import Parser
from ..errors import UserError, run_cli
from ..files import check_folder
from ..rig.files import RIG_NAME
from ..rig.lines import DEFAULT_LINES, LINES
from ..rig.maps import SIZES
from .pairs import pair_up, read_views
from .rectified import check_places
from .results import PICTURE, REPORT, calibrate, write_results
from .solve import LEAST_VIEWS
from .sources import SUFFIXES, UNITS, read_cameras, read_intrinsics
from .views import names, read_board


__all__ = ["main"]


def parser() -> Parser:
    """The arguments of the command."""
    result = Parser(prog="golden calibrate", description=(
        "Calibrate two cameras that are fixed to each other, from pictures of a chessboard that both take at the same time, and write how "
        "the gateware rectifies their pictures."), epilog=(
        f"DIR receives {RIG_NAME} (for golden match --rig and the gateware), left.yaml and right.yaml (camera_info of ROS), calib.txt (for "
        f"golden match --depth), {REPORT} and, of pictures, {PICTURE}, a pair with epipolar lines before and after."))
    result.add_argument("files", nargs="+", type=Path, metavar="FILE", help=(
        f"pictures of the left camera, then as many of the right one in the same order, {LEAST_VIEWS} pairs or more; or OpenCV's "
        "intrinsics.yml and extrinsics.yml; or Kalibr's camchain.yaml"))
    result.add_argument("--board", metavar="9x6", help="inner corners of the chessboard")
    result.add_argument("--square", type=float, metavar="MM", help="side of a square, millimetres")
    result.add_argument("--output", type=Path, required=True, metavar="DIR", help="folder of the results")
    result.add_argument("--flat", nargs=2, type=Path, metavar=("LEFT", "RIGHT"), help=(
        "pictures of an evenly lit white surface: vignetting is made good by the map's gains"))
    result.add_argument("--intrinsics", type=Path, metavar="FILE", help=(
        "keep the lenses of OpenCV's intrinsics.yml and compute from the pictures only how the cameras are placed"))
    result.add_argument("--rectify-lines", type=int, choices=LINES, default=DEFAULT_LINES, metavar="N", help=(
        f"lines that the gateware's rectifiers hold: {', '.join(map(str, LINES))} (default: %(default)s)"))
    result.add_argument("--size", metavar="WIDTHxHEIGHT", help="of the pictures, pixels, where OpenCV's files are given")
    result.add_argument("--baseline-unit", choices=UNITS, metavar="|".join(UNITS), help="unit of T in OpenCV's extrinsics.yml")
    return result


def _is_calibration(options: argparse.Namespace) -> bool:
    """Whether files of others are given; :class:`UserError` if they are mixed with pictures, or options do not belong to them."""
    kinds = {path.suffix.lower() in SUFFIXES for path in options.files}
    if len(kinds) > 1:
        raise UserError(f"{names(options.files)} are pictures and calibrations; give one or the other, or --intrinsics FILE with pictures")
    given = kinds == {True}
    for option, of_pictures in (("board", True), ("square", True), ("intrinsics", True), ("size", False), ("baseline_unit", False)):
        value = getattr(options, option)
        name = option.replace("_", "-")
        if of_pictures is given and value is not None:
            what = "pictures" if of_pictures else "calibrations of others"
            raise UserError(f"--{name} {value} belongs to {what}, which are not given; leave it out")
        if option in ("board", "square") and not given and value is None:
            raise UserError(f"--{name} is missing; give the chessboard as in --board 9x6 --square 25")
    return given


def _size(text: str | None) -> tuple[int, int] | None:
    if text is None:
        return None
    sides = re.fullmatch(r"(\d{1,5})x(\d{1,5})", text)
    if not sides or any(int(side) not in SIZES for side in sides.groups()):
        raise UserError(f"--size is {text}, but must be two numbers from {SIZES[0]} to {SIZES[-1]}, as in 640x480; correct it")
    return int(sides[1]), int(sides[2])


def run(argv: Sequence[str] | None) -> None:
    """The command; :class:`UserError` on bad input."""
    options = parser().parse_args(argv)
    given = _is_calibration(options)
    size = _size(options.size)
    check_folder(options.output)
    flats = options.flat or ()
    if given:
        rectified = read_cameras(options.files, size, UNITS.get(options.baseline_unit))
        check_places(rectified)
        write_results(options.output, rectified, options.rectify_lines, flats=flats)
    else:
        board = read_board(options.board, options.square)
        intrinsics = read_intrinsics(options.intrinsics) if options.intrinsics else None
        found = read_views(pair_up(options.files), board)
        calibrate(found, board, options.output, options.rectify_lines, intrinsics=intrinsics, flats=flats)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is the result."""
    return run_cli(run, argv, "golden calibrate")
