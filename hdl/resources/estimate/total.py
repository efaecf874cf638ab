"""The figures of an estimate, in the blocks of the design, as :class:`hdl.resources.count.Count` has those of a count."""

import contextlib
import gc
from collections import Counter, defaultdict
from collections.abc import Callable, Iterator, Mapping
from typing import NamedTuple

from ...memory_blocks import MemoryShape, blocks, logic_elements
from ...netlist import Netlist
from ..count import FIGURES, Count, Resources
from .cells import register_inputs
from .cover import Cover
from .flat import Flat, FlatCell
from .graph import ADD, CARRY, LOGIC, MULTIPLIER, PRODUCT, RAM, READ, REGISTER
from .resolve import Resolved


__all__ = ["LOGIC_ERROR", "SOFT_PRODUCT", "Elements", "elements", "estimate"]


#: By how much, in percent, the logic elements of a chip or matcher of 64 disparities or more differ at most from the count; docs/fit.md has
#: the comparison. Memory blocks and multipliers are those of the count, but for a block where few labels leave some of its outputs unused.
LOGIC_ERROR = 5

#: Tables for each bit of a product of the widths of the operands of a multiplication that no multiplier does: partial products, and adders.
SOFT_PRODUCT = 1.5


def _shape(cell: FlatCell, literal: Callable[[int], int]) -> MemoryShape:
    """Shape of a memory: bits that are the same in all words take no place, and ports that read the same address are one."""
    nets, words, width = cell.nets, cell.number("SIZE"), cell.number("WIDTH")
    kept, written = list(range(width)), 0
    if cell.number("WR_PORTS"):
        kept = [place for place in kept if any(literal(net) for net in nets["WR_DATA"][place::width])]
        written = len({nets["WR_EN"][place] for place in kept})
    else:
        content = cell.parameters["INIT"][::-1]
        kept = [place for place in kept if len(set(content[place:words * width:width])) > 1]
    clocks = {net for side in ("RD", "WR") for net in nets.get(f"{side}_CLK", ()) if net > 0}
    bits = cell.number("ABITS")
    addresses = {tuple(map(literal, nets["RD_ADDR"][place:place + bits])) for place in range(0, len(nets["RD_ADDR"]), bits)}
    return MemoryShape(words, len(kept), written, len(addresses), len(clocks))


def _with_shared_ports(cell: FlatCell, literal: Callable[[int], int]) -> MemoryShape:
    """Shape of a memory whose blocks have two ports, each of which reads and writes: a read at the address of a write needs none."""
    shape, nets, bits = _shape(cell, literal), cell.nets, cell.number("ABITS")

    def addresses(port: str) -> set[tuple[int, ...]]:
        return {tuple(map(literal, nets[port][place:place + bits])) for place in range(0, len(nets.get(port, ())), bits)}
    return shape._replace(read_ports=max(1, len(addresses("RD_ADDR") - addresses("WR_ADDR"))))


class Elements(NamedTuple):
    """What any family's blocks are made of: tables of four inputs, bits of carry chains, registers; the widths of the operands of products,
    the greater one first; the shapes of memories, where a read at the address of a write needs no port.
    """
    tables: int
    carries: int
    registers: int
    products: list[tuple[int, int]]
    memories: list[MemoryShape]


