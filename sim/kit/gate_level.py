"""The netlist that nextpnr places on an ECP5, as Verilog for a simulator: its cells are those of Yosys, and models of the two that Yosys
has as black boxes only, block RAM and multiplier.
"""

import importlib.util
from pathlib import Path
from typing import Any

from hdl.emit import verilog_text
from hdl.resources.ecp5 import ECP5
from hdl.yosys import Tool, run_yosys

from .simulators import ROOT


__all__ = ["gate_level", "gates_of"]


_WRITE = """
read_json design.json
hierarchy -top {top}
write_verilog -noattr gates.v
"""

#: Yosys's models of the cells, which its `cells_sim_ecp5.v` includes.
_CELLS = ("common_sim.vh", "ccu2c_sim.vh")
_MODELS = tuple(ROOT / "sim" / "stubs" / "ecp5" / name for name in ("dp16kd.v", "mult18x18d.v"))

# Of models that are not ours, and of a netlist.
_WITHOUT = ("WIDTH", "UNUSEDSIGNAL", "UNUSEDPARAM", "DECLFILENAME", "PINMISSING", "SPECIFYIGN", "UNDRIVEN", "PROCASSINIT", "GENUNNAMED",
            "MULTITOP", "CASEINCOMPLETE", "UNOPTFLAT", "INITIALDLY")


def _cells() -> str:
    """Text of the models of all cells."""
    found = importlib.util.find_spec("pyosys")
    assert found and found.origin
    share = Path(found.origin).parent / "share" / "lattice"
    return "\n".join([*((share / name).read_text() for name in _CELLS), *(path.read_text() for path in _MODELS)])


def gates_of(netlist: Path, top: str, folder: Path) -> Path:
    """Verilog of a netlist in Yosys's JSON, with the models of its cells.

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
    run_yosys(Tool.PYOSYS, _WRITE.format(top=top), folder)
    result = folder / f"{top}_gates.v"
    allowed = "\n".join(f"/* verilator lint_off {name} */" for name in _WITHOUT)
    result.write_text(f"`define NO_INCLUDES\n{allowed}\n{(folder / 'gates.v').read_text()}\n{_cells()}")
    return result


def gate_level(component: Any, top: str, folder: Path) -> Path:
    """Verilog of a component after synthesis for an ECP5, as boards are synthesised; see :func:`gates_of`."""
    folder.mkdir(parents=True, exist_ok=True)
    (folder / "design.v").write_text(verilog_text(component, name=top))
    ECP5.synthesise(folder, top, lambda step: None)
    return gates_of(folder / "design.json", top, folder)
