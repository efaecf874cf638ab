"""Jobs whose results the pages show: each takes a pair and gives arrays, and depends on nothing else, so that it can run anywhere."""

import dataclasses
import time
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from ...config import FUSED_1, Arithmetic, MatcherConfig, Method, OnePass, Weights, changed
from ...matcher.cost import local_disparity, matching_cost
from ...matcher.labelling import labelling
from ...matcher.matcher import disparities as match
from ...pictures.dataset import StereoPair
from ...pictures.metrics import bad_pixels
from . import choices
from .cures import balanced, rectified
from .disturb import distort, disturb, straighten


__all__ = ["METHODS", "bad", "background_edges", "border_figures", "choice_figures", "disturbed", "extension", "labels_of", "lens_figures",
           "local_figures", "method_config", "weight_figures"]


Result = dict[str, NDArray[Any]]

# The methods that are compared: the thesis's in the arithmetic of its MATLAB model, of its FPGA and of our gateware; and our second one.
METHODS: dict[str, Method] = {
    **{str(arithmetic): OnePass(arithmetic) for arithmetic in Arithmetic}, "fused": FUSED_1,
}


def method_config(method: str, disparities: int) -> MatcherConfig:
    """The configuration of one of :data:`METHODS`."""
    return MatcherConfig(disparities, method=METHODS[method])


def bad(labels: NDArray[Any], pair: StereoPair) -> list[float]:
    """Bad pixels for each of the pair's masks, percent."""
    return [bad_pixels(labels, pair.truth, mask) for mask in pair.masks.values()]


def labels_of(pair: StereoPair, method: str, weights: tuple[int, int, int] | None = None) -> Result:
    """Disparities of a pair by one of :data:`METHODS`, with its default weights or others.

    Returns
    -------
    dict
        ``labels`` (H, W), pixels; ``bad`` (masks,), percent; ``seconds``, processor time of the golden model.
    """
    config = method_config(method, pair.disparities)
    if weights is not None:
        config = dataclasses.replace(config, method=changed(config.method, weights=Weights(*weights)))
    # Processor time of this thread: other jobs may run meanwhile.
    start = time.thread_time()
    labels = match(pair.left, pair.right, config)
    seconds = time.thread_time() - start
    return {"labels": labels, "bad": np.array(bad(labels, pair)), "seconds": np.array(seconds)}


def local_figures(pair: StereoPair) -> Result:
    """Local disparities, those of least matching cost: ``labels`` and ``bad`` as of :func:`labels_of`."""
    labels = local_disparity(matching_cost(pair.left, pair.right, method_config("float", pair.disparities)))
    return {"labels": labels, "bad": np.array(bad(labels, pair))}


def weight_figures(pair: StereoPair, method: str, weights: Sequence[tuple[int, int, int]]) -> Result:
    """Bad pixels for each of some weights: ``bad`` (weights, masks), percent, and ``extended`` (weights,) of :func:`extension`."""
    config = method_config(method, pair.disparities)
    cost = matching_cost(pair.left, pair.right, config)
    local = local_disparity(cost)
    edges = background_edges(pair)
    result, extended = [], []
    for u1, u2, u3 in weights:
        labels = labelling(cost, local, pair.left, dataclasses.replace(config, method=changed(config.method, weights=Weights(u1, u2, u3))))
        result.append(bad(labels, pair))
        extended.append(extension(labels, pair, edges))
    return {"bad": np.array(result), "extended": np.array(extended)}


def background_edges(pair: StereoPair, reach: int = 4) -> NDArray[np.bool_]:
    """Pixels that some mask counts, with a pixel within ``reach`` columns and rows that is nearer by more than a pixel of disparity.

    Returns
    -------
    (H, W) bool ndarray
    """
    known = np.isfinite(pair.truth)
    near = np.pad(np.where(known, pair.truth, -np.inf), reach, constant_values=-np.inf)
    near = sliding_window_view(near, (2 * reach + 1, 2 * reach + 1)).max(axis=(2, 3))
    edges = known & np.any(list(pair.masks.values()), axis=0)
    edges[edges] = near[edges] > pair.truth[edges] + 1
    return edges


def extension(labels: NDArray[Any], pair: StereoPair, edges: NDArray[np.bool_] | None = None) -> float:
    """How far near objects extend over their background: percent of the background's edge pixels whose disparity is too near.

    Parameters
    ----------
    labels : (H, W) ndarray
        Pixels.
    pair : StereoPair
    edges : (H, W) bool ndarray or None
        Of :func:`background_edges`, also by default.

    Returns
    -------
    float
        ``0..100``; 0 where the background has no edge.
    """
    edges = background_edges(pair) if edges is None else edges
    return float(100 * np.mean(labels[edges] > pair.truth[edges] + 1)) if edges.any() else 0.0


def border_figures(pair: StereoPair, border: str) -> Result:
    """Bad pixels with one of :data:`golden.lab.thesis.choices.BORDERS`: ``labels`` and ``bad`` as of :func:`labels_of`."""
    labels = choices.disparities(pair.left, pair.right, MatcherConfig(pair.disparities), choices.Choice(border=border))
    return {"labels": labels, "bad": np.array(bad(labels, pair))}


def choice_figures(pair: StereoPair, colours: tuple[NDArray[np.uint8], NDArray[np.uint8]], some: Sequence[choices.Choice]) -> Result:
    """Bad pixels of each of some choices: ``bad`` (choices, masks), percent. ``colours`` is the pair as its files have it."""
    config = MatcherConfig(pair.disparities)
    return {"bad": np.array([bad(choices.disparities(*colours, config, choice), pair) for choice in some])}


def disturbed(pair: StereoPair, method: str, gain: float, noise: float, cured: bool = False) -> Result:
    """Bad pixels of a pair with gain and noise, of :func:`golden.lab.thesis.disturb.disturb`; ``cured``: balanced before it is matched.

    Returns
    -------
    dict
        ``left``, ``right``, ``labels`` and ``bad`` of one frame; ``flicker``: percent of all pixels whose disparity differs by more than
        one pixel in a second frame of the same scene.
    """
    config = method_config(method, pair.disparities)
    frames = [disturb(pair, gain, noise, seed) for seed in (1, 2)]
    if cured:
        frames = [balanced(frame) for frame in frames]
    first, second = (match(frame.left, frame.right, config) for frame in frames)
    flicker = np.array(100 * np.mean(np.abs(first - second) > 1))
    return {"left": frames[0].left, "right": frames[0].right, "labels": first, "bad": np.array(bad(first, pair)), "flicker": flicker}


def lens_figures(pair: StereoPair, method: str, k: float) -> Result:
    """Bad pixels of a pair seen through a lens.

    Returns
    -------
    dict
        ``left``, ``labels``, ``bad``, ``off_line`` of :func:`golden.lab.thesis.disturb.distort`; ``straight`` and ``rectified``: bad
        pixels after :func:`golden.lab.thesis.disturb.straighten` and :func:`golden.lab.thesis.cures.rectified`, percent.
    """
    config = method_config(method, pair.disparities)
    seen, off_line = distort(pair, k)
    labels = match(seen.left, seen.right, config)
    straight, again = (np.array(bad(match(cured.left, cured.right, config), pair))
                       for cured in (straighten(pair, k), rectified(seen, pair, k)))
    return {"left": seen.left, "labels": labels, "bad": np.array(bad(labels, seen)), "off_line": np.array(off_line),
            "straight": straight, "rectified": again}
