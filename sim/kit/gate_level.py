"""Netlists after synthesis, as Verilog for a simulator.

That which nextpnr places on an ECP5: its cells are those of Yosys, and models of the two that Yosys has as black boxes only, block RAM and
multiplier. And that of which the elements of a Cyclone III are counted, with models of these elements.
"""

import importlib.util
import re
from pathlib import Path
from typing import Any

from hdl.emit import verilog_text
from hdl.resources.ecp5 import ECP5
from hdl.resources.mapping import map_cyclone3
from hdl.yosys import Tool, run_yosys

from .simulators import ROOT


__all__ = ["cyclone3_level", "gate_level", "gates_of"]


_WRITE = """
read_json {netlist}
hierarchy -top {top}
write_verilog -noattr gates.v
"""

#: Yosys's models of the cells, which its `cells_sim_ecp5.v` includes.
_CELLS = ("common_sim.vh", "ccu2c_sim.vh")
_ECP5_MODELS = tuple(ROOT / "sim" / "stubs" / "ecp5" / name for name in ("dp16kd.v", "mult18x18d.v"))
_CYCLONE3_MODELS = ROOT / "sim" / "stubs" / "cyclone3" / "cells.v"

# Of models that are not ours, and of a netlist.
_WITHOUT = ("WIDTH", "UNUSEDSIGNAL", "UNUSEDPARAM", "DECLFILENAME", "PINMISSING", "SPECIFYIGN", "UNDRIVEN", "PROCASSINIT", "GENUNNAMED",
            "MULTITOP", "CASEINCOMPLETE", "UNOPTFLAT", "INITIALDLY")


def _ecp5_cells() -> str:
    """Text of the models of all cells of an ECP5."""
    found = importlib.util.find_spec("pyosys")
    assert found and found.origin
    share = Path(found.origin).parent / "share" / "lattice"
    # A task that is called by a module itself is of SystemVerilog.
    plain = (re.sub(r"\$error(\(.*\));", r"initial begin $display\1; $finish; end", (share / name).read_text()) for name in _CELLS)
    return "\n".join([*plain, *(path.read_text() for path in _ECP5_MODELS)])


def _as_verilog(netlist: Path, top: str, cells: str) -> Path:
    """Verilog of a netlist with the models of its cells, beside it."""
    folder = netlist.parent
    run_yosys(Tool.PYOSYS, _WRITE.format(netlist=netlist.name, top=top), folder)
    result = folder / f"{top}_gates.v"
    allowed = "\n".join(f"/* verilator lint_off {name} */" for name in _WITHOUT)
    result.write_text(f"`define NO_INCLUDES\n{allowed}\n{(folder / 'gates.v').read_text()}\n{cells}")
    return result


def gates_of(netlist: Path, top: str, folder: Path) -> Path:
    """Verilog of a netlist of an ECP5 in Yosys's JSON, with the models of its cells.

    Parameters
    ----------
    netlist : Path
        As nextpnr takes it.
    top : str
        Its top module.
    folder : Path
        To work in, and of the result.
    """
    if netlist.resolve() != (folder / "design.json").resolve():
        (folder / "design.json").write_bytes(netlist.read_bytes())
    return _as_verilog(folder / "design.json", top, _ecp5_cells())


def gate_level(component: Any, top: str, folder: Path) -> Path:
    """Verilog of a component after synthesis for an ECP5, as boards are synthesised; see :func:`gates_of`."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "design.v").write_text(verilog_text(component, name=top))
    ECP5.synthesise(folder, top, lambda step: None)
    return gates_of(folder / "design.json", top, folder)


def cyclone3_level(component: Any, top: str, folder: Path) -> Path:
    """Verilog of a component of elements of a Cyclone III, those that :mod:`hdl.resources` counts, with the models of these elements."""
    folder.mkdir(parents=True, exist_ok=True)
    map_cyclone3(component, top, folder=folder)
    return _as_verilog(folder / "netlist.json", top, _CYCLONE3_MODELS.read_text())
