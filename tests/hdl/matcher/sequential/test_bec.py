import numpy as np
import pytest

from golden.config import Arithmetic, MatcherConfig, OnePass
from golden.matcher.cost import local_disparity, matching_cost
from golden.pictures.scenes import discriminates, scene
from hdl.matcher.sequential.bec import Bec
from sim.kit.cases import bec_words_of, column_words, comparable, noise
from sim.kit.streams import run_stream


CONFIGS = [
    MatcherConfig(labels=2, method=OnePass(Arithmetic.THESIS)),
    MatcherConfig(labels=13, method=OnePass(Arithmetic.THESIS)),
    MatcherConfig(labels=2, method=OnePass(Arithmetic.LINEAR, 0)),
    MatcherConfig(labels=6, method=OnePass(Arithmetic.LINEAR, 3)),
]


def pairs(config):
    """Pictures of several sizes, in a row; in the first every label is a local disparity."""
    left, right, _ = scene(3 * config.labels, 3, config.labels, seed=1)
    assert discriminates(local_disparity(matching_cost(left, right, config)), config)
    return [(left, right), noise(1, 1, 1), noise(5, 3, 2), noise(2, 1, 3), noise(1, 3, 4)]


@pytest.mark.parametrize("stall", [0.0, 0.4])
@pytest.mark.parametrize("config", CONFIGS, ids=str)
def test_matches_golden(config, stall):
    columns, words = [], []
    for pair in pairs(config):
        columns += column_words(*pair)
        words += bec_words_of(*pair, config)
    out = run_stream(Bec(config), columns, rng=np.random.default_rng(1), stall_i=stall, stall_o=stall,
                     inputs={"in_use": config.labels_in_use})
    assert [comparable(word) for word in out] == words


def test_ties_go_to_the_smaller_disparity():
    """Equal pictures of one grey level: every candidate inside costs nothing."""
    config = MatcherConfig(labels=6, method=OnePass(Arithmetic.THESIS))
    grey = np.full((2, 9), 77)
    out = run_stream(Bec(config), column_words(grey, grey), rng=np.random.default_rng(1), inputs={"in_use": config.labels})
    assert [word.local for word in out] == [0] * 18
    assert list(out[8].cost) == [0] * 6


@pytest.mark.parametrize("disparities", [2, 6, 26])
def test_latency_and_rate(disparities):
    """The first pixel of a line leaves after the latency, those after it at the promised pace."""
    dut = Bec(MatcherConfig(labels=disparities))
    cycles = {}
    width = 12
    run_stream(dut, column_words(*noise(width, 1, 1)), rng=np.random.default_rng(1), cycles=cycles)
    assert cycles["o"][0] - cycles["i"][0] == dut.latency
    assert np.diff(cycles["o"]).tolist() == [dut.clocks_per_pixel] * (width - 1)
