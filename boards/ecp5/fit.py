"""What a project takes of an ECP5-85F, estimated from its netlist in seconds."""

from hdl.fit import Figure, Fit
from hdl.memory_blocks import MemoryShape, logic_elements
from hdl.resources.ecp5 import MEMORIES, MULTIPLIERS, TABLES
from hdl.resources.estimate import SOFT_PRODUCT, Elements, elements

from ..registry import Project


__all__ = ["LOGIC_ERROR", "blocks", "ecp5_fit"]


#: By how much, in percent, tables and registers differ at most from nextpnr's count of designs of 16 disparities or more; docs/fit.md has
#: the comparison.
LOGIC_ERROR = 10

# Tables for a bit of a carry chain: the first and the last of a chain do nothing else, and the bits of short ones are tables.
_CARRY = 1.75

#: Words of a block of one bit, as a power of two, and the widths of its words, each with as many words fewer. Memories of fewer bits than
#: this are registers, those that are never written tables.
_ADDRESS_BITS, _WIDTHS = 14, (1, 2, 4, 9, 18, 36)
_LEAST_BITS, _LEAST_TABLE_BITS = 129, 2048


def blocks(shape: MemoryShape) -> int:
    """Memory blocks of 18 kbit; 0 if the memory is registers or tables instead.

    Examples
    --------
    >>> blocks(MemoryShape(76_800, 8, 1)), blocks(MemoryShape(512, 36, 1)), blocks(MemoryShape(8, 9, 1))
    (38, 1, 0)
    >>> blocks(MemoryShape(7, 19, 1)), blocks(MemoryShape(16, 8, 1))  # 133 and 128 bits
    (1, 0)
    """
    words, width, written, read_ports, _ = shape
    if words * width < (_LEAST_BITS if written else _LEAST_TABLE_BITS):
        return 0
    number = min(-(-words // (1 << _ADDRESS_BITS - place)) * -(-width // unit) for place, unit in enumerate(_WIDTHS))
    return number * read_ports


def _figures(found: Elements) -> tuple[int, int, int, int]:
    """Tables, registers, memory blocks, multipliers."""
    tables, registers, memories = found.tables + round(_CARRY * found.carries), found.registers, 0
    for shape in found.memories:
        if number := blocks(shape):
            memories += number
        else:
            tables += logic_elements(shape)
            registers += shape.words * shape.width if shape.written else 0
    # Products that no multiplier is left for are tables: the narrow ones first, then all.
    products = found.products
    soft = [] if len(products) <= MULTIPLIERS else [widths for widths in products if min(widths) < 9]
    if len(products) - len(soft) > MULTIPLIERS:
        soft = list(products)
    tables += sum(round(SOFT_PRODUCT * wide * narrow) for wide, narrow in soft)
    return tables, registers, memories, len(products) - len(soft)


def ecp5_fit(device: str, project: Project) -> Fit:
    """A project beside an ECP5-85F; ``device`` is its ordering code."""
    names = "tables", "registers", "memory_blocks", "multipliers"
    estimated = _figures(elements(project.netlist, project.name))
    capacity = TABLES, TABLES, MEMORIES, MULTIPLIERS
    titles = "tables of 4 inputs", "registers", "memory blocks of 18 kbit", "18x18 multipliers"
    kinds = "logic", "logic", "memory", "multipliers"
    figures = [Figure(kind, title, number, 0, limit, LOGIC_ERROR if kind == "logic" else 0)
               for kind, title, number, limit in zip(kinds, titles, estimated, capacity)]
    about = (f"Estimate: tables and registers within {LOGIC_ERROR} % of what nextpnr counts, with 16 disparities or more.",)
    return Fit(device, figures, "", about, {"estimated": dict(zip(names, estimated)), "device": dict(zip(names, capacity))})
