"""What cures the disturbances, in the gateware's exact integers: balance of the right picture, and rectification by the lens's map."""

import dataclasses

import numpy as np

from ...pictures.dataset import StereoPair
from ...rig.balance import balance
from ...rig.files import Rig
from ...rig.fit import fit_map
from .disturb import Lens


__all__ = ["balanced", "lens_rig", "rectified"]


def balanced(pair: StereoPair) -> StereoPair:
    """A pair whose right picture has the left one's brightness and contrast, as measured of this pair."""
    return dataclasses.replace(pair, right=balance(pair.left, pair.right, 0, pair.disparities))


def lens_rig(k: float, width: int, height: int) -> Rig:
    """The rig of two perfectly calibrated cameras with the same :class:`golden.lab.thesis.disturb.Lens`."""
    y, x = np.indices((height, width)).astype(np.float64)
    which = fit_map(*Lens(k, width, height).seen(x, y))
    return Rig(which, which)


def rectified(seen: StereoPair, pair: StereoPair, k: float) -> StereoPair:
    """A pair seen through a lens, rectified by the lens's map.

    Parameters
    ----------
    seen : StereoPair
        Of :func:`golden.lab.thesis.disturb.distort`.
    pair : StereoPair
        What it was made of, whose geometry comes back: truth and masks are its.
    k : float
        Of the lens.
    """
    height, width = pair.left.shape
    left, right = lens_rig(k, width, height).rectified(seen.left, seen.right)
    return dataclasses.replace(pair, left=left, right=right)
