"""A floor plan for the stand-in, an ECP5-85F: memory blocks in the order of the labels, along the device's rows; the selection in one area.

The arrays are chains of labels, each label with its memories. Without a plan the placer scatters such a chain: with 80 labels, wires were
half as long again as with the blocks in order, and the router barely converged.
"""

import re
from collections.abc import Iterable, Iterator, Mapping
from pathlib import Path

from ..netlist import Netlist, read_netlist, set_attribute


__all__ = ["SITES", "floor_plan", "is_filled", "label_of", "place_labels", "selection_plan"]


# Rows of blocks, and the number of rows of logic around each.
_ROWS = {22: 34, 46: 24, 70: 18, 82: 19}
# Four blocks every nine columns; the clock's spine is in the middle.
_FIRST, _PERIOD, _SPINE, _WIDTH = 4, 9, 67, 2


def _columns() -> Iterator[tuple[int, int]]:
    """Column of each block of a row, from left to right, and its number within its group of four."""
    for quad in range(13):
        for number in range(4):
            column = _FIRST + _PERIOD * quad + 2 * number
            yield (column if column < _SPINE else column + _WIDTH), number


#: Sites of memory blocks: row to names from left to right.
SITES = {row: [f"X{column}/Y{row}/EBR{number}" for column, number in _columns()] for row in _ROWS}


def label_of(name: str) -> float | None:
    """Position of a memory in the chain of labels, by its name in the hierarchy: the number after ``_`` is the first of its labels.

    Examples
    --------
    >>> [label_of(f"engine.{name}") for name in ("array.wait_7.memory.0.0", "costs.group_8.low.0.1", "costs.edata.memory_3.0.0", "queue.0")]
    [7.0, 9.5, 3.5, None]
    """
    found = re.search(r"_(\d+)\.", name)
    if found is None:
        return None
    shared = 0.0 if re.search(r"\bwait_", name) else 0.5 if re.search(r"\bmemory_", name) else 1.5  # of several labels: the middle one
    return int(found[1]) + shared


# The selection is the one loop that cannot be pipelined: `f = T[f]`. The answers arrive from the whole device; the places of the registers
# directly in front of the multiplexer decide how long the loop's wires are. They are in the middle, between two rows of blocks: columns,
# first row of logic, and rows without logic.
_SELECTION_COLUMNS = range(50, 62)
_SELECTION_ROW = 52
_NO_LOGIC = range(10, 94, 12)
_TILE = 8  # registers


