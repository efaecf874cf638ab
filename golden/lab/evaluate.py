"""`python -m golden evaluate`: bad pixels on the Middlebury benchmark, or on any other sets."""

import argparse
import dataclasses
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from rich.table import Table

from ..cli import Parser, add_method_options, method_config, progress, refines_by_default
from ..config import Arithmetic, MatcherConfig, Method, changed, parameters_of, value_of
from ..errors import run_cli
from ..files import check_output, write_json
from ..matcher.matcher import disparities as match
from ..pictures.dataset import MASKS, PAIRS, StereoPair, add_data_option
from ..pictures.metrics import bad_pixels
from ..pictures.sets import add_noise_option, check_noise, load_data, with_noise
from ..pictures.truth import add_threshold_option, check_threshold
from ..tables import print_table


__all__ = ["average", "evaluate", "main", "table"]


Figures = dict[str, dict[str, float]]
Configure = Callable[[int], MatcherConfig]


def evaluate(pairs: Iterable[StereoPair], configure: Configure, threshold: float = 1.0) -> Figures:
    """Percentage of bad pixels of every pair, for each of its masks.

    Parameters
    ----------
    pairs : iterable of StereoPair
    configure : callable
        Takes a number of disparities, returns the configuration.
    threshold : float
        Pixels; of :func:`golden.pictures.metrics.bad_pixels`.

    Returns
    -------
    dict
        ``result[pair][mask]``, percent.
    """
    result = {}
    for pair in pairs:
        labels = match(pair.left, pair.right, configure(pair.disparities))
        result[pair.name] = {name: bad_pixels(labels, pair.truth, mask, threshold) for name, mask in pair.masks.items()}
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


def table(rows: dict[str, Figures], threshold: float = 1.0, column: str = "method") -> Table:
    """The figures as a table: a block of lines for each row, in percent to two decimals."""
    result = Table(title=f"Bad pixels: off by more than {threshold:g} pixel, percent")
    result.add_column(column)
    result.add_column("pair")
    for mask in MASKS:
        result.add_column(mask, justify="right")
    for name, figures in rows.items():
        for number, (pair, of_pair) in enumerate(figures.items()):
            result.add_row("" if number else name, pair, *(f"{of_pair[mask]:.2f}" for mask in MASKS))
        count = sum(map(len, figures.values()))
        result.add_row("", f"average of {count}", "", "", f"{average(figures):.2f}", end_section=True)
    return result


def parser() -> Parser:
    """The arguments of the command."""
    result = Parser(prog="golden evaluate", description=(
        "Bad pixels of the golden model on the four pairs of the Middlebury benchmark, or on all sets of another folder. Without a "
        "switch, a method with stages of refinement is shown without and with all of them; --sub-pixel shows disparities rounded to "
        "pixels and with a fraction."))
    add_data_option(result, sets=True)
    add_method_options(result, thesis="all three")
    add_threshold_option(result)
    add_noise_option(result)
    result.add_argument("--json", type=Path, metavar="FILE", help="write the figures there too, percent; suffix .json")
    return result


def _stages(method: Method) -> str:
    """Words for the stages in use; the method's name if it has no switches."""
    on = [name for name in method.SWITCHES if value_of(method, name)]
    words = [method.name] if not method.SWITCHES else ["refined"] if len(on) == len(method.SWITCHES) else on or ["unrefined"]
    return " + ".join([*words, "sub-pixel"] if method.disparity_scale > 1 else words)


def _rows(options: argparse.Namespace) -> dict[str, Configure]:
    """The rows that the options select: name, and a function from the number of disparities to the configuration. A method with a choice
    of arithmetics has a row for each, others one for each way through their stages."""
    given = method_config(options, MatcherConfig.LABELS[0]).method
    if "arithmetic" in parameters_of(given):
        def of(arithmetic: Arithmetic) -> Configure:
            return lambda disparities: method_config(options, disparities, arithmetic)

        return {str(each): of(each) for each in ([options.arithmetic] if options.arithmetic else Arithmetic)}

    def row(method: Method) -> Configure:
        return lambda disparities: dataclasses.replace(method_config(options, disparities), method=method)

    whole = changed(given, sub_pixel=False) if "sub_pixel" in parameters_of(given) else given
    alone = [changed(whole, **dict.fromkeys(given.SWITCHES, False))] if given.SWITCHES and refines_by_default(options) else []
    # Each once, in this order.
    return {_stages(each): row(each) for each in [*alone, whole, given]}


def run(argv: Sequence[str] | None) -> None:
    """The command; :class:`UserError` on bad input."""
    options = parser().parse_args(argv)
    check_threshold(options)
    check_noise(options)
    rows = _rows(options)
    sample = [configure(max(disparities for disparities, _ in PAIRS.values())) for configure in rows.values()]
    output = check_output(options.json, (".json",), option="--json") if options.json else None
    pairs = load_data(options.data)
    if options.noise:
        pairs = [with_noise(pair, options.noise) for pair in pairs]

    results: dict[str, Figures] = {}
    with progress() as bar:
        task = bar.add_task("", total=len(rows) * len(pairs))
        for name, configure in rows.items():
            results[name] = {}
            for pair in pairs:
                bar.update(task, description=f"{name} {pair.name}")
                results[name].update(evaluate([pair], configure, options.threshold))
                bar.advance(task)

    if output:
        document: dict[str, Any] = {
            "unit": f"percent of pixels off by more than {options.threshold:g} pixel", "noise": options.noise,
            "method": options.method,
            "rows": [
                {"name": name, "arithmetic": config.method.arithmetic, "method_parameters": config.method.about(),
                 "average": average(figures), "pairs": figures} for config, (name, figures) in zip(sample, results.items(), strict=True)]}
        write_json(output, document)
    shown = table(results, options.threshold, f"method {options.method}")
    if options.noise:
        shown.title = f"{shown.title}; noise of {options.noise:g} grey levels"
    print_table(shown)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is the result."""
    return run_cli(run, argv, "golden evaluate")
