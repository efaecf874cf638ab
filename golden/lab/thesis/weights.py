"""Figures 34, 36 and 37: the effect of the weights, and their optimum."""

import itertools
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...config import WEIGHT_MAX
from ...pictures.dataset import MASKS
from ..published import OPTIMUM
from . import choices, sweeps
from .laboratory import Laboratory, percent
from .page import Picture, Section, Table
from .plots import curves, heat, panels
from .sheets import with_bad


__all__ = ["figure_34", "figure_36", "figure_37"]


Weights = tuple[int, int, int]

EQUAL: Sequence[int] = (0, 1, 2, 3, 5, 7, 10, 15, 20, 25, 30, 40, 50, 63)
SHOWN = (5, 15, 30, 50)  # of figure 36
COMBINATIONS: tuple[Weights, ...] = ((30, 5, 5), (5, 30, 5), (5, 5, 30), OPTIMUM)
SEARCHED = (0, 5, 10, 15, 30)
FINER = (3, 1)  # steps of the searches after it, each about the best so far


def _equal(lab: Laboratory) -> dict[str, sweeps.Result]:
    weights = [(u, u, u) for u in EQUAL]
    return lab.run("figures 34, 36", {name: (sweeps.weight_figures, pair, "float", weights) for name, pair in lab.pairs.items()})


def figure_34(lab: Laboratory) -> Section:
    """Bad pixels against one weight for all neighbours."""
    results = _equal(lab)
    graphs: list[Any] = []
    rows = []
    for name in lab.pairs:
        bad = results[name]["bad"]
        graphs.append((name, {mask: (EQUAL, bad[:, number].tolist()) for number, mask in enumerate(MASKS)}))
        least = bad.argmin(axis=0)
        best = [f"{bad[at, number]:.2f} at {EQUAL[at]}" for number, at in enumerate(least)]
        rows.append([name, *percent(bad[0]), *best, *percent(bad[-1])])
    head = ["pair", *(f"{mask}, u = {u}" for u in ("0", "best", str(EQUAL[-1])) for mask in MASKS)]
    return Section("Figure 34: bad pixels against u_max", [
        "One weight u for all three neighbours, float arithmetic. The thesis prints curves without numbers. It says that errors in all and "
        "nonocc fall as u grows, that disc falls for Venus, Teddy and Cones, and that disc grows for Tsukuba. " + _trend(lab, results)],
        [Table(head, rows)], [Picture("figure-34", "Bad pixels against u = u1 = u2 = u3.", lambda: curves(graphs, "u", "bad pixels, %"))])


def _trend(lab: Laboratory, results: dict[str, sweeps.Result]) -> str:
    """Whether the thesis's sentence holds for each pair, in words."""
    disc = {name: results[name]["bad"][:, MASKS.index("disc")] for name in lab.pairs}
    words = [f"{name} from {values[0]:.1f} to {values.min():.1f} at {EQUAL[int(values.argmin())]}, then {values[-1]:.1f} at {EQUAL[-1]}"
             for name, values in disc.items()]
    return f"Measured, disc changes as follows: {'; '.join(words)}."


def figure_36(lab: Laboratory) -> Section:
    """How far near objects extend over their background, and the effect of the picture's border."""
    pair = lab.tsukuba
    equal = _equal(lab)
    shown = lab.run("figure 36", {u: (sweeps.labels_of, pair, "float", (u, u, u)) for u in SHOWN})
    borders = lab.run("borders", {(name, border): (sweeps.border_figures, each, border)
                                  for name, each in lab.pairs.items() for border in choices.BORDERS})
    pictures = [(f"u = {u}, extended {sweeps.extension(shown[u]['labels'], pair):.1f} %", shown[u]["labels"], pair.disparities - 1)
                for u in SHOWN]
    graph: dict[str, Any] = {name: (EQUAL, equal[name]["extended"].tolist()) for name in lab.pairs}
    rows = [[name, border, *percent(borders[name, border]["bad"])] for name in lab.pairs for border in choices.BORDERS]
    return Section("Figure 36: extensions at object boundaries, and at the border", [
        "The thesis shows by eye that objects of Tsukuba grow beyond their boundaries as u grows. Measured here: of the background pixels "
        "within four columns and rows of something more than a pixel nearer, the percentage whose disparity is too near.",
        "The thesis does not say what a candidate outside the right picture costs. Three readings: more than any other candidate (ours); "
        "the cost with edge replication; the cost against grey level 0. Tsukuba's benchmark leaves out a border of 18 pixels, wider than "
        "its 16 disparities, so all readings are the same there."],
        [Table(["pair", "border", *MASKS], rows, words=2)],
        [Picture("figure-36", "Tsukuba with equal weights.", lambda: panels(pictures, 4)),
         Picture("figure-36-extended", "Background pixels at the edge of a nearer object whose disparity is too near.",
                 lambda: curves([("extension", graph)], "u", "extended, %", columns=1))])


