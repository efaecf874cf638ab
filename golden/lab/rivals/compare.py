"""`python -m golden compare`: both methods of ours and a rival on scenes that are hard for them, with pictures."""

import argparse
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.box import SIMPLE_HEAD
from rich.console import Console
from rich.table import Table

from ...cli import Parser, progress
from ...config import MatcherConfig
from ...errors import UserError, run_cli
from ...files import check_output
from ...pictures.dataset import motorcycle
from ...pictures.images import read_pair
from ...pictures.metrics import bad_pixels
from ...pictures.scenes import SCENES
from ...pictures.sheet import SHEET_SUFFIXES, Strip, write_comparison
from ...pictures.truth import add_truth_options, check_truth_options, read_truth
from ..workers import check_installed
from .options import check_names
from .registry import METHODS


__all__ = ["View", "main", "views"]


DEFAULT_METHODS = ("one-pass-linear", "one-pass-fused", "one-pass-fused-2", "opencv-sgbm")
SCENE_SIZE = (320, 200, 32)  # width and height, pixels; number of disparities
KNOWN = "known"
FIGURES = {KNOWN: "all of known truth", "nonocc": "what the right picture shows too", "hard": "what the scene is about"}

Figures = dict[str, float]


@dataclass(frozen=True)
class View:
    """A pair to compare methods on.

    Parameters
    ----------
    name : str
    left, right : (H, W) uint8 ndarray
        Grey levels.
    truth : (H, W) float64 ndarray or None
        Pixels; ``inf`` where unknown.
    masks : dict of str to (H, W) bool ndarray
        Pixels that count, by the name of the figure, one of :data:`FIGURES`.
    disparities : int
    """
    name: str
    left: NDArray[np.uint8]
    right: NDArray[np.uint8]
    truth: NDArray[np.float64] | None
    masks: dict[str, NDArray[np.bool_]]
    disparities: int


def views(names: Sequence[str]) -> list[View]:
    """Scenes of :data:`golden.pictures.scenes.SCENES`, of 320x200 pixels and 32 disparities; the same at every call."""
    result = []
    for seed, (name, make) in enumerate(SCENES.items(), start=1):
        if name in names:
            scene = make(*SCENE_SIZE, seed)
            masks = dict(zip(FIGURES, (np.ones_like(scene.visible), scene.visible, scene.hard), strict=True))
            result.append(View(name, scene.left, scene.right, scene.truth, masks, SCENE_SIZE[2]))
    return result


def figures(view: View, found: NDArray[Any], threshold: float) -> Figures:
    """Percentage of bad pixels for each mask; none without a truth."""
    return {} if view.truth is None else {name: bad_pixels(found, view.truth, mask, threshold) for name, mask in view.masks.items()}


def table(rows: dict[str, dict[str, Figures]], threshold: float) -> Table:
    """The figures for reading: a block of rows for every view, a column for every method."""
    result = Table(title=f"Bad pixels: off by more than {threshold:g} pixel, percent", box=SIMPLE_HEAD, padding=(0, 1, 0, 0),
                   caption="; ".join(f"{name}: {what}" for name, what in FIGURES.items()))
    for column in ("", "pixels"):
        result.add_column(column, no_wrap=True)
    for method in next(iter(rows.values())):
        result.add_column(method, justify="right", no_wrap=True)
    for name, of_view in rows.items():
        masks = list(next(iter(of_view.values())))
        for mask in masks:
            result.add_row(name if mask == masks[0] else "", mask, *(f"{of_method[mask]:.2f}" for of_method in of_view.values()),
                           end_section=mask == masks[-1])
        if not masks:
            result.add_row(name, "no truth", end_section=True)
    return result


