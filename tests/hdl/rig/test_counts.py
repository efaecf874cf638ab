"""Counts of the stages of two cameras, exact and per block: better or worse, a change is written down.

``python -m tests.hdl.rig.test_counts`` prints what to put here.
"""

import pytest

from hdl.resources.count import Resources, count
from hdl.resources.mapping import map_cyclone3
from hdl.rig.balance import Balance
from hdl.rig.rectifier import Rectifier


SMALL = {"rectifier": lambda: Rectifier(40, 32, 22), "balance": lambda: Balance(40, 32, 8)}

# Logic elements, memory bits, M9K blocks, 9x9 multipliers, without those of the blocks inside.
COUNTS: dict[str, dict[str, tuple[int, int, int, int]]] = {
    "rectifier": {
        "rectifier": (407, 0, 0, 0),
        "rectifier.flag_delay": (6, 0, 0, 0),
        "rectifier.gain_delay": (33, 322, 1, 0),
        "rectifier.left_map": (307, 576, 1, 0),
        "rectifier.left_ring": (402, 0, 0, 4),
        "rectifier.left_ring.bank_00": (8, 1760, 1, 0),
        "rectifier.left_ring.bank_01": (8, 1760, 1, 0),
        "rectifier.left_ring.bank_10": (8, 1760, 1, 0),
        "rectifier.left_ring.bank_11": (8, 1760, 1, 0),
        "rectifier.queue.fifo": (66, 589, 1, 0),
        "rectifier.reader": (237, 0, 0, 0),
        "rectifier.right_map": (307, 576, 1, 0),
        "rectifier.right_ring": (402, 0, 0, 4),
        "rectifier.right_ring.bank_00": (8, 1760, 1, 0),
        "rectifier.right_ring.bank_01": (8, 1760, 1, 0),
        "rectifier.right_ring.bank_10": (8, 1760, 1, 0),
        "rectifier.right_ring.bank_11": (8, 1760, 1, 0),
        "rectifier.weight_delay": (21, 182, 1, 0),
        "rectifier.writer": (152, 0, 0, 0),
    },
    "balance": {
        "balance": (509, 2048, 1, 0),
        "balance.contrast": (471, 0, 0, 0),
    },
}


def blocks_of(name):
    return count(map_cyclone3(SMALL[name](), name)).blocks


@pytest.mark.parametrize("name", SMALL)
def test_counts(name):
    assert blocks_of(name) == {block: Resources(*figures) for block, figures in COUNTS[name].items()}


@pytest.mark.slow  # the size of a camera takes ten seconds; the blocks are those above
def test_limits():
    """Both rectifiers with 34 lines, and the balance, for pictures of 720x576."""
    totals = [count(map_cyclone3(stage, "stage")).total for stage in (Rectifier(720, 576, 34), Balance(720, 576, 80))]
    total = Resources(*map(sum, zip(*totals)))
    assert total.logic_elements <= 4000 and total.m9k <= 60 and total.multipliers_9x9 <= 8


if __name__ == "__main__":
    for name in SMALL:
        print(f'    "{name}": {{')
        for block, figures in blocks_of(name).items():
            print(f'        "{block}": {tuple(figures)},')
        print("    },")
