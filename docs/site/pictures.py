"""Pictures of the methods at work, by the golden model, on synthetic scenes."""

import tempfile
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np
from matplotlib.figure import Figure
from numpy.typing import NDArray

from golden.config import FUSED_1, RECURSIVE_1, Arithmetic, MatcherConfig, OnePass
from golden.matcher import fused, matcher
from golden.matcher.cost import local_disparity, matching_cost
from golden.matcher.recursive import method as recursive
from golden.matcher.recursive.border_fill import border_fill
from golden.matcher.support import fused_cost
from golden.pictures.scenes import SCENES
from golden.pictures.sheet import Strip, save_figure, write_comparison, write_judged


__all__ = ["LABELS", "SHOWN", "pictures"]


#: Size of the scenes, pixels, and their disparities; the seed of their textures.
WIDTH, HEIGHT, LABELS, SEED = 160, 96, 24, 3

#: The label whose costs are shown, that of the middle of the planes.
SHOWN = 16

_METHODS = {"thesis": OnePass(Arithmetic.LINEAR), "fused-1": FUSED_1, "recursive-1": RECURSIVE_1}
_CONFIGS = {name: MatcherConfig(LABELS, WIDTH, method=method) for name, method in _METHODS.items()}

#: Scales of a panel: Matplotlib's, or that of the disparities.
_GREY: dict[str, Any] = {"cmap": "gray", "vmin": 0, "vmax": 255}
_DISPARITY: dict[str, Any] = {"cmap": "viridis", "vmin": 0, "vmax": LABELS - 1}
_COST: dict[str, Any] = {"cmap": "magma"}
_PASSED: dict[str, Any] = {"cmap": "gray", "vmin": 0, "vmax": 1}

Panel = tuple[str, NDArray[Any], dict[str, Any]]


def _write_panels(path: Path, panels: Sequence[Panel]) -> None:
    """Panels in rows of three, each with its title."""
    rows = -(-len(panels) // 3)
    figure = Figure(figsize=(9, rows * 2.05), dpi=110)
    figure.subplots_adjust(0.005, 0.005, 0.995, 1 - 0.1 / rows, 0.03, 0.15)     # a layout that is computed takes longer than the drawing
    for axes, (title, picture, scale) in zip(figure.subplots(rows, 3, squeeze=False).flat, panels, strict=True):
        axes.imshow(picture, interpolation="nearest", **scale)
        axes.set_title(title, fontsize=9, y=1)
        axes.set_axis_off()
    save_figure(path, figure, colours=256)


def _thesis(left: NDArray[Any], right: NDArray[Any]) -> list[Panel]:
    config = _CONFIGS["thesis"]
    cost = matching_cost(left, right, config)
    inside = np.percentile(cost[:, LABELS:, SHOWN], 98)     # brighter still: outside the right picture
    return [(f"matching cost E of label {SHOWN}", cost[..., SHOWN], _COST | {"vmax": inside}),
            ("label of least cost", local_disparity(cost), _DISPARITY),
            ("label of least energy", matcher.disparities(left, right, config), _DISPARITY)]


def _fused(left: NDArray[Any], right: NDArray[Any]) -> list[Panel]:
    config = _CONFIGS["fused-1"]
    found, result = fused.stages(left, right, config), fused.match(left, right, config)
    return [(f"fused cost C of label {SHOWN}", fused_cost(left, right, config)[..., SHOWN], _COST),
            ("pixels of the support", found.support_size, _COST),
            (f"mean of C over the support, label {SHOWN}", found.sums[..., SHOWN] / found.support_size, _COST),
            ("label of least energy", found.found, _DISPARITY),
            ("left-right check: white passed", found.passed, _PASSED),
            ("filled, then median", result.pixels, _DISPARITY)]


def _recursive(left: NDArray[Any], right: NDArray[Any]) -> list[Panel]:
    config = _CONFIGS["recursive-1"]
    found, result = recursive.stages(left, right, config), recursive.match(left, right, config)
    return [(f"cost A of label {SHOWN}, with what was carried", found.costs[..., SHOWN], _COST),
            ("label of least cost", found.found / result.scale, _DISPARITY),
            ("left-right check: white passed", found.passed, _PASSED),
            ("border fill", border_fill(found.found, found.passed, LABELS, result.scale) / result.scale, _DISPARITY),
            ("then the weighted median", result.pixels, _DISPARITY),
            ("confidence: brighter is surer", result.confidence, _GREY | {"vmax": result.confidence.max()})]


def pictures() -> dict[str, bytes]:
    """All pictures, by the names of their files."""
    scenes = {name: scene(WIDTH, HEIGHT, LABELS, SEED) for name, scene in SCENES.items()}
    shown = scenes["slanted"]
    pair = shown.left, shown.right
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        _write_panels(folder / "pair.png", [("left picture", shown.left, _GREY), ("right picture", shown.right, _GREY),
                                            ("disparities", shown.truth, _DISPARITY)])
        for method, panels in {"thesis": _thesis, "fused": _fused, "recursive": _recursive}.items():
            _write_panels(folder / f"{method}.png", panels(*pair))
        found = {scene: {each: matcher.disparities(pair.left, pair.right, config) for each, config in _CONFIGS.items()}
                 for scene, pair in scenes.items()}
        write_judged(folder / "judged.png", f"The scene, {WIDTH}x{HEIGHT} pixels, {LABELS} disparities", shown.left, found["slanted"],
                     (shown.truth, np.ones_like(shown.visible)), (0, LABELS - 1))
        write_comparison(folder / "scenes.png", [Strip(each, pair.left, {"truth": pair.truth, **found[each]}, (0, LABELS - 1))
                                                 for each, pair in scenes.items()])
        return {path.name: path.read_bytes() for path in sorted(folder.iterdir())}
