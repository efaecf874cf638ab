"""Bad pixels of the simulated Verilog on the Middlebury benchmark: ``python -m sim.evaluate``."""

import json
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from golden.cli import Parser, add_gateware_options, gateware_config, progress
from golden.config import MatcherConfig
from golden.errors import run_cli
from golden.files import atomic, check_output
from golden.lab.evaluate import Figures, average, table
from golden.matcher.matcher import in_pixels
from golden.pictures.dataset import PAIRS, data_folder, load_pair
from golden.pictures.metrics import bad_pixels
from golden.tables import print_table

from .kit.harness import mismatches, simulate
from .kit.simulators import SIMULATORS, SimulationError, require


__all__ = ["main"]


def _run(argv: Sequence[str] | None) -> int:
    parser = Parser(prog="python -m sim.evaluate", description=(
        "Send the four pairs of the Middlebury benchmark through the simulated Verilog; bad pixels of its disparities, and how many pixels "
        "are not what the golden model gives. Exit status 1 if there are any."))
    parser.add_argument("--data", type=Path, metavar="DIR",
                        help=f"folder that holds {', '.join(PAIRS)} (default: $STEREO_DATA, else ../shared/data/middlebury)")
    add_gateware_options(parser)
    parser.add_argument("--simulator", choices=SIMULATORS, default=SIMULATORS[0], help="default: %(default)s")
    parser.add_argument("--json", type=Path, metavar="FILE", help="write the figures there too, percent; suffix .json")
    options = parser.parse_args(argv)
    gateware_config(options, MatcherConfig.LABELS[0])  # before anything is read
    if options.json:
        check_output(options.json, [".json"], "--json")
    require(options.simulator)
    folder = data_folder(options.data)
    pairs = [load_pair(folder, name) for name in PAIRS]

    figures: Figures = {}
    rates: dict[str, dict[str, float]] = {}
    wrong = 0
    with progress() as bar:
        task = bar.add_task("", total=sum(pair.left.shape[0] for pair in pairs))
        done = 0
        for pair in pairs:
            config = gateware_config(options, pair.disparities, max_width=pair.left.shape[1])

            def stage(text: str, name: str = pair.name) -> None:
                bar.update(task, description=f"{name}: {text}")

            def lines_done(lines: int, before: int = done) -> None:
                bar.update(task, completed=before + lines)

            with tempfile.TemporaryDirectory(prefix="evaluate-") as work:
                result = simulate(config, [pair.left], [pair.right], simulator=options.simulator, work_dir=Path(work), stage=stage,
                                  progress=lines_done)
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
        with atomic(options.json) as file:
            text = json.dumps({"bad_pixels_percent": figures, "average": average(figures), "mismatches": wrong, "rates": rates}, indent=2)
            file.write((text + "\n").encode())
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
