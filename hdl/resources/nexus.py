"""The LIFCL-40 of Lattice's Nexus family: a second stand-in for a clock rate, of a later process than the ECP5, and another router's view.

Registers behind memory blocks stay outside them here: nextpnr 0.11 has one delay from a block's clock to its output, whether the register
inside is used or not.
"""

import json
from pathlib import Path

from .lattice import Lattice, Limit


__all__ = ["NEXUS"]


# Cells of Yosys that drive constants.
_CONSTANTS = ("VHI", "VLO")
# The clock's driver in place of a pin.
_CLOCK = {"type": "DCC", "parameters": {}, "attributes": {}, "port_directions": {"CLKO": "output"}, "hide_name": 0}


def _prepare(design: Path, top: str) -> None:
    """Make of Yosys's netlist one that nextpnr can place: without ports, and with carry chains that begin with no carry.

    nextpnr has no place for a port that was not given a pin. Paths from and to pins are not counted in any case, so that all may be left
    out; the clock is then that of a buffer. Yosys 0.70 connects the carry at the beginning of a chain, which a cell without effect on it
    precedes, with a constant, and nextpnr takes the output of another carry cell only.
    """
    document = json.loads(design.read_text())
    module = document["modules"][top]
    cells = module["cells"]
    constants = {cell["connections"]["Z"][0] for cell in cells.values() if cell["type"] in _CONSTANTS}
    for cell in cells.values():
        if cell["type"] == "CCU2" and constants.issuperset(cell["connections"].get("CIN", [])):
            cell["connections"].pop("CIN", None)
    cells["clock"] = _CLOCK | {"connections": {"CLKO": module["ports"]["clk"]["bits"]}}
    module["ports"] = {}
    design.write_text(json.dumps(document))


#: Tables of four inputs, each with a register, memory blocks of 18 kbit, and 56 multipliers of 18x18 bits or twice as many of 9x9.
NEXUS = Lattice(
    device="LIFCL-40, speed grade 9", family="nexus", options=("--device", "LIFCL-40-9BG400C"), synthesis="synth_nexus -noiopad",
    tables=Limit("tables", 32_256, {"LUT4": 1, "CCU2": 2, "WIDEFN9": 2, "DPR16X4": 4}),
    registers=Limit("registers", 32_256, {f"FD1P3{kind}": 1 for kind in ("BX", "DX", "IX", "JX")}),
    memories=Limit("memory blocks", 84, {"DP16K": 1, "PDP16K": 1, "PDPSC16K": 1}),
    multipliers=Limit("9x9 multipliers", 112, {"MULT9X9": 1, "MULT18X18": 2, "MULT18X36": 4, "MULT36X36": 8, "MULTPREADD18X18": 2,
                                              "MULTADDSUB18X18": 2, "MULTADDSUB9X9WIDE": 4}),
    prepare=_prepare)
