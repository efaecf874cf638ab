import itertools

import numpy as np
import pytest
from amaranth.sim import Simulator

from hdl.parts.sorting_network import Exchange, Selection, levels, merge, prune, select, sort

from .networks import run


def zeros_and_ones(*sizes):
    """All pairs of sorted lists of zeros and ones: a network that is right for them is right for all values."""
    ways = itertools.product(*(range(size + 1) for size in sizes))
    return np.array([[int(n >= size - ones) for ones, size in zip(way, sizes) for n in range(size)] for way in ways])


@pytest.mark.parametrize("a", range(12))
@pytest.mark.parametrize("b", range(12))
def test_merge(a, b):
    exchanges, order = merge(range(a), range(a, a + b))
    values = zeros_and_ones(a, b)
    assert sorted(order) == list(range(a + b))
    assert run(exchanges, values)[:, order].tolist() == np.sort(values).tolist()


@pytest.mark.parametrize("n", range(1, 10))
def test_sort(n):
    exchanges, order = sort(range(n))
    values = np.array(list(itertools.product(range(2), repeat=n)))
    assert run(exchanges, values)[:, order].tolist() == np.sort(values).tolist()


@pytest.mark.parametrize("a, b", [(1, 0), (0, 3), (1, 1), (6, 5), (4, 3), (2, 7)])
def test_select(a, b):
    values = zeros_and_ones(a, b)
    for rank in range(1, a + b + 1):
        exchanges, wire = select(range(a), range(a, a + b), rank)
        assert run(prune(exchanges, [wire]), values)[:, wire].tolist() == np.sort(values)[:, rank - 1].tolist()


def test_prune():
    """Exchanges that no output needs are removed, and those that remain suffice."""
    exchanges, order = merge(range(8), range(8, 16))
    values = zeros_and_ones(8, 8)
    for ranks in ([0], [15], [7, 8], range(16)):
        outputs = [order[rank] for rank in ranks]
        kept = prune(exchanges, outputs)
        assert run(kept, values)[:, outputs].tolist() == np.sort(values)[:, ranks].tolist()
    assert prune(exchanges, order) == exchanges
    assert prune(exchanges, [order[0]]) == [Exchange(0, 8, True, False)]


def test_levels():
    exchanges, _ = sort(range(5))
    by_level = levels(exchanges)
    assert sorted(exchange for level in by_level for exchange in level) == sorted(exchanges)
    for level in by_level:
        wires = [wire for exchange in level for wire in exchange[:2]]
        assert len(wires) == len(set(wires))
    for before, level in itertools.pairwise(by_level):
        wires = {wire for exchange in before for wire in exchange[:2]}
        assert all(wires & {low, high} for low, high, *_ in level)  # none could be earlier


@pytest.mark.parametrize("outputs", [[0, 1, 2, 3, 4], [2], [4, 1]])
def test_gateware(outputs):
    """A set of values a cycle, ``latency`` cycles later its places."""
    exchanges, order = sort(range(5))
    dut = Selection(7, 5, exchanges, [order[place] for place in outputs])
    values = np.random.default_rng(1).integers(0, 128, (60, 5))
    values[::7] = values[::7, :1]  # equal ones too
    given = []

    async def testbench(ctx):
        for row in [*values.tolist(), *[[0] * 5] * dut.latency]:
            ctx.set(dut.i, row)
            given.append(list(ctx.get(dut.o)))
            await ctx.tick()

    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_testbench(testbench)
    sim.run()
    assert given[dut.latency:] == np.sort(values)[:, outputs].tolist()