def selection_plan(registers: Mapping[str, tuple[int, int]]) -> dict[str, str]:
    """Sites of the registers in front of the selection: those of a bit are adjacent, in the order of the labels.

    Parameters
    ----------
    registers : mapping
        Name to the label and the bit of the answer that the register holds.

    Returns
    -------
    dict of str to str
        Name to site.

    Examples
    --------
    >>> selection_plan({"a": (0, 0), "b": (9, 0)})
    {'a': 'X50/Y52/SLICEA.FF0', 'b': 'X51/Y52/SLICEA.FF1'}
    """
    rows = [row for row in range(_SELECTION_ROW, 94) if row not in _NO_LOGIC]
    tiles = max((label // _TILE + 1 for label, _ in registers.values()), default=0)
    width = 4  # adjacent tiles of a bit
    height = -(-tiles // width)
    across = len(_SELECTION_COLUMNS) // width  # bits
    plan = {}
    for name, (label, bit) in registers.items():
        tile, place = divmod(label, _TILE)
        column = _SELECTION_COLUMNS[bit % across * width + tile % width]
        row = rows[bit // across * height + tile // width]
        plan[name] = f"X{column}/Y{row}/SLICE{'ABCD'[place // 2]}.FF{place % 2}"
    return plan


# Shares of used sites above which all blocks are planned, and those of the line store.
_CROWDED, _FILLED = 0.9, 0.8
# The lines in front of the arrays, whose pixels enter at label 0.
_FRONT = r"(line_store|shift)\."


def is_filled(blocks: int) -> bool:
    """Whether so many memory blocks leave the placer alone too few sites to choose from.

    Examples
    --------
    >>> is_filled(166), is_filled(167)
    (False, True)
    """
    return blocks > _FILLED * sum(map(len, SITES.values()))


def floor_plan(names: Iterable[str], matcher: str = "") -> dict[str, str]:
    """Sites of the memory blocks of labels: along the rows in alternating direction, more where there is more logic around a row.

    The placer finds sites for the others, unless few are left, which would be far apart: then the others are placed first, adjacent in the
    two rows with the least logic around them, and the labels follow from there. From a lower share on the line store's blocks
    are planned in front of the labels.

    Parameters
    ----------
    names : iterable of str
        All memory blocks.
    matcher : str
        What names in the matcher begin with, if it is part of a system.

    Returns
    -------
    dict of str to str
        Name to site; empty if there are more blocks than sites.
    """
    places = {row: list(sites) for row, sites in SITES.items()}
    total = sum(map(len, places.values()))
    labels = {name: label_of(name) if name.startswith(matcher) else None for name in names}
    crowded = _CROWDED * total < len(labels) <= total
    if is_filled(len(labels)):
        front = re.compile(re.escape(matcher) + _FRONT)
        labels |= {name: -1.0 for name in labels if front.match(name)}
    chain = sorted((label, name) for name, label in labels.items() if label is not None)
    if not chain or len(chain) > total:
        return {}
    plan = {}
    if crowded:
        places = dict(reversed(places.items()))
        first = list(places)[:2]
        for number, name in enumerate(sorted(name for name, label in labels.items() if label is None)):
            plan[name] = places[first[number % 2]].pop(0)
    share = dict.fromkeys(places, 0)
    for _ in chain:
        row = min((row for row in places if share[row] < len(places[row])), key=lambda row: (share[row] + 1) / _ROWS[row])
        share[row] += 1
    order = iter(chain)
    for turn, (row, count) in enumerate(share.items()):
        # Spread over the row.
        sites = [places[row][(2 * n + 1) * len(places[row]) // (2 * count)] for n in range(count)]
        for site in reversed(sites) if turn % 2 else sites:
            plan[next(order)[1]] = site
    return plan


# Registers in front of the selection, with the answers of all labels: their number along the pipeline; the output has the last ones.
_ANSWERS = re.compile(r"\btransition_(\d*)$")


def _answer_bits(width: int) -> int:
    """Bits of an answer, a label, if those of all labels have ``width`` bits; 0 if none have.

    Examples
    --------
    >>> _answer_bits(80 * 7), _answer_bits(2), _answer_bits(3)
    (7, 1, 0)
    """
    return next((bits for bits in range(1, width + 1) if width % bits == 0 and (width // bits - 1).bit_length() == bits), 0)


def _selection(module: Netlist) -> dict[str, tuple[int, int]]:
    """The last registers in front of the selection: name to label and bit of the answer; of several that are merged, the last label."""
    found: dict[float, dict[str, tuple[int, int]]] = {}  # by number along the pipeline
    for name, nets in module.nets.items():
        if (match := _ANSWERS.search(name)) and (bits := _answer_bits(len(nets))):
            drivers = {at: module.drivers[net].cell for at, net in enumerate(nets) if net in module.drivers}
            found[float(match[1] or "inf")] = {driver: divmod(at, bits) for at, driver in drivers.items()
                                               if module.cells[driver].kind == "TRELLIS_FF"}
    return found[max(found)] if found else {}


def place_labels(design: Path, top: str, matcher: str = "") -> None:
    """Place the memory blocks of labels and the registers of the selection where the plans say.

    Parameters
    ----------
    design : Path
        The netlist, which is changed.
    top : str
        Its top module.
    matcher : str
        As of :func:`floor_plan`.
    """
    module = read_netlist(design)[top]
    blocks = floor_plan((name for name, cell in module.cells.items() if cell.kind == "DP16KD"), matcher)
    set_attribute(design, top, "BEL", blocks | selection_plan(_selection(module)))
