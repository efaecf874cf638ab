"""The demonstration: ``python -m sim.demo`` compares the thesis's method and ours, simulated as Verilog, on a photographed pair."""

import argparse
import sys
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from golden.cli import Parser
from golden.config import RECURSIVE_1, MatcherConfig
from golden.errors import UserError, run_cli
from golden.files import output_folder, remove_stale, write_json
from golden.matcher.matcher import disparities, in_pixels
from golden.pictures.dataset import StereoPair, motorcycle
from golden.pictures.images import colour_map, write_picture
from golden.pictures.metrics import bad_pixels
from golden.pictures.sheet import write_judged
from golden.tables import print_table

from .kit.harness import Result, mismatches
from .kit.simulators import SIMULATORS, SimulationError, require
from .run import REPORT, REPORT_KEYS, simulate_shown


__all__ = ["LABELS_MULTIPLE", "REDUCTIONS", "TITLES", "configurations", "main"]


#: What the pair of 741x500 pixels may be divided by.
REDUCTIONS = range(1, 9)

#: The number of labels is the least multiple of this that covers the truth.
LABELS_MULTIPLE = 8

#: The methods that are compared, as the sheet and the table name them.
TITLES = {"thesis": "thesis: one-pass graph cut (golden model)", "recursive": "ours: recursive-1 (simulated Verilog)"}


def configurations(pair: StereoPair) -> tuple[MatcherConfig, MatcherConfig]:
    """For the size of the pair: the thesis's method with its weights and number formats, and ours, *recursive-1*.

    On this pair at half size the sets *fused-1*, *fused-2*, *fused-3* and *recursive-1* give 9.82, 9.26, 10.43 and 8.13 % bad pixels.
    """
    labels = -(-pair.disparities // LABELS_MULTIPLE) * LABELS_MULTIPLE
    width = pair.left.shape[1]
    return MatcherConfig(labels, width), MatcherConfig(labels, width, method=RECURSIVE_1)


def _parser() -> Parser:
    parser = Parser(prog="sim.demo", description=(
        "Send the Motorcycle pair through the simulated Verilog of the better method, and draw a sheet of its disparities, "
        "those of the thesis's method, the ground truth and all errors. Exit status 1 if a pixel differs from the golden model."))
    parser.add_argument("--reduce", type=int, default=2, metavar="N", help=(
        f"divide the pair of 741x500 pixels by N, {REDUCTIONS[0]} to {REDUCTIONS[-1]} (default: %(default)s)"))
    parser.add_argument("--simulator", choices=SIMULATORS, default=SIMULATORS[0], help="default: %(default)s")
    parser.add_argument("--output", type=Path, default=Path("build/demo"), metavar="DIR",
                        help="folder for the sheet and the figures (default: %(default)s)")
    return parser


def _write(folder: Path, pair: StereoPair, results: dict[str, NDArray[np.integer]], labels: int, report: dict[str, object]) -> None:
    """Leave the sheet, our disparities as a picture, and the figures last; each file whole."""
    height, width = pair.left.shape
    write_judged(folder / "sheet.png", f"Motorcycle pair, {width}x{height} pixels, {labels} disparities", pair.left,
                 {TITLES[name]: picture for name, picture in results.items()}, (pair.truth, pair.masks["known"]), (0, labels - 1))
    write_picture(folder / "disparity.png", colour_map(results["recursive"], labels))
    files = ["disparity.png", "sheet.png"]
    remove_stale(folder, REPORT, REPORT_KEYS, files)
    write_json(folder / REPORT, {**report, "files": files})


def _print(report: dict, result: Result, folder: Path) -> None:
    print(f"Motorcycle pair, {report['width']}x{report['height']} pixels, {report['disparities']} disparities:")
    table = Table()
    table.add_column("method")
    table.add_column("off by more than 1 pixel", justify="right")
    for name, title in TITLES.items():
        table.add_row(title, f"{report['bad_pixels_percent'][name]:.2f} %")
    print_table(table)
    print(f"{report['mismatches']} of the Verilog's pixels differ from the golden model; {report['clocks_per_pixel']:.3f} clocks a pixel; "
          f"{result.build_seconds:.0f} s of build, {result.seconds:.1f} s of simulation with {report['simulator']}.")
    print(f"The picture is {folder / 'sheet.png'}.")


def _main(argv: Sequence[str] | None) -> int:
    options = _parser().parse_args(argv)
    if options.reduce not in REDUCTIONS:
        raise UserError(f"--reduce must be a whole number from {REDUCTIONS[0]} to {REDUCTIONS[-1]}, not {options.reduce}; "
                        "choose a value in that range")
    require(options.simulator)
    pair = motorcycle(options.reduce, max_width=741, max_height=500)
    thesis, config = configurations(pair)
    with output_folder(options.output) as folder:
        return _simulate(folder, options, pair, thesis, config)


def _simulate(folder: Path, options: argparse.Namespace, pair: StereoPair, thesis: MatcherConfig, config: MatcherConfig) -> int:
    """Run the simulation and leave its results in the folder; the exit status."""
    start = time.perf_counter()
    try:
        result = simulate_shown(config, pair.left, pair.right, options.simulator, folder / "simulation")
    except SimulationError as error:
        print(f"sim.demo: {error}", file=sys.stderr)
        return 1
    wrong = mismatches(result, 0, pair.left, pair.right, config)
    results = {"thesis": disparities(pair.left, pair.right, thesis), "recursive": in_pixels(result.fields[0]["disparity"], config)}
    height, width = pair.left.shape
    report = {
        "pair": pair.name, "width": width, "height": height, "disparities": config.labels, "simulator": options.simulator,
        "mismatches": wrong, "clocks_per_pixel": round(result.frames[0].clocks_per_pixel, 4),
        "bad_pixels_percent": {name: round(bad_pixels(each, pair.truth, pair.masks["known"]), 2) for name, each in results.items()},
    }
    _write(folder, pair, results, config.labels, report | {"seconds": round(time.perf_counter() - start, 1)})
    _print(report, result, folder)
    return 1 if wrong else 0


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command line; return its exit status."""
    return run_cli(_main, argv, "sim.demo")


if __name__ == "__main__":
    sys.exit(main())
