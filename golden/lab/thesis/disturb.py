"""Disturbances of a pair: lens distortion, and cameras of different gain and noise."""

import dataclasses
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from ...pictures.dataset import StereoPair
from ...pictures.surfaces import photometric


__all__ = ["Lens", "distort", "disturb", "straighten"]


@dataclass(frozen=True)
class Lens:
    """Radial distortion about the middle of the picture: a point at ``r`` is seen at ``r * (1 + k * r**2)``.

    Parameters
    ----------
    k : float
        Negative: barrel. ``r`` is 1 in the corner, so the corner moves by the part ``k`` of its distance. Above -4/27: with a stronger
        barrel no point of the scene is in the corner.
    width, height : int
        Pixels.
    """
    k: float
    width: int
    height: int

    def __post_init__(self) -> None:
        if not self.k > -4 / 27:
            raise ValueError(f"k must be above -4/27, not {self.k:g}")

    @property
    def _centre(self) -> NDArray[np.float64]:
        return np.array([self.width - 1, self.height - 1]) / 2

    def seen(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Where a point of the undistorted picture is in the distorted one."""
        cx, cy = self._centre
        factor = 1 + self.k * ((x - cx)**2 + (y - cy)**2) / (cx**2 + cy**2)
        return cx + (x - cx) * factor, cy + (y - cy) * factor

    def source(self, x: NDArray[np.float64], y: NDArray[np.float64]) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """The point of the undistorted picture at a place of the distorted one: the inverse of :meth:`seen`, by fixed-point steps."""
        (cx, cy), (u, v) = self._centre, (x, y)
        for _ in range(60):
            factor = 1 + self.k * ((u - cx)**2 + (v - cy)**2) / (cx**2 + cy**2)
            u, v = cx + (x - cx) / factor, cy + (y - cy) / factor
        return u, v


def _sample(picture: NDArray[np.uint8], x: NDArray[np.float64], y: NDArray[np.float64]) -> NDArray[np.uint8]:
    """Grey levels between pixels, bilinear; edge replication outside the picture."""
    height, width = picture.shape
    x, y = np.clip(x, 0, width - 1), np.clip(y, 0, height - 1)
    x0, y0 = np.minimum(x.astype(int), max(width - 2, 0)), np.minimum(y.astype(int), max(height - 2, 0))
    x1, y1 = np.minimum(x0 + 1, width - 1), np.minimum(y0 + 1, height - 1)
    right, below = x - x0, y - y0
    upper = picture[y0, x0] * (1 - right) + picture[y0, x1] * right
    lower = picture[y1, x0] * (1 - right) + picture[y1, x1] * right
    return np.rint(upper * (1 - below) + lower * below).astype(np.uint8)


def distort(pair: StereoPair, k: float) -> tuple[StereoPair, float]:
    """A pair as taken by two cameras with the same distorting lens; truth and masks are distorted with it.

    A point is at different places in the two pictures, hence displaced by different amounts: the true disparity changes, and the two
    are no longer on the same scanline.

    Returns
    -------
    pair : StereoPair
        Truth: horizontal distance of the point in the distorted pictures, rounded to whole pixels as Tsukuba's truth is: an error of
        a pixel and a fraction is bad only where the truth has fractions. Pixels from outside the picture do not count.
    off_line : float
        Greatest vertical distance of the two, lines, among the pixels that count.
    """
    height, width = pair.left.shape
    lens = Lens(k, width, height)
    y, x = np.indices((height, width)).astype(np.float64)
    u, v = lens.source(x, y)
    left, right = (_sample(side, u, v) for side in (pair.left, pair.right))
    column, row = np.rint(u).astype(int), np.rint(v).astype(int)
    inside = (column >= 0) & (column < width) & (row >= 0) & (row < height)
    at = np.clip(row, 0, height - 1), np.clip(column, 0, width - 1)
    known = inside & np.isfinite(pair.truth[at])
    x_right, y_right = lens.seen(u - np.where(known, pair.truth[at], 0), v)
    truth = np.where(known, np.rint(x - x_right), np.inf)
    masks = {name: mask[at] & inside for name, mask in pair.masks.items()}
    counted = known & np.any(list(masks.values()), axis=0)
    off_line = float(np.abs(y - y_right)[counted].max(initial=0))
    return dataclasses.replace(pair, left=left, right=right, truth=truth, masks=masks), off_line


def straighten(pair: StereoPair, k: float) -> StereoPair:
    """A pair that is distorted by a lens and rectified again: the geometry is right, the pictures are sampled twice."""
    height, width = pair.left.shape
    lens = Lens(k, width, height)
    y, x = np.indices((height, width)).astype(np.float64)
    left, right = (_sample(_sample(side, *lens.source(x, y)), *lens.seen(x, y)) for side in (pair.left, pair.right))
    return dataclasses.replace(pair, left=left, right=right)


def disturb(pair: StereoPair, gain: float, noise: float, seed: int) -> StereoPair:
    """A pair whose right camera multiplies grey levels by ``gain``, and both of which add ``noise``.

    Parameters
    ----------
    pair : StereoPair
    gain : float
    noise : float
        Standard deviation, grey levels.
    seed : int
        Of the noise: another seed is another frame of the same scene.
    """
    rng = np.random.default_rng(seed)
    left, right = photometric(pair.left, rng, noise=noise), photometric(pair.right, rng, gain=gain, noise=noise)
    return dataclasses.replace(pair, left=left, right=right)
