"""`python -m golden evaluate`: bad pixels on the Middlebury benchmark."""

import argparse
import dataclasses
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any

from rich.table import Table

from ..cli import STAGES, Parser, add_method_options, method_config, progress
from ..config import Arithmetic, Fused, MatcherConfig, OnePass, Refinement, value_of
from ..errors import run_cli
from ..files import check_output, write_json
from ..matcher.matcher import disparities as match
from ..pictures.dataset import MASKS, PAIRS, StereoPair, add_data_option, load_pairs
from ..pictures.metrics import bad_pixels
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


def table(rows: dict[str, Figures], threshold: float = 1.0, column: str = "arithmetic") -> Table:
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
        "Bad pixels of the golden model on the four pairs of the Middlebury benchmark. --cost fused without a switch shows the rule alone "
        "and with all stages of the refinement; --sub-pixel shows disparities rounded to pixels and with a fraction."))
    add_data_option(result)
    add_method_options(result, thesis="all three")
    add_threshold_option(result)
    result.add_argument("--json", type=Path, metavar="FILE", help="write the figures there too, percent; suffix .json")
    return result


def _stages(refinement: Refinement) -> str:
    """Words for the stages in use."""
    on = [name for name in STAGES if getattr(refinement, name)]
    words = ["refined"] if len(on) == len(STAGES) else on or ["rule alone"]
    return " + ".join([*words, "sub-pixel"] if refinement.sub_pixel else words)


def _refined(config: MatcherConfig, refinement: Refinement) -> MatcherConfig:
    return dataclasses.replace(config, method=dataclasses.replace(config.method_as(Fused), refinement=refinement))


def _rows(options: argparse.Namespace) -> dict[str, Configure]:
    """The rows that the options select: name, and a function from the number of disparities to the configuration."""
    if options.cost == OnePass.name:
        def thesis(arithmetic: Arithmetic) -> Configure:
            return lambda disparities: method_config(options, disparities, arithmetic)

        return {str(each): thesis(each) for each in ([options.arithmetic] if options.arithmetic else Arithmetic)}

    def fused(refinement: Refinement) -> Configure:
        return lambda disparities: _refined(method_config(options, disparities), refinement)

    given = method_config(options, MatcherConfig.LABELS[0]).method_as(Fused).refinement
    whole = dataclasses.replace(given, sub_pixel=False)
    alone = dataclasses.replace(whole, check=False, fill=False, median=False)
    by_default = all(getattr(options, name) is None for name in ("refine", *STAGES))
    # Each once, in this order.
    return {_stages(each): fused(each) for each in ([alone] if by_default else []) + [whole, given]}


def run(argv: Sequence[str] | None) -> None:
    """The command; :class:`UserError` on bad input."""
    options = parser().parse_args(argv)
    check_threshold(options)
    rows = _rows(options)
    sample = [configure(max(disparities for disparities, _ in PAIRS.values())) for configure in rows.values()]
    output = check_output(options.json, (".json",), option="--json") if options.json else None
    pairs = load_pairs(options.data)

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
        one = sample[0]  # rows differ only in arithmetic or stages
        document: dict[str, Any] = {
            "unit": f"percent of pixels off by more than {options.threshold:g} pixel", "cost": one.method.name,
            "fraction_bits": value_of(one.method, "energy_shift" if options.cost == Fused.name else "fraction_bits"),
            **one.method.weights._asdict(),
            "rows": [
                {"arithmetic": config.method.arithmetic, **({"stages": name} if options.cost == Fused.name else {}),
                 "average": average(figures), "pairs": figures} for config, (name, figures) in zip(sample, results.items(), strict=True)]}
        write_json(output, document)
    print_table(table(results, options.threshold, "arithmetic" if options.cost == OnePass.name else "fused cost"))


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is the result."""
    return run_cli(run, argv, "golden evaluate")
