"""`python -m golden rivals`: bad pixels and time of every method, side by side."""

import argparse
import textwrap
from collections.abc import Sequence
from pathlib import Path
from typing import Any

from rich.box import SIMPLE_HEAD
from rich.table import Table

from ...cli import Parser, progress
from ...errors import run_cli
from ...files import check_folder, check_output, write_json
from ...pictures.dataset import MASKS, StereoPair
from ...tables import print_table
from ..cache import Cache, run_kept
from ..evaluate import average
from ..published import TABLE_1, TABLE_1_PAIR
from ..workers import add_worker_options, check_installed, workers
from .options import add_pair_options, check_names, load_folders
from .registry import METHODS, figures, measure


__all__ = ["main"]


Result = dict[str, Any]

SOURCE = "the thesis, Table 1, as printed; on other machines, of its time"


Folders = dict[str, list[StereoPair]]


def averages(of_method: dict[str, Result], folders: Folders) -> dict[str, float]:
    """Average of all figures of a method, for each folder, percent."""
    return {folder: average({pair.name: of_method[pair.name]["figures"] for pair in pairs}) for folder, pairs in folders.items()}


def document(results: dict[str, dict[str, Result]], folders: Folders) -> dict[str, Any]:
    """The results for a file: measured figures, and printed ones in another part."""
    rows = {}
    for name, of_method in results.items():
        row: dict[str, Any] = {"about": METHODS[name].about, "averages": averages(of_method, folders),
                               "seconds": sum(one["seconds"] for one in of_method.values()), "pairs": of_method}
        if METHODS[name].published:
            row["published"] = METHODS[name].published
        rows[name] = row
    return {
        "unit": "percent of pixels off by more than 1 pixel", "seconds": "processor time of one thread", "energy": "of arithmetic linear",
        "methods": rows,
        "published": {"source": SOURCE, "pair": TABLE_1_PAIR, "rows": {
            name: {**row.figures, "tool": row.tool, "seconds": row.seconds} for name, row in TABLE_1.items()}}}


def summary(results: dict[str, dict[str, Result]], folders: Folders) -> Table:
    """A line for each method: the averages of the folders, and the seconds of all pairs."""
    result = Table(title="Averages, percent; seconds of all", box=SIMPLE_HEAD, padding=(0, 1, 0, 0))
    result.add_column("method", no_wrap=True)
    for folder, pairs in folders.items():
        result.add_column(f"{folder}\n{sum(len(pair.masks) for pair in pairs)} figures", justify="right", no_wrap=True)
    result.add_column("seconds", justify="right", no_wrap=True)
    for name, of_method in results.items():
        seconds = sum(one["seconds"] for one in of_method.values())
        result.add_row(name, *(f"{value:.2f}" for value in averages(of_method, folders).values()), f"{seconds:.2f}")
    return result


def table(results: dict[str, dict[str, Result]]) -> Table:
    """The results of a folder for reading, 80 characters wide: a block for each method; printed figures have separate columns."""
    result = Table(title="Bad pixels: off by more than 1 pixel, percent; seconds of one thread", box=SIMPLE_HEAD, padding=(0, 1, 0, 0),
                   caption=f"Printed: {SOURCE}.")
    result.add_column("method, pair", no_wrap=True)
    for column in (*MASKS, "seconds"):
        result.add_column(column, justify="right", no_wrap=True)
    for column in ("/".join(MASKS), "seconds"):
        result.add_column(f"printed\n{column}", justify="right", no_wrap=True)
    for name, of_method in results.items():
        result.add_row(name, style="bold")
        for pair, one in of_method.items():
            row = TABLE_1.get(METHODS[name].published or "") if pair == TABLE_1_PAIR else None
            printed = ["/".join(f"{row.figures[mask]:g}" for mask in MASKS), f"{row.seconds:g}"] if row else []
            result.add_row(f"  {pair}", *(f"{one['figures'][mask]:.2f}" for mask in MASKS), f"{one['seconds']:.2f}", *printed)
        figures = {pair: one["figures"] for pair, one in of_method.items()}
        seconds = sum(one["seconds"] for one in of_method.values())
        result.add_row(f"  average of {sum(map(len, figures.values()))}", "", "", f"{average(figures):.2f}", f"{seconds:.2f}",
                       end_section=True)
    return result


def energies(results: dict[str, dict[str, Result]]) -> list[str]:
    """A sentence for every pair: how far expansions lower the energy of the one-pass labels."""
    before, after = (results.get(name, {}) for name in ("one-pass-linear", "one-pass-expansion"))
    return [f"{pair}: expansions lower the energy of the one-pass labels from {one['energy']} to {after[pair]['energy']}, "
            f"by {100 * (1 - after[pair]['energy'] / one['energy']):.2f} %" for pair, one in before.items() if pair in after]


def parser() -> Parser:
    """The arguments of the command."""
    result = Parser(
        prog="golden rivals", formatter_class=argparse.RawDescriptionHelpFormatter, description=textwrap.fill(
            "Bad pixels and time of rival methods and of ours on the four pairs of the Middlebury benchmark, or on other sets, all "
            "from the same grey levels, next to the figures that the thesis's Table 1 prints; and their averages in one table. A worker "
            "computes one method on one pair at a time, and measures the processor time of its thread.", 100),
        epilog="\n".join(["methods:", *(f"  {name:22}{method.about}" for name, method in METHODS.items())]))
    add_pair_options(result, several=True)
    result.add_argument("--methods", nargs="+", choices=METHODS, default=list(METHODS), metavar="NAME", help="which (default: all)")
    result.add_argument("--cache", type=Path, default=Path("build/rivals"), metavar="DIR", help=(
        "keep results and times there, by the content of their inputs; a second run computes what changed (default: %(default)s)"))
    add_worker_options(result)
    result.add_argument("--output", type=Path, metavar="FILE", help="write the results there too; suffix .json")
    return result


def run(argv: Sequence[str] | None) -> None:
    """The command; :class:`UserError` on bad input."""
    options = parser().parse_args(argv)
    check_names(options, "methods", "pairs")
    output = check_output(options.output, (".json",)) if options.output else None
    check_installed(*sorted({need for name in options.methods if (need := METHODS[name].needs)}))
    check_folder(options.cache, "--cache")
    folders = load_folders(options.data, options.pairs)

    pairs = {pair.name: pair for of_folder in folders.values() for pair in of_folder}
    with workers(options.workers, options.scheduler) as compute, progress() as bar:
        task = bar.add_task("methods and pairs", total=None)
        found = run_kept(compute, Cache(options.cache), {(name, pair.name): (measure, pair, name)
                                                        for name in options.methods for pair in pairs.values()},
                         lambda count: bar.reset(task, total=count), lambda: bar.advance(task))
    results = {name: {pair: figures(each, found[name, pair]) for pair, each in pairs.items()} for name in options.methods}

    if output:
        write_json(output, document(results, folders))
    for of_folder in folders.values():
        print_table(table({name: {pair.name: of_method[pair.name] for pair in of_folder} for name, of_method in results.items()}))
    print_table(summary(results, folders))
    for sentence in energies(results):
        print(sentence)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is the result."""
    return run_cli(run, argv, "golden rivals")
