"""`python -m golden cameras`: what mounted cameras cost every method, and what rectification and balance are worth."""

import math
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from ..cli import Parser, progress
from ..errors import UserError, run_cli
from ..files import check_output, write_json
from ..pictures.dataset import StereoPair, add_data_option
from ..pictures.metrics import bad_pixels
from ..pictures.sets import load_data
from ..rig.balance import balance
from ..rig.lines import DEFAULT_LINES, check_lines
from ..tables import print_table
from .mounting import Mounting, linear
from .rivals.registry import METHODS
from .workers import check_installed


__all__ = ["COLUMNS", "main", "pictures"]


#: The table's columns: name, and what it shows.
COLUMNS = {
    "published": "rectified pair",
    "mounted": "rolled, offset, lenses",
    "rectified": "the same, rectified",
    "exact": "in floating point",
    "darker": "right one darker",
    "balanced": "the same, balanced",
    "both": "both",
    "both rectified": "both, rectified",
    "both cured": "and balanced",
}

DEFAULT = ("one-pass-thesis", "fused-1", "recursive-1")
LIMITS = {"roll": 15.0, "offset": 60.0, "lens": 0.3}

Pair = tuple[NDArray[np.uint8], NDArray[np.uint8]]


def pictures(pair: StereoPair, mounting: Mounting) -> dict[str, Pair]:
    """What a matcher gets of a pair, for each of :data:`COLUMNS`; :class:`ValueError` if the default rectifier holds too few lines."""
    height, width = pair.left.shape
    level = Mounting(mounting.roll, mounting.offset, mounting.lens, 1)
    dark = Mounting(0, 0, 0, mounting.gain)
    rig = level.rig(width, height)
    check_lines([rig.left, rig.right], DEFAULT_LINES)

    def balanced(left: NDArray[np.uint8], right: NDArray[np.uint8]) -> Pair:
        return left, balance(left, right, 0, pair.disparities)

    seen, darker, both = (each.pair(pair) for each in (level, dark, mounting))
    exact = [linear(side, *level.sources(width, height, camera)) for camera, side in enumerate(seen)]
    return {
        "published": (pair.left, pair.right),
        "mounted": seen, "rectified": rig.rectified(*seen), "exact": (exact[0], exact[1]),
        "darker": darker, "balanced": balanced(*darker),
        "both": both, "both rectified": rig.rectified(*both), "both cured": balanced(*rig.rectified(*both))}


def parser() -> Parser:
    """The arguments of the command."""
    result = Parser(prog="golden cameras", description=(
        "Bad pixels of pairs as mounted cameras see them: the right one rolled and lower, both with a lens, the right one darker; before "
        "and after rectification with the gateware's map and balance, as the gateware computes both. Average of all pairs and masks."))
    add_data_option(result, sets=True)
    default = Mounting()
    result.add_argument("--roll", type=float, default=default.roll, metavar="DEGREES", help="of the right camera (default: %(default)g)")
    result.add_argument("--offset", type=float, default=default.offset, metavar="LINES", help="of the right camera (default: %(default)g)")
    result.add_argument("--lens", type=float, default=default.lens, metavar="K1", help=(
        "of both cameras, with a focal length of the picture's width (default: %(default)g)"))
    result.add_argument("--gain", type=float, default=default.gain, metavar="G", help=(
        "of the right camera's grey levels, above 0 to 1 (default: %(default)g)"))
    result.add_argument("--methods", nargs="+", choices=METHODS, default=DEFAULT, metavar="NAME", help=(
        f"those of golden rivals (default: {' '.join(DEFAULT)})"))
    result.add_argument("--json", type=Path, metavar="FILE", help="write the figures of every pair there too, percent; suffix .json")
    return result


def run(argv: Sequence[str] | None) -> None:
    """The command; :class:`UserError` on bad input."""
    options = parser().parse_args(argv)
    for name, limit in LIMITS.items():
        if not abs(getattr(options, name)) <= limit:
            raise UserError(f"--{name} must be from {-limit:g} to {limit:g}, not {getattr(options, name):g}; choose one in that range")
    if not (math.isfinite(options.gain) and 0 < options.gain <= 1):
        raise UserError(f"--gain must be above 0 and at most 1, not {options.gain:g}; choose one in that range")
    check_installed(*(needs for name in options.methods if (needs := METHODS[name].needs)))
    output = check_output(options.json, (".json",), option="--json") if options.json else None
    pairs = load_data(options.data)
    mounting = Mounting(options.roll, options.offset, options.lens, options.gain)

    figures: dict[str, dict[str, dict[str, list[float]]]] = {name: {column: {} for column in COLUMNS} for name in options.methods}
    with progress() as bar:
        task = bar.add_task("", total=len(pairs) * len(options.methods) * len(COLUMNS))
        for pair in pairs:
            try:
                inputs = pictures(pair, mounting)
            except ValueError as error:
                raise UserError(f"{pair.name}: {error}") from None
            for name in options.methods:
                for column, (left, right) in inputs.items():
                    bar.update(task, description=f"{pair.name} {name}")
                    found = METHODS[name].function(left, right, pair.disparities)
                    figures[name][column][pair.name] = [bad_pixels(found, pair.truth, mask) for mask in pair.masks.values()]
                    bar.advance(task)

    if output:
        document: dict[str, Any] = {
            "unit": "percent of pixels off by more than 1 pixel", "roll": mounting.roll, "offset": mounting.offset, "lens": mounting.lens,
            "gain": mounting.gain, "masks": list(pairs[0].masks), "figures": figures}
        write_json(output, document)
    print_table(_table(figures, mounting))


def _table(figures: dict[str, dict[str, dict[str, list[float]]]], mounting: Mounting) -> Table:
    result = Table(title=(f"Bad pixels, percent: right camera rolled by {mounting.roll:g} degrees and {mounting.offset:g} lines lower, "
                          f"lenses of k1 = {mounting.lens:g}; grey levels times {mounting.gain:g}"))
    result.add_column("pictures")
    for name in figures:
        result.add_column(name, justify="right")
    for column, what in COLUMNS.items():
        result.add_row(what, *(f"{np.mean(list(of[column].values())):.2f}" for of in figures.values()),
                       end_section=column in ("published", "exact", "balanced"))
    return result


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is the result."""
    return run_cli(run, argv, "golden cameras")
