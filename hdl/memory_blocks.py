"""Which memories are in M9K blocks, and in how many: the rule of Yosys's ``memory_libmap`` with ``resources/cyclone3/memories.txt``.

The estimate of resources follows it, and so do the marks in the Verilog, so that a vendor's synthesis does what is counted.
"""

from typing import NamedTuple


__all__ = ["MemoryShape", "blocks", "logic_elements"]


#: Words of one bit in a block, as a power of two, and widths of its words: each is as many words fewer.
_ADDRESS_BITS, _WIDTHS = 13, (1, 2, 4, 9, 18, 36)
#: Costs in the pass: of a block with one clock and with two, of a read port, of a bit of a multiplexer between blocks, and of a bit in
#: registers or, of a memory that is never written, in tables.
_BLOCK, _TWO_CLOCKS, _READ_PORT, _MULTIPLEXER, _REGISTER, _TABLE = 16, 17, 2, 0.5, 0.25, 1 / 16


class MemoryShape(NamedTuple):
    """Words, their bits, groups of bits that are written together, none of a memory that is never written, read ports, number of clocks."""
    words: int
    width: int
    written: int
    read_ports: int = 1
    clocks: int = 1


def blocks(shape: MemoryShape) -> int:
    """Memory blocks; 0 if the memory is registers or tables instead.

    Examples
    --------
    >>> blocks(MemoryShape(720, 8, 1)), blocks(MemoryShape(8, 9, 1)), blocks(MemoryShape(16, 8, 1))
    (1, 0, 1)
    """
    words, width, written, read_ports, clocks = shape
    best: tuple[float, int] | None = None
    for place, unit in enumerate(_WIDTHS):
        deep = (words - 1 >> _ADDRESS_BITS - place) + 1
        number = deep * -(-width // unit)
        cost: float = (_BLOCK if clocks == 1 else _TWO_CLOCKS) * number * max(1, read_ports) + _READ_PORT * read_ports
        if deep > 1:
            cost += _MULTIPLEXER * ((deep - 1) * width * read_ports + deep * written)
        if best is None or cost < best[0]:
            best = cost, number * max(1, read_ports)
    assert best is not None
    return best[1] if best[0] < int(words * width * (_REGISTER if written else _TABLE)) else 0


def logic_elements(shape: MemoryShape) -> int:
    """Logic elements of a memory that is not in blocks.

    A register a bit, a table a word to write it, and two tables for three multiplexers of a bit to read it,
    or of one that is never written a table for 16 bits.
    """
    words, width, written, read_ports, _ = shape
    if not written:
        return -(-words * width // 16)
    return words * (width + 1) + round(2 / 3 * width * (words - 1) * read_ports)
