"""Netlists as Yosys writes them in JSON: modules, cells, nets, and the sources of their clocks."""

import json
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from functools import cached_property
from pathlib import Path
from typing import NamedTuple


__all__ = [
    "Bit", "BlackBox", "Cell", "Hierarchy", "InstancePath", "Netlist", "Pin", "Port", "clock_sources", "read_netlist", "set_attribute",
]


#: A bit of a net, by its number within the module; or a constant: ``"0"``, ``"1"``, ``"x"`` or ``"z"``.
Bit = int | str


class Pin(NamedTuple):
    """Bit ``offset`` of ``port`` of a cell, or of the module itself if ``cell`` is empty."""
    cell: str
    port: str
    offset: int


@dataclass(frozen=True)
class Port:
    """``direction``: ``input``, ``output`` or ``inout``. ``bits``: from the lowest one."""
    direction: str
    bits: list[Bit]


@dataclass(frozen=True)
class Cell:
    """An instance of a module, of a black box or of a primitive of Yosys, whose kinds begin with ``$``.

    ``connections`` maps a port to its bits, ``directions`` a port to its direction; a black box has no directions.
    """
    kind: str
    connections: dict[str, list[Bit]]
    directions: dict[str, str] = field(default_factory=dict)
    parameters: dict[str, str] = field(default_factory=dict)
    attributes: dict[str, str] = field(default_factory=dict)


@dataclass(frozen=True)
class Netlist:
    """``nets`` maps a name to its bits: one bit may have several names.

    ``drivers`` and ``users`` know neither constants nor the pins of black boxes, whose directions are unknown.
    """
    ports: dict[str, Port]
    cells: dict[str, Cell]
    nets: dict[str, list[Bit]]

    @cached_property
    def drivers(self) -> dict[Bit, Pin]:
        """Bit to the pin that drives it."""
        return {bit: Pin(name, port, offset) for name, cell in self.cells.items() for port, bits in cell.connections.items()
                if cell.directions.get(port) == "output" for offset, bit in enumerate(bits) if isinstance(bit, int)}

    @cached_property
    def users(self) -> dict[Bit, list[Pin]]:
        """Bit to the pins that it leads to, the module's outputs last."""
        pins = [(Pin(name, port, offset), bit) for name, cell in self.cells.items() for port, bits in cell.connections.items()
                if cell.directions.get(port, "output") != "output" for offset, bit in enumerate(bits)]
        pins += [(Pin("", name, offset), bit) for name, port in self.ports.items() if port.direction == "output"
                 for offset, bit in enumerate(port.bits)]
        found: dict[Bit, list[Pin]] = {}
        for pin, bit in pins:
            if isinstance(bit, int):
                found.setdefault(bit, []).append(pin)
        return found

    @cached_property
    def inputs(self) -> dict[Bit, Pin]:
        """Bit to the input or bidirectional port of the module that it enters by."""
        return {bit: Pin("", name, offset) for name, port in self.ports.items() if port.direction != "output"
                for offset, bit in enumerate(port.bits)}

    def port_bit(self, pin: Pin) -> str:
        """Name of a bit of a port of the module: with its index if the port has several."""
        return pin.port if len(self.ports[pin.port].bits) == 1 else f"{pin.port}[{pin.offset}]"

    def net_of(self, bit: Bit) -> str:
        """Name of the net that a bit belongs to, one that the source gave if there is one; ``constant`` of a constant."""
        if isinstance(bit, str):
            return "constant"
        names = [name for name, bits in self.nets.items() if bit in bits]
        return min(names, key=lambda name: name.startswith("$"), default=str(bit))


def read_netlist(path: Path) -> dict[str, Netlist]:
    """The modules that Yosys's ``write_json`` wrote to ``path``, by name."""
    return {
        name: Netlist(
            ports={port: Port(entry["direction"], entry["bits"]) for port, entry in module["ports"].items()},
            cells={cell: Cell(entry["type"], entry["connections"], entry.get("port_directions", {}), entry["parameters"],
                              entry["attributes"]) for cell, entry in module["cells"].items()},
            nets={net: entry["bits"] for net, entry in module["netnames"].items()})
        for name, module in json.loads(path.read_text())["modules"].items()}


def set_attribute(path: Path, module: str, attribute: str, values: Mapping[str, str]) -> None:
    """Give cells of a netlist file an attribute: ``values`` maps a cell of ``module`` to the value."""
    document = json.loads(path.read_text())
    for cell, value in values.items():
        document["modules"][module]["cells"][cell]["attributes"][attribute] = value
    path.write_text(json.dumps(document))


