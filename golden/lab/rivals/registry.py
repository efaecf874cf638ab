"""All methods that are measured side by side, ours among them, and their measurement."""

import functools
import time
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...config import Arithmetic, MatcherConfig, OnePass
from ...config import Method as MatcherMethod
from ...matcher.cost import matching_cost
from ...matcher.energy import energy
from ...matcher.matcher import disparities as match
from ...matcher.parameters import NAMED
from ...pictures.dataset import StereoPair
from ...pictures.metrics import bad_pixels
from . import census_sgm, cuts, opencv, scanline, ssd


__all__ = ["COMPARED", "METHODS", "Method", "figures", "measure"]


Disparities = Callable[[NDArray[Any], NDArray[Any], int], NDArray[Any]]


@dataclass(frozen=True)
class Method:
    """A stereo matching method.

    Parameters
    ----------
    function : callable
        Left and right picture, (H, W) uint8, and the number of disparities to (H, W) disparities in pixels.
    about : str
        A phrase for tables.
    needs : str or None
        The package that it imports; of the extra ``lab``.
    published : str or None
        Its row in :data:`golden.lab.published.TABLE_1`.
    lowers : bool
        Whether it minimises the energy of :func:`golden.matcher.energy.energy`, ``LINEAR``.
    ours : bool
        Whether it is a method of this project.
    """
    function: Disparities
    about: str
    needs: str | None = None
    published: str | None = None
    lowers: bool = False
    ours: bool = False


def _disparities(left: NDArray[Any], right: NDArray[Any], labels: int, method: MatcherMethod) -> NDArray[Any]:
    """Disparities by a method of ours, in the golden model."""
    result: NDArray[Any] = match(left, right, MatcherConfig(labels, method=method))
    return result


def _ours(about: str, method: MatcherMethod, published: str | None = None, lowers: bool = False) -> Method:
    return Method(functools.partial(_disparities, method=method), about, published=published, lowers=lowers, ours=True)


METHODS = {
    "dynamic-programming": Method(scanline.disparities, "dynamic programming on every scanline", published="Dynamic Programming"),
    "ssd-min-filter": Method(ssd.disparities, "squared differences, shiftable windows", published="SSD+min filter"),
    "alpha-expansion": Method(cuts.potts_expansion, "graph cuts by expansions, Potts", "maxflow", "Graph Cut Method"),
    "alpha-beta-swap": Method(cuts.potts_swap, "graph cuts by swaps, Potts", "maxflow", "Graph Cut Method"),
    "one-pass-expansion": Method(cuts.improved, "expansions that minimise the energy of one-pass-linear", "maxflow", lowers=True),
    "opencv-bm": Method(opencv.block_matching, "OpenCV's StereoBM", "cv2"),
    "opencv-sgbm": Method(opencv.semi_global_matching, "OpenCV's StereoSGBM over four full paths", "cv2"),
    "census-sgm": Method(census_sgm.disparities, "semi-global matching of a census over eight paths"),
    "one-pass-float": _ours("the thesis's rule in float64: its MATLAB model", OnePass(Arithmetic.FLOAT), published="Proposed Method"),
    "one-pass-thesis": _ours("the thesis's rule in its gateware's arithmetic", OnePass(Arithmetic.THESIS)),
    "one-pass-linear": _ours("the thesis's rule in ours", OnePass(Arithmetic.LINEAR), lowers=True),
    **{name: _ours(f"ours, --method {kind} --parameters {name}", method) for kind, sets in NAMED.items() for name, method in sets.items()},
}

#: The strongest rivals, and of each method of ours that has named sets the first two.
COMPARED = ("opencv-sgbm", "census-sgm", *(name for sets in NAMED.values() for name in list(sets)[:2]))


def measure(pair: StereoPair, name: str) -> dict[str, NDArray[Any]]:
    """Bad pixels and time of a method on a pair.

    Parameters
    ----------
    pair : StereoPair
    name : str
        Of :data:`METHODS`.

    Returns
    -------
    dict of str to ndarray
        ``bad`` (masks,): percentage of bad pixels for each mask; ``seconds``: processor time of this thread; ``energy``, for methods that
        lower it: that of :func:`golden.matcher.energy.energy` in ``LINEAR`` arithmetic.
    """
    method = METHODS[name]
    # Processor time, because other tasks may run meanwhile; of the thread, because a worker may have several.
    start = time.thread_time()
    found = method.function(pair.left, pair.right, pair.disparities)
    result = {"seconds": np.array(time.thread_time() - start)}
    result["bad"] = np.array([bad_pixels(found, pair.truth, mask) for mask in pair.masks.values()])
    if method.lowers:
        config = MatcherConfig(pair.disparities, method=OnePass(Arithmetic.LINEAR))
        result["energy"] = np.array(energy(found, matching_cost(pair.left, pair.right, config), pair.left, config))
    return result


def figures(pair: StereoPair, measured: Mapping[str, NDArray[Any]]) -> dict[str, Any]:
    """A result of :func:`measure` for reports: ``figures`` by the name of the mask, and the other values as numbers."""
    numbers = {name: value.item() for name, value in measured.items() if name != "bad"}
    return {"figures": dict(zip(pair.masks, measured["bad"].tolist(), strict=True)), **numbers}
