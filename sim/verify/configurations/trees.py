"""Which inputs of a matcher's minimum trees win in its pictures, by the golden model. A further method adds a row to ``TREES``."""

from collections.abc import Callable, Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from golden.config import Fused, MatcherConfig, OnePass, Recursive
from golden.matcher import fused
from golden.matcher.cost import local_disparity, matching_cost
from golden.matcher.labelling import labelling
from golden.matcher.recursive import method as recursive

from .case import Case


__all__ = ["TREES", "unreachable", "winners"]


Labels = Mapping[str, NDArray[Any]]


def _one_pass(left: NDArray[Any], right: NDArray[Any], config: MatcherConfig) -> Labels:
    cost = matching_cost(left, right, config)
    local = local_disparity(cost)
    return {"local": local, "labels": labelling(cost, local, left, config)}


def _fused(left: NDArray[Any], right: NDArray[Any], config: MatcherConfig) -> Labels:
    result = fused.stages(left, right, config)
    labels = fused.labelling(result.sums, result.support_size, left, config)
    return {"local": np.argmin(result.sums, axis=-1), "labels": labels, "right view": result.right}


def _recursive(left: NDArray[Any], right: NDArray[Any], config: MatcherConfig) -> Labels:
    result = recursive.stages(left, right, config)
    return {"labels": np.argmin(result.costs, axis=-1), "right view": result.right}


#: Method to the function that gives the winner of each minimum tree at each pixel.
TREES: dict[type, Callable[[NDArray[Any], NDArray[Any], MatcherConfig], Labels]] = {
    OnePass: _one_pass, Fused: _fused, Recursive: _recursive}


def winners(case: Case) -> dict[str, set[int]]:
    """For each minimum tree of the matcher, the labels that win somewhere in the case's frames."""
    result: dict[str, set[int]] = {}
    for (left, right), config in zip(case.pictures(), case.configs(), strict=True):
        for name, labels in TREES[type(config.method)](left, right, config).items():
            result.setdefault(name, set()).update(np.unique(labels).tolist())
    return result


def unreachable(case: Case) -> set[int]:
    """Labels that no frame can show: its lines are too short for their disparities, or they are not in use in any."""
    reached: set[int] = set()
    for frame, config in zip(case.frames, case.configs(), strict=True):
        reached |= {label for label in range(min(config.labels_in_use, case.labels)) if abs(label + config.minimum) < frame.width}
    return set(range(case.labels)) - reached