@dataclass(frozen=True)
class BlackBox:
    """Description of a kind of cell that has no module, for :class:`Hierarchy`.

    ``repeats`` maps an output to the input that it repeats, bit by bit; ``generates`` names the outputs that are clocks, ``clocked`` the
    inputs whose lowest bit must be a clock.
    """
    repeats: Mapping[str, str] = field(default_factory=dict)
    generates: tuple[str, ...] = ()
    clocked: tuple[str, ...] = ()


def _clocks(cell: Cell) -> Iterator[Bit]:
    """The clock inputs of a register or of a memory, whose asynchronous ports have none."""
    yield from cell.connections.get("CLK", ())
    for side in ("RD", "WR"):
        enables = cell.parameters.get(f"{side}_CLK_ENABLE", "")   # the lowest port is the last digit
        yield from (bit for bit, enable in zip(cell.connections.get(f"{side}_CLK", ()), reversed(enables)) if enable == "1")


#: An instance: (module, name of the instance in the module before), from the top level, which is instance of itself, to the one meant.
InstancePath = tuple[tuple[str, str], ...]


class Hierarchy:
    """A design with all its instances, and where its clocks originate.

    Parameters
    ----------
    modules : mapping
        The design, not flattened.
    top : str
        Name of its top-level module.
    boxes : mapping
        Kind of cell to its description.
    """
    def __init__(self, modules: Mapping[str, Netlist], top: str, boxes: Mapping[str, BlackBox]):
        self.modules = modules
        self.top = top
        self.boxes = boxes
        self._box_drivers = {name: {bit: Pin(cell_name, port, offset) for cell_name, cell in module.cells.items() if cell.kind in boxes
                                    for port in (*boxes[cell.kind].repeats, *boxes[cell.kind].generates)
                                    for offset, bit in enumerate(cell.connections.get(port, ()))} for name, module in modules.items()}

    @cached_property
    def instances(self) -> list[InstancePath]:
        """All instances, the top level first."""
        found: list[InstancePath] = [((self.top, self.top),)]
        for path in found:
            found += [(*path, (cell.kind, name)) for name, cell in self.modules[path[-1][0]].cells.items() if cell.kind in self.modules]
        return found

    def source(self, path: InstancePath, bit: Bit) -> str:
        """Where a clock originates, followed from a bit of the instance ``path``.

        A bit of a port of the top level; ``kind.port`` if a black box generates it; ``? path.net`` for a net that could be traced to
        neither.
        """
        seen: list[tuple[InstancePath, Bit]] = []
        while (path, bit) not in seen:
            seen.append((path, bit))
            name, instance = path[-1]
            module = self.modules[name]
            if pin := module.drivers.get(bit) or self._box_drivers[name].get(bit):
                cell = module.cells[pin.cell]
                if cell.kind in self.modules:
                    path, bit = (*path, (cell.kind, pin.cell)), self.modules[cell.kind].ports[pin.port].bits[pin.offset]
                elif cell.kind not in self.boxes:
                    break
                elif pin.port in self.boxes[cell.kind].generates:
                    return f"{cell.kind}.{pin.port}"
                else:
                    bit = cell.connections[self.boxes[cell.kind].repeats[pin.port]][pin.offset]
            elif pin := module.inputs.get(bit):
                if len(path) == 1:
                    return module.port_bit(pin)
                path = path[:-1]
                bit = self.modules[path[-1][0]].cells[instance].connections[pin.port][pin.offset]
        path, bit = seen[-1]
        return "? " + ".".join([*(instance for _, instance in path[1:]), self.modules[path[-1][0]].net_of(bit)])


def clock_sources(modules: Mapping[str, Netlist], top: str, boxes: Mapping[str, BlackBox]) -> set[str]:
    """Where the clocks of all registers, memories and black boxes originate, as :meth:`Hierarchy.source` tells; parameters as there."""
    design = Hierarchy(modules, top, boxes)
    sources: set[str] = set()
    for path in design.instances:
        clocks: list[Bit] = []
        for cell in modules[path[-1][0]].cells.values():
            if cell.kind in boxes:
                clocks += [cell.connections[port][0] for port in boxes[cell.kind].clocked]
            elif cell.kind not in modules:
                clocks += _clocks(cell)
        sources.update(design.source(path, bit) for bit in dict.fromkeys(clocks))
    return sources
