"""The methods of Table 1 that are not ours."""

from ..rivals.registry import METHODS


__all__ = ["RIVALS", "SLOW"]


#: All rivals, and the one that minimises the energy of our rule by another method.
RIVALS = tuple(name for name, method in METHODS.items() if not method.ours)

#: Graph cuts: minutes on the four pairs, where the others take a second.
SLOW = tuple(name for name in RIVALS if METHODS[name].needs == "maxflow")
