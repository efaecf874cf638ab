import numpy as np
import pytest
from amaranth.sim import Simulator

from golden.matcher.argmin import comparator_tree
from hdl.matcher.sequential.argmin import ComparatorTree


def run_tree(dut, sets, enables=None):
    """Feed a set of values each enabled cycle; return what stands at the output after each enabled edge, from the latency on."""
    given = []

    async def testbench(ctx):
        at = 0
        for enable in enables if enables is not None else [1] * (len(sets) + dut.latency - 1):
            ctx.set(dut.enable, enable)
            ctx.set(dut.i, sets[at] if at < len(sets) else sets[-1])
            await ctx.tick()
            at += enable
            if enable and at >= dut.latency:
                result = ctx.get(dut.o)
                given.append((result.value, result.index))

    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_testbench(testbench)
    sim.run()
    return given[:len(sets)]


def expected(sets):
    value, index = comparator_tree(np.array(sets))
    return list(zip(value.tolist(), index.tolist()))


@pytest.mark.parametrize("inputs, stages", [(1, 1), (2, 1), (5, 1), (6, 2), (13, 2), (25, 2), (26, 3), (80, 3), (125, 3), (128, 4)])
def test_matches_golden(inputs, stages):
    bits = 6
    rng = np.random.default_rng(inputs)
    top = 2**bits - 1
    few = rng.integers(0, 3, (40, inputs))              # many ties
    wide = rng.integers(0, 2**bits, (40, inputs))
    winners = np.full((inputs, inputs), top)            # each input wins once, against the greatest value
    winners[np.arange(inputs), np.arange(inputs)] = top - 1
    equal = np.stack([np.full(inputs, value) for value in (0, 1, top)])
    # Each pair of inputs ties; a neighbour comparison that is strict the wrong way shows.
    pairs = np.full((inputs, inputs), top)
    pairs[np.arange(inputs), np.arange(inputs)] = 0
    pairs[np.arange(inputs), rng.integers(0, inputs, inputs)] = 0
    sets = np.vstack([few, wide, winners, equal, pairs]).tolist()

    dut = ComparatorTree(bits, inputs)
    assert dut.latency == stages
    out = run_tree(dut, sets)
    assert out == expected(sets)
    assert {index for _, index in out} == set(range(inputs))


def test_ties_of_every_pair():
    """For each pair of 13 inputs: equal and least, the smaller index wins; one less than the other, the lesser wins."""
    sets = []
    for low in range(13):
        for high in range(low + 1, 13):
            for at_low, at_high in ((3, 3), (3, 4), (4, 3)):
                values = [9] * 13
                values[low], values[high] = at_low, at_high
                sets.append(values)
    assert run_tree(ComparatorTree(4, 13), sets) == expected(sets)


def test_enable_freezes_all_stages():
    rng = np.random.default_rng(1)
    sets = rng.integers(0, 16, (40, 26)).tolist()
    enables = rng.integers(0, 2, 200).tolist()
    assert run_tree(ComparatorTree(4, 26), sets, enables) == expected(sets)
