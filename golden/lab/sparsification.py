"""`python -m golden sparsification`: how well confidence ranks errors."""

from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.table import Table

from ..cli import Parser, add_method_options, either, method_config, methods_with, progress
from ..config import Fused
from ..errors import UserError, run_cli
from ..files import check_output
from ..matcher.matcher import in_pixels, match
from ..pictures.dataset import PAIRS, add_data_option, load_pairs
from ..pictures.sheet import SHEET_SUFFIXES, save_figure
from ..tables import print_table


__all__ = ["area", "area_above_oracle", "main", "sparsification"]


KEPT = (100, 90, 80, 70, 60, 50)  # percent of the pixels, columns of the table


def sparsification(confidence: NDArray[Any], bad: NDArray[np.bool_]) -> NDArray[np.float64]:
    """Bad pixels among the ``k`` most confident, percent, for ``k = 1 .. N``.

    Pixels of equal confidence are kept in random order; the result is the expectation.

    Parameters
    ----------
    confidence : (N,) ndarray
        Greater is more confident.
    bad : (N,) bool ndarray

    Returns
    -------
    (N,) float64 ndarray

    Examples
    --------
    >>> sparsification(np.array([3, 1, 3, 2]), np.array([False, True, True, False])).tolist()
    [50.0, 50.0, 33.333333333333336, 50.0]
    """
    _, level, count = np.unique(-np.asarray(confidence, dtype=np.float64), return_inverse=True, return_counts=True)
    share = np.bincount(level, weights=bad) / count  # of bad pixels at each level, the most confident first
    return 100 * np.cumsum(np.repeat(share, count)) / np.arange(1, level.size + 1)


def area(curve: NDArray[np.float64]) -> float:
    """Area under a curve of :func:`sparsification` over the share of pixels kept, 0 to 1: percent."""
    return float(curve.mean())


def area_above_oracle(confidence: NDArray[Any], bad: NDArray[np.bool_]) -> float:
    """Area between the curve and that of an oracle, which rejects bad pixels first (AUSE): percent; 0 is perfect.

    Examples
    --------
    >>> area_above_oracle(np.array([1, 1, 0]), np.array([False, False, True]))
    0.0
    """
    return area(sparsification(confidence, bad)) - area(sparsification(~np.asarray(bad), bad))


def plot(path: Path, curves: dict[str, tuple[NDArray[np.float64], NDArray[np.float64]]]) -> None:
    """Write a picture of the curves of every pair, and of its oracle; the suffix decides the format."""
    from matplotlib.figure import Figure  # here, because it takes longer to load than all the rest

    figure = Figure(figsize=(7, 5), layout="constrained")
    axes = figure.add_subplot()
    for number, (name, (curve, oracle)) in enumerate(curves.items()):
        kept = 100 * np.arange(1, curve.size + 1) / curve.size
        # A few hundred points suffice for the eye.
        some = slice(curve.size // 100, None, max(1, curve.size // 500))
        axes.plot(kept[some], curve[some], color=f"C{number}", label=name)
        axes.plot(kept[some], oracle[some], color=f"C{number}", linestyle=":", label=f"{name}, oracle")
    axes.set(xlabel="pixels kept, most confident first, %", ylabel="bad among them, %", xlim=(0, 100), ylim=(0, None),
             title="Sparsification: bad pixels (off by more than 1) by confidence")
    axes.legend()
    axes.grid(alpha=0.3)
    save_figure(path, figure)


def parser() -> Parser:
    """The arguments of the command."""
    result = Parser(prog="golden sparsification", description=(
        "Bad pixels among those kept when the least confident are rejected, on the four pairs of the Middlebury benchmark (all), and the "
        "area between that curve and an oracle's (AUSE): 0 is perfect; the last column is the area for random confidence."))
    add_data_option(result)
    add_method_options(result, method=Fused.name)
    result.add_argument("--output", type=Path, metavar="FILE", help=f"draw the curves there; suffix {', '.join(SHEET_SUFFIXES)}")
    return result


def run(argv: Sequence[str] | None) -> None:
    """The command; :class:`UserError` on bad input."""
    options = parser().parse_args(argv)
    config = method_config(options, max(disparities for disparities, _ in PAIRS.values()))
    if "confidence" not in config.result_fields:
        ranked = either(methods_with(lambda method: "confidence" in method.result_fields(config.labels, config.minimum)))
        raise UserError(f"--method {options.method} has no confidence; choose --method {ranked}")
    output = check_output(options.output, SHEET_SUFFIXES) if options.output else None
    pairs = load_pairs(options.data)

    table = Table(title="Sparsification: bad pixels (off by more than 1) among those kept, percent")
    for column in ("pair", *(f"{kept} %" for kept in KEPT), "AUSE", "of random"):
        table.add_column(column, justify="left" if column == "pair" else "right")
    curves = {}
    areas = []
    with progress() as bar:
        for pair in bar.track(pairs):
            config = method_config(options, pair.disparities)
            fields = match(pair.left, pair.right, config)
            counted = pair.masks["all"] & np.isfinite(pair.truth)
            bad = (np.abs(in_pixels(fields["disparity"], config) - pair.truth) > 1)[counted]
            confidence = fields["confidence"][counted]
            curve, oracle = sparsification(confidence, bad), sparsification(~bad, bad)
            curves[pair.name] = curve, oracle
            areas.append((area_above_oracle(confidence, bad), area_above_oracle(np.zeros(bad.size), bad)))
            shares = [curve[bad.size * kept // 100 - 1] for kept in KEPT]
            table.add_row(pair.name, *(f"{value:.2f}" for value in (*shares, *areas[-1])))
    table.add_section()
    table.add_row(f"average of {len(areas)}", *[""] * len(KEPT), *(f"{value:.2f}" for value in np.mean(areas, axis=0)))
    if output:
        plot(output, curves)
    print_table(table)


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is the result."""
    return run_cli(run, argv, "golden sparsification")
