"""`python -m golden evaluate`: bad pixels on the Middlebury benchmark."""

import json
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from rich.console import Console
from rich.table import Table

from .cli import Parser, add_matcher_options, matcher_config, progress
from .config import Arithmetic, MatcherConfig
from .dataset import MASKS, PAIRS, StereoPair, data_folder, load_pair
from .errors import run_cli
from .files import atomic, check_output
from .labelling import match
from .metrics import bad_pixels


__all__ = ["average", "evaluate", "main", "table"]


Figures = dict[str, dict[str, float]]


def evaluate(pairs: Iterable[StereoPair], configure: Callable[[int], MatcherConfig]) -> Figures:
    """Percentage of bad pixels of every pair, for each of its masks.

    Parameters
    ----------
    pairs : iterable of StereoPair
    configure : callable
        Gives the configuration for a number of disparities.

    Returns
    -------
    dict
        ``result[pair][mask]``, percent.
    """
    result = {}
    for pair in pairs:
        labels = match(pair.left, pair.right, configure(pair.disparities))
        result[pair.name] = {name: bad_pixels(labels, pair.truth, mask) for name, mask in pair.masks.items()}
    return result


def average(figures: Figures) -> float:
    """Mean of all figures, percent: the benchmark's, over the twelve of four pairs with three masks.

    Examples
    --------
    >>> average({"tsukuba": {"nonocc": 1.0, "all": 2.0}, "venus": {"nonocc": 4.0, "all": 5.0}})
    3.0
    """
    values = [value for of_pair in figures.values() for value in of_pair.values()]
    return sum(values) / len(values)


def table(rows: dict[str, Figures]) -> Table:
    """The figures for reading: a block of lines for each arithmetic, in percent to two decimals."""
    result = Table(title="Bad pixels: off by more than 1 pixel, percent")
    result.add_column("arithmetic")
    result.add_column("pair")
    for mask in MASKS:
        result.add_column(mask, justify="right")
    for arithmetic, figures in rows.items():
        for number, (pair, of_pair) in enumerate(figures.items()):
            result.add_row("" if number else arithmetic, pair, *(f"{of_pair[mask]:.2f}" for mask in MASKS))
        count = sum(map(len, figures.values()))
        result.add_row("", f"average of {count}", "", "", f"{average(figures):.2f}", end_section=True)
    return result


def parser() -> Parser:
    """The arguments of the command."""
    result = Parser(prog="golden evaluate", description="Bad pixels of the golden model on the four pairs of the Middlebury benchmark.")
    result.add_argument("--data", type=Path, metavar="DIR",
                        help=f"folder that holds {', '.join(PAIRS)} (default: $STEREO_DATA, else ../shared/data/middlebury)")
    add_matcher_options(result, default=None)
    result.add_argument("--json", type=Path, metavar="FILE", help="write the figures there too, percent; suffix .json")
    return result


def run(argv: Sequence[str] | None) -> None:
    """The command; :class:`UserError` on bad input."""
    options = parser().parse_args(argv)
    arithmetics = [options.arithmetic] if options.arithmetic else list(Arithmetic)
    matcher_config(options, max(disparities for disparities, _ in PAIRS.values()), arithmetics[0])
    output = check_output(options.json, (".json",), option="--json") if options.json else None
    folder = data_folder(options.data)
    pairs = [load_pair(folder, name) for name in PAIRS]

    rows: dict[str, Figures] = {}
    with progress() as bar:
        task = bar.add_task("", total=len(arithmetics) * len(pairs))
        for arithmetic in arithmetics:
            def configure(disparities: int, arithmetic: Arithmetic = arithmetic) -> MatcherConfig:
                return matcher_config(options, disparities, arithmetic)

            rows[arithmetic.value] = {}
            for pair in pairs:
                bar.update(task, description=f"{arithmetic} {pair.name}")
                rows[arithmetic.value].update(evaluate([pair], configure))
                bar.advance(task)

    if output:
        settings = {name: getattr(options, name) for name in ("fraction_bits", "u1", "u2", "u3")}
        document: dict[str, Any] = {"unit": "percent of pixels off by more than 1 pixel", **settings, "rows": [
            {"arithmetic": arithmetic, "average": average(figures), "pairs": figures} for arithmetic, figures in rows.items()]}
        with atomic(output) as file:
            file.write(f"{json.dumps(document, indent=2)}\n".encode())
    Console().print(table(rows))


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is the result."""
    return run_cli(run, argv, "golden evaluate")