def parser() -> Parser:
    """The arguments of the command."""
    result = Parser(prog="golden compare", description=(
        "Bad pixels and disparities of several methods side by side: on the Motorcycle pair of scikit-image at full size, or on LEFT and "
        "RIGHT in its place, and on synthetic scenes that are hard for them. Needs no data."))
    result.add_argument("left", nargs="?", type=Path, metavar="LEFT", help="left picture, as of golden match")
    result.add_argument("right", nargs="?", type=Path, metavar="RIGHT", help="right picture, of the same size")
    result.add_argument("--disparities", type=int, metavar="N", help="number of disparities of LEFT and RIGHT")
    result.add_argument("--scenes", nargs="*", choices=SCENES, default=list(SCENES), metavar="NAME",
                        help=f"which scenes, none too: {', '.join(SCENES)} (default: all)")
    result.add_argument("--methods", nargs="+", choices=METHODS, default=list(DEFAULT_METHODS), metavar="NAME",
                        help=f"which of those of golden rivals (default: {' '.join(DEFAULT_METHODS)})")
    add_truth_options(result)
    result.add_argument("--output", type=Path, metavar="FILE", help=f"draw all pictures there; suffix {', '.join(SHEET_SUFFIXES)}")
    return result


def _own(options: argparse.Namespace) -> View:
    """The view of LEFT and RIGHT."""
    try:
        config = MatcherConfig(disparities=options.disparities)
    except ValueError as error:
        raise UserError(f"--{error}; choose a value in that range") from None
    left, right = read_pair(options.left, options.right)
    found = read_truth(options, left.shape, config)
    truth, mask = found or (None, None)
    return View(options.left.name, left, right, truth, {} if mask is None else {KNOWN: mask}, options.disparities)


def _first(options: argparse.Namespace) -> View:
    """The view of LEFT and RIGHT, or else of the Motorcycle pair."""
    if options.left:
        return _own(options)
    pair = motorcycle(factor=1, max_width=1000, max_height=1000)
    return View(pair.name, pair.left, pair.right, pair.truth, {KNOWN: pair.masks["known"]}, pair.disparities)


def _check(options: argparse.Namespace) -> None:
    """:class:`UserError` unless the options make sense together."""
    check_names(options, "scenes", "methods")
    if options.left and not options.right:
        raise UserError(f"{options.left} has no right picture; give LEFT and RIGHT, or neither for the Motorcycle pair")
    limits = MatcherConfig.DISPARITIES
    if options.left and options.disparities is None:
        raise UserError(f"--disparities is missing; give the number of disparities of the pictures, {limits[0]} to {limits[-1]}")
    for name in ("disparities", "truth"):
        if getattr(options, name) is not None and not options.left:
            raise UserError(f"--{name} {getattr(options, name)} is for LEFT and RIGHT, which are missing; give them or leave it out")
    check_truth_options(options)


def run(argv: Sequence[str] | None) -> None:
    """The command; :class:`UserError` on bad input."""
    options = parser().parse_args(argv)
    _check(options)
    output = check_output(options.output, SHEET_SUFFIXES) if options.output else None
    check_installed(*sorted({need for name in options.methods if (need := METHODS[name].needs)}))

    rows: dict[str, dict[str, Figures]] = {}
    strips = []
    compared = [_first(options), *views(options.scenes)]
    with progress() as bar:
        task = bar.add_task("", total=len(compared) * len(options.methods))
        for view in compared:
            rows[view.name] = {}
            unknown = np.full(view.left.shape, np.inf)
            pictures: dict[str, NDArray[Any]] = {"truth": unknown if view.truth is None else view.truth}
            for method in options.methods:
                bar.update(task, description=f"{view.name}, {method}")
                found = METHODS[method].function(view.left, view.right, view.disparities)
                rows[view.name][method] = bad = figures(view, found, options.threshold)
                pictures[f"{method}: {bad[KNOWN]:.1f} % bad" if bad else method] = found
                bar.advance(task)
            strips.append(Strip(view.name, view.left, pictures, (0, view.disparities - 1)))
    if output:
        write_comparison(output, strips)
    Console().print(table(rows, options.threshold))


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is the result."""
    return run_cli(run, argv, "golden compare")
