# amaranth: UnusedElaboratable=no
"""The matcher with the method recursive; its blocks have tests of their own."""

import numpy as np
import pytest

from golden.config import RECURSIVE_1, MatcherConfig, changed
from golden.matcher.matcher import match
from golden.pictures.scenes import scene
from hdl.matcher.matcher import Matcher
from hdl.matcher.settings import setting_ports
from sim.kit.cases import comparable, field_words, noise, pixel_words
from sim.kit.ragged import MAX_WIDTH, RAGGED, repaired
from sim.kit.streams import run_stream

from .matcher_runs import after_reset, run_script


def config_of(labels, max_width, *, minimum=0, **parameters):
    return MatcherConfig(labels, max_width, minimum, method=changed(RECURSIVE_1, **parameters))


def as_bytes(pair):
    return [np.asarray(picture, dtype=np.uint8) for picture in pair]


def words_of(pair, config):
    return field_words(match(*pair, config))


# Slow: with stalls what is seen without, and the other way round.
@pytest.mark.parametrize("config, width, height, stall", [
    (config_of(2, 1, reach=2, fan=3), 1, 1, 0.3),
    (config_of(2, 5, reach=0, fan=3), 5, 3, 0.0),
    (config_of(3, 16, minimum=4), 11, 4, 0.3),                                # narrower than the fan
    (config_of(6, 60, census_rows=7, census_columns=9, census_weight=25), 60, 5, 0.0),
    (config_of(6, 3, census_rows=1, census_columns=1), 1, 9, 0.0),            # one column, no census
    (config_of(13, 27, fan=12), 5, 2, 0.0),                                   # narrower than its labels
    pytest.param(config_of(13, 90, minimum=3, census_threshold=2), 90, 3, 0.3, marks=pytest.mark.slow),
    # Slow: stages off, and a lead, which cases with costs from below have, too.
    pytest.param(config_of(6, 40, check=False, median=False), 40, 1, 0.0, marks=pytest.mark.slow),
    pytest.param(config_of(6, 40, minimum=-5), 40, 4, 0.3, marks=pytest.mark.slow),
    (config_of(3, 16, minimum=-64), 11, 4, 0.0),                              # a lead longer than the lines
    (config_of(2, 1, minimum=-1, fan=3), 1, 2, 0.0),
    (config_of(6, 24, fill=False, lower_share=0, own_share=7), 24, 4, 0.0),
    pytest.param(config_of(6, 50, near_threshold=40, far_threshold=30, step_threshold=50, reach=31), 50, 3, 0.3, marks=pytest.mark.slow),
    (config_of(6, 50, spread_step=1, spread_jump=127, gate_floor=127, above_share=15, cost_limit=9), 50, 4, 0.0),
    (config_of(2, 1, from_below=True, reach=2, fan=3), 1, 1, 0.3),
    (config_of(3, 16, from_below=True, minimum=4, below_share=15), 11, 4, 0.0),
    # Slow: at full rate, line behind line, as `test_frame_clocks` has them; two groups, as 11 labels have.
    pytest.param(config_of(3, 100, from_below=True, reach=3, fan=3, below_share=15), 100, 4, 0.0, marks=pytest.mark.slow),
    pytest.param(config_of(10, 40, from_below=True, census_rows=3, census_columns=3), 40, 4, 0.6, marks=pytest.mark.slow),
    pytest.param(config_of(6, 60, from_below=True, near_threshold=40, far_threshold=30, step_threshold=50, reach=31), 50, 5, 0.3,
                 marks=pytest.mark.slow),
    (config_of(6, 24, from_below=True, check=False, minimum=-5, lower_share=0, own_share=7), 24, 3, 0.0),
    (config_of(6, 30, soft_multipliers=True), 30, 4, 0.0),
    (config_of(11, 40, sub_pixel=True, minimum=2), 40, 6, 0.3),                           # labels of two groups beside each other
    *(pytest.param(config_of(13, 90, minimum=3), 90, 5, stall, marks=pytest.mark.slow) for stall in (0.0, 0.3)),
    *(pytest.param(config_of(26, 110), 110, 4, stall, marks=pytest.mark.slow) for stall in (0.0, 0.3)),
    *(pytest.param(config_of(26, 250, from_below=True), 250, 4, stall, marks=pytest.mark.slow) for stall in (0.0, 0.3)),
], ids=lambda value: f"D{value.labels}" if isinstance(value, MatcherConfig) else str(value))
def test_matches_golden(config, width, height, stall):
    """A scene, and noise of other sizes before and after it, in a row."""
    most = config.max_width
    pairs = [noise(max(1, width // 2), 2, seed=1), scene(width, height, config.labels, seed=5)[:2], noise(min(3, most), 1, seed=2),
             noise(most, 2, seed=3)]
    pairs = [as_bytes(pair) for pair in pairs]
    out = run_stream(Matcher(config), [word for pair in pairs for word in pixel_words(*pair)], rng=np.random.default_rng(1),
                     stall_i=stall, stall_o=stall)
    assert [comparable(word) for word in out] == [word for pair in pairs for word in words_of(pair, config)]


def test_one_pixel_a_clock():
    """Inside a line no clock is lost, between lines as many as fan, census and padding take; latency is close to its bound."""
    dut = Matcher(config_of(6, 60))
    width, height, cycles = 60, 12, {}
    run_stream(dut, pixel_words(*noise(width, height, 1)), rng=np.random.default_rng(1), cycles=cycles)
    gaps = np.diff(cycles["o"])
    inside = np.delete(gaps, slice(width - 1, None, width))
    assert np.count_nonzero(inside != 1) <= 2 * height      # a line store in between may shift a pause
    assert cycles["o"][-1] - cycles["o"][0] <= height * (width + dut.line_clocks) + 8
    assert dut.line_clocks == dut.config.method.propagation.fan + 1 + dut.config.method.cost.census_columns // 2
    latency = np.subtract(cycles["o"], cycles["i"]).max() - dut.latency_lines * width
    assert dut.latency_clocks - 20 <= latency <= dut.latency_clocks


# Slow: more labels, a wider fan and census, other heights.
@pytest.mark.parametrize("config, height", [
    (config_of(3, 42, reach=3, fan=3, census_columns=1), 5), (config_of(3, 50, reach=3, minimum=-5), 3),
    (config_of(2, 72, reach=3, fan=3, from_below=True), 4),
    *(pytest.param(config, height, marks=pytest.mark.slow) for config, height in (
        (config_of(3, 60, reach=3), 4), (config_of(13, 8, reach=3), 4), (config_of(3, 50, reach=3, census_rows=3, census_columns=3), 4),
        (config_of(6, 100), 14), (config_of(3, 90, fan=31, census_columns=9), 7), (config_of(20, 20), 14), (config_of(6, 60), 2),
        (config_of(6, 90, census_rows=7, census_columns=9, census_weight=20, minimum=-20), 6),
        (config_of(3, 60, census_rows=3, census_columns=3), 40),
    )),
], ids=lambda value: f"D{value.labels}-{value.max_width}" if isinstance(value, MatcherConfig) else str(value))
def test_frame_clocks(config, height):
    """The distance of frames in a row is what builds and tables calculate with: exactly, but an upper bound for narrow lines, and for a
    census of three rows, where the engine waits for the median."""
    dut = Matcher(config)
    width = config.max_width
    cycles = {}
    run_stream(dut, [word for seed in range(3) for word in pixel_words(*noise(width, height, seed))], rng=np.random.default_rng(1),
               cycles=cycles)
    firsts = cycles["o"][::width * height]
    slack = 1.7 if width < dut.full_rate_width else 1.15 if config.method.cost.census_rows <= 3 else 1
    assert firsts[2] - firsts[1] <= dut.frame_clocks(width, height) <= slack * (firsts[2] - firsts[1])


def check_sets(config, left, right, sets):
    """The pair, once for each of ``sets`` of settings, which are set while the one before is output: each with its own settings."""
    expected = [words_of((left, right), config.with_settings(settings)) for settings in sets]
    assert all(a != b for n, a in enumerate(expected) for b in expected[:n])  # each set gives another picture
    dut = Matcher(config)
    ports = [name for name in setting_ports(config) if name != "apply_settings"]

    async def put(ctx, values, pulse):
        for name in ports:
            ctx.set(getattr(dut, name), int(values[name]))
        ctx.set(dut.apply_settings, pulse)
        await ctx.tick()
        ctx.set(dut.apply_settings, 0)

    async def script(ctx, send_words, given):
        other = {name: setting.maximum for name, setting in config.settings.items()}
        await put(ctx, other, 0)  # inputs alone change nothing
        for number in range(len(sets)):
            await send_words(pixel_words(left, right))
            while len(given) < number * left.size + 1:  # the frame has begun to leave
                await ctx.tick()
            if number + 1 < len(sets):
                await put(ctx, config.defaults | sets[number + 1], 1)
                await put(ctx, other, 0)

    given, errors = run_script(dut, script, len(sets) * left.size)
    assert given == [word for words in expected for word in words]
    assert not any(errors)
    return dut


def test_settings():
    """Built-in ones until the first pulse; new ones from the next frame on, even if they are set while a frame is output."""
    config = config_of(4, 20, near_threshold=20, far_threshold=9, step_threshold=20)
    left, right, _ = scene(20, 4, 4, seed=11)
    rng = np.random.default_rng(1)
    left, right = (np.clip(side.astype(int) // 3 + 90 + rng.integers(-6, 7, side.shape), 0, 255).astype(np.uint8) for side in (left, right))
    check_sets(config, left, right, [
        {}, {"minimum": 2}, {"check": 0, "fill": 0}, {"fill": 0}, {"median": 0}, {"census_threshold": 7}, {"near_threshold": 3},
        {"step_threshold": 4}, {"far_threshold": 90}, {"above_share": 0}, {"gate_numerator": 1000}, {"gate_offset": 8}, {"gate_floor": 20},
        {"in_use": 2}])


def test_gates_of_great_differences():
    """The last gates are in the tables before the third line needs them, which comes soonest on lines of full rate."""
    config = config_of(5, 48, reach=0, fan=3, census_rows=1, census_columns=1, check=False, median=False, above_share=15)
    rng = np.random.default_rng(2)
    left, right = (np.where(rng.random((3, 48)) < 0.5, rng.integers(0, 9, (3, 48)), rng.integers(247, 256, (3, 48))).astype(np.uint8)
                   for _ in range(2))
    assert check_sets(config, left, right, [{}, {"gate_floor": 127}]).full_rate_width <= 48


@pytest.mark.parametrize("case", list(RAGGED)[::6])
def test_ragged(case):
    """``error`` is raised; frames around the ragged one are bit-exact, and that one is output rectangular, bit-exact with golden."""
    config = config_of(3, MAX_WIDTH)
    before, after = noise(5, 3, 20), noise(5, 4, 21)
    words = [*pixel_words(*before), *RAGGED[case][0], *pixel_words(*after)]
    frames, _ = repaired(words)
    expected = [word for pair in frames for word in words_of(as_bytes(pair), config)]

    async def script(ctx, send_words, given):
        await send_words(words)

    given, errors = run_script(Matcher(config), script, len(expected), stall=0.2)
    assert given == expected
    assert any(errors)


@pytest.mark.parametrize("cut", [pytest.param(1, marks=pytest.mark.slow), 200])
def test_reset_in_mid_frame(cut):
    """Nothing of the frame before a reset is output; the next one is bit-exact."""
    config = config_of(6, 40)
    left, right, _ = scene(40, 5, 6, seed=1)
    given, _ = after_reset(Matcher(config), left, right, cut)
    assert given == words_of((left, right), config)


