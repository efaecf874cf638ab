"""Maps of mounted cameras for tests, and rectified pairs of them."""

import dataclasses
from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from golden.rig.fit import fit_map
from golden.rig.lines import row_bounds
from golden.rig.maps import RectifyMap, grid, identity
from golden.rig.rectify import rectify

from .cases import Payload, pixel_words


__all__ = ["camera_map", "noise_map", "rectified_words"]


def camera_map(width: int, height: int, *, roll: float = 0.0, offset: float = 0.0, aside: float = 0.0, lens: float = 0.0,
               gain: float = 128) -> RectifyMap:
    """The map of a camera that is rolled, in degrees, and moved by lines and columns, with a lens of k1 = ``lens`` and darker corners.

    The focal length is the picture's width; ``gain`` is that of its corners.
    """
    y, x = np.mgrid[:height, :width]
    u, v = (x - (width - 1) / 2) / width, (y - (height - 1) / 2) / width
    angle = np.radians(roll)
    u, v = u * np.cos(angle) - v * np.sin(angle), u * np.sin(angle) + v * np.cos(angle)
    bent = 1 + lens * (u * u + v * v)
    far = (u * u + v * v) / max(float((u * u + v * v).max()), 1e-9)
    return fit_map(u * bent * width + (width - 1) / 2 + aside, v * bent * width + (height - 1) / 2 + offset, 1 + (gain / 128 - 1) * far)


def noise_map(width: int, height: int, reach: int, seed: int) -> RectifyMap:
    """A map of random displacements, in 1/32 pixel, and gains, with the row bounds that belong to it."""
    rng = np.random.default_rng(seed)
    shape = grid(width, height)
    which = dataclasses.replace(identity(width, height), dx=rng.integers(-reach, reach + 1, shape),
                                dy=rng.integers(-reach, reach + 1, shape), gain=rng.integers(0, 256, shape))
    return dataclasses.replace(which, bounds=row_bounds(which))


def rectified_words(pair: Sequence[NDArray[Any]], maps: Sequence[RectifyMap]) -> list[Payload]:
    """Payloads of :class:`hdl.matcher.stream.PixelPair` of a rectified pair."""
    left, right = (rectify(side, which) for side, which in zip(pair, maps))
    return pixel_words(left, right)
