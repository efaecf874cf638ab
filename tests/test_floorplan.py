import itertools
import re

from hdl.resources.floorplan import SITES, floor_plan, label_of


def names(labels):
    """Memory blocks as the streaming engine has them, and some of no label."""
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
    # Neighbours along the chain are neighbours on the device: in the same row, or one below the other at its end.
    chain = sorted(plan, key=lambda name: (label_of(name), name))
    at = [tuple(map(int, re.match(r"X(\d+)/Y(\d+)", plan[name]).groups())) for name in chain]
    rows = [row for row, _ in itertools.groupby(at, key=lambda place: place[1])]
    assert rows == list(SITES)
    assert max(abs(a[0] - b[0]) for a, b in itertools.pairwise(at)) <= 8
    share = {row: sum(1 for _, y in at if y == row) for row in SITES}
    assert share[22] > share[46] > share[70] >= 20


def test_no_plan():
    assert floor_plan([]) == floor_plan(["engine.queue.storage.0.0"]) == {}
    assert floor_plan(names(120)) == {}  # more than there are
    assert len(floor_plan(["a.wait_3.memory"])) == 1
