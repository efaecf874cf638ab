"""Registers in a netlist of ECP5 cells that Yosys wrote, for the steps that move them into the blocks that they are written beside."""

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any


__all__ = ["Bit", "Cell", "CellNetlist"]


#: A cell as it stands in Yosys's JSON.
Cell = dict[str, Any]

#: A net's number, or a constant.
Bit = int | str


class CellNetlist:
    """A module of a netlist, which can be changed and written back.

    Parameters
    ----------
    path : Path
    top : str
        Name of the module.
    """
    def __init__(self, path: Path, top: str):
        self._path = path
        self._document = json.loads(path.read_text())
        module = self._document["modules"][top]
        self.cells: dict[str, Cell] = module["cells"]
        self._readers: dict[Bit, list[tuple[str, str]]] = {}
        self._registers: dict[Bit, str] = {}
        pins = [(name, port, bits) for name, cell in self.cells.items() for port, bits in cell["connections"].items()
                if cell["port_directions"].get(port) != "output"]
        pins += [("", name, port["bits"]) for name, port in module["ports"].items()]
        for name, pin, bits in pins:
            for bit in bits:
                self._readers.setdefault(bit, []).append((name, pin))
        for name, cell in self.cells.items():
            if cell["type"] == "TRELLIS_FF":
                self._registers[cell["connections"]["Q"][0]] = name

    def of_type(self, kind: str) -> dict[str, Cell]:
        """Cells of a type, by name."""
        return {name: cell for name, cell in self.cells.items() if cell["type"] == kind}

    def readers(self, bit: Bit) -> list[tuple[str, str]]:
        """Cell and pin of each input at a net; a port of the module has no cell, ``""``."""
        return self._readers.get(bit, [])

    def register_of(self, bit: Bit) -> str | None:
        """The plain register that drives a net."""
        name = self._registers.get(bit)
        return name if name is not None and _plain(self.cells[name]) else None

    def clocking(self, registers: Iterable[str]) -> tuple[Bit, Bit] | None:
        """Clock and clock enable of registers if they are all alike, else ``None``."""
        found = {(cell["connections"]["CLK"][0], _enable(cell)) for cell in map(self.cells.__getitem__, registers)}
        return found.pop() if len(found) == 1 else None

    def behind(self, block: Cell, outputs: Iterable[str]) -> dict[str, str]:
        """Output to the plain register behind it, if every output that is used leads to one and nothing else; else nothing."""
        found: dict[str, str] = {}
        for port in outputs:
            pins = self.readers(block["connections"][port][0]) if block["connections"][port] else []
            if not pins:
                continue
            (name, pin), *others = pins
            if others or name not in self.cells or self.cells[name]["type"] != "TRELLIS_FF" or pin != "DI" or not _plain(self.cells[name]):
                return {}
            found[port] = name
        return found

    def move_behind(self, block: Cell, found: dict[str, str]) -> None:
        """Drive with the outputs what the registers behind them drove, and remove those."""
        for port, name in found.items():
            block["connections"][port] = self.cells.pop(name)["connections"]["Q"]

    def write(self) -> None:
        """Write the netlist to where it was read."""
        self._path.write_text(json.dumps(self._document))


def _plain(register: Cell) -> bool:
    """Whether it is a register with a rising clock, without reset, that is 0 at first, as those of blocks are."""
    parameters, connections = register["parameters"], register["connections"]
    return (parameters.get("CLKMUX", "CLK") == "CLK" and parameters.get("REGSET", "RESET") == "RESET"
            and parameters.get("LSRMUX", "LSR") == "LSR" and connections.get("LSR", ["0"]) in (["0"], [])
            and _clock_enable(register) in ("1", "CE"))


def _clock_enable(register: Cell) -> str:
    """What its clock enable is; Yosys writes a space behind a string of digits, to tell it from a number."""
    return register["parameters"].get("CEMUX", "1").strip()


def _enable(register: Cell) -> Bit:
    """The bit of its clock enable."""
    return register["connections"]["CE"][0] if _clock_enable(register) == "CE" else "1"
