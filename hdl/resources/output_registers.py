"""Registers behind memory blocks become those inside the blocks, in a netlist for the stand-in, an ECP5.

A block of this family, as of most, has a register at its output, and without it a slow read access: 5.6 ns of a period. Yosys 0.70 leaves
it unused. A vendor's synthesis moves a register that is written behind a memory into the block; this is the same step.
"""

from collections.abc import Iterator
from pathlib import Path

from .cell_registers import Cell, CellNetlist


__all__ = ["absorb_output_registers"]


def _sides(memory: Cell) -> Iterator[tuple[str, list[str]]]:
    """Ports of a block that reads: the letter of its clock and enable, and its outputs. A block of 36 bits has one, with all outputs."""
    outputs = {side: [port for port in memory["connections"] if port.startswith(f"DO{side}")] for side in "AB"}
    if int(memory["parameters"]["DATA_WIDTH_A"], 2) == 36:
        yield "B", outputs["A"] + outputs["B"]
    else:
        yield from outputs.items()


def _unused(memory: Cell, side: str) -> bool:
    """Whether the port reads with a rising clock, without a reset, and its register is free."""
    connections, parameters = memory["connections"], memory["parameters"]
    return (parameters[f"CLK{side}MUX"] == f"CLK{side}" and connections[f"RST{side}"] == ["0"]
            and parameters[f"REGMODE_{side}"] == "NOREG")


def absorb_output_registers(path: Path, top: str) -> int:
    """Move registers into memory blocks in a netlist of ECP5 cells that Yosys wrote, and write it back.

    A register is moved if it is the only reader of an output, has the block's clock, no reset, and the same clock enable, or none, as
    those behind all other outputs of the port: the function stays the same, bit by bit and cycle by cycle.

    Returns
    -------
    int
        Registers that were moved.
    """
    netlist = CellNetlist(path, top)
    moved = 0
    for memory in netlist.of_type("DP16KD").values():
        for side, outputs in _sides(memory):
            found = netlist.behind(memory, outputs) if _unused(memory, side) else {}
            clocking = netlist.clocking(found.values())
            if clocking is None or clocking[0] != memory["connections"][f"CLK{side}"][0]:
                continue
            for regmode in ("AB" if len(outputs) > 18 else side):
                memory["parameters"][f"REGMODE_{regmode}"] = "OUTREG"
            memory["connections"][f"OCE{side}"] = [clocking[1]]
            netlist.move_behind(memory, found)
            moved += len(found)
    netlist.write()
    return moved
