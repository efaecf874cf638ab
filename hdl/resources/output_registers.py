"""Registers behind memory blocks become those inside the blocks, in a netlist for the stand-in, an ECP5.

A block of this family, as of most, has a register at its output, and without it a slow read access: 5.6 ns of a period. Yosys 0.70 leaves
it unused. A vendor's synthesis moves a register that is written behind a memory into the block; this is the same step.
"""

import json
from collections.abc import Iterator
from pathlib import Path
from typing import Any


__all__ = ["absorb_output_registers"]


Cells = dict[str, dict[str, Any]]


def _sides(memory: dict[str, Any]) -> Iterator[tuple[str, list[str]]]:
    """Ports of a block that reads: the letter of its clock and enable, and its outputs. A block of 36 bits has one, with all outputs."""
    outputs = {side: [port for port in memory["connections"] if port.startswith(f"DO{side}")] for side in "AB"}
    if int(memory["parameters"]["DATA_WIDTH_A"], 2) == 36:
        yield "B", outputs["A"] + outputs["B"]
    else:
        yield from outputs.items()


def _plain(register: dict[str, Any]) -> bool:
    """Whether it is a register with a rising clock, without reset, that is 0 at first, as those of blocks are."""
    parameters, connections = register["parameters"], register["connections"]
    return (parameters.get("CLKMUX", "CLK") == "CLK" and parameters.get("REGSET", "RESET") == "RESET"
            and parameters.get("LSRMUX", "LSR") == "LSR" and connections.get("LSR", ["0"]) in (["0"], [])
            and _clock_enable(register) in ("1", "CE"))


def _clock_enable(register: dict[str, Any]) -> str:
    """What its clock enable is; Yosys writes a space behind a string of digits, to tell it from a number."""
    return register["parameters"].get("CEMUX", "1").strip()


def _enable(register: dict[str, Any]) -> int | str:
    """The bit of its clock enable."""
    return register["connections"]["CE"][0] if _clock_enable(register) == "CE" else "1"


def _registers_behind(memory: dict[str, Any], side: str, outputs: list[str], cells: Cells, users: dict[int, list[tuple[str, str]]]
                      ) -> dict[str, str]:
    """Output to the register behind it, if every output that is used leads to one only, all alike; else nothing."""
    connections, parameters = memory["connections"], memory["parameters"]
    if parameters[f"CLK{side}MUX"] != f"CLK{side}" or connections[f"RST{side}"] != ["0"] or parameters[f"REGMODE_{side}"] != "NOREG":
        return {}
    found: dict[str, str] = {}
    for port in outputs:
        pins = users.get(connections[port][0], []) if connections[port] else []
        if not pins:
            continue
        (name, pin), *others = pins
        if others or name not in cells or cells[name]["type"] != "TRELLIS_FF" or pin != "DI" or not _plain(cells[name]):
            return {}
        found[port] = name
    registers = [cells[name] for name in found.values()]
    alike = {(_enable(register), register["connections"]["CLK"][0]) for register in registers}
    return found if {clock for _, clock in alike} == {connections[f"CLK{side}"][0]} and len(alike) == 1 else {}


def absorb_output_registers(path: Path, top: str) -> int:
    """Move registers into memory blocks in a netlist of ECP5 cells that Yosys wrote, and write it back.

    A register is moved if it is the only reader of an output, has the block's clock, no reset, and the same clock enable, or none, as
    those behind all other outputs of the port: the function stays the same, bit by bit and cycle by cycle.

    Returns
    -------
    int
        Registers that were moved.
    """
    document = json.loads(path.read_text())
    module = document["modules"][top]
    cells: Cells = module["cells"]
    users: dict[int, list[tuple[str, str]]] = {}
    pins = [(name, port, bits) for name, cell in cells.items() for port, bits in cell["connections"].items()
            if cell["port_directions"].get(port) != "output"]
    pins += [("", name, port["bits"]) for name, port in module["ports"].items()]
    for name, pin, bits in pins:
        for bit in bits:
            users.setdefault(bit, []).append((name, pin))
    moved = 0
    for memory in [cell for cell in cells.values() if cell["type"] == "DP16KD"]:
        for side, outputs in _sides(memory):
            found = _registers_behind(memory, side, outputs, cells, users)
            if not found:
                continue
            enable = _enable(cells[next(iter(found.values()))])
            for regmode in ("AB" if len(outputs) > 18 else side):
                memory["parameters"][f"REGMODE_{regmode}"] = "OUTREG"
            memory["connections"][f"OCE{side}"] = [enable]
            for port, name in found.items():
                memory["connections"][port] = cells.pop(name)["connections"]["Q"]
            moved += len(found)
    path.write_text(json.dumps(document))
    return moved