class _Total:
    def __init__(self, flat: Flat, resolved: Resolved, cover: Cover):
        self.resolved = resolved
        self.cover = cover
        self.nodes = resolved.graph.nodes
        self.used = [node for node, uses in enumerate(cover.uses) if uses]
        self.figures: dict[str, Counter[str]] = defaultdict(Counter)
        self.flat = flat
        self.in_logic: set[int] = set()     # memories and multipliers that are none

    def add(self, node: int, figure: str, number: int) -> None:
        self.figures[self.flat.paths[self.resolved.graph.blocks[node]]][figure] += number

    def add_memories(self) -> None:
        for node in self.used:
            kind, *rest = self.nodes[node]
            if kind == RAM:
                shape = _shape(rest[0], self.resolved.literal)
                number = blocks(shape)
                if number:
                    self.add(node, "m9k", number)
                    self.add(node, "memory_bits", shape.words * shape.width)
                else:
                    self.in_logic.add(node)
                    self.add(node, "logic_elements", logic_elements(shape))
            elif kind == MULTIPLIER:
                multipliers, _, (wide, narrow) = rest
                self.add(node, "multipliers_9x9", multipliers)
                if not multipliers:
                    self.in_logic.add(node)
                    self.add(node, "logic_elements", round(SOFT_PRODUCT * wide * narrow))

    def add_logic(self) -> None:
        for node in self.cover.tables:
            self.add(node, "logic_elements", 1)
        elements = set()
        for node in self.used:
            kind, *rest = self.nodes[node]
            if kind in (ADD, CARRY) and tuple(rest) not in elements:
                elements.add(tuple(rest))
                self.add(node, "logic_elements", 1)

    def _registers_in_blocks(self, data: Mapping[int, int]) -> set[int]:
        """Registers that memory blocks and multipliers include: all bits are registered, with one clock enable and no clear."""
        outputs: dict[int, list[int]] = defaultdict(list)
        for node in self.used:
            if self.nodes[node][0] in (READ, PRODUCT):
                outputs[self.nodes[node][1] >> 1].append(node)
        registers: dict[int, list[int]] = defaultdict(list)
        for register, node in data.items():
            registers[node].append(register)
        found: set[int] = set()
        for source, bits in outputs.items():
            after = [register for bit in bits for register in registers[bit]]
            cells = [self.nodes[register][1] for register in after]
            alone = source not in self.in_logic and all(self.cover.uses[bit] == len(registers[bit]) == 1 for bit in bits)
            enables = {self.resolved.literal(cell.nets["EN"][0]) if "EN" in cell.nets else -1 for cell in cells}
            if alone and len(enables) == 1 and not any("RST" in port for cell in cells for port in cell.nets):
                found.update(after)
        return found

    def add_registers(self) -> None:
        """A register shares the element that feeds it, one each."""
        data = {node: self.resolved.literal(register_inputs(*self.nodes[node][1:])[0]) >> 1
                for node in self.used if self.nodes[node][0] == REGISTER}
        inside = self._registers_in_blocks(data)
        taken: set[int] = set()
        for register, node in data.items():
            if register in inside:
                continue
            kind = self.nodes[node][0]
            computed = kind <= LOGIC or kind == ADD or (kind == PRODUCT and self.nodes[node][1] >> 1 in self.in_logic)
            if node and computed and node not in taken:
                taken.add(node)
            else:
                self.add(register, "logic_elements", 1)


@contextlib.contextmanager
def _no_collection() -> Iterator[None]:
    """Millions of objects that live to the end: see `hdl.emit.rtlil_text`."""
    collects = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if collects:
            gc.enable()


def _covered(modules: Mapping[str, Netlist], top: str) -> tuple[Flat, Resolved, Cover]:
    flat = Flat(modules, top)
    resolved = Resolved(flat)
    return flat, resolved, Cover(resolved)


def elements(modules: Mapping[str, Netlist], top: str) -> Elements:
    """What a design is made of, whatever the family; parameters as of :func:`estimate`."""
    with _no_collection():
        _, resolved, cover = _covered(modules, top)
        nodes = [resolved.graph.nodes[node] for node, uses in enumerate(cover.uses) if uses]
        return Elements(
            len(cover.tables), len({tuple(rest) for kind, *rest in nodes if kind in (ADD, CARRY)}),
            sum(node[0] == REGISTER for node in nodes),
            [node[3] for node in nodes if node[0] == MULTIPLIER],
            [_with_shared_ports(node[1], resolved.literal) for node in nodes if node[0] == RAM])


def estimate(modules: Mapping[str, Netlist], top: str) -> Count:
    """Estimate logic elements, memory blocks and multipliers of a Cyclone III: seconds where a count takes minutes.

    Parameters
    ----------
    modules : mapping
        The design as :mod:`hdl.emit` emits it. What black boxes take is not included.
    top : str
        Name of its top-level module.

    Returns
    -------
    Count
        Without numbers of its elements, and without bounds; :data:`LOGIC_ERROR` is that of the total.
    """
    with _no_collection():
        total = _Total(*_covered(modules, top))
        total.add_memories()
        total.add_logic()
        total.add_registers()
    figures = total.figures or {top: Counter()}
    return Count({block: Resources(**{figure: figures[block][figure] for figure in FIGURES}) for block in sorted(figures)})
