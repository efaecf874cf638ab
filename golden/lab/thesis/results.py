"""Figures 35, 38 and 42, and the thesis's figures of Tsukuba against ours: results of the method with its default parameters."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...pictures.dataset import MASKS
from ..published import OPTIMUM, TSUKUBA
from . import choices, sweeps
from .laboratory import Laboratory, difference, percent
from .page import Picture, Section, Table
from .plots import panels
from .sheets import difference_map, errors, with_bad


__all__ = ["figure_35", "figure_38", "figure_42", "tsukuba"]


CHUNK = 12  # choices a job
PRINTED = np.array([0.005, 0.005, 0.05]) + 1e-9  # half of the last digit that the thesis prints: nonocc, all, disc


def figure_35(lab: Laboratory) -> Section:
    """Local disparities."""
    results = lab.run("figure 35", {name: (sweeps.local_figures, pair) for name, pair in lab.pairs.items()})
    pictures = [(f"{name}: {with_bad(results[name]['bad'])}", results[name]["labels"], pair.disparities - 1)
                for name, pair in lab.pairs.items()]
    rows = [[name, *percent(results[name]["bad"])] for name in lab.pairs]
    return Section("Figure 35: local disparity", [
        "The disparity of least matching cost at every pixel, without smoothness; the rule takes it for the lower neighbour. The thesis "
        "shows the pictures without numbers."],
        [Table(["pair", *MASKS], rows)],
        [Picture("figure-35", "Local disparities; bad pixels nonocc / all / disc.", lambda: panels(pictures, 4))])


def figure_38(lab: Laboratory) -> Section:
    """Results next to the truth."""
    results = lab.by_method()
    pictures: list[Any] = []
    rows = []
    for name, pair in lab.pairs.items():
        labels, bad = (results[name, "float"][key] for key in ("labels", "bad"))
        greatest = pair.disparities - 1
        pictures += [(name, pair.left, None), ("truth", pair.truth, greatest), (f"ours: {with_bad(bad)}", labels, greatest),
                     ("bad", errors(labels, pair), None)]
        printed = percent([TSUKUBA[mask] for mask in MASKS]) if name == "tsukuba" else ["not printed"] * 3
        rows.append([name, *printed, *percent(bad), *(difference(bad, TSUKUBA) if name == "tsukuba" else ["-"] * 3)])
    head = ["pair", *(f"{mask}, {whose}" for whose in ("thesis", "ours", "difference") for mask in MASKS)]
    return Section("Figure 38: results with ground truth", [
        f"Weights {'/'.join(map(str, OPTIMUM))}, float arithmetic. The thesis's text has numbers for Tsukuba only."],
        [Table(head, rows)],
        [Picture("figure-38", "Left picture; truth, black is unknown; disparities; errors: off by more than a pixel, red, not counted, "
                              "grey.", lambda: panels(pictures, 4))])


def figure_42(lab: Laboratory) -> Section:
    """Float against fixed point."""
    results = lab.by_method()
    pair = lab.tsukuba
    float_, fixed = (results["tsukuba", method]["labels"] for method in ("float", "thesis"))
    pictures = [(f"float: {with_bad(results['tsukuba', 'float']['bad'])}", float_, pair.disparities - 1),
                (f"fixed point: {with_bad(results['tsukuba', 'thesis']['bad'])}", fixed, pair.disparities - 1),
                ("where they differ", difference_map(float_, fixed, pair.left), None)]
    rows = []
    for name, each in lab.pairs.items():
        exact = results[name, "float"]["labels"]
        for method in ("float", "thesis", "linear"):
            labels = results[name, method]["labels"]
            rows.append([name if method == "float" else "", method, *percent(results[name, method]["bad"]),
                         f"{100 * np.mean(labels != exact):.2f}", f"{100 * np.mean(np.abs(labels - exact) > 1):.2f}",
                         f"{sweeps.extension(labels, each):.2f}"])
    extended = [sweeps.extension(labels, pair) for labels in (float_, fixed)]
    verdict = "more" if extended[1] > extended[0] else "less"
    return Section("Figure 42: float against fixed point", [
        "The thesis says that its fixed-point result on Tsukuba is worse than MATLAB's at some boundaries, with more extension, and gives "
        f"no number. Measured: {100 * np.mean(float_ != fixed):.2f} % of the pixels differ; objects extend {verdict} in fixed point "
        f"({extended[1]:.1f} % against {extended[0]:.1f} %, as in figure 36), and bad pixels (all) change from "
        f"{results['tsukuba', 'float']['bad'][1]:.2f} to {results['tsukuba', 'thesis']['bad'][1]:.2f} %; the table has the other pairs. "
        "The arithmetic linear of our streaming engine is exact in the sub-pixels and nearer to float."],
        [Table(["pair", "arithmetic", *MASKS, "differ from float, %", "by more than 1, %", "extended, %"], rows, words=2)],
        [Picture("figure-42", "Tsukuba. Orange: the two differ by one pixel; red: by more.", lambda: panels(pictures, 3))])


def tsukuba(lab: Laboratory) -> Section:
    """Whether what the thesis leaves open can explain its figures of Tsukuba."""
    theirs = np.array([TSUKUBA[mask] for mask in MASKS])
    methods = lab.by_method()
    ours = methods["tsukuba", "float"]["bad"]
    rows = [["thesis", *percent(theirs), *["-"] * 3]]
    rows += [[f"ours, {method}", *percent(methods["tsukuba", method]["bad"]), *difference(methods["tsukuba", method]["bad"], TSUKUBA)]
             for method in ("float", "thesis", "linear")]
    every = list(choices.all_choices())
    readings, added = ([], []) if lab.quick else _readings(lab, every, theirs)
    return Section(
        "Tsukuba: the thesis's figures against ours", [
            f"The thesis prints {theirs[0]:.2f} nonocc, {theirs[1]:.2f} all, {theirs[2]:.1f} disc; ours, float, are {ours[0]:.2f}, "
            f"{ours[1]:.2f}, {ours[2]:.2f}. It leaves open the costs outside the picture, the conversion of colours to grey, rounding, and "
            "ties.", *readings],
        [Table(["Tsukuba", *MASKS, *(f"{mask}, difference" for mask in MASKS)], rows + added)],
        left_out=[f"the {len(every)} readings of what the thesis leaves open"] if lab.quick else [])


def _readings(lab: Laboratory, every: list[choices.Choice], theirs: NDArray[np.float64]) -> tuple[list[str], list[list[str]]]:
    """Paragraphs and rows on all readings of the thesis: how far they span, and which are nearest to its figures."""
    chunks = [every[start:start + CHUNK] for start in range(0, len(every), CHUNK)]
    results = lab.run("Tsukuba, choices", {number: (sweeps.choice_figures, lab.tsukuba, lab.colours, chunk)
                                           for number, chunk in enumerate(chunks)})
    bad = np.concatenate([results[number]["bad"] for number in range(len(chunks))])
    ours = bad[every.index(choices.Choice())]
    rows = [[f"{word} of all readings", *percent(values), *difference(values, TSUKUBA)]
            for word, values in (("least", bad.min(axis=0)), ("greatest", bad.max(axis=0)))]
    # Two measures of nearness; of equals the first, which keeps most choices as ours are.
    apart = np.round(np.abs(bad - theirs).sum(axis=1), 9)
    alike = (np.abs(bad - theirs) <= PRINTED).sum(axis=1)
    nearest, most = int(np.argmin(apart)), int(np.lexsort((apart, -alike))[0])
    rows += [[word, *percent(bad[number]), *difference(bad[number], TSUKUBA)]
             for word, number in (("nearest in all three", nearest), ("most figures as printed", most))]
    within = (bad.min(axis=0) <= theirs + PRINTED) & (theirs - PRINTED <= bad.max(axis=0))
    verdict = "lie" if within.all() else "do not all lie"
    return [
        f"All {len(every)} combinations of such readings were tried: the thesis's three figures {verdict} within what they span. "
        f"Nearest in all three together is: {every[nearest]}; it is off by {apart[nearest]:.2f} points in sum, ours by "
        f"{np.abs(ours - theirs).sum():.2f}. To the last digit printed, {alike[most]} of the three figures result from: {every[most]}.",
        "Number formats: float is exact; float/256 has smoothness in 256ths in place of 255ths; floor and floor/256 are these with "
        "sub-pixels halved with a floor, as the thesis's FPGA does; thesis is all of its FPGA; linear is our gateware's; q=0 is that "
        "without fraction bits.",
        _reach(every, bad)], rows


def _reach(every: list[choices.Choice], bad: NDArray[np.float64]) -> str:
    """How far each choice alone moves the figures, in words."""
    base = bad[every.index(choices.Choice())]
    words = []
    for name in ("border", "levels", "numbers", "outside", "last"):
        alone = [bad[number] for number, choice in enumerate(every)
                 if all(getattr(choice, other) == getattr(choices.Choice(), other)
                        for other in ("border", "levels", "numbers", "outside", "last") if other != name)]
        moved = np.abs(np.array(alone) - base).max(axis=0)
        what = {"border": "the border", "levels": "grey levels", "numbers": "number formats", "outside": "a neighbour outside",
                "last": "ties"}[name]
        words.append(f"{what} {' / '.join(percent(moved))}")
    return f"Each choice alone moves the figures (nonocc / all / disc, points) by at most: {'; '.join(words)}."
