"""Vignetting: from a picture of an evenly lit white surface to the gain of every pixel."""

import os
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import UserError
from ..pictures.images import read_picture
from ..rig.maps import GAIN_ONE


__all__ = ["Flat", "read_flat"]


_BLOCK = 8              # pixels; blocks are averaged before the fit, which makes noise harmless and the fit quick
_DEGREE = 4             # of the surface: a lens darkens by the fourth power of a cosine
_LEVELS = range(16, 251)
_GREATEST_GAIN = 255 / GAIN_ONE

Floats = NDArray[np.float64]


def _terms(x: Floats, y: Floats, width: int, height: int) -> Floats:
    """Terms of the surface: polynomials up to :data:`_DEGREE`; coordinates of the picture's size are made -1 .. 1."""
    u, v = 2 * x / (width - 1) - 1, 2 * y / (height - 1) - 1
    return np.stack([u**i * v**j for i in range(_DEGREE + 1) for j in range(_DEGREE + 1 - i)], axis=-1)


class Flat:
    """The brightness of a camera over its picture, as a smooth surface.

    Parameters
    ----------
    picture : (H, W) uint8 ndarray
        Of an evenly lit white surface. At least 40 pixels wide and high.
    name : str
        For messages. :class:`UserError` if the picture is too dark, too bright, or darker at its edges than a gain can make good.
    """
    def __init__(self, picture: NDArray[np.uint8], name: str):
        self.height, self.width = picture.shape
        lines, columns = self.height // _BLOCK, self.width // _BLOCK
        blocks = picture[:lines * _BLOCK, :columns * _BLOCK].reshape(lines, _BLOCK, columns, _BLOCK).mean(axis=(1, 3))
        y, x = np.mgrid[:lines, :columns] * _BLOCK + (_BLOCK - 1) / 2
        if min(blocks.shape) <= _DEGREE:
            raise UserError(f"{name} is too small, {self.width}x{self.height} pixels; {(_DEGREE + 1) * _BLOCK} are needed at least")
        self._factors = np.linalg.lstsq(_terms(x.ravel(), y.ravel(), self.width, self.height), blocks.ravel(), rcond=None)[0]
        surface = self._surface(*np.meshgrid(np.arange(self.width), np.arange(self.height)))
        self.brightest, darkest = float(surface.max()), float(surface.min())
        for level, end in ((self.brightest, "brightest"), (darkest, "darkest")):
            if not _LEVELS[0] <= level <= _LEVELS[-1]:
                raise UserError(f"{name} has a grey level of {level:.0f} where it is {end}, and {_LEVELS[0]} to {_LEVELS[-1]} are usable; "
                                "change the exposure or the light")
        if self.brightest > _GREATEST_GAIN * darkest:
            raise UserError(f"{name} has {100 * darkest / self.brightest:.0f} % of its greatest brightness where it is darkest, and "
                            f"{100 / _GREATEST_GAIN:.0f} % can be made good; light the surface evenly")

    def _surface(self, x: Any, y: Any) -> Floats:
        result: Floats = _terms(np.asarray(x, dtype=np.float64), np.asarray(y, dtype=np.float64), self.width, self.height) @ self._factors
        return result

    def gain(self, x: Floats, y: Floats) -> Floats:
        """What the grey level at a place of the camera's picture is multiplied by: 1 where it is brightest. Beyond the edge as at the edge.

        Parameters
        ----------
        x, y : float ndarray
            Pixels.
        """
        return np.clip(self.brightest / self._surface(np.clip(x, 0, self.width - 1), np.clip(y, 0, self.height - 1)), 1, _GREATEST_GAIN)


def read_flat(path: str | os.PathLike[str], size: tuple[int, int]) -> Flat:
    """The brightness that a picture file shows; :class:`UserError` if it has not that width and height."""
    picture = read_picture(path)
    if picture.shape[::-1] != size:
        raise UserError(f"{path} has {picture.shape[1]}x{picture.shape[0]} pixels and the cameras have {size[0]}x{size[1]}; "
                        "take it as the others")
    return Flat(picture, str(path))
