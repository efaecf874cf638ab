"""Figures 45 and 46: cameras that differ, and lens distortion."""

from collections.abc import Sequence
from dataclasses import dataclass

from . import sweeps
from .laboratory import Laboratory, percent
from .page import Picture, Section, Table
from .plots import curves, panels
from .sheets import with_bad


__all__ = ["figure_45", "figure_46"]


GAINS = (1.0, 0.98, 0.95, 0.9, 0.8, 0.7)
NOISES = (0.0, 1.0, 2.0, 4.0, 8.0)
SHOWN = (0.95, 2.0)
LENSES = (-0.1, -0.05, -0.02, 0.0, 0.02, 0.05, 0.1)
METHODS = {"float": "thesis's method", "fused": "second method"}



@dataclass(frozen=True)
class _Cured:
    """Bad pixels (all) at some places, disturbed and cured: a list for each of :data:`METHODS`."""
    cure: str
    places: Sequence[float]
    before: Sequence[Sequence[float]]
    after: Sequence[Sequence[float]]

    @property
    def curves(self) -> dict[str, tuple[Sequence[float], Sequence[float]]]:
        """By name, the cured one of a method after its disturbed one."""
        return {name: (self.places, figures) for word, *both in zip(METHODS.values(), self.before, self.after)
                for name, figures in zip((word, f"{word}, {self.cure}"), both)}

    @property
    def dashed(self) -> dict[str, str]:
        """Of every cured curve the disturbed one."""
        return {f"{word}, {self.cure}": word for word in METHODS.values()}

    def words(self, place: float) -> str:
        """What the cure changes at a place."""
        at = self.places.index(place)
        return " and ".join(f"from {before[at]:.2f} to {after[at]:.2f} % ({word})"
                            for word, before, after in zip(METHODS.values(), self.before, self.after))


def figure_45(lab: Laboratory) -> Section:
    """Noise, and a right camera that is darker."""
    pair = lab.tsukuba
    settings = [*((gain, 0.0) for gain in GAINS), *((1.0, noise) for noise in NOISES[1:]), SHOWN]
    results = lab.run("figure 45", {(method, *setting): (sweeps.disturbed, pair, method, *setting)
                                    for method in METHODS for setting in settings})
    cured = lab.run("figure 45, balanced", {(method, *setting): (sweeps.disturbed, pair, method, *setting, True)
                                            for method in METHODS for setting in settings})
    rows = [[f"{gain:g}", f"{noise:g}", *(text for method in METHODS for text in percent(
        [*results[method, gain, noise]["bad"].tolist(), float(results[method, gain, noise]["flicker"]),
         float(cured[method, gain, noise]["bad"][1]), float(cured[method, gain, noise]["flicker"])]))] for gain, noise in settings]
    head = ["gain", "noise", *(f"{word}, {figure}" for word in METHODS.values()
                               for figure in ("nonocc", "all", "disc", "flicker", "all, balanced", "flicker, balanced"))]
    shown = results["float", *SHOWN]
    pictures = [("right picture", shown["right"], None),
                *((f"{word}: {with_bad(results[method, *SHOWN]['bad'])}", results[method, *SHOWN]["labels"], pair.disparities - 1)
                  for method, word in METHODS.items())]
    gains, noises = (
        _Cured("balanced", places, *([[float(of[method, *setting]["bad"][1]) for setting in which] for method in METHODS]
                                     for of in (results, cured)))
        for places, which in ((GAINS, [(gain, 0.0) for gain in GAINS]), (NOISES, [(1.0, noise) for noise in NOISES])))
    graphs = [("all, against the gain", gains.curves), ("all, against the noise, grey levels", noises.curves)]
    return Section("Figure 45: intensity that varies", [
        "The thesis records one pixel of its cameras: the left one reads 95 to 100, the right one 60 to 76, and it names this as one of "
        "two reasons for distortions in its live pictures. Here Tsukuba's right picture is multiplied by a gain (its cameras: about 0.7), "
        "and noise is added to both (standard deviation in grey levels). Flicker: pixels whose disparity differs by more than one between "
        "two frames of the same scene. A gain of 0.7 is far more than a sum of absolute differences tolerates: cameras must be adjusted "
        "to each other first, or the cost must be invariant to gain, as the census of the second method is.",
        "Balanced, dashed: before it is matched the right picture gets the left one's mean and contrast, as `golden match --balance` and "
        f"the gateware compute them. It helps where the cameras differ in gain: at {GAINS[-1]:g} bad pixels (all) go "
        f"{gains.words(GAINS[-1])}. Noise it does not cure: at {NOISES[-1]:g} grey levels they go {noises.words(NOISES[-1])}."],
        [Table(head, rows, words=0)],
        [Picture("figure-45", f"Tsukuba with gain {SHOWN[0]:g} and noise {SHOWN[1]:g}; bad pixels nonocc / all / disc.",
                 lambda: panels(pictures, 3)),
         Picture("figure-45-curves", "Bad pixels (all) against gain and noise; dashed: balanced.",
                 lambda: curves(graphs, "gain; noise", "bad pixels, %", dashed=gains.dashed))])


