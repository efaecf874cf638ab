"""The methods of Table 1 that are not ours, as jobs."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...pictures.dataset import StereoPair
from ..rivals.registry import METHODS, measure


__all__ = ["RIVALS", "SLOW", "rival_figures"]


#: All rivals, and the one that minimises the energy of our rule by another method.
RIVALS = tuple(name for name, method in METHODS.items() if not method.ours)

#: Graph cuts: minutes on the four pairs, where the others take a second.
SLOW = tuple(name for name in RIVALS if METHODS[name].needs == "maxflow")


def rival_figures(pair: StereoPair, name: str) -> dict[str, NDArray[Any]]:
    """``bad`` (masks,), percent, and ``seconds``, processor time, of one of :data:`RIVALS` on a pair."""
    found = measure(name, pair)
    return {"bad": np.array(list(found["figures"].values())), "seconds": np.array(found["seconds"])}
