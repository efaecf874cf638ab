"""What the sections of the pages share: the pairs, and where jobs are computed."""

from collections.abc import Callable, Hashable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ...pictures.dataset import MASKS, StereoPair
from ..cache import Cache, run_kept
from ..workers import Job, Run
from . import sweeps


__all__ = ["Laboratory", "difference", "percent"]


Result = dict[str, NDArray[Any]]


@dataclass(frozen=True)
class Laboratory:
    """The pairs, and where jobs are computed and their results are kept.

    Parameters
    ----------
    pairs : dict of str to StereoPair
        By name; Tsukuba among them.
    colours : ((H, W, 3) uint8 ndarray, (H, W, 3) uint8 ndarray)
        Tsukuba as its files have it.
    workers : Run
        Of :func:`golden.lab.workers.workers`.
    cache : Cache or None
        ``None``: nothing is kept.
    begin, advance : callable
        Called with the name of what is about to be computed and the number of its jobs, and after each of them.
    quick : bool
        Whether the sections leave out what takes minutes; each names it.
    """
    pairs: Mapping[str, StereoPair]
    colours: tuple[NDArray[np.uint8], NDArray[np.uint8]]
    workers: Run
    cache: Cache | None
    begin: Callable[[str, int], object] = lambda what, count: None
    advance: Callable[[], object] = lambda: None
    quick: bool = False

    @property
    def tsukuba(self) -> StereoPair:
        return self.pairs["tsukuba"]

    def run(self, what: str, jobs: Mapping[Hashable, Job]) -> dict[Any, Result]:
        """Results of jobs, by the same keys: from the cache, or computed."""
        return run_kept(self.workers, self.cache, jobs, lambda count: self.begin(what, count), self.advance)

    def by_method(self) -> dict[tuple[str, str], Result]:
        """Results of :func:`golden.lab.thesis.sweeps.labels_of` for every pair and method."""
        return self.run("results", {(name, method): (sweeps.labels_of, pair, method)
                                    for name, pair in self.pairs.items() for method in sweeps.METHODS})


def percent(values: Sequence[float] | NDArray[np.float64]) -> list[str]:
    """Percent to two decimals."""
    return [f"{value:.2f}" for value in values]


def difference(ours: Sequence[float] | NDArray[np.float64], theirs: Mapping[str, float]) -> list[str]:
    """Ours less the thesis's, with the sign, for each of the benchmark's masks."""
    # Added to 0, a rounded -0.0 loses its sign.
    return [f"{0.0 + round(value - theirs[mask], 2):+.2f}" for value, mask in zip(ours, MASKS, strict=True)]
