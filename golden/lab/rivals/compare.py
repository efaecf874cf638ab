"""`python -m golden compare`: our methods and a rival on scenes that are hard for them, with pictures and a page."""

import argparse
import hashlib
import os
import shlex
import sys
from collections.abc import Callable, Collection, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray
from rich.box import SIMPLE_HEAD
from rich.table import Table

from ...cli import Parser, check_disparities, progress
from ...config import MatcherConfig
from ...errors import UserError, run_cli
from ...files import atomic, check_output
from ...pages import digest, origin
from ...pages import table as markdown_table
from ...pictures.dataset import motorcycle
from ...pictures.images import read_pair
from ...pictures.metrics import bad_pixels
from ...pictures.scenes import SCENES
from ...pictures.sheet import SHEET_SUFFIXES, Strip, write_comparison
from ...pictures.truth import add_truth_options, check_truth_options, read_truth
from ...pictures.white import add_white_option, check_white
from ...tables import print_table
from ..workers import check_installed
from .options import check_names, load_folders
from .registry import COMPARED, METHODS


__all__ = ["BY_HAND", "DEFAULT_METHODS", "View", "compare", "inputs", "main", "motorcycle_view", "views"]


DEFAULT_METHODS = ("one-pass-linear", *COMPARED)
SCENE_SIZE = (320, 200, 32)  # width and height, pixels; number of disparities
SMALL_SIZE = (48, 40, 8)     # of the scenes for the digest
KNOWN = "known"
SEEN = ("nonocc", "disc")
FIGURES = {KNOWN: "all of known truth", "nonocc": "not occluded", "disc": "near discontinuities",
           "hard": "the objects that the scene is made for"}

#: Of a page, what follows this line is written by hand and kept when the page is written again.
BY_HAND = "<!-- By hand from here on; the command keeps it. -->"

Figures = dict[str, float]
Rows = dict[str, dict[str, Figures]]  # by view and method


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
    folder : str or None
        Of a set: that of ``--data``, over which figures are averaged.
    """
    name: str
    left: NDArray[np.uint8]
    right: NDArray[np.uint8]
    truth: NDArray[np.float64] | None
    masks: dict[str, NDArray[np.bool_]]
    disparities: int
    folder: str | None = None


def set_views(folders: Sequence[Path]) -> list[View]:
    """The sets of some folders."""
    return [View(pair.name, pair.left, pair.right, pair.truth, {KNOWN: pair.masks["all"], **{name: pair.masks[name] for name in SEEN}},
                 pair.disparities, folder) for folder, pairs in load_folders(folders).items() for pair in pairs]


def views(names: Collection[str], size: tuple[int, int, int] | None = None) -> list[View]:
    """Scenes of :data:`golden.pictures.scenes.SCENES` by name, of 320x200 pixels and 32 disparities or another size; always the same."""
    size = size or SCENE_SIZE
    result = []
    for seed, (name, make) in enumerate(SCENES.items(), start=1):
        if name in names:
            scene = make(*size, seed)
            masks = {KNOWN: np.ones_like(scene.visible), "nonocc": scene.visible, "hard": scene.hard}
            result.append(View(name, scene.left, scene.right, scene.truth, masks, size[2]))
    return result


def motorcycle_view() -> View:
    """The Motorcycle pair at full size."""
    pair = motorcycle(factor=1, max_width=1000, max_height=1000)
    return View(pair.name, pair.left, pair.right, pair.truth, {KNOWN: pair.masks["known"]}, pair.disparities)


def figures(view: View, found: NDArray[Any], threshold: float) -> Figures:
    """Percentage of bad pixels for each mask; empty without a truth."""
    return {} if view.truth is None else {name: bad_pixels(found, view.truth, mask, threshold) for name, mask in view.masks.items()}


def compare(compared: Sequence[View], methods: Sequence[str], threshold: float,
            begin: Callable[[str], object] = lambda what: None,
            advance: Callable[[], object] = lambda: None) -> tuple[Rows, list[Strip]]:
    """Bad pixels of every view and method, and a row of pictures for every view.

    ``begin`` is called before each view and method with their names, ``advance`` after it.
    """
    rows: Rows = {}
    strips = []
    for view in compared:
        rows[view.name] = {}
        unknown = np.full(view.left.shape, np.inf)
        pictures: dict[str, NDArray[Any]] = {"truth": unknown if view.truth is None else view.truth}
        for method in methods:
            begin(f"{view.name}, {method}")
            found = METHODS[method].function(view.left, view.right, view.disparities)
            rows[view.name][method] = bad = figures(view, found, threshold)
            pictures[f"{method}: {bad[KNOWN]:.1f} % bad" if bad else method] = found
            advance()
        strips.append(Strip(view.name, view.left, pictures, (0, view.disparities - 1)))
    return rows, strips


def inputs(compared: Sequence[View], methods: Sequence[str], threshold: float) -> str:
    """Digest of a page's inputs: the pictures and truths that are compared, and what the methods give on small scenes."""
    pictures = {view.name: [hashlib.sha256(np.asarray(array).tobytes()).hexdigest()
                            for array in (view.left, view.right, view.truth, *view.masks.values())] for view in compared}
    small, _ = compare(views(SCENES, SMALL_SIZE), methods, threshold)
    return digest(pictures, small)


