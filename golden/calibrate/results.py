"""Results of a calibration: from the corners that were found, or known cameras, to the files of a rig and what is printed."""

from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from ..files import atomic, output_folder, remove_stale, write_json
from ..notes import note
from ..pictures.images import read_picture, write_picture
from ..rig.files import RIG_NAME, Rig, write_rig
from ..tables import print_table
from .flat import Flat, read_flat
from .outputs import calib_txt, camera_info
from .pairs import Files, Found
from .picture import epipolar_lines
from .rectified import Rectified, corners_after, make_rig, rig_dy
from .solve import Solution, solve
from .views import Board, View


__all__ = ["PICTURE", "REPORT", "calibrate", "write_results"]


#: Names of files in the folder of the results.
REPORT = "report.json"
PICTURE = "epipolar.png"


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


def write_results(output: Path, rectified: Rectified, lines: int, *, flats: Sequence[Path] = (), solution: Solution | None = None,
                  files: Mapping[str, Files] | None = None, without: Sequence[Path] = (), left_out: int = 0) -> Rig:
    """Write all files of a calibration into a folder, and print what it is worth.

    Parameters
    ----------
    output : Path
    rectified : Rectified
    lines : int
        That the gateware's rectifiers hold; :class:`golden.errors.UserError` if they are not enough.
    flats : sequence of path
        Pictures of a white surface, none or two.
    solution : Solution or None
        With views, where the cameras were computed from some.
    files : mapping of str to (path, path)
        Those of each view, by its name.
    without : sequence of path
        Pictures without corners.
    left_out : int
        Pairs without corners.
    """
    maps = rectified.maps(0), rectified.maps(1)
    surfaces = [read_flat(path, rectified.size) for path in flats]
    rig = make_rig(*maps, lines, _gains(surfaces, maps))

    width, height = rectified.size
    report: dict[str, Any] = {
        "generator": "golden calibrate", "width": width, "height": height,
        "focal_pixels": rectified.focal, "baseline_millimetres": rectified.baseline,
        "lines": rig.lines, "rectify_lines": lines, "row_offset": rig.row_offset}
    shown = None
    if solution and files:
        first = solution.kept[0]
        shown = _Shown(files[first.name], first, rig)
        report |= {"rms_pixels": solution.rms, "dy": _dy(solution, rig), "dropped": [each.name for each in solution.dropped],
                   "without_corners": [path.name for path in without]}
        if not surfaces:   # gains are not OpenCV's
            report["grey_levels_from_remap"] = shown.grey_levels(rectified)

    with output_folder(output) as folder:
        written = _write(folder, rectified, rig, report, shown)
    if solution:
        print_table(_table(report))
        print(f"rms {solution.rms:.3f} pixels, {len(solution.kept)} views used, {len(solution.dropped)} dropped, "
              f"{left_out} without corners")
    if levels := report.get("grey_levels_from_remap"):
        print(f"{first.name} differ from OpenCV's remap with exact maps by {levels[0]:.2f} and {levels[1]:.2f} grey levels, mean")
    print(f"focal length {rectified.focal:.1f} pixels, baseline {rectified.baseline:.2f} mm; the rectifiers hold {rig.lines} lines of "
          f"{lines}, the right picture is moved by {rig.row_offset} lines")
    print(f"{output}: {', '.join(written)}")
    return rig


def calibrate(found: Found, board: Board, output: Path, lines: int, *, intrinsics: Sequence[NDArray[np.float64]] | None = None,
              flats: Sequence[Path] = ()) -> Rig:
    """Compute the cameras that took these views, and :func:`write_results`; errors are those of :func:`golden.calibrate.solve.solve`.

    Parameters
    ----------
    found : Found
    board : Board
    output : Path
    lines : int
        That the gateware's rectifiers hold.
    intrinsics : sequence of ndarray or None
        As of :func:`golden.calibrate.solve.solve`.
    flats : sequence of path
        As of :func:`write_results`.
    """
    solution = solve(found.views, board, found.size, intrinsics)
    if solution.dropped:
        note(f"dropped as outliers: {', '.join(each.name for each in solution.dropped)}")
    return write_results(output, solution.rectified, lines, flats=flats, solution=solution, files=found.files, without=found.without,
                         left_out=found.left_out)
