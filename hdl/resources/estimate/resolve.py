"""A flat design entered into a graph, from its outputs back: what leads to none of them is left out."""

from .cells import REGISTER_CONTROLS, combinational, operands, register_inputs
from .flat import ONE, UNDEFINED, Flat, FlatCell
from .graph import ANY, FALSE, OTHER, RAM, READ, REGISTER, TRUE, Graph


__all__ = ["Resolved", "memory_inputs"]


def memory_inputs(cell: FlatCell) -> list[int]:
    """Nets that a memory takes, without clocks."""
    return [net for port, nets in cell.nets.items() if port != "RD_DATA" and not port.endswith("_CLK") for net in nets]


def _is_register(driver: tuple[FlatCell, int] | int | None) -> bool:
    return isinstance(driver, tuple) and "dff" in driver[0].kind


class Resolved:
    """The graph of a design.

    Registers that take the same are one, those that take a constant are none. A register is ``(REGISTER, cell, place)``, a memory
    ``(RAM, cell)``, a bit that is read from it ``(READ, literal of the memory)``.

    Parameters
    ----------
    flat : Flat

    Attributes
    ----------
    graph : Graph
    """
    def __init__(self, flat: Flat):
        self.flat = flat
        self.graph = Graph()
        self._literals: list[int | None] = [None] * len(flat.drivers)
        self._waiting: set[int] = set()     # nets whose operands are being resolved
        self._memories: dict[int, int] = {}
        self._left = list(flat.outputs)     # nets to be resolved
        while self._left:
            nets, self._left = self._left, []
            self._resolve([net for net in nets if net > 0 and self._literals[net] is None])

    def value(self, net: int) -> int:
        """Literal of a net, or :data:`ANY`."""
        if net <= 0:
            return TRUE if net == ONE else ANY if net == UNDEFINED else FALSE
        literal = self._literals[net]
        assert literal is not None
        return literal

    def literal(self, net: int) -> int:
        """Literal of a net: an undefined one is 0."""
        value = self.value(net)
        return FALSE if value == ANY else value

    def _resolve(self, stack: list[int]) -> None:
        """Depth first, without recursion: paths through a chip's pipelines are longer than Python's stack."""
        literals, waiting, drivers = self._literals, self._waiting, self.flat.drivers
        while stack:
            net = stack[-1]
            if literals[net] is not None:
                stack.pop()
                continue
            driver = drivers[net]
            if driver is None:
                literals[net] = self.graph.new(OTHER)
            elif net in waiting:
                literals[net] = self.value(driver) if isinstance(driver, int) else self._output(*driver)
            else:
                waiting.add(net)
                for needed in self._needed(driver):
                    if needed <= 0 or literals[needed] is not None:
                        continue
                    if needed not in waiting:
                        stack.append(needed)
                    elif _is_register(drivers[needed]):
                        self._cut(needed)
                    else:
                        self._back_to_register(stack)
                        break

    def _needed(self, driver: tuple[FlatCell, int] | int) -> list[int]:
        if isinstance(driver, int):
            return [driver]
        cell, place = driver
        if cell.kind == "$mem_v2":
            return []
        return register_inputs(cell, place) if _is_register(driver) else operands(cell, place)

    def _back_to_register(self, stack: list[int]) -> None:
        """A net waits for itself: leave the way to it down to the last register, where the loop is cut."""
        while True:
            net = stack.pop()
            if _is_register(self.flat.drivers[net]) and net in self._waiting:
                self._cut(net)
                return
            if self._literals[net] is None:
                self._waiting.discard(net)

    def _cut(self, net: int) -> None:
        """Enter a register whose inputs are resolved later."""
        driver = self.flat.drivers[net]
        if self._literals[net] is None and isinstance(driver, tuple):
            self._left += register_inputs(*driver)
            self._literals[net] = self._new(driver[0], REGISTER, *driver)

    def _new(self, cell: FlatCell, *node: object) -> int:
        self.graph.block = cell.block
        return self.graph.new(*node)

    def _output(self, cell: FlatCell, place: int) -> int:
        """Literal of a bit of the output of a cell."""
        self.graph.block = cell.block
        if cell.kind == "$mem_v2":
            if id(cell) not in self._memories:
                self._memories[id(cell)] = self.graph.new(RAM, cell)
                self._left += memory_inputs(cell)
            return self.graph.new(READ, self._memories[id(cell)])
        if "dff" in cell.kind:
            return self._register(cell, place)
        return combinational(self.graph, cell, place, self.literal, self.value)

    def _register(self, cell: FlatCell, place: int) -> int:
        inputs = register_inputs(cell, place)
        if any(net > 0 and self._literals[net] is None for net in inputs):
            self._left += inputs
            return self._new(cell, REGISTER, cell, place)
        values = [self.literal(net) for net in inputs]
        cleared = [cell.parameters[f"{port}_VALUE"][-1 - place] for port in REGISTER_CONTROLS if f"{port}_VALUE" in cell.parameters]
        if values[0] == FALSE and "1" not in cleared:
            return FALSE
        key = REGISTER, cell.kind, cell.nets["CLK"][0], *values, *cleared
        if key not in self.graph.known:
            self.graph.known[key] = self._new(cell, REGISTER, cell, place)
        return self.graph.known[key]