def page(head: str, compared: Sequence[View], rows: Rows, threshold: float, picture: str, by_hand: str) -> str:
    """The page, in Markdown.

    Parameters
    ----------
    head : str
        Names command and digest.
    compared : sequence of View
    rows : Rows
        Of :func:`compare`.
    threshold : float
        Pixels.
    picture : str
        Link to the picture.
    by_hand : str
        Text below the marker :data:`BY_HAND`.
    """
    cells = []
    for view in compared:
        height, width = view.left.shape
        for number, mask in enumerate(view.masks):
            cells.append([f"{view.name} {width}x{height}x{view.disparities}" if number == 0 else "", FIGURES[mask],
                          *(f"{of_method[mask]:.2f}" for of_method in rows[view.name].values())])
    methods = list(next(iter(rows.values())))
    return "\n".join([
        "# Hard scenes", "", head, "",
        "The Motorcycle pair (D. Scharstein et al., GCPR 2014) of scikit-image and the synthetic scenes of `golden.pictures.scenes`, with",
        f"width, height and number of disparities. Bad pixels: off by more than {threshold:g} pixel, percent. No data are needed.", "",
        f"![For each scene a row: left picture, truth, {', '.join(methods)}]({picture})", "",
        *markdown_table(["scene", "pixels", *(f"`{method}`" for method in methods)], cells, words=2), "", BY_HAND]) + by_hand


def averages(compared: Sequence[View], rows: Rows) -> Rows:
    """Averages of all figures of each method, for every folder that sets are from: a row for the table."""
    result: Rows = {}
    for folder in dict.fromkeys(view.folder for view in compared if view.folder):
        of_sets = [rows[view.name] for view in compared if view.folder == folder]
        found = {method: [value for of_view in of_sets for value in of_view[method].values()] for method in of_sets[0]}
        result[folder] = {method: {f"average of {len(values)}": float(np.mean(values))} for method, values in found.items()}
    return result


def table(rows: Rows, threshold: float) -> Table:
    """The figures as a table: a block of rows for every view, a column for every method."""
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
        "RIGHT or --data instead, and on synthetic scenes that are hard for them. Needs no data."))
    result.add_argument("left", nargs="?", type=Path, metavar="LEFT", help="left picture, as of golden match")
    result.add_argument("right", nargs="?", type=Path, metavar="RIGHT", help="right picture, of the same size")
    result.add_argument("--disparities", type=int, metavar="N", help="number of disparities of LEFT and RIGHT")
    result.add_argument("--scenes", nargs="*", choices=SCENES, default=list(SCENES), metavar="NAME",
                        help=f"which scenes, none too: {', '.join(SCENES)} (default: all)")
    result.add_argument("--methods", nargs="+", choices=METHODS, default=list(DEFAULT_METHODS), metavar="NAME",
                        help=f"which of those of golden rivals (default: {' '.join(DEFAULT_METHODS)})")
    result.add_argument("--data", nargs="+", type=Path, metavar="DIR", help=(
        "compare on the benchmark or on all sets of these folders, see docs/data.md, in place of the Motorcycle pair, and average"))
    add_white_option(result)
    add_truth_options(result)
    result.add_argument("--output", type=Path, metavar="FILE", help=f"draw all pictures there; suffix {', '.join(SHEET_SUFFIXES)}")
    result.add_argument("--page", type=Path, metavar="FILE", help=(
        "write a page of figures and of the picture --output there, in Markdown; text added to it by hand is kept; suffix .md"))
    return result


