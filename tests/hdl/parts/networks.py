"""Sorting networks computed in NumPy."""

import numpy as np


__all__ = ["evaluate", "run"]


def evaluate(network, values):
    """Outputs of a :class:`hdl.parts.sorting_network.Selection` for rows of values."""
    return run([exchange for level in network.levels for exchange in level], values)[:, network.outputs]


def run(exchanges, values):
    """The values on all wires, row by row; a half that is not kept is made useless."""
    wires = np.array(values)
    for low, high, keeps_low, keeps_high in exchanges:
        pair = wires[:, [low, high]]
        wires[:, low] = pair.min(axis=1) if keeps_low else -1
        wires[:, high] = pair.max(axis=1) if keeps_high else -1
    return wires
