"""Logic elements, memory and multipliers of a mapped netlist, per block of the hierarchy."""

from collections import Counter, defaultdict
from dataclasses import dataclass, field
from functools import cached_property
from typing import NamedTuple

from ..netlist import Bit, Pin
from .mapping import Mapped, block_of


__all__ = ["FIGURES", "Count", "Resources", "count"]


#: The figures of a count, as the JSON names them.
FIGURES = ("logic_elements", "memory_bits", "m9k", "multipliers_9x9")

_MULTIPLIERS_9X9 = {"C3_MULT9": 1, "C3_MULT18": 2}


class Resources(NamedTuple):
    """Figures of a block or of a whole design."""
    logic_elements: int = 0
    memory_bits: int = 0
    m9k: int = 0
    multipliers_9x9: int = 0


@dataclass(frozen=True)
class Count:
    """Figures of a design.

    ``blocks`` maps the path of each block to its figures without those of the blocks inside it, so that they add up to ``total``.
    ``kinds``: numbers of tables, carry elements and registers; a packed register shares the logic element of one of the other two.
    ``least`` and ``most`` are bounds of the packing: all registers that can be packed, or only those whose table feeds nothing else.
    """
    blocks: dict[str, Resources]
    kinds: dict[str, int] = field(default_factory=dict)
    least: int = 0
    most: int = 0

    @property
    def total(self) -> Resources:
        return Resources(*map(sum, zip(*self.blocks.values(), strict=True)))


def _common(blocks: set[str]) -> str:
    """The innermost block that holds all of ``blocks``."""
    common = []
    for names in zip(*(block.split(".") for block in blocks), strict=False):
        if len(set(names)) > 1:
            break
        common.append(names[0])
    return ".".join(common)


class _Elements:
    """The netlist as logic elements: which cells need one, and which registers share one."""
    def __init__(self, mapped: Mapped):
        self.mapped = mapped
        self.cells = mapped.module.cells
        self.driver = mapped.module.drivers
        self.users = mapped.module.users
        self._blocks: dict[str, frozenset[str]] = {}

    def kind(self, name: str) -> str:
        return self.cells[name].kind if name else ""

    def bit(self, name: str, port: str) -> Bit:
        """The bit that is connected to a port of one bit."""
        return self.cells[name].connections.get(port, ["x"])[0]

    def of_kind(self, kind: str) -> list[str]:
        return [name for name, cell in self.cells.items() if cell.kind == kind]

    @cached_property
    def absorbed(self) -> set[str]:
        """Inverters that a carry element includes: before its operands, or after a sum that has no other use."""
        found = set()
        for name in self.of_kind("C3_LUT"):
            if int(self.cells[name].parameters["WIDTH"], 2) != 1:
                continue
            users = self.users.get(self.bit(name, "O"), [])
            before = all(self.kind(user.cell) == "C3_ADD" and user.port in "AB" for user in users)
            source = self.driver.get(self.bit(name, "A"))
            after = source is not None and self.kind(source.cell) == "C3_ADD" and source.port == "S" \
                and len(self.users.get(self.bit(name, "A"), [])) == 1
            if before or after:
                found.add(name)
        return found

    @cached_property
    def inside_blocks(self) -> set[str]:
        """Registers at the outputs of a multiplier or a memory block, which includes them.

        All outputs must lead to registers only, with one clock enable and no clear.
        """
        found: set[str] = set()
        for kind, port in (("C3_MULT18", "Y"), ("C3_MULT9", "Y"), ("C3_M9K", "Q")):
            for name in self.of_kind(kind):
                users = [self.users[bit] for bit in self.cells[name].connections[port] if self.users.get(bit)]
                alone = all(len(pins) == 1 and self.kind(pins[0].cell) == "C3_FF" and pins[0].port == "D" for pins in users)
                registers = {pins[0].cell for pins in users}
                if alone and {self.bit(register, "CLR") for register in registers} == {"0"} \
                        and len({self.bit(register, "EN") for register in registers}) == 1:
                    found |= registers
        return found

    @cached_property
    def carries_out(self) -> set[Bit]:
        """Carries that need a further element as output.

        The carry output of an element reaches only the next one, in arithmetic mode or as a table with the carry as one of its inputs.
        """
        found, taken = set(), set()
        for name in self.of_kind("C3_ADD"):
            bit = self.bit(name, "CO")
            users = self.users.get(bit, [])
            if not users:
                continue
            chained = len(users) == 1 and (self.kind(users[0].cell) == "C3_LUT" or users[0].port == "CI") and users[0].cell not in taken
            if chained:
                taken.add(users[0].cell)
            else:
                found.add(bit)
        return found

    def element(self, bit: Bit) -> Pin | None:
        """The element that computes ``bit``; none if it is not the output of an element."""
        pin = self.driver.get(bit)
        if pin is None or self.kind(pin.cell) not in ("C3_LUT", "C3_ADD"):
            return None
        if pin.cell in self.absorbed:
            return self.driver.get(self.bit(pin.cell, "A"))
        return None if pin.port == "CO" and bit not in self.carries_out else pin

    def packed(self, alone: bool) -> dict[str, Pin]:
        """Registers that share the element that feeds them, one each; with ``alone`` only if it feeds nothing else."""
        found, taken = {}, set()
        for name in self.of_kind("C3_FF"):
            bit = self.bit(name, "D")
            pin = self.element(bit)
            if pin is not None and pin not in taken and not (alone and len(self.users[bit]) > 1):
                taken.add(pin)
                found[name] = pin
        return found

    def blocks(self, name: str) -> frozenset[str]:
        """The block of a cell; of a table the blocks that it leads to."""
        if name not in self._blocks:
            cell = self.cells[name]
            marked = block_of(cell.attributes)
            if cell.kind == "C3_M9K":  # named after the memory, with two numbers
                found = frozenset([".".join([self.mapped.top, *name.split(".")[:-3]])])
            elif marked:
                found = frozenset([marked])
            else:
                self._blocks[name] = frozenset()  # ends the recursion at a loop through an unmarked register
                bits = [bit for port, bits in cell.connections.items() if cell.directions[port] == "output" for bit in bits]
                found = frozenset().union(*(self.blocks(user.cell) for bit in bits for user in self.users.get(bit, []) if user.cell))
            self._blocks[name] = found
        return self._blocks[name]

    def block(self, name: str) -> str:
        """The block that a cell counts for: if a table leads to several, the innermost block around all of them."""
        return _common(set(self.blocks(name))) or self.mapped.top