def _search(lab: Laboratory, what: str, sets: Iterable[Weights], names: Iterable[str]) -> tuple[list[Weights], NDArray[np.float64]]:
    """Bad pixels (weights, pairs, masks) of some weights, and the weights in their order; a job for each pair and ``u1``."""
    groups = [list(group) for _, group in itertools.groupby(sorted(sets), key=lambda weights: weights[0])]
    names = list(names)
    results = lab.run(what, {(name, number): (sweeps.weight_figures, lab.pairs[name], "float", group)
                             for name in names for number, group in enumerate(groups)})
    bad = np.stack([np.concatenate([results[name, number]["bad"] for number in range(len(groups))]) for name in names], axis=1)
    return list(itertools.chain.from_iterable(groups)), bad


def _around(centre: Weights, step: int) -> set[Weights]:
    """Each weight less, the same and more by a step, in all combinations."""
    near = [[u for u in (middle - step, middle, middle + step) if 0 <= u <= WEIGHT_MAX] for middle in centre]
    return {(a, b, c) for a, b, c in itertools.product(*near)}


def _best(lab: Laboratory, names: list[str]) -> dict[Weights, float]:
    """Average of bad pixels on some pairs for all weights that were tried: the coarse grid, in order, and what was tried after it."""
    average: dict[Weights, float] = {}

    def attempt(what: str, sets: set[Weights]) -> None:
        weights, bad = _search(lab, f"figure 37, {what}", sets, names)
        # Rounded, because equal averages must be equal in any order of the sum.
        average.update(zip(weights, bad.mean(axis=(1, 2)).round(9).tolist(), strict=True))

    attempt("grid", {(a, b, c) for a, b, c in itertools.product(SEARCHED, repeat=3)})
    for step in FINER:
        # As long as a neighbour of the best is better.
        while more := (_around(min(average, key=average.__getitem__), step) | {OPTIMUM}) - set(average):
            attempt(f"steps of {step}", more)
    return average


def figure_37(lab: Laboratory) -> Section:
    """Different weights for different neighbours, and the search for the best."""
    pair = lab.tsukuba
    shown = lab.run("figure 37", {weights: (sweeps.labels_of, pair, "float", weights) for weights in COMBINATIONS})
    pictures = [(f"u = {_slashes(weights)}: {with_bad(shown[weights]['bad'])}", shown[weights]["labels"], pair.disparities - 1)
                for weights in COMBINATIONS]
    searched = Section("") if lab.quick else _searched(lab)
    return Section(
        "Figure 37: different weights, and the search for the best", [
            "Each panel raises one weight; titles give bad pixels nonocc / all / disc in percent. The thesis prints its pictures' weights "
            "in the figure only, so these are ours. A great u1 smears along the line, a great u2 down the picture, a great u3 pulls "
            "towards the local disparities.", *searched.paragraphs],
        searched.tables,
        [Picture("figure-37", "Tsukuba with four combinations of weights.", lambda: panels(pictures, 2)), *searched.pictures],
        left_out=["the search for the best weights"] if lab.quick else [])


def _searched(lab: Laboratory) -> Section:
    """Paragraph, table and picture of the search for the best weights."""
    rows, sentences, maps = [], [], []
    for title, names in (("Tsukuba, average of three", ["tsukuba"]), (f"all pairs, average of {3 * len(lab.pairs)}", list(lab.pairs))):
        tried = _best(lab, names)
        weights, average = list(tried), np.array(list(tried.values()))
        order = np.argsort(average, kind="stable")
        at = weights.index(OPTIMUM)
        rank = int((average < average[at]).sum()) + 1
        rows += [[title if number == 0 else "", _slashes(weights[index]), f"{average[index]:.2f}",
                  f"{average[index] - average[at]:+.2f}"] for number, index in enumerate(order[:5])]
        rows.append(["", f"{_slashes(OPTIMUM)}, the thesis's: rank {rank} of {len(weights)}", f"{average[at]:.2f}", ""])
        best = weights[order[0]]
        sentences.append(f"{title}: {_slashes(best)} gives {average[order[0]]:.2f} %, the thesis's {average[at]:.2f} %, rank "
                         f"{rank} of {len(weights)} tried")
        # Of the coarse grid, the best over u3 for every u1 and u2.
        cube = average[:len(SEARCHED)**3].reshape([len(SEARCHED)] * 3)
        maps.append((title, cube.min(axis=2).T))
    return Section("", [
        f"The search tries all combinations of {', '.join(map(str, SEARCHED))}, then walks from the best of them in steps of "
        f"{' and '.join(map(str, FINER))} for as long as a neighbour is better. "
        f"The thesis calls {_slashes(OPTIMUM)} optimal. {'. '.join(sentences)}. So {_slashes(OPTIMUM)} "
        + ("is the optimum of what was tried." if "rank 1 of" in sentences[-1] else "is near the optimum but not it.")],
        [Table(["searched on", "u1/u2/u3", "average, %", f"less {_slashes(OPTIMUM)}"], rows, words=2)],
        [Picture("figure-37-search", "Average of bad pixels for u1 and u2, with the best u3 for each, percent.",
                 lambda: heat(maps, SEARCHED, "u1", "u2"))])


def _slashes(weights: Weights) -> str:
    return "/".join(map(str, weights))
