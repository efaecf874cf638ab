"""Synthetic stereo pairs for tests, and whether what a matcher makes of one can tell right from nearly right."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .config import PIXEL_MAX, MatcherConfig


__all__ = ["NOISE", "discriminates", "scene"]


NOISE = 8  # grey levels


def scene(width: int, height: int, disparities: int, seed: int) -> tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.float64]]:
    """A textured pair whose disparity climbs along every line.

    From the left edge, 0 for a few columns, then a staircase through all labels up to ``disparities - 1``, which holds to the right
    edge. Each label lies at ``x >= d`` and next to the label before it, so smoothness does not hide it: where
    ``width >= 2*disparities`` all labels win. So that energies come close to each other and a wrong rounding shows, the left picture
    has noise, and every fourth line has no match at all; 150x33 pixels with 128 labels tell ``THESIS`` from ``LINEAR`` with 0, 1 or
    3 fraction bits.

    Parameters
    ----------
    width, height : int
        Pixels, at least 1.
    disparities : int
        Number of labels.
    seed : int

    Returns
    -------
    left, right : (H, W) uint8 ndarray
        Grey levels ``0..255``; ``left[y, x]`` is within :data:`NOISE` of ``right[y, x - truth[y, x]]``.
    truth : (H, W) float64 ndarray
        Pixels; ``inf`` on lines without a match.

    Examples
    --------
    >>> left, right, truth = scene(9, 1, 4, seed=1)
    >>> truth.tolist()
    [[0.0, 0.0, 0.0, 1.0, 1.0, 2.0, 2.0, 3.0, 3.0]]
    >>> left[0].tolist(), right[0].tolist()
    ([162, 87, 201, 189, 184, 193, 149, 146, 87], [168, 82, 193, 187, 150, 81, 243, 205, 24])
    """
    rng = np.random.default_rng(seed)
    left, right = rng.integers(0, 256, (2, height, width), dtype=np.uint8)
    column = np.arange(width)
    # Never steeper than x itself: a picture narrower than its disparities reaches fewer of them.
    climb = np.maximum(column - 1, 0) * disparities // max(width - 1, disparities)
    steps = np.minimum(climb, disparities - 1)
    truth = np.full((height, width), np.inf)
    match = np.arange(height) % 4 != 3
    noise = rng.integers(-NOISE, NOISE + 1, (height, width))
    left[match] = np.clip(right[:, column - steps] + noise, 0, PIXEL_MAX)[match]
    truth[match] = steps
    return left, right, truth


def discriminates(labels: NDArray[Any], config: MatcherConfig) -> bool:
    """Whether every label wins somewhere, ``0`` and ``D-1`` among them.

    Then every input of every comparator has won, so a comparator that drops or confuses one gives another picture.

    Parameters
    ----------
    labels : integer ndarray
        Pixels, ``0 .. D-1``: disparities, or local disparities.

    Examples
    --------
    >>> discriminates(np.array([0, 1, 2]), MatcherConfig(disparities=3))
    True
    >>> discriminates(np.array([0, 2, 2]), MatcherConfig(disparities=3))
    False
    """
    return bool(np.isin(np.arange(config.disparities), labels).all())
