"""The whole chip: ``python -m sim.system [LEFT RIGHT]`` sends a pair from two simulated cameras to a simulated monitor.

One pair of 720x576 pixels goes through the Verilog of the system at the formats of the board, PAL in and 720x576 at 50 Hz out, and what
the monitor saw must equal the golden model's picture in every pixel. With ``--mounted`` the cameras see the pair as mounted by hand, and
the system is built with the maps that rectify it; the monitor then shows the third pair, the first one that is balanced. ``--frames`` and
``--faults`` run a small system instead, against models that check every rule: how full the FIFOs get, and whether each fault is counted
and got over.
"""

import argparse
import functools
import json
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from golden.cli import Parser
from golden.errors import UserError, run_cli
from golden.files import output_folder
from golden.matcher.labelling import match
from golden.pictures.dataset import StereoPair, motorcycle
from golden.pictures.images import read_pair, write_picture
from golden.pictures.white import add_white_option, check_white
from golden.rig.balance import Auto
from golden.tables import print_table
from golden.video.bt656 import clip, encode
from golden.video.display import DisplayMode, monitor_picture
from golden.video.formats import PAL, CameraFormat
from golden.video.memory_map import Plane
from hdl.emit import verilog_text, write_verilog
from hdl.video.system import StereoSystem
from sim.benches.system_sizes import CLOCK_HZ, MOUNTING, SIZES, TOP, Size, mounted
from sim.kit.simulators import SimulationError, build, require, run
from sim.models.monitor import Monitor


__all__ = ["main", "run_full", "run_small"]


_HARNESS = Path(__file__).with_suffix(".v")

# What a run leaves: the picture of the whole system, or the figures of a small one.
_RESULTS = _MONITOR, _FIGURES = "monitor.png", "told.json"

# Delay of the right camera; and of the monitor's first frame after the reset, a whole number of its frames before the one that finds the
# picture in the memory.
_RIGHT_SECONDS = 0.002
_DISPLAY_SECONDS = 0.0105

# Pairs of a scene that stands still, until they are balanced by what was measured of it.
_BALANCED = 3


@functools.cache
def _emitted(size: str) -> tuple[StereoSystem, str]:
    system = SIZES[size].system()
    return system, verilog_text(system, name=TOP)


def run_small(folder: Path, test: str, *, size: str = "small", brief: bool = False, **env: str | int) -> StereoSystem:
    """Run a test of ``system_tb.py`` by its name on a small system, which is returned; ``brief`` as in :func:`sim.kit.simulators.build`."""
    system, verilog = _emitted(size)
    source = folder / "small.v"
    source.write_text(verilog)
    build("verilator", [source], TOP, folder / "small", brief=brief)
    ran = run("verilator", TOP, folder / "small", "sim.benches.system_tb",
              env={"SYSTEM_SIZE": size, "COCOTB_TEST_FILTER": rf"\b{test}$", **env})
    assert ran == 1
    return system


