"""`python -m golden.lab.bench`: run time of the fast and of the plain version of the disparity rule."""

import sys
import time
from collections.abc import Callable, Sequence
from typing import Any

from rich.table import Table

from ..cli import Parser, check_disparities, progress
from ..config import Arithmetic, MatcherConfig, OnePass
from ..errors import UserError, run_cli
from ..matcher.labelling import match, match_plain
from ..pictures.scenes import scene
from ..tables import print_table


__all__ = ["main"]


def timed(function: Callable[..., Any], *arguments: Any) -> tuple[float, float]:
    """Wall-clock and processor seconds of one call."""
    wall, processor = time.perf_counter(), time.process_time()
    function(*arguments)
    return time.perf_counter() - wall, time.process_time() - processor


def parser() -> Parser:
    """The arguments of the command."""
    result = Parser(prog="golden.lab.bench", description=(
        "Seconds of the fast version of the disparity rule (NumPy over anti-diagonals, one thread) and of the plain one (pixel by pixel), "
        "matching cost included, on a synthetic pair."))
    result.add_argument("--width", type=int, default=720, metavar="W", help="pixels (default: %(default)s)")
    result.add_argument("--height", type=int, default=576, metavar="H", help="pixels (default: %(default)s)")
    result.add_argument("--disparities", type=int, default=80, metavar="N", help="number of disparities (default: %(default)s)")
    result.add_argument("--arithmetic", type=Arithmetic, choices=list(Arithmetic), metavar="float|thesis|linear",
                        help="number formats (default: all three)")
    result.add_argument("--plain-rows", type=int, default=16, metavar="ROWS",
                        help="rows of the picture that the plain version is measured on; its time is scaled by the pixels "
                             "(default: %(default)s, about a minute)")
    return result


def run(argv: Sequence[str] | None) -> None:
    """The command; :class:`UserError` on bad input."""
    options = parser().parse_args(argv)
    if options.width not in MatcherConfig.WIDTHS or options.height < 1:
        raise UserError(f"the size {options.width}x{options.height} is not within 1x1 .. {MatcherConfig.WIDTHS[-1]}x(any); "
                        "choose another --width or --height")
    if options.plain_rows < 1:
        raise UserError(f"--plain-rows must be at least 1, not {options.plain_rows}; choose a larger one")
    rows = min(options.plain_rows, options.height)
    check_disparities(options.disparities)
    configs = [MatcherConfig(options.disparities, method=OnePass(arithmetic))
               for arithmetic in ([options.arithmetic] if options.arithmetic else Arithmetic)]

    left, right, _ = scene(options.width, options.height, options.disparities, seed=1)
    table = Table(title=f"{options.width}x{options.height} pixels, {options.disparities} disparities, single-threaded NumPy",
                  caption=f"plain: measured on {rows} of {options.height} rows, scaled by the pixels")
    for column in ("arithmetic", "fast, s", "fast, CPU s", "plain, s", "plain / fast"):
        table.add_column(column, justify="left" if column == "arithmetic" else "right")
    with progress() as bar:
        task = bar.add_task("", total=2 * len(configs))
        for config in configs:
            bar.update(task, description=f"{config.method.arithmetic} fast")
            fast, processor = timed(match, left, right, config)
            bar.update(task, advance=1, description=f"{config.method.arithmetic} plain")
            plain = timed(match_plain, left[:rows], right[:rows], config)[0] * options.height / rows
            bar.advance(task)
            table.add_row(config.method.arithmetic, f"{fast:.2f}", f"{processor:.2f}", f"{plain:.0f}", f"{plain / fast:.0f}")
    print_table(table)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is the result."""
    return run_cli(run, argv, "golden.lab.bench")


if __name__ == "__main__":
    sys.exit(main())
