"""All methods that are measured side by side, ours among them, and their measurement."""

import functools
import time
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from ...config import FUSED_1, FUSED_2, Arithmetic, MatcherConfig, OnePass
from ...config import Method as MatcherMethod
from ...matcher.cost import matching_cost
from ...matcher.energy import energy
from ...matcher.matcher import disparities as match
from ...pictures.dataset import StereoPair
from ...pictures.metrics import bad_pixels
from . import cuts, opencv, scanline, ssd


__all__ = ["METHODS", "Method", "measure"]


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
    "opencv-sgbm": Method(opencv.semi_global_matching, "OpenCV's StereoSGBM over eight paths", "cv2"),
    "one-pass-float": _ours("the thesis's rule in float64: its MATLAB model", OnePass(Arithmetic.FLOAT), published="Proposed Method"),
    "one-pass-thesis": _ours("the thesis's rule in its gateware's arithmetic", OnePass(Arithmetic.THESIS)),
    "one-pass-linear": _ours("the thesis's rule in ours", OnePass(Arithmetic.LINEAR), lowers=True),
    "one-pass-fused": _ours("our second method: fused cost, support, refinement", FUSED_1),
    "one-pass-fused-2": _ours("the same with vertical support", FUSED_2),
}


def measure(name: str, pair: StereoPair) -> dict[str, Any]:
    """Bad pixels and time of a method on a pair.

    Parameters
    ----------
    name : str
        Of :data:`METHODS`.
    pair : StereoPair

    Returns
    -------
    dict
        ``"figures"``: percentage of bad pixels for each mask; ``"seconds"``: processor time of this thread; ``"energy"``, for methods that
        lower it: that of :func:`golden.matcher.energy.energy` in ``LINEAR`` arithmetic.
    """
    method = METHODS[name]
    # Processor time, because other tasks may run meanwhile; of the thread, because a worker may have several.
    start = time.thread_time()
    found = method.function(pair.left, pair.right, pair.disparities)
    result: dict[str, Any] = {"seconds": time.thread_time() - start}
    result["figures"] = {mask: bad_pixels(found, pair.truth, counted) for mask, counted in pair.masks.items()}
    if method.lowers:
        config = MatcherConfig(pair.disparities, method=OnePass(Arithmetic.LINEAR))
        result["energy"] = energy(found, matching_cost(pair.left, pair.right, config), pair.left, config)
    return result