def _fit(picture, format: CameraFormat):
    """The picture in a camera's size: cropped around the centre, or padded by edge replication."""
    for axis, size in enumerate((format.height, format.width)):
        beyond = picture.shape[axis] - size
        if beyond > 0:
            picture = np.take(picture, range(beyond // 2, beyond // 2 + size), axis=axis)
        pads = [(0, 0), (0, 0)]
        pads[axis] = (max(-beyond, 0) // 2, max(-beyond, 0) - max(-beyond, 0) // 2)
        picture = np.pad(picture, pads, mode="edge")
    return picture


def _pair(names, white, format):
    if len(names) not in (0, 2):
        raise UserError(f"LEFT and RIGHT are two pictures, not {len(names)}; name both or none")
    if names:
        left, right = read_pair(*names, white)
    else:
        pair = motorcycle(1, format.width, format.height)
        left, right = pair.left, pair.right
    return [_fit(clip(side), format) for side in (left, right)]


def _report(path: Path) -> dict[str, float]:
    return {key: float(value) for key, value in (line.split() for line in path.read_text().splitlines())}


def run_full(size: Size, pair: Sequence[NDArray[np.uint8]], folder: Path, simulator: str = "verilator", *,
             pairs: int = 1) -> tuple[dict[str, float], NDArray[np.uint8]]:
    """A pair through ``system.v``, so many times; the counts, and the monitor's picture of the last one."""
    system = size.system()
    memory_map = system.memory_map
    source = write_verilog(system, folder / "full.v", name=TOP)
    shown = memory_map.base(Plane.DISPARITY, 0)
    camera, display = size.camera, size.display
    build(simulator, [source, _HARNESS], "system_bench", folder / simulator, parameters={
        "FRAME_BYTES": camera.frame_bytes, "WORDS": memory_map.total_words, "SHOWN": shown,
        "PICTURE_WORDS": 2 * memory_map.line_words * memory_map.height})
    files = {name: folder / f"{name}.txt" for name in ("left", "right", "output", "report")}
    for name, picture in zip(("left", "right"), pair):
        files[name].write_text("\n".join(f"{byte:02x}" for byte in encode(picture, camera).tolist()) + "\n")
    late = round(_RIGHT_SECONDS * camera.byte_clock_hz)
    periods = [2 * round(0.5e12 / hertz) for hertz in (CLOCK_HZ, display.pixel_clock_hz, camera.byte_clock_hz, camera.byte_clock_hz)]
    for name in ("output", "report"):   # of an earlier run
        files[name].unlink(missing_ok=True)
    # Relative to where the simulator runs: Verilog's file names are of limited length.
    run(simulator, "system_bench", folder / simulator, "sim.benches.system_bench_tb",
        plusargs=[*(f"+{name}=../{path.name}" for name, path in files.items()), f"+right_at={camera.frame_bytes - late}"],
        env={"PERIODS": " ".join(map(str, periods)),
             "DISPLAY_NS": round((_DISPLAY_SECONDS + (pairs > 1) * pairs * camera.frame_seconds) * 1e9)})
    monitor = Monitor(display)
    for _ in range(2):  # so that it sees an edge
        monitor.clock(7 << 24)
    with files["output"].open() as file:
        for line in file:
            monitor.clock(int(line, 16))
    if monitor.frames != 1:
        raise SimulationError(f"the monitor has seen {monitor.frames} frames, not 1")
    return _report(files["report"]), monitor.pictures[-1]


def _print_full(size: Size, report, mismatches) -> None:
    clocks = int(report["finished"] - report["started"])
    rate = CLOCK_HZ / clocks
    table = Table()
    table.add_column("figure")
    table.add_column("value", justify="right")
    for name, value in (
            ("mismatching pixels at the monitor", f"{mismatches}"),
            ("clocks, first pair's first word to its picture's last", f"{clocks:,}"),
            ("clocks per pixel", f"{clocks / (size.camera.width * size.camera.height):.3f}"),
            (f"frames/s at {CLOCK_HZ / 1e6:g} MHz", f"{rate:.1f}"),
            (f"margin over {1 / size.camera.frame_seconds:.0f} frames/s", f"{rate * size.camera.frame_seconds:.1f} times"),
            ("simulated clocks of sync", f"{report['clocks']:,.0f}"),
            ("words read, written", f"{report['words_read']:,.0f}, {report['words_written']:,.0f}"),
            ("seconds of simulation", f"{report['seconds']:.0f}")):
        table.add_row(name, value)
    print_table(table)


def _print_frames(system: StereoSystem, told) -> None:
    table = Table(title=f"{told['frames']} frames of the small system, hostile memory", title_justify="left")
    for column in ("FIFO", "deepest fill, words", "size, words"):
        table.add_column(column, justify="left" if column == "FIFO" else "right")
    for name, fill in told["fills"].items():
        table.add_row(name, f"{fill}", f"{system.depths[name]}")
    print_table(table)
    print_table(system.budget.table())
    moved = told["words"] * CLOCK_HZ / told["clocks"]
    print(f"Moved: {moved:,.0f} words/s on the average of {told['clocks']:,} clocks, {moved / system.budget.available:.1%} of what "
          "there is.")


def _print_faults(told) -> None:
    table = Table(caption="frames: the monitor's, from the fault's beginning to the second exact picture", caption_justify="left")
    for column in ("fault", "counter", "count", "frames"):
        table.add_column(column, justify="left" if column in ("fault", "counter") else "right")
    for entry in told:
        table.add_row(*(str(entry[key]) for key in ("fault", "counter", "count", "frames")))
    print_table(table)


def _main(argv: Sequence[str] | None) -> int:
    parser = Parser(prog="sim.system", description="Send a pair from two simulated cameras to a simulated monitor, through the Verilog of "
                    "the whole system. Exit status 1 if the monitor shows anything but the golden model's picture.")
    parser.add_argument("pictures", nargs="*", metavar="LEFT RIGHT",
                        help=f"rectified pair, cropped or its edges repeated to {PAL.width}x{PAL.height}; without it, the Motorcycle pair")
    add_white_option(parser)
    parser.add_argument("--mounted", action="store_true", help="cameras as one mounts them: rolled, one lower and darker, with lenses, "
                        "darker corners and noise; the system rectifies and balances the pair")
    parser.add_argument("--frames", type=int, metavar="N", help="instead: N frames of a small system, how full its FIFOs get")
    parser.add_argument("--faults", action="store_true", help="instead: faults of a small system")
    parser.add_argument("--output", type=Path, default=Path("build/system"), metavar="DIR", help="default: %(default)s")
    options = parser.parse_args(argv)
    if options.frames is not None and options.frames < 1:
        raise UserError(f"--frames must be at least 1, not {options.frames}")
    small = options.faults or options.frames is not None
    if options.faults and options.frames is not None:
        raise UserError("--frames and --faults are two benches; choose one of them")
    if small and (options.pictures or options.mounted):
        raise UserError("LEFT, RIGHT and --mounted are for the full size, and --frames and --faults have pictures of their own; "
                        "leave them out")
    check_white(options, bool(options.pictures))
    size = mounted() if options.mounted else SIZES["full"]
    pair = [] if small else _pair(options.pictures, options.white, size.camera)
    require("verilator")
    try:
        with output_folder(options.output) as folder:
            return _run_small(folder.absolute(), options) if small else _run_full(folder.absolute(), size, pair, options)
    except SimulationError as error:
        print(f"sim.system: {error}", file=sys.stderr)
        return 1


def _only(folder: Path, result: str) -> None:
    """Remove the result of an earlier run of the other kind: it would look like one of this run."""
    for name in {*_RESULTS} - {result}:
        (folder / name).unlink(missing_ok=True)


def _run_small(folder: Path, options: argparse.Namespace) -> int:
    """One of the benches of a small system; the exit status."""
    told = folder / _FIGURES
    told.unlink(missing_ok=True)
    system = run_small(folder, "faults" if options.faults else "fills", REPORT=str(told), FAULTS="[]", FRAMES=options.frames or 0)
    _only(folder, _FIGURES)
    data = json.loads(told.read_text())
    _print_faults(data) if options.faults else _print_frames(system, data)
    return 0


def _seen(pair: Sequence[NDArray[np.uint8]], size: Size) -> tuple[list[NDArray[np.uint8]], list[NDArray[np.uint8]]]:
    """What cameras mounted as the size says see of a pair, and what the matcher gets of that."""
    left, right = pair
    seen = [clip(side) for side in MOUNTING.pair(StereoPair("scene", left, right, np.zeros(left.shape), {}, size.config.labels))]
    rig = size.rig and size.rig.rig
    assert rig
    auto = Auto(size.config.minimum, size.config.labels)
    left, right = rig.rectified(*seen)
    *_, balanced = (auto.pair(left, right) for _ in range(_BALANCED))
    return seen, [left, balanced]


def _run_full(folder: Path, size: Size, pair: Sequence[NDArray[np.uint8]], options: argparse.Namespace) -> int:
    """A pair through the whole system, compared at the monitor; the exit status."""
    start = time.perf_counter()
    seen, matched = _seen(pair, size) if options.mounted else (pair, pair)
    labels = match(matched[0], matched[1], size.config)
    expected = monitor_picture(labels, matched[0], size.display, DisplayMode.DISPARITY, False, size.config.labels)
    report, picture = run_full(size, seen, folder, pairs=_BALANCED if options.mounted else 1)
    mismatches = int(np.count_nonzero((picture != expected).any(axis=-1)))
    write_picture(folder / _MONITOR, picture)
    _only(folder, _MONITOR)
    _print_full(size, report, mismatches)
    print(f"What the monitor saw is in {folder / _MONITOR}. {time.perf_counter() - start:.0f} s in all.")
    return 1 if mismatches else 0


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return its exit status."""
    return run_cli(_main, argv, "sim.system")


if __name__ == "__main__":
    sys.exit(main())
