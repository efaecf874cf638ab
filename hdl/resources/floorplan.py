"""A floor plan for the stand-in, an ECP5-85F: memory blocks in the order of the labels, along the device's rows; the selection in one spot.

The arrays are chains, label after label, each with memories of its own. A placer that starts from nothing folds such a chain into a knot:
at 80 labels the wires came out half as long again as with the blocks in order, and the router hardly got through.
"""

import re
from collections.abc import Iterable, Iterator, Mapping


__all__ = ["SITES", "floor_plan", "label_of", "selection_plan"]


# Rows of blocks, and how many rows of logic lie around each.
_ROWS = {22: 34, 46: 24, 70: 18, 82: 19}
# Four blocks every nine columns; the clock's spine is in the middle.
_FIRST, _PERIOD, _SPINE, _WIDTH = 4, 9, 67, 2


def _columns() -> Iterator[tuple[int, int]]:
    """Column of each block of a row, from left to right, and its number among its neighbours."""
    for quad in range(13):
        for number in range(4):
            column = _FIRST + _PERIOD * quad + 2 * number
            yield (column if column < _SPINE else column + _WIDTH), number


#: Names of the places of memory blocks: row to places from left to right.
SITES = {row: [f"X{column}/Y{row}/EBR{number}" for column, number in _columns()] for row in _ROWS}


def label_of(name: str) -> float | None:
    """Where in the chain of labels a memory belongs, by its name in the hierarchy: a number behind ``_``, the first of its labels.

    Examples
    --------
    >>> [label_of(name) for name in ("engine.array.wait_7.memory.0.0", "engine.costs.group_8.low.0.1", "engine.queue.storage.0.0")]
    [7.0, 9.5, None]
    """
    found = re.search(r"_(\d+)\.", name)
    if found is None:
        return None
    shared = 0.0 if re.search(r"\bwait_", name) else 1.5  # a memory of several labels: its middle one
    return int(found[1]) + shared


# The selection is the one loop that no register can cut: `f = T[f]`. The answers come from all over the device; where the registers right
# in front of the multiplexer stand decides how far the loop reaches. In the middle, between two rows of blocks: columns, first row of
# logic, and rows that hold none.
_SELECTION_COLUMNS = range(50, 62)
_SELECTION_ROW = 52
_NO_LOGIC = range(10, 94, 12)
_TILE = 8  # registers


def selection_plan(registers: Mapping[str, tuple[int, int]]) -> dict[str, str]:
    """Places of the registers in front of the selection: those of a bit beside each other, label by label.

    Parameters
    ----------
    registers : mapping
        Name to label and bit of the answer that the register holds.

    Returns
    -------
    dict of str to str
        Name to place.

    Examples
    --------
    >>> selection_plan({"a": (0, 0), "b": (9, 0)})
    {'a': 'X50/Y52/SLICEA.FF0', 'b': 'X51/Y52/SLICEA.FF1'}
    """
    rows = [row for row in range(_SELECTION_ROW, 94) if row not in _NO_LOGIC]
    tiles = max((label // _TILE + 1 for label, _ in registers.values()), default=0)
    width = 4  # tiles of a bit beside each other
    height = -(-tiles // width)
    beside = len(_SELECTION_COLUMNS) // width
    plan = {}
    for name, (label, bit) in registers.items():
        tile, place = divmod(label, _TILE)
        column = _SELECTION_COLUMNS[bit % beside * width + tile % width]
        row = rows[bit // beside * height + tile // width]
        plan[name] = f"X{column}/Y{row}/SLICE{'ABCD'[place // 2]}.FF{place % 2}"
    return plan


#: Share of the places that are taken from which on all blocks are planned.
_CROWDED = 0.9


def floor_plan(names: Iterable[str]) -> dict[str, str]:
    """Places of memory blocks that belong to labels: along the rows, to and fro; more where there is more logic around a row.

    The others find places between them, unless few are left, which would be far apart: then they come first, side by side in the two rows
    with the least logic around them, and the labels follow from there.

    Parameters
    ----------
    names : iterable of str
        Of all memory blocks.

    Returns
    -------
    dict of str to str
        Name to place; empty if there are more blocks than places.
    """
    places = {row: list(sites) for row, sites in SITES.items()}
    total = sum(map(len, places.values()))
    labels = {name: label_of(name) for name in names}
    chain = sorted((label, name) for name, label in labels.items() if label is not None)
    if not chain or len(chain) > total:
        return {}
    plan = {}
    if _CROWDED * total < len(labels) <= total:
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
