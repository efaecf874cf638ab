"""Bad pixels of the simulated Verilog on the Middlebury benchmark: ``python -m sim.evaluate``."""

import argparse
import sys
import tempfile
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import TypedDict

from rich.progress import Progress, TaskID

from golden.cli import Parser, add_gateware_options, gateware_config, progress
from golden.config import MatcherConfig
from golden.errors import UserError, run_cli
from golden.files import check_output, write_json
from golden.lab.cameras import COLUMNS
from golden.lab.evaluate import Figures, average, table
from golden.lab.mounting import Mounting
from golden.matcher.matcher import in_pixels
from golden.pictures.dataset import PAIRS, StereoPair, data_folder, load_pair
from golden.pictures.metrics import bad_pixels
from golden.tables import print_table

from .kit.harness import mismatches, simulate
from .kit.mounted import FRAMES, simulate_mounted
from .kit.simulators import SIMULATORS, SimulationError, require


__all__ = ["main"]


def _run(argv: Sequence[str] | None) -> int:
    parser = Parser(prog="python -m sim.evaluate", description=(
        "Send the four pairs of the Middlebury benchmark through the simulated Verilog; bad pixels of its disparities, and how many pixels "
        "are not what the golden model gives. Exit status 1 if there are any."))
    parser.add_argument("--data", type=Path, metavar="DIR",
                        help=f"folder that holds {', '.join(PAIRS)} (default: $STEREO_DATA, else ../shared/data/middlebury)")
    parser.add_argument("--pairs", nargs="+", choices=PAIRS, default=list(PAIRS), metavar="NAME", help="some of them (default: all)")
    parser.add_argument("--mounted", action="store_true", help=(
        "the pairs as the mounted cameras of golden cameras see them, through the core with rectification and balance"))
    add_gateware_options(parser)
    parser.add_argument("--simulator", choices=SIMULATORS, default=SIMULATORS[0], help="default: %(default)s")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there too, percent; suffix .json")
    options = parser.parse_args(argv)
    gateware_config(options, MatcherConfig.LABELS[0])  # before anything is read
    if options.mounted and options.minimum:
        raise UserError(f"--mounted is for pairs whose least disparity is 0, not {options.minimum}; leave --minimum out")
    if options.json:
        check_output(options.json, [".json"], "--json")
    require(options.simulator)
    folder = data_folder(options.data)
    pairs = [load_pair(folder, name) for name in dict.fromkeys(options.pairs)]
    return _mounted(options, pairs) if options.mounted else _published(options, pairs)


class _Reports(TypedDict):
    """Functions that a simulation tells what it does, and how many lines it has done."""
    stage: Callable[[str], None]
    progress: Callable[[int], None]


def _reports(bar: Progress, task: TaskID, name: str, before: int) -> _Reports:
    """Of the pair ``name``, before which so many lines were done."""
    return {"stage": lambda text: bar.update(task, description=f"{name}: {text}"),
            "progress": lambda lines: bar.update(task, completed=before + lines)}


def _published(options: argparse.Namespace, pairs: Sequence[StereoPair]) -> int:
    """The pairs as they are published; the exit status."""
    figures: Figures = {}
    rates: dict[str, dict[str, float]] = {}
    wrong = 0
    with progress() as bar:
        task = bar.add_task("", total=sum(pair.left.shape[0] for pair in pairs))
        done = 0
        for pair in pairs:
            config = gateware_config(options, pair.disparities, max_width=pair.left.shape[1])
            with tempfile.TemporaryDirectory(prefix="evaluate-") as work:
                result = simulate(config, [pair.left], [pair.right], simulator=options.simulator, work_dir=Path(work),
                                  **_reports(bar, task, pair.name, done))
            done += pair.left.shape[0]
            wrong += mismatches(result, 0, pair.left, pair.right, config)
            disparity = in_pixels(result.fields[0]["disparity"], config)
            figures[pair.name] = {name: bad_pixels(disparity, pair.truth, mask) for name, mask in pair.masks.items()}
            rates[pair.name] = {"clocks_per_pixel": round(result.frames[0].clocks_per_pixel, 4), "seconds": round(result.seconds, 2)}

    print_table(table({config.method.name: figures}))
    for name, rate in rates.items():
        print(f"{name}: {rate['clocks_per_pixel']} clocks a pixel, {rate['seconds']} s of simulation")
    print(f"Mismatching pixels against golden: {wrong}")
    if options.json:
        write_json(options.json, {"bad_pixels_percent": figures, "average": average(figures), "mismatches": wrong, "rates": rates})
    return 1 if wrong else 0


def _mounted(options: argparse.Namespace, pairs: Sequence[StereoPair]) -> int:
    """The pairs as mounted cameras see them; the exit status."""
    figures: dict[str, Figures] = {column: {} for column in COLUMNS if column != "exact"}
    rates: dict[str, dict[str, float]] = {}
    wrong = done = 0
    with progress() as bar:
        task = bar.add_task("", total=FRAMES * sum(pair.left.shape[0] for pair in pairs))
        for pair in pairs:
            config = gateware_config(options, pair.disparities, max_width=pair.left.shape[1])
            try:
                with tempfile.TemporaryDirectory(prefix="evaluate-") as work:
                    result = simulate_mounted(pair, config, Mounting(), simulator=options.simulator, work_dir=Path(work),
                                              **_reports(bar, task, pair.name, done))
            except ValueError as error:
                raise UserError(f"{pair.name}: {error}") from None
            done += FRAMES * pair.left.shape[0]
            wrong += result.mismatches
            rates[pair.name] = {"frame_clocks": result.frame_clocks, "seconds": round(result.seconds, 2)}
            for column, disparity in result.disparities.items():
                figures[column][pair.name] = {name: bad_pixels(disparity, pair.truth, mask) for name, mask in pair.masks.items()}

    print_table(table({COLUMNS[column]: of for column, of in figures.items()}, column=f"{config.method.name}, pictures"))
    for name, rate in rates.items():
        print(f"{name}: {rate['frame_clocks']} clocks a frame with rectification and balance, {rate['seconds']} s of simulation")
    print(f"Mismatching pixels against golden: {wrong}")
    if options.json:
        averages = {column: average(of) for column, of in figures.items()}
        write_json(options.json, {"bad_pixels_percent": figures, "averages": averages, "mismatches": wrong, "rates": rates})
    return 1 if wrong else 0


def _main(argv: Sequence[str] | None) -> int:
    try:
        return _run(argv)
    except SimulationError as error:
        print(f"sim.evaluate: {error}", file=sys.stderr)
        return 1


def main(argv: Sequence[str] | None = None) -> int:
    """Entry point; the exit status."""
    return run_cli(_main, argv, "sim.evaluate")


if __name__ == "__main__":
    sys.exit(main())