def count(mapped: Mapped) -> Count:
    """Count the elements of a mapped design."""
    elements = _Elements(mapped)
    tables = [name for name in elements.of_kind("C3_LUT") if name not in elements.absorbed]
    carries = elements.of_kind("C3_ADD")
    registers = [name for name in elements.of_kind("C3_FF") if name not in elements.inside_blocks]
    packed = elements.packed(alone=False)
    logic = len(tables) + len(carries) + len(elements.carries_out)

    figures: dict[str, Counter[str]] = defaultdict(Counter)
    of_pair = {pin.cell: register for register, pin in packed.items() if elements.kind(pin.cell) == "C3_LUT"}
    for name in tables:
        figures[elements.block(of_pair.get(name, name))]["logic_elements"] += 1
    for name in carries:
        figures[elements.block(name)]["logic_elements"] += 1
    for bit in elements.carries_out:
        figures[elements.block(elements.driver[bit].cell)]["logic_elements"] += 1
    for name in registers:
        figures[elements.block(name)]["logic_elements"] += name not in packed
    for name in elements.of_kind("C3_M9K"):
        figures[elements.block(name)]["m9k"] += 1
    for kind, number in _MULTIPLIERS_9X9.items():
        for name in elements.of_kind(kind):
            figures[elements.block(name)]["multipliers_9x9"] += number
    for memory in mapped.memories:
        figures[".".join([mapped.top, *memory.name.split(".")[:-1]])]["memory_bits"] += memory.bits

    known = {"C3_LUT", "C3_ADD", "C3_FF", "C3_M9K", *_MULTIPLIERS_9X9}
    unknown = sorted({cell.kind for cell in elements.cells.values()} - known - {"$scopeinfo"})
    if unknown:
        raise RuntimeError(f"the mapping left {', '.join(unknown)}, which are not elements of a Cyclone III")
    return Count(
        blocks={block: Resources(**{figure: figures[block][figure] for figure in FIGURES}) for block in sorted(figures)},
        kinds={"tables": len(tables), "carry_elements": len(carries) + len(elements.carries_out), "registers": len(registers),
               "packed_registers": len(packed), "registers_in_blocks": len(elements.inside_blocks)},
        least=max(logic, len(registers)),
        most=logic + len(registers) - len(elements.packed(alone=True)),
    )
