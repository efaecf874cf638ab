"""Pairs as two mounted cameras would see them: rolled, one lower, through lenses, one darker; and the rig that cures them."""

import dataclasses

import numpy as np
from numpy.typing import NDArray

from ..config import PIXEL_MAX
from ..pictures.dataset import StereoPair
from ..rig.files import Rig
from ..rig.fit import fit_map


__all__ = ["Mounting", "cubic", "linear"]


Floats = NDArray[np.float64]

_STEPS = 30     # of the inversion of a lens; each one reduces the error tenfold or more


def _weights(part: Floats) -> list[Floats]:
    """Of the pixels -1, 0, 1, 2 for a place between 0 and 1: the cubic through 0 and 1 with the slopes of their neighbours."""
    t = part
    return [(-t + 2 * t**2 - t**3) / 2, (2 - 5 * t**2 + 3 * t**3) / 2, (t + 4 * t**2 - 3 * t**3) / 2, (t**3 - t**2) / 2]


def _sampled(picture: NDArray[np.uint8], x: Floats, y: Floats, taps: list[int], weights: list[list[Floats]]) -> NDArray[np.uint8]:
    height, width = picture.shape
    i, j = np.floor(x).astype(int), np.floor(y).astype(int)
    total = np.zeros(x.shape)
    for down, row in zip(taps, weights[1]):
        for across, column in zip(taps, weights[0]):
            total += row * column * picture[np.clip(j + down, 0, height - 1), np.clip(i + across, 0, width - 1)]
    return np.clip(np.floor(total + 0.5), 0, PIXEL_MAX).astype(np.uint8)


def cubic(picture: NDArray[np.uint8], x: Floats, y: Floats) -> NDArray[np.uint8]:
    """Grey levels at places of a picture, bicubic (Catmull and Rom), rounded; the edge is replicated."""
    return _sampled(picture, x, y, [-1, 0, 1, 2], [_weights(each - np.floor(each)) for each in (x, y)])


def linear(picture: NDArray[np.uint8], x: Floats, y: Floats) -> NDArray[np.uint8]:
    """The same, bilinear: a rectifier in floating point."""
    places = np.clip(x, 0, picture.shape[1] - 1), np.clip(y, 0, picture.shape[0] - 1)
    return _sampled(picture, *places, [0, 1], [[1 - each % 1, each % 1] for each in places])


@dataclasses.dataclass(frozen=True)
class Mounting:
    """How far two cameras are from a rectified pair. Both have the lens; the rest is the right one's.

    Parameters
    ----------
    roll : float
        Degrees.
    offset : float
        Lines by which its picture is lower.
    lens : float
        ``k1`` of both: a point at a distance ``r`` from the middle of the picture, in focal lengths, is seen at ``r (1 + k1 r r)``. The
        focal length is the width of the picture.
    gain : float
        Of its grey levels.
    vignetting : float
        By which both darken towards the corners of their pictures, as a part of the grey levels there.
    noise : float
        Standard deviation of both cameras' noise, grey levels; the same at each call.
    """
    roll: float = 1.0
    offset: float = 3.0
    lens: float = -0.1
    gain: float = 0.7
    vignetting: float = 0.0
    noise: float = 0.0

    def sources(self, width: int, height: int, camera: int) -> tuple[Floats, Floats]:
        """Where camera 0, the left one, or 1 sees each pixel of its rectified picture: x and y, (H, W) each, pixels."""
        u, v = _centred(width, height)
        u, v = _turned(u, v, self.roll * camera)
        bent = 1 + self.lens * (u * u + v * v)
        return _pixels(u * bent, v * bent, width, height, self.offset * camera)

    def seen(self, picture: NDArray[np.uint8], camera: int) -> NDArray[np.uint8]:
        """A rectified picture as that camera sees it."""
        height, width = picture.shape
        u, v = _centred(width, height, self.offset * camera)
        straight, down = u, v
        for _ in range(_STEPS):
            bent = 1 + self.lens * (straight * straight + down * down)
            straight, down = u / bent, v / bent
        return cubic(picture, *_pixels(*_turned(straight, down, -self.roll * camera), width, height, 0))

    def pair(self, pair: StereoPair) -> tuple[NDArray[np.uint8], NDArray[np.uint8]]:
        """What the cameras see of a rectified pair."""
        height, width = pair.left.shape
        y, x = np.mgrid[:height, :width].astype(np.float64)
        brightness = self._brightness(x, y, width, height)
        left, right = (
            np.floor(gain * brightness * self.seen(side, camera) + self._noise(width, height, camera) + 0.5).clip(0, PIXEL_MAX)
            for camera, (side, gain) in enumerate(((pair.left, 1.0), (pair.right, self.gain))))
        return left.astype(np.uint8), right.astype(np.uint8)

    def rig(self, width: int, height: int) -> Rig:
        """The rig of perfectly calibrated cameras, with the gain that undoes the vignetting."""
        places = [self.sources(width, height, camera) for camera in (0, 1)]
        left, right = (fit_map(x, y, 1 / self._brightness(x, y, width, height)) for x, y in places)
        return Rig(left, right)

    def _brightness(self, x: Floats, y: Floats, width: int, height: int) -> Floats:
        """At places of a camera's picture."""
        right, down = x - (width - 1) / 2, y - (height - 1) / 2
        result: Floats = 1 - self.vignetting * 4 * (right * right + down * down) / (width * width + height * height)
        return result

    def _noise(self, width: int, height: int, camera: int) -> Floats:
        return np.random.default_rng(camera).normal(0, self.noise, (height, width))


def _centred(width: int, height: int, offset: float = 0.0) -> tuple[Floats, Floats]:
    y, x = np.mgrid[:height, :width].astype(np.float64)
    return (x - (width - 1) / 2) / width, (y - offset - (height - 1) / 2) / width


def _pixels(u: Floats, v: Floats, width: int, height: int, offset: float) -> tuple[Floats, Floats]:
    return u * width + (width - 1) / 2, v * width + (height - 1) / 2 + offset


def _turned(u: Floats, v: Floats, degrees: float) -> tuple[Floats, Floats]:
    angle = np.radians(degrees)
    return u * np.cos(angle) - v * np.sin(angle), u * np.sin(angle) + v * np.cos(angle)
