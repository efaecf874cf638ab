"""The energy of a labelling, whichever algorithm minimises it."""

import numpy as np

from ..config import Arithmetic, MatcherConfig
from .labelling import slopes


__all__ = ["energy"]


def energy(labels, cost, left, config: MatcherConfig):
    """Energy of a labelling: matching costs plus the three smoothness terms (2-13) of every pixel.

    Each horizontal pair of neighbours counts once, with ``u1``; each vertical pair twice, with ``u2`` seen from below and with
    ``u3`` seen from above, as in the rule (2-15), but with the label of the lower neighbour in place of its local disparity.

    Parameters
    ----------
    labels : (H, W) integer ndarray
        Disparities, pixels.
    cost : (H, W, D) ndarray
        Of :func:`golden.matcher.cost.matching_cost`.
    left : (H, W) integer ndarray
        Grey levels.

    Returns
    -------
    float or int
        In units of the energy of ``config.method.arithmetic``; exact for integers.
    """
    labels = np.asarray(labels, dtype=np.int64)
    data = np.take_along_axis(cost, labels[..., None], axis=-1)[..., 0].sum(dtype=np.result_type(cost, np.int64))
    w1, w2, w3 = slopes(left, config)
    horizontal, vertical = np.abs(np.diff(labels, axis=1)), np.abs(np.diff(labels, axis=0))
    terms = [horizontal * w1[:, 1:], vertical * w2[1:], vertical * w3[:-1]]
    if config.method.arithmetic is Arithmetic.THESIS:
        terms = [term >> 8 for term in terms]
    return (data * config.rule.energy_scale + sum(term.sum() for term in terms)).item()
