import numpy as np
import pytest
from amaranth.sim import Simulator

from golden.config import Arithmetic, MatcherConfig, OnePass
from golden.matcher.cost import matching_cost
from golden.pictures.scenes import scene
from hdl.matcher.sequential.cost import BuffersWord, CostEnergy, CostWord, Edata, EdataWord, SubPixelBuffers, SubPixels, SubPixelWord
from hdl.matcher.stream import ColumnWord
from sim.kit.cases import buffers_words, column_words, comparable, cost_words, edata_words, noise, sub_pixel_words
from sim.kit.streams import run_stream


CONFIGS = [
    MatcherConfig(labels=2, method=OnePass(Arithmetic.THESIS)),
    MatcherConfig(labels=7, method=OnePass(Arithmetic.THESIS)),
    MatcherConfig(labels=2, method=OnePass(Arithmetic.LINEAR, 0)),
    MatcherConfig(labels=7, in_use=5, method=OnePass(Arithmetic.LINEAR, 3)),
]
SIZES = [(1, 1), (5, 3), (1, 2), (2, 1), (12, 2), (1, 1)]

# Component, payloads it takes, payloads it gives.
STAGES = {
    "SubPixels": (SubPixels, lambda left, right, config: column_words(left, right), sub_pixel_words),
    "SubPixelBuffers": (SubPixelBuffers, sub_pixel_words, buffers_words),
    "CostEnergy": (CostEnergy, buffers_words, cost_words),
    "Edata": (Edata, cost_words, edata_words),
}


def pairs():
    """Pictures of all sizes, in a row; the first is wide enough for the greatest cost, which the next holds for one label only."""
    white, black = np.full((2, 9), 255), np.zeros((2, 9), dtype=int)
    return [(white, black), (black, white), *(noise(*size, seed) for seed, size in enumerate(SIZES))]


@pytest.mark.parametrize("stall", [0.0, 0.4])
@pytest.mark.parametrize("config", CONFIGS, ids=str)
@pytest.mark.parametrize("stage", STAGES)
def test_matches_golden(stage, config, stall):
    component, gives_in, gives_out = STAGES[stage]
    words, expected = ([word for pair in pairs() for word in give(*pair, config)] for give in (gives_in, gives_out))
    inputs = {"in_use": config.labels_in_use} if stage == "SubPixelBuffers" else {}
    out = run_stream(component(config), words, count=len(expected), rng=np.random.default_rng(1), stall_i=stall, stall_o=stall,
                     inputs=inputs)
    assert [comparable(word) for word in out] == [comparable(word) for word in expected]


@pytest.mark.parametrize("stage", STAGES)
def test_latency_and_rate(stage):
    component, gives_in, gives_out = STAGES[stage]
    config = CONFIGS[1]
    pair = noise(9, 3, 1)
    words, expected = (give(*pair, config) for give in (gives_in, gives_out))
    cycles = {}
    run_stream(component(config), words, count=len(expected), rng=np.random.default_rng(1), cycles=cycles)
    assert cycles["o"][0] - cycles["i"][0] == component.LATENCY
    # One word a cycle on the side that has more of them.
    longer = max(cycles.values(), key=len)
    assert longer == list(range(longer[0], longer[0] + len(longer)))


@pytest.mark.parametrize("stage", STAGES)
def test_offers_without_ready(stage):
    """``valid`` does not wait for ``ready``; a word that is not taken holds back those after it."""
    component, gives_in, _ = STAGES[stage]
    dut = component(CONFIGS[1])
    words = gives_in(*noise(9, 1, 1), dut.config)

    async def testbench(ctx):
        ctx.set(dut.i.valid, 1)
        for word in words[:dut.LATENCY]:
            ctx.set(dut.i.p, word)
            assert not ctx.get(dut.o.valid)
            assert ctx.get(dut.i.ready)
            await ctx.tick()
        ctx.set(dut.i.p, words[dut.LATENCY])
        for _ in range(20):
            assert ctx.get(dut.o.valid)
            await ctx.tick()
        assert not ctx.get(dut.i.ready)

    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_testbench(testbench)
    sim.run()


@pytest.mark.parametrize("arithmetic, largest", [("thesis", 1275), ("linear", 2550)])
def test_largest_cost(arithmetic, largest):
    """The five differences at their greatest sum to what the width was made for, and a candidate outside costs more."""
    config = MatcherConfig(labels=3, method=OnePass(arithmetic))
    white, black = np.full((1, 4), 255), np.zeros((1, 4), dtype=int)
    out = run_stream(Edata(config), cost_words(white, black, config), count=4, rng=np.random.default_rng(1))
    cost = config.matching_cost
    assert cost.inside_max == largest < cost.outside
    assert [list(word.cost) for word in out] == [
        [largest] + 2 * [cost.outside], 2 * [largest] + [cost.outside], 3 * [largest], 3 * [largest]]


@pytest.mark.parametrize("config", CONFIGS, ids=str)
def test_chain_is_the_matching_cost(config):
    """Golden's stages one after another are golden's matching cost, so the blocks between two of the words above are too."""
    left, right, _ = scene(17, 7, config.labels, seed=2)
    words = edata_words(left, right, config)
    assert [word["cost"] for word in words] == matching_cost(left, right, config).reshape(-1, config.labels).tolist()


@pytest.mark.parametrize("layout, words", [(SubPixelWord, sub_pixel_words), (BuffersWord, buffers_words), (CostWord, cost_words),
                                           (EdataWord, edata_words)])
@pytest.mark.parametrize("config", CONFIGS, ids=str)
def test_words_hold_their_values(config, layout, words):
    """No golden number is cut by the layout that carries it."""
    for pair in pairs():
        for word in words(*pair, config):
            assert comparable(word, layout(config)) == comparable(word)


def test_column_words_hold_their_values():
    for pair in pairs():
        assert [comparable(word, ColumnWord()) for word in column_words(*pair)] == column_words(*pair)
