"""The matcher with the streaming engine; its blocks have tests of their own."""


import numpy as np
import pytest
from amaranth import *

from golden.config import Arithmetic, Engine, MatcherConfig, OnePass
from golden.matcher.labelling import match
from golden.pictures.scenes import discriminates, scene
from hdl.matcher.matcher import Matcher
from sim.kit.cases import comparable, noise, pixel_words
from sim.kit.ragged import MAX_WIDTH, RAGGED, in_a_row, repaired
from sim.kit.streams import run_stream
from tests.kit import by_turns

from .matcher_runs import after_reset, golden_words, run_script


def config_of(labels, max_width, fraction_bits=OnePass.fraction_bits, **settings):
    return MatcherConfig(labels, max_width, engine=Engine.STREAMING, method=OnePass(Arithmetic.LINEAR, fraction_bits), **settings)


# Slow: 26 labels; benches on Verilog have 16, and by `make slow` 39.
@pytest.mark.parametrize("labels, fraction_bits, width, height, max_width, stall", by_turns([
    (2, 0, 1, 1, 1),
    (2, 4, 5, 3, 5),
    (3, 3, 11, 4, 16),
    (6, 0, 12, 5, 12),
    (6, 3, 1, 9, 3),        # one column
    (13, 1, 5, 3, 27),      # narrower than its labels
    (13, 3, 27, 5, 27),
    (13, 2, 40, 1, 64),     # one line
    (6, 3, 17, 4, 17),
    pytest.param(26, 3, 70, 4, 70, marks=pytest.mark.slow),    # the top label reads its costs long after label 0
], (0.0, 0.3)))
def test_matches_golden(labels, fraction_bits, width, height, max_width, stall):
    """A scene, and noise of other sizes before and after it, in a row; where it is wide enough all labels win."""
    config = config_of(labels, max_width, fraction_bits=fraction_bits)
    left, right, _ = scene(width, height, labels, seed=5)
    if width >= 2 * labels and height > 1:
        assert discriminates(match(left, right, config), config)
    pairs = [noise(max(1, width // 2), 2, seed=1), (left, right), noise(min(3, max_width), 1, seed=2), noise(max_width, 2, seed=3)]
    out = run_stream(Matcher(config), [word for pair in pairs for word in pixel_words(*pair)], rng=np.random.default_rng(1),
                     stall_i=stall, stall_o=stall)
    assert [comparable(word) for word in out] == [word for pair in pairs for word in golden_words(*pair, config)]


def test_long_stalls():
    """Everything fills up, then runs dry; nothing is lost."""
    config = config_of(6, 20)
    pairs = [scene(20, 4, 6, seed=6)[:2], noise(20, 3, seed=7)]
    out = run_stream(Matcher(config), [word for pair in pairs for word in pixel_words(*pair)], rng=np.random.default_rng(2), stall_o=0.95)
    assert [comparable(word) for word in out] == [word for pair in pairs for word in golden_words(*pair, config)]


@pytest.mark.parametrize("labels, width", [(6, 60), (13, 100)])
def test_one_pixel_a_clock(labels, width):
    """Inside a line no clock is lost, between lines two are; latency is within its bound."""
    config = config_of(labels, width)
    dut = Matcher(config)
    height = 4
    cycles = {}
    run_stream(dut, pixel_words(*noise(width, height, 1)), rng=np.random.default_rng(1), cycles=cycles)
    gaps = np.diff(cycles["o"]).reshape(-1)
    assert np.delete(gaps, slice(width - 1, None, width)).tolist() == [1] * (height * (width - 1))
    assert gaps[width - 1::width].tolist() == [3] * (height - 1)
    latency = np.subtract(cycles["o"], cycles["i"])
    assert latency.max() <= 2 * width + dut.latency_clocks


def test_ragged():
    """Each ``error`` is raised; frames around a ragged one are bit-exact, and that one is output rectangular, bit-exact with golden."""
    dut = Matcher(config_of(3, MAX_WIDTH))
    words = in_a_row()
    frames, pulses = repaired(words)
    expected = [word for pair in frames for word in golden_words(*pair, dut.config)]

    async def script(ctx, send_words, given):
        ctx.set(dut.clear, 1)   # an error is seen for one clock
        await send_words(words)

    given, errors = run_script(dut, script, len(expected), stall=0.2)
    assert given == expected
    assert sum(errors) == pulses >= len(RAGGED)


# Slow: cuts between those.
@pytest.mark.parametrize("cut", [1, 75, 119, *(pytest.param(cut, marks=pytest.mark.slow) for cut in (40, 100))])
def test_reset_in_mid_frame(cut):
    """Nothing of the frame before a reset is output; the next one is bit-exact."""
    config = config_of(6, 40)
    left, right, _ = scene(40, 3, 6, seed=1)
    given, _ = after_reset(Matcher(config), left, right, cut)
    assert given == golden_words(left, right, config)


# Slow: more labels, of which 6 show the same. With these 34 pixels are the shortest line at full rate.
@pytest.mark.parametrize("config", [
    config_of(6, 34), config_of(13, 8), MatcherConfig(labels=6, max_width=20), MatcherConfig(labels=26, max_width=5),
    *(pytest.param(config, marks=pytest.mark.slow)
      for config in (config_of(13, 90), config_of(26, 60), MatcherConfig(labels=26, max_width=60))),
], ids=lambda config: f"{config.engine}-{config.labels}-{config.max_width}")
def test_frame_clocks(config):
    """The distance of frames in a row is what the builds and the tables calculate with: exactly, but a bound for narrow lines."""
    dut = Matcher(config)
    width, height = config.max_width, 5
    pairs = [noise(width, height, seed) for seed in range(3)]
    cycles = {}
    run_stream(dut, [word for pair in pairs for word in pixel_words(*pair)], rng=np.random.default_rng(1), cycles=cycles)
    firsts = cycles["o"][::width * height]
    slack = 1 if width >= dut.full_rate_width else 1.25
    assert firsts[2] - firsts[1] <= dut.frame_clocks(width, height) <= slack * (firsts[2] - firsts[1])
