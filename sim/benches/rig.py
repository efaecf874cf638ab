"""What the bench of rectification and balance runs on."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from golden.rig.maps import RectifyMap
from sim.kit.cases import noise
from sim.kit.rig_cases import camera_map, noise_map


__all__ = ["maps_of", "pictures_of"]


def maps_of(case: Mapping[str, Any], second: bool) -> list[RectifyMap]:
    """Maps of both cameras: the first ones, or those that are loaded later."""
    width, height = case["width"], case["height"]
    if width < 64:      # too few pixels to fit a lens to
        return [noise_map(width, height, 90, seed) for seed in ((3, 4) if second else (1, 2))]
    left, right = {"roll": 1, "lens": -0.1, "gain": 200}, {"roll": -1, "offset": 1.3, "lens": -0.05}
    return [camera_map(width, height, **camera) for camera in ((right, left) if second else (left, right))]


def pictures_of(case: Mapping[str, Any]) -> list[tuple[NDArray[Any], NDArray[Any]]]:
    """Pairs: noise, the right one darker."""
    pairs = [noise(case["width"], case["height"], seed) for seed in range(case["frames"])]
    return [(left, (np.where(right < 250, left, right) * 3) >> 2) for left, right in pairs]
