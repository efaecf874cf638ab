"""Clock rate of a component, placed and routed by nextpnr for an ECP5: a stand-in, because no open tool routes a Cyclone III.

It begins with the Verilog that is delivered. Between synthesis and place and route, registers behind memory blocks become those of the
blocks, :mod:`hdl.resources.output_registers`, those around multipliers become those of the multipliers,
:mod:`hdl.resources.multiplier_registers`, and memories of labels get their places, :mod:`hdl.resources.floorplan`.
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
from ..netlist import Netlist, read_netlist, set_attribute
from .ecp5 import run_nextpnr, synthesise
from .floorplan import floor_plan, selection_plan
from .multiplier_registers import absorb_multiplier_registers
from .output_registers import absorb_output_registers
from .paths import PathClass, path_classes


__all__ = ["DEVICE", "Clock", "place_and_route"]


DEVICE = "ECP5-85F, speed grade 6"
_CLASSES = 10  # of slow paths that are reported
_TARGET_MHZ = 120  # nextpnr optimises until it reaches a target; this one is out of reach

# Suffixes of the names that Yosys derives from those of the source: type and port of the driving cell, or a number.
_DERIVED = re.compile(r"_(LUT4|TRELLIS_FF|CCU2C|PFUMX|L6MUX21|DP16KD|MULT18X18D|TRELLIS_DPR16X4|INV)_.*|(\.\d+)+$|\[\d+\]$|\$.*")
# Registers in front of the selection, with the answers of all labels: their number along the pipeline; the output has the last ones.
_ANSWERS = re.compile(r"\btransition_(\d*)$")


@dataclass(frozen=True)
class Clock:
    """Clock rate and worst paths.

    ``path``: from register to register, the names of the source along the path, with ``logic`` and ``routing`` in ns.
    ``cells``: placed cells by type. ``soft_multipliers``: all multipliers, or the narrow ones, are tables, because the device has too few.
    ``classes``: the slowest paths between registers, those alike together, the slowest first.
    """
    mhz: float
    path: tuple[str, ...]
    logic: float
    routing: float
    cells: dict[str, int]
    soft_multipliers: bool
    classes: tuple[PathClass, ...] = ()

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


def _answer_bits(width: int) -> int:
    """Bits of an answer, a label, if those of all labels have ``width`` bits; 0 if none have.

    Examples
    --------
    >>> _answer_bits(80 * 7), _answer_bits(2), _answer_bits(3)
    (7, 1, 0)
    """
    return next((bits for bits in range(1, width + 1) if width % bits == 0 and (width // bits - 1).bit_length() == bits), 0)


def _selection(module: Netlist) -> dict[str, tuple[int, int]]:
    """The last registers in front of the selection: name to label and bit of the answer; of several that are merged, the last label."""
    found: dict[float, dict[str, tuple[int, int]]] = {}  # by number along the pipeline
    for name, nets in module.nets.items():
        if (match := _ANSWERS.search(name)) and (bits := _answer_bits(len(nets))):
            drivers = {at: module.drivers[net].cell for at, net in enumerate(nets) if net in module.drivers}
            found[float(match[1] or "inf")] = {driver: divmod(at, bits) for at, driver in drivers.items()
                                               if module.cells[driver].kind == "TRELLIS_FF"}
    return found[max(found)] if found else {}


def _plan(design: Path, top: str) -> None:
    """Place the memory blocks of labels and the registers of the selection as :mod:`hdl.resources.floorplan` says."""
    module = read_netlist(design)[top]
    blocks = floor_plan(name for name, cell in module.cells.items() if cell.kind == "DP16KD")
    set_attribute(design, top, "BEL", blocks | selection_plan(_selection(module)))


def place_and_route(component: Any, report: Callable[[str], None] = lambda step: None, *, seed: int = 1) -> Clock:
    """Synthesise, place and route ``component``, its ports at pins, which takes minutes. Paths from and to pins are not counted."""
    top = "matcher"
    with tempfile.TemporaryDirectory(prefix="clock-") as temporary:
        folder = Path(temporary)
        (folder / "design.v").write_text(verilog_text(component, name=top))
        types, soft = synthesise(folder, top, report)
        for absorb in (absorb_output_registers, absorb_multiplier_registers):
            absorb(folder / "design.json", top)
        _plan(folder / "design.json", top)
        # Relative names: the tool runs in a sandbox that sees the working folder only.
        arguments = ["--85k", "--speed", "6", "--package", "CABGA756", "--router", "router1", "--timing-allow-fail",
                     "--freq", str(_TARGET_MHZ), "--seed", str(seed),
                     "--json", "design.json", "--report", "report.json", "--sdf", "delays.sdf"]
        reason = run_nextpnr(folder, arguments, folder / "nextpnr.log", report)
        if reason:
            raise UserError(f"nextpnr did not place and route the design on an {DEVICE} ({reason}); choose fewer disparities")
        text = json.loads((folder / "report.json").read_text())
        with (folder / "delays.sdf").open() as delays:
            classes = tuple(islice(path_classes(delays, our_name), _CLASSES))
    clock, rate = min(text["fmax"].items(), key=lambda item: item[1]["achieved"])
    path, logic, routing = _worst_path(text, clock)
    return Clock(rate["achieved"], path, logic, routing, dict(types), soft, classes)
