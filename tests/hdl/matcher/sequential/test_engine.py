
import numpy as np
import pytest
from amaranth.sim import Simulator

from golden.config import WEIGHT_MAX, Arithmetic, MatcherConfig, OnePass
from golden.matcher.labelling import cost_summation, labelling
from golden.pictures.scenes import discriminates
from hdl.matcher.sequential.engine import CostSummation, SequentialEngine
from sim.kit.cases import bec_words, comparable, disparity_words, noise
from sim.kit.streams import check_rules, receive, send


CONFIGS = [
    MatcherConfig(labels=2, max_width=9, method=OnePass(Arithmetic.THESIS)),
    MatcherConfig(labels=13, max_width=9, method=OnePass(Arithmetic.THESIS)),
    MatcherConfig(labels=2, max_width=9, method=OnePass(Arithmetic.LINEAR, 0)),
    MatcherConfig(labels=6, max_width=9, method=OnePass(Arithmetic.LINEAR, 3)),
]
# Widths and heights, with weights; a look-up table is not yet filled when a narrow first line is over.
FRAMES = [((1, 3), (63, 63, 63)), ((9, 4), (15, 10, 5)), ((2, 2), (5, 63, 40)), ((3, 1), (63, 0, 0)), ((1, 1), (1, 2, 3)),
          ((1, 2), (9, 0, 63)), ((5, 3), (0, 0, 0)), ((9, 6), (2, 3, 1))]


def energies(width, height, config, seed):
    """Costs and local disparities as no picture gives them: any of both anywhere, costs low enough for smoothness to matter."""
    rng = np.random.default_rng(seed)
    cost = rng.integers(0, 60, (height, width, config.labels))
    cost[rng.random(cost.shape) < 0.1] = config.matching_cost.outside
    cost[rng.random(cost.shape) < 0.1] = 0
    return cost, rng.integers(0, config.labels, (height, width)), noise(width, height, seed, pictures=1)[0]


def run_engine(dut, frames, *, stall=0.0, cycles=None):
    """Each frame is (words, weights); the weights stand while its first word is offered, and at no other time."""
    rng = np.random.default_rng(1)
    taken, given = [], []
    cycles = {"i": [], "o": []} if cycles is None else cycles
    count = sum(len(words) for words, _ in frames)

    def weigh(ctx, weights):
        for name, weight in zip(("u1", "u2", "u3"), weights):
            ctx.set(getattr(dut, name), weight)

    async def source(ctx):
        for words, weights in frames:
            weigh(ctx, weights)
            await send(ctx, dut.i, words[:1], rng=rng, stall=stall)
            weigh(ctx, rng.integers(0, WEIGHT_MAX + 1, 3).tolist())
            await send(ctx, dut.i, words[1:], rng=rng, stall=stall)

    async def sink(ctx):
        await receive(ctx, dut.o, count, rng=rng, stall=stall, timeout=1000)
        ctx.set(dut.o.ready, 1)
        await ctx.tick().repeat(50)

    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_testbench(source)
    sim.add_testbench(sink)
    sim.add_testbench(check_rules(dut.i, taken, cycles["i"]), background=True)
    sim.add_testbench(check_rules(dut.o, given, cycles["o"]), background=True)
    sim.run()
    assert len(taken) == count
    return [comparable(word) for word in given]


@pytest.mark.parametrize("config", CONFIGS, ids=str)
def test_summation_matches_golden(config):
    dut = CostSummation(config)
    rng = np.random.default_rng(1)
    limits = config.matching_cost.outside, config.smooth_max, config.smooth_max, config.smooth_max
    sets = [rng.integers(0, limit + 1, (30, config.labels)) for limit in limits]
    for terms, limit in zip(sets, limits):
        terms[0], terms[1] = limit, 0  # the greatest energy proves the width
    cost, s1, s2, s3 = sets
    expected = cost_summation(cost, s1, s2, s3, config)
    assert expected.max() == config.energy_max

    async def testbench(ctx):
        for n in range(len(cost) + 1):
            # The early terms of one set are due with s1 of the set before.
            for member, terms, at in ((dut.cost, cost, n), (dut.s2, s2, n), (dut.s3, s3, n), (dut.s1, s1, n - 1)):
                ctx.set(member, terms[at % len(cost)].tolist())
            await ctx.tick()
            if n:
                assert list(ctx.get(dut.energy)) == expected[n - 1].tolist()

    assert dut.EARLY_LATENCY - dut.LATENCY == 1
    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_testbench(testbench)
    sim.run()


@pytest.mark.parametrize("stall", [0.0, 0.4])
@pytest.mark.parametrize("config", CONFIGS, ids=str)
def test_matches_golden(config, stall):
    """Frames of all sizes, in a row, each with weights of its own."""
    frames, expected, labels = [], [], []
    for seed, (size, weights) in enumerate(FRAMES):
        cost, local, left = energies(*size, config, seed)
        golden = labelling(cost, local, left, config.with_settings(dict(zip(("u1", "u2", "u3"), weights))))
        frames.append((bec_words(cost, local, left, seed), weights))
        expected += disparity_words(golden)
        labels += golden.ravel().tolist()
    assert discriminates(np.array(labels), config)
    assert run_engine(SequentialEngine(config), frames, stall=stall) == expected


def test_weights_at_their_greatest():
    """The widest energies: every label as far away from its neighbours' as can be, in equal pixels."""
    for config in CONFIGS:
        config = config.with_settings(dict.fromkeys(("u1", "u2", "u3"), WEIGHT_MAX))
        rng = np.random.default_rng(2)
        cost = rng.choice([0, config.matching_cost.outside // 2, config.matching_cost.outside], (4, 5, config.labels))
        local = rng.choice([0, config.labels - 1], (4, 5))
        left = np.full((4, 5), 9)
        expected = disparity_words(labelling(cost, local, left, config))
        assert run_engine(SequentialEngine(config), [(bec_words(cost, local, left), config.rule.weights)]) == expected


def test_ties_go_to_the_smaller_disparity():
    config = CONFIGS[3]
    cost = np.full((3, 4, 6), 17)
    frame = bec_words(cost, np.zeros((3, 4), dtype=int), noise(4, 3, 1, pictures=1)[0]), (15, 10, 5)
    assert {word["disparity"] for word in run_engine(SequentialEngine(config), [frame])} == {0}


@pytest.mark.parametrize("disparities, clocks", [(2, 4), (5, 4), (6, 5), (26, 6), (80, 6), (128, 7)])
def test_clocks_per_pixel(disparities, clocks):
    """Within a line a pixel each ``clocks_per_pixel`` cycles; at ``D = 80`` that is at most 8."""
    config = MatcherConfig(labels=disparities, max_width=12)
    dut = SequentialEngine(config)
    assert dut.clocks_per_pixel == clocks <= 8
    cost, local, left = energies(6, 2, config, 1)
    cycles = {"i": [], "o": []}
    run_engine(dut, [(bec_words(cost, local, left), (15, 10, 5))], cycles=cycles)
    assert np.diff(cycles["o"][:6]).tolist() == np.diff(cycles["o"][6:]).tolist() == [clocks] * 5
