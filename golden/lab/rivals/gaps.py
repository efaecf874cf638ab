"""`python -m golden gaps`: how far the one-pass rule is from the minimum cut of every line."""

import time
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from ...cli import Parser, progress
from ...config import Arithmetic, MatcherConfig, OnePass
from ...errors import UserError, run_cli
from ...files import check_output, write_json
from ...matcher.cost import local_disparity, matching_cost
from ...matcher.labelling import labelling
from ...pictures.dataset import StereoPair
from ...pictures.sets import load_data
from ...pictures.sheet import SHEET_SUFFIXES, save_figure
from ...tables import print_table
from ..workers import check_installed
from .maxflow import LineGraph, augmenting_path, cut_labels, line_energy, line_graph, line_terms, push_relabel
from .options import add_pair_options, check_names


__all__ = ["LineGap", "gaps", "main"]


QUANTILES = (0, 10, 25, 50, 75, 90, 100)  # percent of the lines


@dataclass(frozen=True)
class LineGap:
    """The rule and the minimum cut on a line; all energies in ``LINEAR`` arithmetic.

    Parameters
    ----------
    rule, least : int
        Energies of the rule's labels and of the minimum cut.
    differ : float
        Share of the pixels whose labels differ in rule and cut, ``0..1``.
    seconds : (float, float)
        Processor time of augmenting paths and of push-relabel, including the construction of their graphs.
    """
    rule: int
    least: int
    differ: float
    seconds: tuple[float, float]

    @property
    def percent(self) -> float:
        """Energy of the rule above the minimum, percent of the minimum."""
        return 100 * (self.rule - self.least) / self.least if self.least else 0.0 if self.rule == 0 else float("inf")


def _timed(solve: Callable[[LineGraph], tuple[int, NDArray[np.bool_]]], graph: LineGraph) -> tuple[int, NDArray[np.bool_], float]:
    start = time.thread_time()
    flow, side = solve(graph)
    return flow, side, time.thread_time() - start


def gaps(pair: StereoPair, every: int = 1, advance: Callable[[], object] = lambda: None) -> list[LineGap]:
    """The gap of every line of a pair, or of one line in ``every``.

    The energy of a line is that of the rule (2-15): matching costs, smoothness along the line, and smoothness against the upper line as
    the rule labels it and against the lower line's local disparities. So rule and cut minimise the same sum: the rule in one pass from
    the left, the cut for the whole line. The two maximum flows must agree.

    Parameters
    ----------
    pair : StereoPair
    every : int
    advance : callable
        Called after every line.
    """
    config = MatcherConfig(pair.disparities, method=OnePass(Arithmetic.LINEAR))
    cost = matching_cost(pair.left, pair.right, config)
    local = local_disparity(cost)
    labels = labelling(cost, local, pair.left, config)
    result = []
    for y in range(0, len(labels), every):
        data, weight = line_terms(cost, pair.left, labels, local, y, config)
        graph = line_graph(data, weight)
        flow, side, by_paths = _timed(augmenting_path, graph)
        other_flow, _, by_push = _timed(push_relabel, graph)
        found = cut_labels(side)
        least = line_energy(found, data, weight)
        if not flow == other_flow == least:
            raise ArithmeticError(f"line {y} of {pair.name}: augmenting paths give {flow}, push-relabel {other_flow}, the labels {least}")
        result.append(LineGap(line_energy(labels[y], data, weight), least, float(np.mean(found != labels[y])), (by_paths, by_push)))
        advance()
    return result


def table(results: dict[str, list[LineGap]]) -> Table:
    """The distribution of the gaps, a column for each pair."""
    result = Table(title="Energy of the one-pass rule above the minimum cut of each line")
    result.add_column("")
    for name in results:
        result.add_column(name, justify="right")
    every = list(results.values())
    percents = [[line.percent for line in lines] for lines in every]

    def row(words: str, values: Iterable[str], **options: Any) -> None:
        result.add_row(words, *values, **options)

    row("lines", (str(len(lines)) for lines in every))
    row("of them, the rule is optimal on", (str(sum(line.rule == line.least for line in lines)) for lines in every), end_section=True)
    for quantile in QUANTILES:
        row(f"gap, quantile {quantile} %", (f"{np.percentile(values, quantile):.2f} %" for values in percents))
    row("gap, mean", (f"{np.mean(values):.2f} %" for values in percents), end_section=True)
    row("pixels of another label", (f"{100 * np.mean([line.differ for line in lines]):.1f} %" for lines in every), end_section=True)
    for number, words in enumerate(("augmenting paths", "push-relabel")):
        row(f"{words}, ms a line, median", (f"{1000 * np.median([line.seconds[number] for line in lines]):.2f}" for lines in every))
    return result


