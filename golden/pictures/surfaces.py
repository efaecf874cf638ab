"""Slanted textured surfaces in front of a pair of cameras: the pictures, exact disparities, and occlusions."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..config import PIXEL_MAX


__all__ = ["Box", "Surface", "photometric", "render", "texture"]


Floats = Any  # a float64 ndarray, or a number that is broadcast


@dataclass(frozen=True)
class Box:
    """An upright rectangle in the left picture: ``x0 <= x < x1`` and ``y0 <= y < y1``, pixels."""
    x0: float
    y0: float
    x1: float
    y1: float

    def holds(self, x: Floats, y: Floats) -> NDArray[np.bool_]:
        return (x >= self.x0) & (x < self.x1) & (y >= self.y0) & (y < self.y1)


@dataclass(frozen=True)
class Surface:
    """A plane in space, seen in a box: disparity ``base + along*x + down*y``.

    Parameters
    ----------
    levels : (H, W) float64 ndarray
        Grey levels at every pixel of the left picture; linear between pixels, edge replication outside. As large as the picture also
        for a surface in a box.
    base, along, down : float
        Pixels, and pixels a pixel; ``along < 1``, otherwise the right camera would see the surface from behind.
    box : Box or None
        ``None``: everywhere.
    """
    levels: Floats
    base: float
    along: float = 0.0
    down: float = 0.0
    box: Box | None = None

    def __post_init__(self) -> None:
        if not self.along < 1:
            raise ValueError(f"along must be below 1, not {self.along:g}: the right camera sees no surface from behind")

    def disparity(self, x: Floats, y: Floats) -> Floats:
        """Disparity at a place of the left picture, pixels; ``-inf``, behind all others, outside the box."""
        plane = self.base + self.along * x + self.down * y
        return plane if self.box is None else np.where(self.box.holds(x, y), plane, -np.inf)

    def seen_from_right(self, x: Floats, y: Floats) -> Floats:
        """Column in the left picture of the point that is at ``x, y`` in the right one: ``x_left - d(x_left) = x``."""
        return (x + self.base + self.down * y) / (1 - self.along)

    def level(self, x: Floats) -> Floats:
        """Grey levels at the columns ``x[y]`` of every line."""
        column = np.arange(self.levels.shape[1])
        return np.stack([np.interp(places, column, line) for places, line in zip(x, self.levels, strict=True)])


def render(surfaces: list[Surface]) -> tuple[Floats, Floats, Floats, NDArray[np.bool_]]:
    """Both pictures of some surfaces; nearer ones occlude others, and the first must cover the picture.

    Parameters
    ----------
    surfaces : list of Surface
        With ``levels`` of the size of the pictures.

    Returns
    -------
    left, right : (H, W) float64 ndarray
        Grey levels.
    truth : (H, W) float64 ndarray
        Disparities of the left picture, pixels.
    visible : (H, W) bool ndarray
        Whether the pixel is in the right picture too: inside it, and not occluded.

    Examples
    --------
    >>> ground = Surface(np.array([[10.0, 20, 30, 40, 50, 60]]), base=0)
    >>> left, right, truth, visible = render([ground, Surface(np.full((1, 6), 99.0), base=2, box=Box(3, 0, 5, 1))])
    >>> left[0].tolist(), right[0].tolist()
    ([10.0, 20.0, 30.0, 99.0, 99.0, 60.0], [10.0, 99.0, 99.0, 40.0, 50.0, 60.0])
    >>> truth[0].tolist(), visible[0].tolist()
    ([0.0, 0.0, 0.0, 2.0, 2.0, 0.0], [True, False, False, True, True, True])
    """
    if not surfaces or surfaces[0].box is not None:
        raise ValueError("the first surface must be everywhere, so that every pixel shows one")
    y, x = np.indices(surfaces[0].levels.shape).astype(np.float64)
    near = np.stack([surface.disparity(x, y) for surface in surfaces])
    truth = near.max(axis=0)
    left = np.take_along_axis(np.stack([surface.level(x) for surface in surfaces]), near.argmax(axis=0)[None], axis=0)[0]

    at = [surface.seen_from_right(x, y) for surface in surfaces]
    shown = np.stack([surface.disparity(places, y) for surface, places in zip(surfaces, at, strict=True)])
    right = np.stack([surface.level(places) for surface, places in zip(surfaces, at, strict=True)])
    right = np.take_along_axis(right, shown.argmax(axis=0)[None], axis=0)[0]

    seen = x - truth  # column of the point in the right picture
    before = np.stack([surface.disparity(surface.seen_from_right(seen, y), y) for surface in surfaces]).max(axis=0)
    # The surface of the point itself gives the same disparity, up to rounding.
    visible = (seen >= 0) & (before <= truth + 1e-6)
    return left, right, truth, visible


def texture(rng: np.random.Generator, width: int, height: int, amplitude: float = 40.0, grain: int = 3) -> Floats:
    """Grey levels with detail from ``grain`` pixels to 32, around 128: random values on a grid, linear between them.

    Parameters
    ----------
    rng : numpy.random.Generator
    width, height : int
        Pixels.
    amplitude : float
        Standard deviation, grey levels.
    grain : int
        Finest detail, pixels.
    """
    result = np.zeros((height, width))
    for size in (grain, 8, 32):
        rows, columns = height // size + 2, width // size + 2
        grid = rng.uniform(-1, 1, (rows, columns))
        wide = np.stack([np.interp(np.arange(width) / size, np.arange(columns), line) for line in grid])
        result += np.stack([np.interp(np.arange(height) / size, np.arange(rows), line) for line in wide.T], axis=1)
    return np.clip(128 + amplitude * result / max(result.std(), 1e-9), 0, PIXEL_MAX)


def photometric(picture: Floats, rng: np.random.Generator, gain: float = 1.0, offset: float = 0.0, noise: float = 0.0) -> NDArray[np.uint8]:
    """Grey levels as a camera gives them: ``gain * picture + offset``, Gaussian noise added, rounded, clipped to ``0..255``.

    Parameters
    ----------
    picture : (H, W) ndarray
        Grey levels.
    rng : numpy.random.Generator
    gain, offset : float
        Factor, and grey levels.
    noise : float
        Standard deviation, grey levels.

    Examples
    --------
    >>> photometric(np.array([[10.0, 100, 250]]), np.random.default_rng(1), gain=1.1, offset=-20).tolist()
    [[0, 90, 255]]
    """
    levels = gain * np.asarray(picture, dtype=np.float64) + offset + rng.normal(0, noise, np.shape(picture))
    return np.clip(np.rint(levels), 0, PIXEL_MAX).astype(np.uint8)
