"""Whether a pair of pictures is given the right way round: left, then right."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from .config import FUSED_1, MatcherConfig
from .matcher.fused import stages
from .notes import note


__all__ = ["note_order", "passing"]


# Lines in the middle of the picture that are looked at: matching them takes a fraction of a second.
BAND = 64

# Of 19 Middlebury pairs 21 to 84 % of the pixels pass the left-right check, and 7 to 40 % of the same pair exchanged, at most three
# fifths of what pass in order.
FEW = 0.45
RATIO = 1.5

# Fewer pixels say nothing.
LEAST_PIXELS = 500


def passing(left: NDArray[Any], right: NDArray[Any], config: MatcherConfig) -> float:
    """Share of the pixels in the middle of a pair that pass the left-right check of the set *fused-1*, ``0..1``.

    Parameters
    ----------
    left, right : (H, W) integer ndarray
        Grey levels ``0..255``.
    config : MatcherConfig
        Gives the disparities that are searched.
    """
    top = max(0, (len(left) - BAND) // 2)
    band = slice(top, top + BAND)
    checked = MatcherConfig(config.labels, left.shape[1], config.minimum, method=FUSED_1)
    return float(np.mean(stages(left[band], right[band], checked).passed))


def note_order(left: NDArray[Any], right: NDArray[Any], config: MatcherConfig) -> None:
    """A note if few pixels pass the left-right check, and clearly more of them with the pictures exchanged. Parameters as of
    :func:`passing`."""
    if min(len(left), BAND) * left.shape[1] < LEAST_PIXELS or (given := passing(left, right, config)) >= FEW:
        return
    exchanged = passing(right, left, config)
    if exchanged > RATIO * given:
        note(f"{100 * given:.0f} % of the pixels pass the left-right check, {100 * exchanged:.0f} % with the pictures exchanged: the pair "
             "may be given the wrong way round; left(x) must match right(x - d)")
