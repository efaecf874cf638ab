"""The modules of a design joined to one, in which a net has one number."""

from collections.abc import Mapping

from ...netlist import Bit, Netlist


__all__ = ["ONE", "UNDEFINED", "ZERO", "Flat", "FlatCell"]


#: Numbers of the constant nets; those of others are positive.
ZERO, ONE, UNDEFINED = 0, -1, -2

_CONSTANTS = {"0": ZERO, "1": ONE, "x": UNDEFINED, "z": UNDEFINED}


class FlatCell:
    """A primitive of Yosys.

    Parameters
    ----------
    kind : str
    nets : dict
        Port to its nets, from the lowest bit.
    parameters : mapping
        As in :class:`hdl.netlist.Cell`.
    block : int
        Its block, an index of :attr:`Flat.paths`.
    """
    __slots__ = ("block", "kind", "nets", "parameters", "state")

    def __init__(self, kind: str, nets: dict[str, list[int]], parameters: Mapping[str, str], block: int):
        self.kind = kind
        self.nets = nets
        self.parameters = parameters
        self.block = block
        self.state: list[int] | None = None     # results that are computed together

    def number(self, parameter: str) -> int:
        """A parameter as a number; 0 if the cell does not have it."""
        return int(self.parameters.get(parameter, "0"), 2)

    @property
    def signed(self) -> bool:
        """Whether the operands are extended by their sign: Yosys does it if both are signed."""
        return all(self.number(f"{port}_SIGNED") for port in "AB" if port in self.nets)


class Flat:
    """A design without hierarchy.

    Parameters
    ----------
    modules : mapping
        The design, as :func:`hdl.netlist.read_netlist` reads it.
    top : str
        Name of its top-level module.

    Attributes
    ----------
    drivers : list
        What drives each net: a cell and the bit of its output, the number of another net, or ``None`` of an input or a black box.
    outputs : list of int
        Nets that leave the design, by its ports or into black boxes.
    paths : list of str
        Path of each block, as :attr:`hdl.resources.count.Count.blocks` has it.
    """
    def __init__(self, modules: Mapping[str, Netlist], top: str):
        self.drivers: list[tuple[FlatCell, int] | int | None] = [None]
        self.outputs: list[int] = []
        self.paths: list[str] = []
        self._modules = modules
        self._sizes = {name: _highest(module) + 1 for name, module in modules.items()}
        nets = self._new_nets(top)
        self._expand(modules[top], nets, top)
        self.outputs += [nets[bit] for port in modules[top].ports.values() if port.direction != "input"
                         for bit in port.bits if isinstance(bit, int)]

    def _new_nets(self, module: str) -> list[int]:
        """Numbers for the nets of an instance, by their numbers within the module."""
        first, size = len(self.drivers), self._sizes[module]
        self.drivers.extend([None] * size)
        return list(range(first, first + size))

    def _drive(self, net: int, source: int) -> None:
        if net > 0 and net != source:
            self.drivers[net] = source

    def _expand(self, module: Netlist, nets: list[int], path: str) -> None:
        """Add the cells of an instance whose nets have these numbers."""
        block = len(self.paths)
        self.paths.append(path)
        for name, cell in module.cells.items():
            connections = {port: [nets[bit] if isinstance(bit, int) else _CONSTANTS[bit] for bit in bits]
                           for port, bits in cell.connections.items()}
            if cell.kind in self._modules:
                self._expand(self._modules[cell.kind], self._inside(cell.kind, connections), f"{path}.{name}")
            elif not cell.kind.startswith("$"):
                self.outputs += [net for bits in connections.values() for net in bits if net > 0]
            elif cell.kind != "$scopeinfo":
                flat = FlatCell(cell.kind, connections, cell.parameters, block)
                for port, direction in cell.directions.items():
                    if direction == "output":
                        for place, net in enumerate(connections[port]):
                            self.drivers[net] = flat, place

    def _inside(self, module: str, connections: Mapping[str, list[int]]) -> list[int]:
        """Nets of an instance: those at its ports have the numbers that they have outside."""
        nets = self._new_nets(module)
        named: set[Bit] = set()
        # Inputs first: an output may repeat one.
        ports = sorted(self._modules[module].ports.items(), key=lambda item: item[1].direction != "input")
        for name, port in ports:
            for bit, outside in zip(port.bits, connections.get(name, ())):
                if not isinstance(bit, int):
                    self._drive(outside, _CONSTANTS[bit])
                elif bit in named:
                    self._drive(outside, nets[bit])
                else:
                    named.add(bit)
                    nets[bit] = outside
        return nets


def _highest(module: Netlist) -> int:
    """The highest number of a net."""
    return max((bit for bits in module.nets.values() for bit in bits if isinstance(bit, int)), default=0)
