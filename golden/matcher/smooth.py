"""Smoothness between neighbours, equation (2-13)."""

import numpy as np

from ..config import PIXEL_MAX, Arithmetic, MatcherConfig


__all__ = ["cones", "slope", "smooth"]


def slope(difference, weight, config: MatcherConfig):
    """Smoothness of one pixel of disparity between neighbours whose grey levels differ by ``difference``.

    ``FLOAT``: ``u * (255 - dI)``, in 255ths, exact: see :attr:`MatcherConfig.energy_scale`.
    ``LINEAR``: ``(u*(256 - dI) << slope_shift) >> 8``, floor; where there are supports, for each pixel of one.
    ``THESIS``: ``u * (256 - dI)``, in 256ths, exact: that arithmetic floors after the product with the disparity difference.

    Parameters
    ----------
    difference : integer ndarray
        Grey levels ``0..255``.
    weight : int
        One of ``u1, u2, u3``.

    Examples
    --------
    >>> from golden.config import OnePass
    >>> slope(np.array([0, 100, 255]), 15, MatcherConfig(method=OnePass("linear"))).tolist()
    [240, 146, 0]
    """
    difference = np.asarray(difference)
    match config.method.arithmetic:
        case Arithmetic.FLOAT:
            return weight * (PIXEL_MAX - difference.astype(np.float64))
        case Arithmetic.THESIS:
            return weight * (256 - difference.astype(np.int32))
        case Arithmetic.LINEAR:
            return (weight * (256 - difference.astype(np.int32)) << config.rule.slope_shift) >> 8


def smooth(distance, difference, weight, config: MatcherConfig):
    """Smoothness term ``S``, equation (2-13), of neighbours ``distance`` disparities and ``difference`` grey levels apart.

    Returns
    -------
    ndarray
        In units of the energy: grey levels (``THESIS``), their 255ths (``FLOAT``) or ``2**-(q+1)`` of them (``LINEAR``).

    Examples
    --------
    >>> smooth(np.arange(4), 100, 15, MatcherConfig()).tolist()
    [0, 9, 18, 27]
    """
    term = distance * slope(difference, weight, config)
    return term >> 8 if config.method.arithmetic is Arithmetic.THESIS else term


def cones(upper, lower, w1, w2, w3, config: MatcherConfig):  # type: ignore[no-untyped-def]
    """Term that an upward pass over the labels adds to the matching cost: two cones, less a ramp.

    ``w2*|d - upper| + w3*|d - lower| - w1*d``: the smoothness against the upper and the lower neighbour, less ``w1*d`` so that the
    recursion adds nothing from label to label.

    Parameters
    ----------
    upper, lower : (...) integer ndarray
        Labels of the neighbours, pixels.
    w1, w2, w3 : (...) integer ndarray
        Slopes, of :func:`slope`.

    Returns
    -------
    (..., D) int64 ndarray

    Examples
    --------
    >>> from golden.config import OnePass
    >>> cones(1, 2, 3, 10, 100, MatcherConfig(labels=4, method=OnePass("linear"))).tolist()
    [210, 97, 4, 111]
    """
    label = np.arange(config.labels)
    upper, lower, w1, w2, w3 = (np.asarray(value, dtype=np.int64)[..., None] for value in (upper, lower, w1, w2, w3))
    return w2 * np.abs(label - upper) + w3 * np.abs(label - lower) - w1 * label
