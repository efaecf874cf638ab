"""The minimum of many values and its index."""

import numpy as np


__all__ = ["comparator_tree"]


def comparator_tree(values):
    """Least value and its index along the last axis; the smaller index on a tie.

    Parameters
    ----------
    values : (..., N) ndarray

    Returns
    -------
    value : (...) ndarray
    index : (...) intp ndarray

    Examples
    --------
    >>> [part.item() for part in comparator_tree(np.array([7, 3, 9, 3]))]
    [3, 1]
    """
    index = np.argmin(values, axis=-1)
    return np.take_along_axis(np.asarray(values), index[..., None], axis=-1)[..., 0], index
