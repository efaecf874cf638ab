"""Seconds of simulation of a frame, for each engine and method: ``python -m sim.bench``."""

import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from rich.table import Table

from golden.cli import Parser, progress
from golden.config import FUSED_1, Arithmetic, Engine, MatcherConfig, OnePass
from golden.errors import UserError, run_cli
from golden.pictures.scenes import scene
from golden.tables import print_table

from .kit.harness import Result, mismatches, simulate
from .kit.simulators import SIMULATORS, SimulationError, require


__all__ = ["main"]


def _name(config: MatcherConfig) -> str:
    return f"{config.engine}, cost {config.method.name}"


def _run(argv: Sequence[str] | None) -> int:
    parser = Parser(prog="python -m sim.bench", description=__doc__)
    parser.add_argument("--width", type=int, default=720, metavar="PIXELS", help="default: %(default)s")
    parser.add_argument("--height", type=int, default=576, metavar="LINES", help="default: %(default)s")
    parser.add_argument("--disparities", type=int, default=80, metavar="D", help="default: %(default)s")
    parser.add_argument("--simulator", choices=SIMULATORS, default=SIMULATORS[0], help="default: %(default)s")
    options = parser.parse_args(argv)
    if options.height not in range(1, 4097):
        raise UserError(f"--height must be a whole number from 1 to 4096, not {options.height}; choose a value in that range")
    linear = OnePass(Arithmetic.LINEAR)
    try:
        configs = [MatcherConfig(labels=options.disparities, max_width=options.width, engine=engine, method=method)
                   for engine, method in ((Engine.SEQUENTIAL, linear), (Engine.STREAMING, linear), (Engine.STREAMING, FUSED_1))]
    except ValueError as error:
        raise UserError(f"{error}; choose a value in that range") from None
    if options.disparities not in MatcherConfig.SEQUENTIAL_LABELS:
        raise UserError(f"--disparities must be at most {MatcherConfig.SEQUENTIAL_LABELS[-1]}, not {options.disparities}: "
                        "both engines are run; choose fewer")
    require(options.simulator)

    left, right, _ = scene(options.width, options.height, options.disparities, seed=1)
    results: list[Result] = []
    wrong = 0
    with progress() as bar:
        task = bar.add_task("", total=len(configs) * options.height)
        for number, config in enumerate(configs):
            def stage(text: str, name: str = _name(config)) -> None:
                bar.update(task, description=f"{name}: {text}")

            def lines_done(lines: int, before: int = number * options.height) -> None:
                bar.update(task, completed=before + lines)

            with tempfile.TemporaryDirectory(prefix="bench-") as work:
                result = simulate(config, [left], [right], simulator=options.simulator, work_dir=Path(work), stage=stage,
                                  progress=lines_done)
            wrong += mismatches(result, 0, left, right, config)
            results.append(result)

    table = Table(title=f"{options.width}x{options.height}, {options.disparities} disparities, one frame on {options.simulator}",
                  title_justify="left")
    table.add_column("")
    for config in configs:
        table.add_column(_name(config), justify="right")
    frames = [result.frames[0] for result in results]
    for title, cells in (
        ("seconds", [f"{result.seconds:.2f}" for result in results]),
        ("of the sequential engine's", [f"{result.seconds / results[0].seconds:.2f}" for result in results]),
        ("clocks", [f"{result.report['clocks']:,}" for result in results]),
        ("clocks a second", [f"{result.clocks_per_second:,.0f}" for result in results]),
        ("clocks a pixel", [f"{frame.clocks_per_pixel:.4f}" for frame in frames]),
        ("latency, clocks", [f"{frame.latency:,}" for frame in frames]),
        ("seconds of output and build", [f"{result.build_seconds:.0f}" for result in results]),
    ):
        table.add_row(title, *cells)
    print_table(table)
    print(f"Mismatching pixels against golden: {wrong}")
    return 1 if wrong else 0


def _main(argv: Sequence[str] | None) -> int:
    try:
        return _run(argv)
    except SimulationError as error:
        print(f"sim.bench: {error}", file=sys.stderr)
        return 1


def main(argv: Sequence[str] | None = None) -> int:
    """Entry point; the exit status."""
    return run_cli(_main, argv, "sim.bench")


if __name__ == "__main__":
    sys.exit(main())
