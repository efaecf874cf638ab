"""`python -m golden calibrate`: from pictures of a chessboard to a rig."""

import argparse
import re
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from ..cli import Parser
from ..errors import UserError, run_cli
from ..files import atomic, check_folder, output_folder, remove_stale, write_json
from ..notes import note
from ..pictures.images import read_picture, write_picture
from ..rig.files import RIG_NAME, Rig, write_rig
from ..rig.lines import DEFAULT_LINES, LINES
from ..rig.maps import SIZES
from ..tables import print_table
from .flat import Flat, read_flat
from .outputs import calib_txt, camera_info
from .pairs import Files, pair_up, read_views
from .picture import epipolar_lines
from .rectified import Rectified, check_places, corners_after, make_rig, rig_dy
from .solve import LEAST_VIEWS, Solution, solve
from .sources import SUFFIXES, UNITS, read_cameras, read_intrinsics
from .views import View, names, read_board


__all__ = ["main"]


REPORT = "report.json"
PICTURE = "epipolar.png"



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


def _mean(values: Sequence[NDArray[Any]]) -> float:
    return float(np.mean([np.abs(each).mean() for each in values]))


def _dy(solution: Solution, rig: Rig) -> dict[str, Any]:
    """Mean distance of corresponding corners, lines: before, after exact rectification, after the gateware's; and by view."""
    kept = solution.kept
    before = [each.left[:, 1] - each.right[:, 1] for each in kept]
    exact = [solution.rectified.corner_dy(each.left, each.right) for each in kept]
    after = [rig_dy(rig, each.left, each.right) for each in kept]
    views = [{"name": each.name, **{name: float(np.abs(values[number]).mean()) for name, values in
                                    (("before", before), ("exact", exact), ("rectified", after))}} for number, each in enumerate(kept)]
    return {"before": _mean(before), "exact": _mean(exact), "rectified": _mean(after), "views": views}


class _Shown:
    """A pair before and after rectification, for the picture and the report."""
    def __init__(self, files: Files, each: View, rig: Rig):
        self.before = read_picture(files[0]), read_picture(files[1])
        self.after = rig.rectified(*self.before)
        self._corners = (each.left, each.right), (corners_after(rig.left, each.left),
                                                  corners_after(rig.right, each.right, rig.row_offset))

    def draw(self, path: Path) -> None:
        """Write the pair with epipolar lines."""
        write_picture(path, epipolar_lines(self.before, self.after, *self._corners))

    def grey_levels(self, rectified: Rectified) -> list[float]:
        """Mean difference from OpenCV's ``remap`` with exact maps, grey levels: left, right."""
        return [float(np.abs(side.astype(int) - rectified.remapped(picture, camera)).mean())
                for camera, (picture, side) in enumerate(zip(self.before, self.after))]


def _write(folder: Path, rectified: Rectified, rig: Rig, report: dict[str, Any], shown: _Shown | None) -> list[str]:
    """All files; their names are the result."""
    texts = {"left.yaml": camera_info(rectified, 0), "right.yaml": camera_info(rectified, 1), "calib.txt": calib_txt(rectified)}
    written = [RIG_NAME, *texts, *([PICTURE] if shown else [])]
    write_rig(folder / RIG_NAME, rig)
    for name, text in texts.items():
        with atomic(folder / name) as file:
            file.write(text.encode())
    if shown:
        shown.draw(folder / PICTURE)
    remove_stale(folder, REPORT, ("generator", "lines"), written)
    write_json(folder / REPORT, {**report, "files": written})
    return [*written, REPORT]


def _table(report: dict[str, Any]) -> Table:
    result = Table(title="|dy|: lines between corresponding corners, mean")
    for column in ("pictures", "before", "rectified exactly", "rectified by the gateware"):
        result.add_column(column, justify="left" if column == "pictures" else "right")
    for each in report["dy"]["views"]:
        result.add_row(each["name"], *(f"{each[name]:.3f}" for name in ("before", "exact", "rectified")))
    result.add_section()
    result.add_row(f"mean of {len(report['dy']['views'])}", *(f"{report['dy'][name]:.3f}" for name in ("before", "exact", "rectified")))
    return result


def _gains(flats: Sequence[Flat], maps: Sequence[Any]) -> Any:
    return [flat.gain(*each) for flat, each in zip(flats, maps)] if flats else None


def run(argv: Sequence[str] | None) -> None:
    """The command; :class:`UserError` on bad input."""
    options = parser().parse_args(argv)
    given = _is_calibration(options)
    size = _size(options.size)
    check_folder(options.output)
    solution, files, without = None, dict[str, Files](), list[Path]()
    if given:
        rectified = read_cameras(options.files, size, UNITS.get(options.baseline_unit))
        check_places(rectified)
    else:
        board = read_board(options.board, options.square)
        intrinsics = read_intrinsics(options.intrinsics) if options.intrinsics else None
        views, files, without, size = read_views(pair_up(options.files), board)
        solution = solve(views, board, size, intrinsics)
        rectified = solution.rectified
        if solution.dropped:
            note(f"dropped as outliers: {', '.join(each.name for each in solution.dropped)}")
    maps = rectified.maps(0), rectified.maps(1)
    flats = [read_flat(path, rectified.size) for path in options.flat or ()]
    rig = make_rig(*maps, options.rectify_lines, _gains(flats, maps))

    width, height = rectified.size
    report: dict[str, Any] = {
        "generator": "golden calibrate", "width": width, "height": height,
        "focal_pixels": rectified.focal, "baseline_millimetres": rectified.baseline,
        "lines": rig.lines, "rectify_lines": options.rectify_lines, "row_offset": rig.row_offset}
    shown = None
    if solution:
        first = solution.kept[0]
        shown = _Shown(files[first.name], first, rig)
        report |= {"rms_pixels": solution.rms, "dy": _dy(solution, rig), "dropped": [each.name for each in solution.dropped],
                   "without_corners": [path.name for path in without]}
        if not flats:   # gains are not OpenCV's
            report["grey_levels_from_remap"] = shown.grey_levels(rectified)

    with output_folder(options.output) as folder:
        written = _write(folder, rectified, rig, report, shown)
    if solution:
        print_table(_table(report))
        print(f"rms {solution.rms:.3f} pixels, {len(solution.kept)} views used, {len(solution.dropped)} dropped, "
              f"{len(options.files) // 2 - len(files)} without corners")
    if levels := report.get("grey_levels_from_remap"):
        print(f"{first.name} differ from OpenCV's remap with exact maps by {levels[0]:.2f} and {levels[1]:.2f} grey levels, mean")
    print(f"focal length {rectified.focal:.1f} pixels, baseline {rectified.baseline:.2f} mm; the rectifiers hold {rig.lines} lines of "
          f"{options.rectify_lines}, the right picture is moved by {rig.row_offset} lines")
    print(f"{options.output}: {', '.join(written)}")


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is the result."""
    return run_cli(run, argv, "golden calibrate")
