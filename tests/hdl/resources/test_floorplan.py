import itertools
import re

import pytest

from hdl.resources.floorplan import SITES, floor_plan, label_of, selection_plan


def names(labels):
    """Memory blocks like those of the streaming engine, and some that belong to no label."""
    yield from (f"engine.array.wait_{label}.memory.0.0" for label in range(labels))
    yield from (f"engine.costs.edata.memory_{label}.{n}.0" for label in range(0, labels, 4) for n in range(3))
    yield from ("engine.queue.storage.0.0", "line_store.line_memory.0.0")


def test_sites():
    every = [site for row in SITES.values() for site in row]
    assert len(every) == len(set(every)) == 208
    columns = [int(re.match(r"X(\d+)", site)[1]) for site in SITES[22]]
    assert columns == sorted(columns) and (columns[0], columns[-1]) == (4, 120)
    assert SITES[70][24:29] == ["X58/Y70/EBR0", "X60/Y70/EBR1", "X62/Y70/EBR2", "X64/Y70/EBR3", "X69/Y70/EBR0"]


def test_plan():
    plan = floor_plan(names(80))
    assert len(plan) == len(set(plan.values())) == 140
    assert set(plan) == {name for name in names(80) if label_of(name) is not None}
    assert set(plan.values()) <= {site for row in SITES.values() for site in row}
    # Neighbours in the chain are neighbours on the device: in the same row, or one below the other at its end.
    chain = sorted(plan, key=lambda name: (label_of(name), name))
    at = [tuple(map(int, re.match(r"X(\d+)/Y(\d+)", plan[name]).groups())) for name in chain]
    rows = [row for row, _ in itertools.groupby(at, key=lambda place: place[1])]
    assert rows == list(SITES)
    assert max(abs(a[0] - b[0]) for a, b in itertools.pairwise(at)) <= 8
    share = {row: sum(1 for _, y in at if y == row) for row in SITES}
    assert share[22] > share[46] > share[70] >= 20


def test_crowded():
    """Few sites left: all blocks are planned, those without a label first and adjacent, in the rows where the chain begins, with what is in
    front of label 0."""
    others = [f"block_of_none.x{n}" for n in range(24)]
    chain = ["line_store.line_memory.0.0", "shift.ring.0.0", *(f"array.wait_{n}.memory" for n in range(182))]
    plan = floor_plan([*chain, *others])
    assert len(plan) == len(set(plan.values())) == 208
    at = {name: tuple(map(int, re.match(r"X(\d+)/Y(\d+)", place).groups())) for name, place in plan.items()}
    begin = list(SITES)[:1:-1]
    assert begin == [82, 70]
    assert {at[name][1] for name in others} == set(begin) and max(at[name][0] for name in others) <= 28
    rows = [row for row, _ in itertools.groupby(at[name][1] for name in chain)]
    assert rows == [82, 70, 46, 22]
    steps = [abs(at[a][0] - at[b][0]) for a, b in itertools.pairwise(chain)]
    assert max(steps) <= 28 and sum(step > 8 for step in steps) <= 1  # once, past the others
    # With enough sites, the placer finds those of the others, and with more those of what is in front.
    assert set(floor_plan([*chain[:150], *others])) == set(chain[:150])
    assert set(floor_plan([*chain[:100], *others])) == set(chain[2:100])


def test_matcher_in_a_system():
    """The plan is that of the matcher alone; what is around it has no label, whatever its name."""
    chain = ["line_store.line_memory.0.0", "shift.ring.0.0", *(f"array.wait_{n}.memory" for n in range(182))]
    others = [f"core.queue_{n}.memory" for n in range(14)] + ["core.line_store.memory"]
    plan = floor_plan([*(f"core.matcher.{name}" for name in chain), *others], "core.matcher.")
    alone = floor_plan([*chain, *(f"x{n}" for n in range(len(others)))])
    assert len(plan) == 199
    assert {name: plan[f"core.matcher.{name}"] for name in chain} == {name: alone[name] for name in chain}
    assert floor_plan(others, "core.matcher.") == {}


def test_no_plan():
    assert floor_plan([]) == floor_plan(["engine.queue.storage.0.0"]) == {}
    assert floor_plan(names(120)) == {}  # more blocks than sites
    assert len(floor_plan(["a.wait_3.memory"])) == 1


@pytest.mark.parametrize("labels", [2, 64, 80, 256])
def test_selection(labels):
    """Every register has a site without another, in a row of logic, and those of a bit are close together."""
    bits = (labels - 1).bit_length()
    plan = selection_plan({f"{label}.{bit}": (label, bit) for label in range(labels) for bit in range(bits)})
    assert len(plan) == len(set(plan.values())) == labels * bits
    at = {name: tuple(map(int, re.match(r"X(\d+)/Y(\d+)/SLICE[A-D].FF[01]$", place).groups())) for name, place in plan.items()}
    assert not {y for _, y in at.values()} & {10, 22, 34, 46, 58, 70, 82}
    for bit in range(bits):
        xs, ys = zip(*(at[f"{label}.{bit}"] for label in range(labels)))
        assert max(xs) - min(xs) < 4 and max(ys) - min(ys) <= labels // 32 + 1


def test_no_selection():
    assert selection_plan({}) == {}
