"""Costs that are carried to another line: spread over neighbouring labels, less their least, and limited by a gate."""

import numpy as np

from ...config import RECURSIVE_1, Propagation


__all__ = ["gates", "spread", "spread_plain"]


def spread(cost, parameters: Propagation = RECURSIVE_1.propagation):
    """``Q(d) = min(A(d), A(d - 1) + step, A(d + 1) + step, min A + jump) - min A``.

    Parameters
    ----------
    cost : (..., D) integer ndarray
        ``A``.

    Returns
    -------
    (..., D) ndarray of the same type
        ``0 .. spread_jump``.

    Examples
    --------
    >>> spread(np.array([40, 13, 200, 300])).tolist()
    [8, 0, 8, 78]
    """
    least = cost.min(axis=-1, keepdims=True)
    result = np.minimum(cost, least + parameters.spread_jump)
    np.minimum(result[..., 1:], cost[..., :-1] + parameters.spread_step, out=result[..., 1:])
    np.minimum(result[..., :-1], cost[..., 1:] + parameters.spread_step, out=result[..., :-1])
    result -= least
    return result


def gates(one, other, parameters: Propagation = RECURSIVE_1.propagation):
    """Greatest costs that are carried between pixels of these grey levels: ``max(floor, numerator // (offset + dI))``.

    Parameters
    ----------
    one, other : (...) integer ndarray
        Grey levels ``0..255``.

    Returns
    -------
    (...) int16 ndarray
    """
    difference = np.abs(np.asarray(one, dtype=np.int16) - np.asarray(other, dtype=np.int16))
    return np.array(parameters.gate, dtype=np.int16)[difference]


def spread_plain(cost, parameters: Propagation = RECURSIVE_1.propagation):
    """:func:`spread` of one pixel, label by label: for reading, and to test the fast version against."""
    least = min(cost)
    result = []
    for d, value in enumerate(cost):
        neighbours = [cost[n] + parameters.spread_step for n in (d - 1, d + 1) if 0 <= n < len(cost)]
        result.append(min(value, least + parameters.spread_jump, *neighbours) - least)
    return result
