"""Synthesis, place and route for devices of Lattice by open tools: for a clock rate, and for boards."""

import re
import signal
import subprocess
import sys
from collections import Counter
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from golden.errors import UserError
from golden.processes import started

from ..netlist import read_netlist
from ..yosys import Tool, run_yosys, tool_environment


__all__ = ["Lattice", "Limit"]


_NARROW_BITS = 6

# A clock enable or a synchronous reset of few registers is made of tables: hundreds of them would each occupy part of a tile, and routing.
_ENABLED = "-cell $_DFFE_?P??_ r -cell $_SDFFE_?P??_ r"
_SYNTHESIS = """
# synthesis: reading
read_verilog design.v
{synthesis} {options} -top {top} -run begin:coarse
# synthesis: multipliers, memories
{multipliers}
{synthesis} {options} -top {top} -run coarse:map_ram
{narrow}
{synthesis} {options} -top {top} -run map_ram:map_ffs
# synthesis: registers, tables
dfflegalize -minsrst 24 -mince 16 -cell $_DFF_?_ 01 -cell $_DFF_?P?_ r -cell $_SDFF_?P?_ r -cell $_DFFE_??_ 01 {more}
opt_clean
{tables}
"""
# A carry chain begins and ends with a tile's halves that do nothing else: narrow sums and comparisons are smaller as tables.
_NARROW = f"""
techmap -map +/techmap.v t:$alu r:Y_WIDTH<={_NARROW_BITS} %i
"""
# Tables are mapped by ABC9, which knows the delays of carry chains; by ABC, where Yosys 0.70 fails to read the result of ABC9, as happens
# with designs of some 80,000 registers and tables.
_ABC9 = "{synthesis} {options} -top {top} -run map_ffs: -json design.json"
_ABC = """
{synthesis} {options} -top {top} -run map_ffs:map_luts
abc -lut 4:7 -dress
clean
{synthesis} {options} -top {top} -run map_cells: -json design.json
"""
_NEXTPNR = """
import sys
from {module} import run_nextpnr_{family}
sys.exit(run_nextpnr_{family}(sys.argv[1:]))
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


def _step(line: str) -> str | None:
    """What a line of nextpnr's log says that begins; ``None`` if it is another one."""
    for pattern, step in _STEPS:
        if found := re.match(pattern, line):
            return step.format(*found.groups())
    return None


class Limit(NamedTuple):
    """What a device has of something: its name, how many there are, and how many of them a cell takes, by the cell's type."""
    name: str
    available: int
    cells: Mapping[str, int]

    def used(self, types: Mapping[str, int]) -> int:
        """By so many cells of each type.

        Examples
        --------
        >>> Limit("tables", 100, {"LUT4": 1, "CCU2": 2}).used({"LUT4": 7, "CCU2": 3, "VHI": 1})
        13
        """
        return sum(number * self.cells.get(kind, 0) for kind, number in types.items())


@dataclass(frozen=True)
class Lattice:
    """A device, and what Yosys and nextpnr must be told of it.

    ``device``: its name and speed grade. ``family``: as nextpnr's program is called. ``options``: nextpnr's, for device and package.
    ``synthesis``: Yosys's command. ``tables``, ``registers``, ``memories``, ``multipliers``: what it has. ``wide_only``: commands of Yosys
    that make multipliers of wide products only, and narrow ones of tables; without, all products become tables where multipliers do not
    suffice. ``prepare``: changes the netlist before it is placed, a file and its top module.
    """
    device: str
    family: str
    options: tuple[str, ...]
    synthesis: str
    tables: Limit
    registers: Limit
    memories: Limit
    multipliers: Limit
    prepare: Callable[[Path, str], None]
    wide_only: str = ""

    @property
    def package(self) -> str:
        """The Python package of nextpnr."""
        return f"yowasp-nextpnr-{self.family}"

    @property
    def module(self) -> str:
        """The Python module of nextpnr."""
        return self.package.replace("-", "_")

    def synthesise(self, folder: Path, top: str, report: Callable[[str], None]) -> tuple[Counter[str], bool]:
        """Write ``design.json``; cells by type, and whether multipliers were made of tables.

        Memories are made of blocks as long as there are any: memories of tables need whole tiles, which logic could use.
        """
        options, tables, multipliers = {"-nolutram"}, _ABC9, ""
        while True:
            given = {"synthesis": self.synthesis, "options": " ".join(sorted(options)), "top": top}
            script = _SYNTHESIS.format(more=_ENABLED, multipliers=multipliers, narrow=_NARROW, tables=tables.strip().format(**given),
                                       **given)
            try:
                run_yosys(Tool.PYOSYS, script, folder, report)
            except RuntimeError:
                if tables is _ABC:
                    raise
                tables = _ABC
                continue
            types = Counter(cell.kind for cell in read_netlist(folder / "design.json")[top].cells.values())
            if self.multipliers.used(types) > self.multipliers.available:
                # All products in tables, but the wide ones; those too, if they are still too many.
                multipliers = "" if "-nodsp" in options else self.wide_only
                options.add("-nodsp")
            elif self.memories.used(types) > self.memories.available and "-nolutram" in options:
                options.remove("-nolutram")
            else:
                return types, "-nodsp" in options

    def check(self, types: Mapping[str, int]) -> None:
        """Raise :class:`UserError` if the device has too little for so many cells of each type."""
        for limit in (self.tables, self.registers, self.memories, self.multipliers):
            if (used := limit.used(types)) > limit.available:
                raise UserError(f"the design takes {used:,} {limit.name} and the stand-in {self.device}, has {limit.available:,}; "
                                "choose fewer disparities")

    def run_nextpnr(self, folder: Path, arguments: Sequence[str], log: Path,
                    report: Callable[[str], None] = lambda step: None) -> str | None:
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
        program = _NEXTPNR.format(module=self.module, family=self.family)
        with log.open("w") as file, started([sys.executable, "-c", program, *arguments], cwd=folder, env=tool_environment(),
                                            stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True) as run:
            assert run.stdout
            for line in run.stdout:
                file.write(line)
                file.flush()
                if step := _step(line):
                    report(step)
                if reason is None and line.startswith("ERROR"):
                    reason = line.removeprefix("ERROR: ").strip()
        if run.returncode < 0:
            return f"it was ended by the signal {signal.Signals(-run.returncode).name}"
        return (reason or "it gave no reason") if run.returncode else None
