"""A floor plan for the stand-in: memory blocks in the order of the labels, along the rows of blocks of an ECP5-85F.

The arrays are chains, label after label, each with memories of its own. A placer that starts from nothing folds such a chain into a knot:
at 80 labels the wires came out half as long again as with the blocks in order, and the router hardly got through.
"""

import re
from collections.abc import Iterable, Iterator


__all__ = ["SITES", "floor_plan", "label_of"]


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


def floor_plan(names: Iterable[str]) -> dict[str, str]:
    """Places of those memory blocks that belong to labels: along the rows, to and fro; more where there is more logic around a row.

    Parameters
    ----------
    names : iterable of str
        Of the memory blocks.

    Returns
    -------
    dict of str to str
        Name to place; empty if there are more blocks than places.
    """
    chain = sorted((label, name) for name in names if (label := label_of(name)) is not None)
    places = {row: len(sites) for row, sites in SITES.items()}
    if not chain or len(chain) > sum(places.values()):
        return {}
    share = dict.fromkeys(_ROWS, 0)
    for _ in chain:
        row = min((row for row in _ROWS if share[row] < places[row]), key=lambda row: (share[row] + 1) / _ROWS[row])
        share[row] += 1
    order = iter(chain)
    plan = {}
    for turn, (row, count) in enumerate(share.items()):
        # Spread over the row.
        sites = [SITES[row][(2 * n + 1) * places[row] // (2 * count)] for n in range(count)]
        for site in reversed(sites) if turn % 2 else sites:
            plan[next(order)[1]] = site
    return plan
