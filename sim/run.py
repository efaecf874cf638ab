"""The main job: ``python -m sim.run [LEFT RIGHT]`` sends a stereo pair through the simulated Verilog of the matcher.

The pictures are written as text, the simulator reads them and writes the disparities as text, and the disparity picture must equal
the golden model's in every pixel. With ``--hardware PORT`` a board is in the simulator's place.
"""

import argparse
import functools
import shutil
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from golden.cli import Parser, add_gateware_options, gateware_config, progress
from golden.config import MatcherConfig
from golden.errors import UserError, run_cli
from golden.files import output_folder, remove_stale, write_json
from golden.matcher.matcher import in_pixels
from golden.order import note_order
from golden.pictures.dataset import StereoPair, motorcycle
from golden.pictures.images import colour_map, read_pair, write_picture
from golden.pictures.metrics import bad_pixels
from golden.pictures.white import add_white_option, check_white
from hdl.host.loop import Board

from .figures import common_report, print_figures
from .hardware import Connect, add_hardware_options, as_result, board_report, match_shown, opened, print_board, serial_port
from .kit.harness import Result, mismatches, simulate
from .kit.simulators import SIMULATORS, SimulationError, require


__all__ = ["REPORT", "REPORT_KEYS", "main", "simulate_shown"]


#: The file in which a run lists its files, and what else is in it.
REPORT = "report.json"
REPORT_KEYS = ("mismatches", "clocks_per_pixel")


def _parser() -> Parser:
    parser = Parser(prog="sim.run", description="Send a stereo pair through the simulated Verilog of the matcher, and compare its "
                    "disparities with the golden model's. Exit status 1 if they differ.")
    parser.add_argument("pictures", nargs="*", metavar="LEFT RIGHT",
                        help="rectified pair, left(x) matches right(x-d); without it, the Motorcycle pair, reduced")
    parser.add_argument("--disparities", type=int, metavar="N",
                        help="number of disparities, 0 .. N-1 pixels, 2 to 256; what covers the truth for the Motorcycle pair")
    add_white_option(parser)
    add_gateware_options(parser)
    parser.add_argument("--simulator", choices=SIMULATORS, help=f"default: {SIMULATORS[0]}")
    add_hardware_options(parser)
    parser.add_argument("--output", type=Path, default=Path("build/run"), metavar="DIR",
                        help="folder for the results (default: %(default)s)")
    parser.add_argument("--waves", action="store_true", help="also leave a waveform file in DIR: FST from icarus, VCD from verilator; "
                        "for small pictures, because it has kilobytes for each clock")
    return parser


def _pictures(options, board: Board | None) -> tuple[NDArray[np.uint8], NDArray[np.uint8], int, StereoPair | None]:
    """Left, right, number of disparities, and the pair with its truth if no pictures were named. A board tells how many it has."""
    if len(options.pictures) not in (0, 2):
        raise UserError(f"LEFT and RIGHT are two pictures, not {len(options.pictures)}; name both or none")
    check_white(options, bool(options.pictures))
    asked = board.labels if board and options.disparities is None else options.disparities
    if asked is not None:
        gateware_config(options, asked)  # before anything is read
    if options.pictures:
        if asked is None:
            raise UserError("--disparities is missing; say how many disparities, 2 to 256, the pair needs")
        left, right = options.pictures
        return *read_pair(left, right, options.white), asked, None
    pair = motorcycle()
    return pair.left, pair.right, pair.disparities if asked is None else asked, pair