def figure_46(lab: Laboratory) -> Section:
    """Lens distortion."""
    pair = lab.tsukuba
    results = lab.run("figure 46", {(method, k): (sweeps.lens_figures, pair, method, k) for method in METHODS for k in LENSES})
    rows = [[f"{k:g}", f"{results['float', k]['off_line']:.2f}", *(text for method in METHODS for text in (
        *percent(results[method, k]["bad"]), *(f"{results[method, k][cure][1]:.2f}" for cure in ("rectified", "straight"))))]
        for k in LENSES]
    head = ["k", "lines apart", *(f"{word}, {figure}" for word in METHODS.values()
                                  for figure in ("nonocc", "all", "disc", "all, rectified", "all, straightened"))]
    strongest = LENSES[0], LENSES[-1]
    pictures = [each for k in strongest for each in (
        (f"left picture, k = {k:g}", results["float", k]["left"], None),
        *((f"{word}: {with_bad(results[method, k]['bad'])}", results[method, k]["labels"], pair.disparities - 1)
          for method, word in METHODS.items()))]
    lenses = _Cured("rectified", LENSES, *([[float(results[method, k][figure][1]) for k in LENSES] for method in METHODS]
                                           for figure in ("bad", "rectified")))
    return Section("Figure 46: lens distortion", [
        "The thesis photographs a bent book shelf and gives no number. Here both pictures of Tsukuba, and its truth, pass through the same "
        "lens, which moves a point from r (1 in the corner) to r*(1 + k*r*r). A point is at another place in the other picture, so it is "
        "displaced by another amount, and the two are on different scanlines. Resampling costs accuracy too: for the column straightened "
        "both pictures are distorted and rectified again, so what remains of the loss there is due to resampling.",
        "Rectified, dashed: before they are matched both pictures are rectified by the gateware's map of this lens, with control points "
        "fitted to it; the truth is the pair's own. It helps where lenses are strong: bad pixels (all) go "
        f"{lenses.words(LENSES[0])} at k = {LENSES[0]:g}, and {lenses.words(LENSES[-1])} at {LENSES[-1]:g}. What resampling costs remains, "
        "as in the column straightened, which is computed in floating point, and it can be more than what is won: at k = "
        f"{LENSES[1]:g} they go {lenses.words(LENSES[1])}. `python -m golden cameras` measures what rectification is worth for cameras "
        "that are rolled, too, and of which one is lower."],
        [Table(head, rows, words=0)],
        [Picture("figure-46", "Tsukuba through a barrel and a pincushion lens; bad pixels nonocc / all / disc.",
                 lambda: panels(pictures, 3)),
         Picture("figure-46-curves", "Bad pixels (all) against the lens: barrel left, pincushion right; dashed: rectified.",
                 lambda: curves([("all, against the lens", lenses.curves)], "k", "bad pixels, %", columns=1, dashed=lenses.dashed))])
