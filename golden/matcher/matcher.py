"""Disparities of a pair, whichever method the configuration asks for."""

from ..config import Cost, MatcherConfig
from . import fused, labelling


__all__ = ["disparities"]


def disparities(left, right, config: MatcherConfig):  # type: ignore[no-untyped-def]
    """Disparities of a rectified pair by the method of ``config.cost``.

    Parameters
    ----------
    left, right : (H, W) integer ndarray
        Grey levels ``0..255``.

    Returns
    -------
    (H, W) ndarray
        Pixels: int32, or float64 with sub-pixel disparities.
    """
    return fused.match(left, right, config).pixels if config.cost is Cost.FUSED else labelling.match(left, right, config)
