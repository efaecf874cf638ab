"""Synthetic stereo pairs for tests, and whether what a matcher makes of one can tell right from nearly right."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .config import PIXEL_MAX, MatcherConfig


__all__ = ["NOISE", "discriminates", "layers", "scene"]


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


def _texture(rng: np.random.Generator, width: int, height: int) -> NDArray[np.float64]:
    """Grey levels ``0..255`` with detail of every size from a pixel to 32: patches of even grey, of steps, and of grain."""
    result = np.zeros((height, width))
    for size in (1, 2, 4, 8, 16, 32):
        coarse = rng.uniform(-1, 1, (height // size + 1, width // size + 1))
        result += size**0.5 * np.kron(coarse, np.ones((size, size)))[:height, :width]
    return np.clip(128 + 10 * result, 0, PIXEL_MAX)


def layers(width: int, height: int, disparities: int, seed: int, noise: float = 2.0) -> tuple[
        NDArray[np.uint8], NDArray[np.uint8], NDArray[np.int64], NDArray[np.bool_]]:
    """A textured pair of upright rectangles before a slanted ground, each nearer than what it hides: with occlusions, and true everywhere.

    Parameters
    ----------
    width, height : int
        Pixels, at least 1.
    disparities : int
        Number of labels.
    seed : int
    noise : float
        Standard deviation of what is added to either picture, grey levels.

    Returns
    -------
    left, right : (H, W) uint8 ndarray
        Grey levels ``0..255``.
    truth : (H, W) int64 ndarray
        Pixels, ``0 .. disparities - 1``.
    visible : (H, W) bool ndarray
        Whether the right picture shows the pixel too.
    """
    rng = np.random.default_rng(seed)
    # The ground climbs from the top to a third of the disparities; rectangles follow from the far one to the near one.
    truth = np.repeat((np.arange(height) * disparities // (3 * height))[:, None], width, axis=1)
    left = _texture(rng, width, height)
    for disparity in np.sort(rng.integers(disparities // 3, disparities, 8)):
        x, y = rng.integers(0, width), rng.integers(0, height)
        box = np.s_[y:y + rng.integers(height // 8, height // 2 + 1) + 1, x:x + rng.integers(width // 16, width // 3 + 1) + 1]
        truth[box], left[box] = disparity, _texture(rng, width, height)[box]
    # What nothing in the left picture is seen at has a texture of its own.
    right = _texture(rng, width, height)
    row, column = np.indices(truth.shape)
    shown = np.full(truth.shape, -1)
    for d in range(disparities):  # the nearer is painted over the farther
        ys, xs = np.nonzero((truth == d) & (column >= d))
        right[ys, xs - d], shown[ys, xs - d] = left[ys, xs], d
    visible = (column >= truth) & (shown[row, np.maximum(column - truth, 0)] == truth)
    grain = rng.normal(0, noise, (2, height, width))
    noisy = (np.clip(np.rint(side + added), 0, PIXEL_MAX).astype(np.uint8) for side, added in zip((left, right), grain, strict=True))
    return *noisy, truth, visible


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
