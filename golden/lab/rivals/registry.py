"""All methods that are measured side by side, ours among them, and what the thesis prints of them."""

import functools
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

from numpy.typing import NDArray

from ...config import FUSED_1, FUSED_2, Arithmetic, Cost, FusedParameters, MatcherConfig
from ...matcher.matcher import disparities as match
from . import cuts, opencv, scanline, ssd


__all__ = ["METHODS", "PUBLISHED", "PUBLISHED_PAIR", "Method", "Published"]


Disparities = Callable[[NDArray[Any], NDArray[Any], int], NDArray[Any]]


@dataclass(frozen=True)
class Published:
    """A row of the thesis's Table 1, as printed: bad pixels of :data:`PUBLISHED_PAIR`, percent, and the time of its computation.

    Parameters
    ----------
    name : str
        The table's.
    figures : dict of str to float
        By the name of the mask.
    tool : str
    seconds : float
    """
    name: str
    figures: dict[str, float]
    tool: str
    seconds: float


@dataclass(frozen=True)
class Method:
    """A way to disparities.

    Parameters
    ----------
    function : callable
        Left and right picture, (H, W) uint8, and the number of disparities to (H, W) disparities in pixels.
    about : str
    needs : str or None
        The package that it imports; of the extra ``lab``.
    published : str or None
        Its row in :data:`PUBLISHED`.
    lowers : bool
        Whether its labels are to be of little energy in the sense of :func:`golden.matcher.energy.energy`, ``LINEAR``.
    """
    function: Disparities
    about: str
    needs: str | None = None
    published: str | None = None
    lowers: bool = False


PUBLISHED_PAIR = "tsukuba"

PUBLISHED = {row.name: row for row in (
    Published("Dynamic Programming", {"nonocc": 4.12, "all": 5.04, "disc": 12.0}, "CPU", 1.0),
    Published("Graph Cut Method", {"nonocc": 1.19, "all": 2.01, "disc": 6.24}, "CPU", 69.8),
    Published("SSD+min filter", {"nonocc": 5.08, "all": 7.22, "disc": 24.1}, "CPU", 1.1),
    Published("Proposed Method", {"nonocc": 5.09, "all": 7.08, "disc": 18.2}, "FPGA", 0.040),
)}


def _one_pass(left: NDArray[Any], right: NDArray[Any], labels: int, arithmetic: Arithmetic, cost: Cost = Cost.THESIS,
              fused: FusedParameters = FUSED_1) -> NDArray[Any]:
    """Disparities by the one-pass rule, in the golden model."""
    result: NDArray[Any] = match(left, right, MatcherConfig(disparities=labels, arithmetic=arithmetic, cost=cost, fused=fused))
    return result


def _ours(about: str, *options: Any, published: str | None = None, lowers: bool = False) -> Method:
    return Method(functools.partial(_one_pass, **dict(zip(("arithmetic", "cost", "fused"), options, strict=False))), about,
                  published=published, lowers=lowers)


METHODS = {
    "dynamic-programming": Method(scanline.disparities, "dynamic programming on every scanline", published="Dynamic Programming"),
    "ssd-min-filter": Method(ssd.disparities, "squared differences, shiftable windows", published="SSD+min filter"),
    "alpha-expansion": Method(cuts.potts_expansion, "graph cuts by expansions, Potts", "maxflow", "Graph Cut Method"),
    "alpha-beta-swap": Method(cuts.potts_swap, "graph cuts by swaps, Potts", "maxflow", "Graph Cut Method"),
    "one-pass-expansion": Method(cuts.improved, "expansions of one-pass-linear, on its own energy", "maxflow", lowers=True),
    "opencv-bm": Method(opencv.block_matching, "OpenCV's StereoBM", "cv2"),
    "opencv-sgbm": Method(opencv.semi_global_matching, "OpenCV's StereoSGBM over eight paths", "cv2"),
    "one-pass-float": _ours("the thesis's rule in float64: its MATLAB model", Arithmetic.FLOAT, published="Proposed Method"),
    "one-pass-thesis": _ours("the thesis's rule in its gateware's arithmetic", Arithmetic.THESIS),
    "one-pass-linear": _ours("the thesis's rule in ours", Arithmetic.LINEAR, lowers=True),
    "one-pass-fused": _ours("our second method: fused cost, support, refinement", Arithmetic.LINEAR, Cost.FUSED),
    "one-pass-fused-2": _ours("the same with vertical support", Arithmetic.LINEAR, Cost.FUSED, FUSED_2),
}
