"""Clock rate of a component, placed and routed by nextpnr for a stand-in, because no open tool places and routes for a Cyclone III.

It begins with the Verilog that is delivered. What is done between synthesis and place and route is a device's own:
:mod:`hdl.resources.ecp5` moves registers into blocks and has a floor plan.
"""

import json
import re
import tempfile
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from itertools import islice
from pathlib import Path
from typing import Any

from golden.errors import UserError

from ..emit import verilog_text
from .lattice import Lattice
from .paths import PathClass, path_classes


__all__ = ["SEEDS", "Clock", "place_and_route"]


#: Numbers of placements that can be asked for.
SEEDS = range(1, 101)
_CLASSES = 10  # of slow paths that are reported
_TARGET_MHZ = 120  # nextpnr optimises until it reaches a target; this one is out of reach

# Suffixes of the names that Yosys derives from those of the source: type and port of the driving cell, or a number.
_CELLS = ("LUT4", "INV", "TRELLIS_FF", "CCU2C?", "PFUMX", "L6MUX21", "DP16KD", "MULT18X18D", "TRELLIS_DPR16X4", "FD1P3.X", "WIDEFN9",
          "PDP(?:SC)?16K", "MULT[0-9X]+")
_DERIVED = re.compile(rf"_({'|'.join(_CELLS)})_.*|(\.\d+)+$|\[\d+\]$|\$.*|/.*")


@dataclass(frozen=True)
class Clock:
    """Clock rate and worst paths.

    ``device``: the stand-in. ``seed``: of the placement. ``path``: from register to register, the names of the source along the path, with
    ``logic`` and ``routing`` in ns. ``cells``: placed cells by type. ``soft_multipliers``: all multipliers, or the narrow ones, are tables,
    because the device has too few.
    ``classes``: the slowest paths between registers, those alike together, the slowest first.
    """
    device: str
    mhz: float
    path: tuple[str, ...]
    logic: float
    routing: float
    cells: dict[str, int]
    soft_multipliers: bool
    classes: tuple[PathClass, ...] = ()
    seed: int = 1

    @property
    def path_classes(self) -> list[dict[str, Any]]:
        """The classes for the JSON document."""
        return [{"from": found.begin, "to": found.end, "logic_ns": round(found.logic, 2), "routing_ns": round(found.routing, 2),
                 "ends": found.ends} for found in self.classes]

    @property
    def worst_path(self) -> dict[str, Any]:
        """The path for the JSON document."""
        return {"from": self.path[0], "to": self.path[-1], "through": list(self.path[1:-1]),
                "logic_ns": round(self.logic, 2), "routing_ns": round(self.routing, 2)}


def our_name(name: str) -> str:
    """The source's name of a net or cell, without the suffixes that Yosys adds.

    Examples
    --------
    >>> our_name("matcher.engine.busy_TRELLIS_FF_Q_DI_LUT4_Z_1")
    'matcher.engine.busy'
    """
    return _DERIVED.sub("", name)


def _worst_path(report: dict[str, Any], clock: str) -> tuple[tuple[str, ...], float, float]:
    """Names along the worst path inside the clock domain, ns of logic and of routing."""
    paths = [path["path"] for path in report["critical_paths"] if path["from"] == path["to"] == f"posedge {clock}"]
    names: list[str] = []
    spent: Counter[str] = Counter()
    for step in paths[0] if paths else []:
        spent["routing" if step["type"] == "routing" else "logic"] += step["delay"]
        candidates = [step["from"]["cell"], step.get("net", ""), step["to"]["cell"]]
        for name in map(our_name, candidates if not names else candidates[1:]):
            if name and (not names or names[-1] != name):
                names.append(name)
    return tuple(names), spent["logic"], spent["routing"]


def place_and_route(component: Any, stand_in: Lattice, report: Callable[[str], None] = lambda step: None, *, seeds: int = 1
                    ) -> list[Clock]:
    """Synthesise, place and route ``component``, which takes minutes. Paths from and to pins are not counted.

    Parameters
    ----------
    component : Component
    stand_in : Lattice
    report : callable
        Called with the name of each step as it begins.
    seeds : int
        Placements from other random numbers, one after another, of ``SEEDS``.

    Returns
    -------
    list of Clock
        The fastest placement first.

    Raises
    ------
    UserError
        If the stand-in is too small, or the design cannot be placed or routed.
    """
    top = "matcher"
    with tempfile.TemporaryDirectory(prefix="clock-") as temporary:
        folder = Path(temporary)
        (folder / "design.v").write_text(verilog_text(component, name=top))
        types, soft = stand_in.synthesise(folder, top, report)
        stand_in.check(types)
        stand_in.prepare(folder / "design.json", top)
        found = [_placed(folder, stand_in, seed, report, cells=dict(types), soft_multipliers=soft) for seed in range(1, seeds + 1)]
    return sorted(found, key=lambda clock: -clock.mhz)


def _placed(folder: Path, stand_in: Lattice, seed: int, report: Callable[[str], None], **about: Any) -> Clock:
    """One placement of ``design.json``; ``about``: fields of the result that are the same for all."""
    # Relative names: the tool runs in a sandbox that sees the working folder only.
    arguments = [*stand_in.options, "--router", "router1", "--timing-allow-fail", "--freq", str(_TARGET_MHZ), "--seed", str(seed),
                 "--json", "design.json", "--report", "report.json", "--sdf", "delays.sdf"]
    reason = stand_in.run_nextpnr(folder, arguments, folder / "nextpnr.log", report)
    if reason:
        raise UserError(f"nextpnr did not place and route the design on the stand-in {stand_in.device} ({reason}); "
                        "choose fewer disparities")
    text = json.loads((folder / "report.json").read_text())
    with (folder / "delays.sdf").open() as delays:
        classes = tuple(islice(path_classes(delays, our_name), _CLASSES))
    clock, rate = min(text["fmax"].items(), key=lambda item: item[1]["achieved"])
    path, logic, routing = _worst_path(text, clock)
    return Clock(stand_in.device, rate["achieved"], path, logic, routing, classes=classes, seed=seed, **about)
