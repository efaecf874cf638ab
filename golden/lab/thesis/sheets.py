"""Words and colours that several sections share."""

from collections.abc import Sequence

import numpy as np
from numpy.typing import NDArray

from ...pictures.dataset import StereoPair
from ...pictures.sheet import error_map


__all__ = ["difference_map", "errors", "with_bad"]


def with_bad(bad: Sequence[float] | NDArray[np.float64]) -> str:
    """Bad pixels of the masks in a title."""
    return " / ".join(f"{value:.1f}" for value in bad)


def errors(labels: NDArray[np.int32], pair: StereoPair) -> NDArray[np.uint8]:
    """The error map of a benchmark's pair, with the mask ``all``."""
    return error_map(labels, pair.truth, pair.masks["all"])


def difference_map(one: NDArray[np.int32], other: NDArray[np.int32], left: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Where two disparity pictures differ: orange by one pixel, red by more, over the left picture."""
    colours = np.repeat((128 + left // 2)[..., None], 3, axis=-1).astype(np.uint8)
    apart = np.abs(one.astype(np.int64) - other)
    colours[apart == 1] = (240, 150, 30)
    colours[apart > 1] = (200, 20, 20)
    return colours
