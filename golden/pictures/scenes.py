"""Synthetic stereo pairs for tests, and a check that a result discriminates between right and nearly right matchers."""

import dataclasses
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..config import PIXEL_MAX, MatcherConfig
from .surfaces import Box, Surface, photometric, render, texture


__all__ = ["NOISE", "SCENES", "Scene", "discriminates", "layers", "repetitive", "scene", "slanted", "textureless", "thin", "unequal"]


NOISE = 8  # grey levels


def scene(width: int, height: int, disparities: int, seed: int) -> tuple[NDArray[np.uint8], NDArray[np.uint8], NDArray[np.float64]]:
    """A textured pair whose disparity increases along every line.

    From the left edge, 0 for a few columns, then a staircase through all labels up to ``disparities - 1``, which continues to the right
    edge. Each label is at ``x >= d`` and next to the label before it, so smoothness does not suppress it: where
    ``width >= 2*disparities`` all labels win. To make energies nearly equal, so that a wrong rounding shows, the left picture has noise,
    and every fourth line has no match at all; 150x33 pixels with 128 labels discriminate ``THESIS`` from ``LINEAR`` with 0, 1 or 3
    fraction bits.

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
    """Grey levels ``0..255`` with detail of all sizes from 1 pixel to 32: patches of uniform grey, of steps, and of grain."""
    result = np.zeros((height, width))
    for size in (1, 2, 4, 8, 16, 32):
        coarse = rng.uniform(-1, 1, (height // size + 1, width // size + 1))
        result += size**0.5 * np.kron(coarse, np.ones((size, size)))[:height, :width]
    return np.clip(128 + 10 * result, 0, PIXEL_MAX)


def layers(width: int, height: int, disparities: int, seed: int, noise: float = 2.0) -> tuple[
        NDArray[np.uint8], NDArray[np.uint8], NDArray[np.int64], NDArray[np.bool_]]:
    """A textured pair of upright rectangles in front of a slanted ground, nearer ones occluding others; the truth is known everywhere.

    Parameters
    ----------
    width, height : int
        Pixels, at least 1.
    disparities : int
        Number of labels.
    seed : int
    noise : float
        Standard deviation of the noise in both pictures, grey levels.

    Returns
    -------
    left, right : (H, W) uint8 ndarray
        Grey levels ``0..255``.
    truth : (H, W) int64 ndarray
        Pixels, ``0 .. disparities - 1``.
    visible : (H, W) bool ndarray
        Whether the pixel is in the right picture too.
    """
    rng = np.random.default_rng(seed)
    # The ground rises from the top to a third of the disparities; rectangles are painted from far to near.
    truth = np.repeat((np.arange(height) * disparities // (3 * height))[:, None], width, axis=1)
    left = _texture(rng, width, height)
    for disparity in np.sort(rng.integers(disparities // 3, disparities, 8)):
        x, y = rng.integers(0, width), rng.integers(0, height)
        box = np.s_[y:y + rng.integers(height // 8, height // 2 + 1) + 1, x:x + rng.integers(width // 16, width // 3 + 1) + 1]
        truth[box], left[box] = disparity, _texture(rng, width, height)[box]
    # Pixels of the right picture that the left one does not show have another texture.
    right = _texture(rng, width, height)
    row, column = np.indices(truth.shape)
    shown = np.full(truth.shape, -1)
    for d in range(disparities):  # from far to near
        ys, xs = np.nonzero((truth == d) & (column >= d))
        right[ys, xs - d], shown[ys, xs - d] = left[ys, xs], d
    visible = (column >= truth) & (shown[row, np.maximum(column - truth, 0)] == truth)
    grain = rng.normal(0, noise, (2, height, width))
    noisy = (np.clip(np.rint(side + added), 0, PIXEL_MAX).astype(np.uint8) for side, added in zip((left, right), grain, strict=True))
    return *noisy, truth, visible


def discriminates(labels: NDArray[Any], config: MatcherConfig) -> bool:
    """Whether every label wins somewhere, ``0`` and ``D-1`` among them.

    Then every input of every comparator has won, so a comparator that loses or swaps one gives another picture.

    Parameters
    ----------
    labels : integer ndarray
        Pixels, ``0 .. D-1``: disparities, or local disparities.

    Examples
    --------
    >>> discriminates(np.array([0, 1, 2]), MatcherConfig(labels=3))
    True
    >>> discriminates(np.array([0, 2, 2]), MatcherConfig(labels=3))
    False
    """
    return bool(np.isin(np.arange(config.labels), labels).all())


@dataclass(frozen=True)
class Scene:
    """A synthetic pair with its ground truth.

    Parameters
    ----------
    left, right : (H, W) uint8 ndarray
        Grey levels.
    truth : (H, W) float64 ndarray
        Disparities of the left picture, pixels: known everywhere, with fractions.
    visible : (H, W) bool ndarray
        Whether the pixel is in the right picture too.
    hard : (H, W) bool ndarray
        The region for which the scene is made.
    """
    left: NDArray[np.uint8]
    right: NDArray[np.uint8]
    truth: NDArray[np.float64]
    visible: NDArray[np.bool_]
    hard: NDArray[np.bool_]


def slanted(width: int, height: int, disparities: int, seed: int) -> Scene:
    """Planes slanted along the line and down the picture, in front of a ground of all disparities; hard: the planes."""
    rng = np.random.default_rng(seed)
    boxes = [Box(width * (0.2 + 0.27 * k), height * 0.1, width * (0.4 + 0.27 * k), height * 0.9) for k in range(3)]
    planes = []
    for box, (across, downward) in zip(boxes, [(0.3, 0.0), (-0.3, 0.3), (0.0, -0.4)], strict=True):
        # Slants by these parts of all disparities from one side of its box to the other, around the middle of the space in front of the
        # ground.
        along, down = (part * (disparities - 1) / size for part, size in ((across, box.x1 - box.x0), (downward, box.y1 - box.y0)))
        x, y = (box.x0 + box.x1) / 2, (box.y0 + box.y1) / 2
        base = 0.7 * (disparities - 1) - along * x - down * y
        planes.append(Surface(texture(rng, width, height), base, along, down, box))
    return _on_ground(rng, width, height, disparities, planes)


def thin(width: int, height: int, disparities: int, seed: int) -> Scene:
    """Upright bars, 1 to 6 pixels wide, in front of a ground of all disparities; hard: the bars."""
    rng = np.random.default_rng(seed)
    bars = []
    for k, thickness in enumerate(range(1, 7)):
        x = round(width * (0.3 + 0.11 * k))
        levels = np.full((height, width), float(rng.integers(20, 90) if k % 2 else rng.integers(170, 236)))
        bars.append(Surface(levels, base=0.8 * (disparities - 1), box=Box(x, height * 0.05, x + thickness, height * 0.75)))
    return _on_ground(rng, width, height, disparities, bars)


def textureless(width: int, height: int, disparities: int, seed: int) -> Scene:
    """Boxes without texture in front of a ground of all disparities; hard: the boxes."""
    rng = np.random.default_rng(seed)
    boxes = [Surface(np.full((height, width), float(rng.integers(60, 200))), base=(0.4 + 0.2 * k) * (disparities - 1),
                     box=Box(width * (0.2 + 0.25 * k), height * 0.15, width * (0.38 + 0.25 * k), height * 0.6)) for k in range(3)]
    return _on_ground(rng, width, height, disparities, boxes)


def repetitive(width: int, height: int, disparities: int, seed: int) -> Scene:
    """A fence whose pattern repeats within the disparities that are searched, in front of a ground of all; hard: the fence."""
    rng = np.random.default_rng(seed)
    period = max(2, disparities // 3)
    stripes = np.tile(128 + 80 * np.sin(2 * np.pi * np.arange(width) / period), (height, 1))
    fence = Surface(stripes, base=0.6 * (disparities - 1), box=Box(width * 0.25, height * 0.1, width * 0.95, height * 0.55))
    return _on_ground(rng, width, height, disparities, [fence])


def unequal(width: int, height: int, disparities: int, seed: int) -> Scene:
    """:func:`slanted` seen by two cameras that differ: the right one is darker by a fifth and noisier; hard: everywhere."""
    same = slanted(width, height, disparities, seed)
    right = photometric(same.right, np.random.default_rng(seed), gain=0.8, offset=5, noise=3)
    return dataclasses.replace(same, right=right, hard=np.ones_like(same.hard))


#: All scenes of this kind, by name. Each shows every label if it is at least four times as wide as its number of disparities, and has
#: at least four lines for each.
SCENES = {scene.__name__: scene for scene in (slanted, thin, textureless, repetitive, unequal)}


def _on_ground(rng: np.random.Generator, width: int, height: int, disparities: int, objects: list[Surface]) -> Scene:
    """Objects in front of a textured ground that gets nearer down the picture, from disparity 0 to the greatest; with a little noise."""
    ground = Surface(texture(rng, width, height), base=0, down=(disparities - 1) / max(1, height - 1))
    left, right, truth, visible = render([ground, *objects])
    truth = np.minimum(truth, disparities - 1)  # rounding
    hard = truth > render([ground])[2]
    return Scene(photometric(left, rng, noise=1), photometric(right, rng, noise=1), truth, visible, hard)