def document(results: dict[str, list[LineGap]]) -> dict[str, Any]:
    """The results for a file: the energies of every line."""
    return {"energy": "of arithmetic linear", "pairs": {
        name: {"rule": [line.rule for line in lines], "least": [line.least for line in lines], "differ": [line.differ for line in lines],
               "seconds_augmenting_path": sum(line.seconds[0] for line in lines),
               "seconds_push_relabel": sum(line.seconds[1] for line in lines)} for name, lines in results.items()}}


def plot(path: Path, results: dict[str, list[LineGap]]) -> None:
    """Write a picture of a histogram for every pair; the suffix decides the format."""
    from matplotlib.figure import Figure  # here, because it takes longer to load than all the rest

    figure = Figure(figsize=(7, 1.6 + 1.5 * len(results)), layout="constrained")
    percents = {name: np.array([line.percent for line in lines]) for name, lines in results.items()}
    # The few outliers would compress the others into one bar; the last bar collects them.
    end = max(float(np.percentile(values, 97)) for values in percents.values()) or 1.0
    bins = np.linspace(0, end, 41)
    for number, (axes, (name, values)) in enumerate(zip(figure.subplots(len(results), sharex=True, squeeze=False)[:, 0], percents.items(),
                                                        strict=True)):
        axes.hist(np.minimum(values, end), bins, color=f"C{number}")
        median = float(np.median(values))
        axes.axvline(median, color="black", linestyle=":", label=f"median {median:.2f} %")
        axes.set(ylabel="lines", title=f"{name}, {values.size} lines")
        axes.legend()
        axes.grid(alpha=0.3)
    axes.set(xlabel=f"energy above the minimum cut, % (last bar: {bins[-2]:.1f} and more)", xlim=(0, end))
    figure.suptitle("One-pass rule against the minimum cut of each line")
    save_figure(path, figure)


def parser() -> Parser:
    """The arguments of the command."""
    result = Parser(prog="golden gaps", description=(
        "The thesis's row-column graph of every scanline, cut exactly by the maximum flows of two libraries, augmenting paths (PyMaxflow) "
        "and push-relabel (OR-Tools), which must agree; and how far the energy of the one-pass rule is above it on that line."))
    add_pair_options(result)
    result.add_argument("--every", type=int, default=1, metavar="N", help="take one line in N (default: %(default)s)")
    result.add_argument("--output", type=Path, metavar="FILE", help=f"draw the histograms there; suffix {', '.join(SHEET_SUFFIXES)}")
    result.add_argument("--json", type=Path, metavar="FILE", help="write the energies of all lines there; suffix .json")
    return result


def run(argv: Sequence[str] | None) -> None:
    """The command; :class:`UserError` on bad input."""
    options = parser().parse_args(argv)
    check_names(options, "pairs")
    if options.every < 1:
        raise UserError(f"--every must be at least 1, not {options.every}; choose a greater number")
    output = check_output(options.output, SHEET_SUFFIXES) if options.output else None
    numbers = check_output(options.json, (".json",), "--json") if options.json else None
    check_installed("maxflow", "ortools")
    pairs = load_data(options.data, options.pairs)

    results = {}
    with progress() as bar:
        task = bar.add_task("", total=sum(len(range(0, len(pair.left), options.every)) for pair in pairs))
        for pair in pairs:
            bar.update(task, description=pair.name)
            results[pair.name] = gaps(pair, options.every, lambda: bar.advance(task))

    if output:
        plot(output, results)
    if numbers:
        write_json(numbers, document(results))
    print_table(table(results))


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is the result."""
    return run_cli(run, argv, "golden gaps")