def _write(folder: Path, left, right, result: Result, config: MatcherConfig, report: dict) -> None:
    """Leave the results: each file whole, the report last. Disparities are in pixels."""
    fields = dict(result.fields[0])
    labels = fields.pop("disparity")
    disparity = in_pixels(labels, config)
    pictures = {
        "left.txt": left, "right.txt": right, "disparity.npy": disparity,
        "disparity.png": colour_map(labels // config.method.disparity_scale - config.minimum, config.labels),
        **{f"{name}.png": (values * (255 // (2**config.result_fields[name] - 1))).astype(np.uint8) for name, values in fields.items()},
    }
    if disparity is labels and 0 <= labels.min() and labels.max() <= 255:  # what a text picture holds
        pictures["disparity.txt"] = labels.astype(np.uint8)
    for name, picture in pictures.items():
        write_picture(folder / name, picture)
    files = sorted([*pictures, *([result.waves.name] if result.waves else [])])
    remove_stale(folder, REPORT, REPORT_KEYS, files)
    write_json(folder / REPORT, {**report, "files": files})


def simulate_shown(config: MatcherConfig, left: NDArray[np.uint8], right: NDArray[np.uint8], simulator: str,
                   work: Path, waves: bool = False) -> Result:
    """:func:`sim.kit.harness.simulate` of one frame, with a progress bar; without a terminal, a line a stage."""
    with progress() as bar:
        task = bar.add_task("", total=left.shape[0])

        def stage(text: str) -> None:
            bar.update(task, description=text)
            if bar.disable:
                print(f"{text} ...", file=sys.stderr, flush=True)

        return simulate(config, [left], [right], simulator=simulator, work_dir=work, waves=waves, stage=stage,
                        progress=lambda lines: bar.update(task, completed=lines))


def _print(report: dict, config: MatcherConfig, folder: Path) -> None:
    """The figures, as a table on stdout."""
    print_figures(report, config, f"{report['engine']} engine, {report['simulator']}", (
        ("clocks per pixel", f"{report['clocks_per_pixel']:.3f}"),
        ("latency, clocks", f"{report['latency_clocks']}"),
        ("simulated clocks", f"{report['clocks']}"),
        ("simulated clocks per second", f"{report['clocks_per_second']:.0f}"),
        ("seconds of simulation", f"{report['seconds']:.2f}"),
        ("seconds of Verilog output and build", f"{report['build_seconds']:.1f}"),
    ), folder)


def _main(connect: Connect, argv: Sequence[str] | None) -> int:
    options = _parser().parse_args(argv)
    with opened(options, connect) as board:
        left, right, disparities, pair = _pictures(options, board)
        config = gateware_config(options, disparities, max_width=left.shape[1])
        if board:
            board.check(config, *left.shape[::-1])
        else:
            options.simulator = options.simulator or SIMULATORS[0]
            require(options.simulator)
        with output_folder(options.output) as folder:
            if board:
                return _match(folder, options, board, config, left, right, pair)
            return _simulate(folder, options, config, left, right, pair)


def _match(folder: Path, options: argparse.Namespace, board: Board, config: MatcherConfig, left: NDArray[np.uint8],
           right: NDArray[np.uint8], pair: StereoPair | None) -> int:
    """Match the pair on the board and leave the results in the folder; the exit status."""
    run = match_shown(board, config, left, right)
    result = as_result(run)
    wrong = mismatches(result, 0, left, right, config, lambda fields: board.seen(fields, config))
    report = board_report(board, run, config, options, wrong) | _quality(result, config, pair)
    _write(folder, left, right, result, config, report)
    print_board(report, config, folder)
    note_order(left, right, config)
    return 1 if wrong else 0


def _quality(result: Result, config: MatcherConfig, pair: StereoPair | None) -> dict:
    """Figures of the disparities, for the report."""
    report: dict = {}
    if "passed" in result.fields[0]:
        report["passed_percent"] = round(100 * float(np.mean(result.fields[0]["passed"])), 2)
    if pair is not None:
        report["pair"] = pair.name
        disparity = in_pixels(result.fields[0]["disparity"], config)
        report["bad_pixels_percent"] = round(bad_pixels(disparity, pair.truth, pair.masks["known"]), 2)
    return report


def _simulate(folder: Path, options: argparse.Namespace, config: MatcherConfig, left: NDArray[np.uint8], right: NDArray[np.uint8],
              pair: StereoPair | None) -> int:
    """Run the simulation and leave its results in the folder; the exit status."""
    start = time.perf_counter()
    try:
        result = simulate_shown(config, left, right, options.simulator, folder / "simulation", options.waves)
    except SimulationError as error:
        print(f"sim.run: {error}", file=sys.stderr)
        return 1
    waves = None
    if result.waves is not None:
        waves = Path(shutil.move(result.waves, folder / result.waves.name))
    wrong = mismatches(result, 0, left, right, config)
    height, width = left.shape
    frame = result.frames[0]
    report = {
        **common_report(config, height, width, result.report["clocks"], wrong),
        "engine": str(config.engine), "simulator": options.simulator,
        "clocks_per_pixel": round(frame.clocks_per_pixel, 4), "latency_clocks": frame.latency,
        "clocks_per_second": round(result.clocks_per_second), "seconds": round(result.seconds, 3),
        "build_seconds": round(result.build_seconds, 3), "total_seconds": round(time.perf_counter() - start, 3),
    }
    report |= _quality(result, config, pair)
    _write(folder, left, right, result, config, report)
    _print(report, config, folder)
    note_order(left, right, config)
    if waves is not None:
        print(f"The waveforms are in {waves}: open it with gtkwave or surfer.")
    return 1 if wrong else 0


def main(argv: Sequence[str] | None = None, connect: Connect = serial_port) -> int:
    """Run the command line; return its exit status. ``connect`` opens the port of ``--hardware``, at a baud rate."""
    return run_cli(functools.partial(_main, connect), argv, "sim.run")


if __name__ == "__main__":
    sys.exit(main())