def _pair(options: argparse.Namespace) -> View:
    """The view of LEFT and RIGHT."""
    check_disparities(options.disparities)
    config = MatcherConfig(options.disparities)
    left, right = read_pair(options.left, options.right, options.white)
    found = read_truth(options, left.shape, config)
    truth, mask = found or (None, None)
    return View(options.left.name, left, right, truth, {} if mask is None else {KNOWN: mask}, options.disparities)


def _first(options: argparse.Namespace) -> list[View]:
    """The views of the sets of ``--data``, of LEFT and RIGHT, or of the Motorcycle pair."""
    if options.data:
        return set_views(options.data)
    return [_pair(options) if options.left else motorcycle_view()]


def _check(options: argparse.Namespace) -> None:
    """:class:`UserError` unless the options make sense together."""
    check_names(options, "scenes", "methods")
    if options.left and not options.right:
        raise UserError(f"{options.left} has no right picture; give LEFT and RIGHT, or neither for the Motorcycle pair")
    limits = MatcherConfig.LABELS
    if options.left and options.disparities is None:
        raise UserError(f"--disparities is missing; give the number of disparities of the pictures, {limits[0]} to {limits[-1]}")
    for name in ("disparities", "truth"):
        if getattr(options, name) is not None and not options.left:
            raise UserError(f"--{name} {getattr(options, name)} is for LEFT and RIGHT, which are missing; give them or leave it out")
    if options.data and options.left:
        raise UserError(f"--data {options.data[0]} is in place of LEFT and RIGHT, but {options.left} is given; leave one of them out")
    if options.page and options.data:
        raise UserError(f"--page {options.page} is for the Motorcycle pair, not for --data {options.data[0]}; leave one of them out")
    if options.page and options.left:
        raise UserError(f"--page {options.page} is for the Motorcycle pair, not for {options.left}; leave one of them out")
    if options.page and not options.output:
        raise UserError(f"--page {options.page} shows the picture --output, which is missing; give --output FILE too")
    check_white(options, bool(options.left))
    check_truth_options(options)


def _write_page(options: argparse.Namespace, command: str, compared: Sequence[View], rows: Rows) -> None:
    """Write the page that the options name; what was written by hand below the marker stays."""
    before = options.page.read_text(encoding="utf-8") if options.page.exists() else ""
    picture = Path(os.path.relpath(options.output.resolve(), options.page.resolve().parent)).as_posix()
    head = origin(command, inputs(compared, options.methods, options.threshold))
    text = page(head, compared, rows, options.threshold, picture, before.partition(BY_HAND)[2] or "\n")
    with atomic(options.page) as file:
        file.write(text.encode())


def run(argv: Sequence[str] | None) -> None:
    """The command; :class:`UserError` on bad input."""
    options = parser().parse_args(argv)
    _check(options)
    output = check_output(options.output, SHEET_SUFFIXES) if options.output else None
    if options.page:
        check_output(options.page, (".md",), "--page")
    check_installed(*sorted({need for name in options.methods if (need := METHODS[name].needs)}))

    compared = [*_first(options), *views(options.scenes)]
    with progress() as bar:
        task = bar.add_task("", total=len(compared) * len(options.methods))
        rows, strips = compare(compared, options.methods, options.threshold, lambda what: bar.update(task, description=what),
                               lambda: bar.advance(task))
    if output:
        write_comparison(output, strips)
    if options.page:
        _write_page(options, shlex.join(["python", "-m", "golden", "compare", *(sys.argv[1:] if argv is None else argv)]), compared, rows)
    print_table(table(rows | averages(compared, rows), options.threshold))


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is the result."""
    return run_cli(run, argv, "golden compare")
