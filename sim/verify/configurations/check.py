"""A case on a simulator: the emitted Verilog is bit-exact with the golden model in every frame, or what is wrong."""

import functools
import os
from collections.abc import Callable
from pathlib import Path

import numpy as np

from golden.config import MatcherConfig
from golden.matcher.matcher import match
from hdl.emit import verilog_text
from hdl.matcher.matcher import Matcher

from ...kit.harness import simulate
from ...kit.simulators import SimulationError
from ...kit.store import Store
from .case import Case


__all__ = ["emitted", "failure"]


# Clocks without a transfer: more than a matcher of these sizes and a burst of stalls ever need.
_TIMEOUT = 20_000


@functools.lru_cache(maxsize=8)
def emitted(config: MatcherConfig) -> str:
    """The Verilog of a matcher; cached, as a case that is made smaller keeps its matcher for many runs."""
    return verilog_text(Matcher(config), name="matcher")


def failure(case: Case, simulator: str, folder: str | os.PathLike[str], *, change: Callable[[str], str] = str,
            store: Store | None = None) -> str | None:
    """What is wrong with the matcher of a case, in one sentence; ``None`` if it is bit-exact with the golden model, and keeps all rules.

    Parameters
    ----------
    case : Case
    simulator : str
        One of :data:`sim.kit.simulators.SIMULATORS`.
    folder : path
        For the files of the run.
    change : callable
        Takes the emitted Verilog and gives the one that is run.
    store : Store
        Where models are kept, as of :func:`sim.kit.simulators.build`.
    """
    folder = Path(folder)
    folder.mkdir(parents=True, exist_ok=True)
    verilog = folder / "matcher.v"
    verilog.write_text(change(emitted(case.config)))
    lefts, rights = zip(*case.pictures())
    try:
        result = simulate(case.config, lefts, rights, simulator=simulator, work_dir=folder, verilog=verilog, seed=case.seed,
                          traffic=[frame.traffic for frame in case.frames], timeout=_TIMEOUT, store=store)
    except SimulationError as error:
        return str(error).partition("\n")[0]
    for number, (config, left, right, given) in enumerate(zip(case.configs(), lefts, rights, result.fields, strict=True)):
        for name, expected in match(left, right, config).items():
            wrong = np.argwhere(given[name] != expected)
            if len(wrong):
                y, x = wrong[0]
                return (f"frame {number}: {name} differs in {len(wrong)} of {left.size} pixels, first at x {x}, y {y}: "
                        f"{given[name][y, x]}, golden {int(expected[y, x])}")
    return None
