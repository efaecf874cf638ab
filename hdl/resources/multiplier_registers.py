"""Registers around multipliers become those inside them, in a netlist for the stand-in, an ECP5.

A multiplier of this family, as that of a Cyclone, has registers at its inputs and at its output. Without them the way from the registers to
the multiplier and the one from there to the register of the product share a period with the product itself, 3.9 ns of it. Yosys 0.70 leaves
them unused. A vendor's synthesis moves registers that are written around a product into the multiplier; this is the same step.

The place and route tool has no delay for the path inside, from the registers at the inputs to the one at the output. It is shorter than the
3.9 ns from the former to the product, which that tool gives for a multiplier without the latter.
"""

from pathlib import Path

from .cell_registers import Bit, Cell, CellNetlist


__all__ = ["absorb_multiplier_registers"]


# The delays that the place and route tool knows are those of both inputs with registers or without, with the clock CLK0.
_CLOCK, _RESET, _INPUT_ENABLE, _OUTPUT_ENABLE = "CLK0", "RST0", "CE0", "CE1"
_CONSTANTS = ("0", "x")


def _ports(multiplier: Cell, sides: str) -> list[str]:
    """Ports of a multiplier with one of these letters."""
    return [port for port in multiplier["connections"] if port[0] in sides]


def _in_front(netlist: CellNetlist, multiplier: Cell) -> dict[str, str]:
    """Input to the plain register in front of it, if every input that is no zero has one, all alike; else nothing."""
    connections = multiplier["connections"]
    inputs = [port for port in _ports(multiplier, "AB") if connections[port][0] not in _CONSTANTS]
    constant = all(isinstance(connections[port][0], str) for port in ("SIGNEDA", "SIGNEDB", "SOURCEA", "SOURCEB"))
    found = {port: name for port in inputs if (name := netlist.register_of(connections[port][0])) is not None}
    return found if constant and len(found) == len(inputs) and netlist.clocking(found.values()) else {}


def _all_in_front(netlist: CellNetlist) -> dict[str, dict[str, str]]:
    """Multiplier to its inputs with registers that can be moved: each register is read by such inputs only."""
    found = {name: inputs for name, cell in netlist.of_type("MULT18X18D").items() if (inputs := _in_front(netlist, cell))}
    while True:
        registers = {register for inputs in found.values() for register in inputs.values()}
        kept = {register for register in registers if any(
            pin not in found.get(reader, {}) for reader, pin in netlist.readers(netlist.cells[register]["connections"]["Q"][0]))}
        left = {name: inputs for name, inputs in found.items() if kept.isdisjoint(inputs.values())}
        if len(left) == len(found):
            return found
        found = left


def _clock(multiplier: Cell, which: str, clock: Bit, enable: Bit, enable_port: str) -> None:
    """Turn on the registers at ports of a multiplier."""
    for port, bit in ((_CLOCK, clock), (_RESET, "0"), (enable_port, enable)):
        multiplier["connections"][port] = [bit]
        multiplier["port_directions"][port] = "input"
    multiplier["parameters"] |= {f"REG_{which}_CLK": _CLOCK, f"REG_{which}_RST": _RESET, f"REG_{which}_CE": enable_port}


def absorb_multiplier_registers(path: Path, top: str) -> int:
    """Move registers into multipliers in a netlist of ECP5 cells that Yosys wrote, and write it back.

    Registers at the inputs are moved if all inputs have some, without a reset, with the same clock and the same clock enable or none, and
    nothing else reads them; several multipliers that read one get a copy each. The register of the product is moved if it is the only
    reader, and all its bits are alike. The function stays the same, bit by bit and cycle by cycle.

    Returns
    -------
    int
        Registers that were removed.
    """
    netlist = CellNetlist(path, top)
    before = len(netlist.cells)
    in_front = _all_in_front(netlist)
    clocks = {name: clocking for name, inputs in in_front.items() if (clocking := netlist.clocking(inputs.values()))}
    multipliers = netlist.of_type("MULT18X18D")
    sources = {register: netlist.cells[register]["connections"]["DI"] for inputs in in_front.values() for register in inputs.values()}
    for name, inputs in in_front.items():
        for side in "AB":
            _clock(multipliers[name], f"INPUT{side}", *clocks[name], _INPUT_ENABLE)
        multipliers[name]["connections"] |= {port: sources[register] for port, register in inputs.items()}
    for register in sources:
        del netlist.cells[register]
    for name, multiplier in multipliers.items():
        found = netlist.behind(multiplier, _ports(multiplier, "P"))
        output = netlist.clocking(found.values())
        if output and (name not in clocks or clocks[name][0] == output[0]):
            _clock(multiplier, "OUTPUT", *output, _OUTPUT_ENABLE)
            netlist.move_behind(multiplier, found)
    netlist.write()
    return before - len(netlist.cells)
