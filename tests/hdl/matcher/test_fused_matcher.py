# amaranth: UnusedElaboratable=no
"""The matcher with the method fused; its blocks have tests of their own."""


import numpy as np
import pytest
from amaranth.hdl import Fragment

from golden.config import FUSED_1, MatcherConfig, Refinement, changed
from golden.pictures.scenes import scene
from hdl.matcher.matcher import Matcher
from hdl.matcher.settings import setting_ports
from sim.kit.cases import comparable, fused_words, noise, pixel_words
from sim.kit.ragged import MAX_WIDTH, RAGGED, in_a_row, repaired
from sim.kit.streams import run_stream
from tests.kit import by_turns

from .matcher_runs import after_reset, run_script


ALL = Refinement()
# Lines longer than the first one: with a lead their surplus pixels of the right picture are in the place of replicated ones.
TOO_LONG = ("short first line", "long line", "long last line")
VERTICAL = {"vertical_lines": 1, "vertical_threshold": 30, "truncation": 60, "cost_shift": 6, "cost_outside": 12}


def config_of(labels, max_width, *, refinement=ALL, minimum=0, **fused):
    return MatcherConfig(labels, max_width, minimum, method=changed(FUSED_1, refinement=refinement, **fused))


def as_bytes(pair):
    return [np.asarray(picture, dtype=np.uint8) for picture in pair]


# A matcher, width and height of a scene.
CASES = [
    (config_of(2, 1), 1, 1),
    (config_of(2, 5, reach=0, median_size=3), 5, 3),
    (config_of(3, 16, minimum=4), 11, 4),
    (config_of(6, 3, census_rows=1, census_columns=1), 1, 9),                 # one column, no census
    (config_of(13, 27), 5, 3),                                                # narrower than its labels
    (config_of(6, 24, refinement=Refinement(fill=False)), 24, 4),
    (config_of(2, 1, minimum=-1), 1, 1),
    (config_of(3, 16, minimum=-64), 11, 4),                                   # a lead longer than the lines
    (config_of(6, 40, minimum=-3), 40, 7),
    (config_of(2, 1, **VERTICAL), 1, 1),
    (config_of(3, 7, census_rows=1, **VERTICAL), 1, 9),
    (config_of(8, 27, reach=31, **VERTICAL), 5, 3),
    (config_of(6, 26, refinement=Refinement(sub_pixel=True), **VERTICAL), 26, 4),
    # Slow: what the cases above have one by one, together, and more labels; the benches on Verilog have them with 14 and 16.
    *(pytest.param(*case, marks=pytest.mark.slow) for case in (
        (config_of(6, 40, reach=3, census_rows=7, census_columns=9, census_weight=25), 40, 7),
        (config_of(6, 27, refinement=Refinement(sub_pixel=True), minimum=3), 27, 5),
        (config_of(6, 64, refinement=Refinement(check=False, median=False)), 40, 1),
        (config_of(13, 27, minimum=-9, refinement=Refinement(sub_pixel=True)), 5, 3),
        (config_of(6, 30, minimum=-12, **VERTICAL), 30, 5),                   # all disparities negative
        (config_of(6, 40, census_columns=9, **VERTICAL), 40, 7),
        (config_of(6, 64, minimum=3, **VERTICAL), 40, 1),
        (config_of(13, 60, refinement=Refinement(sub_pixel=True), minimum=3), 60, 5),
        (config_of(26, 70, refinement=Refinement(fill=False)), 70, 4),
        (config_of(26, 70, refinement=Refinement(sub_pixel=True), **VERTICAL), 70, 4))),
]


@pytest.mark.parametrize("config, width, height, stall", by_turns(CASES, (0.0, 0.3)),
                         ids=lambda value: f"D{value.labels}" if isinstance(value, MatcherConfig) else str(value))
def test_matches_golden(config, width, height, stall):
    """A scene, and noise of other sizes before and after it, in a row."""
    most = config.max_width
    pairs = [noise(max(1, width // 2), 2, seed=1), scene(width, height, config.labels, seed=5)[:2], noise(min(3, most), 1, seed=2),
             noise(most, 2, seed=3)]
    pairs = [as_bytes(pair) for pair in pairs]
    out = run_stream(Matcher(config), [word for pair in pairs for word in pixel_words(*pair)], rng=np.random.default_rng(1),
                     stall_i=stall, stall_o=stall)
    assert [comparable(word) for word in out] == [word for pair in pairs for word in fused_words(*pair, config)]


def test_long_pauses():
    """Lines shorter than the labels, supports ready long before the right picture's labels: nothing is asked for before it is there."""
    config = config_of(13, 5, reach=1, cost_outside=255, tolerance=0)
    left, right, _ = scene(5, 6, 4, seed=5)

    async def script(ctx, send_words, given):
        words = pixel_words(left, right)
        for begin in range(0, len(words), 5):
            await send_words(words[begin:begin + 5])
            await ctx.tick().repeat(120)

    given, _ = run_script(Matcher(config), script, left.size)
    assert given == fused_words(left, right, config)


# Slow: neither vertical support nor lead; 13 labels, of which 4 show the same.
@pytest.mark.parametrize("labels, width, fused", [
    (4, 45, VERTICAL), (4, 45, {"minimum": -5}), pytest.param(4, 45, {}, marks=pytest.mark.slow),
    *(pytest.param(13, 100, fused, marks=pytest.mark.slow) for fused in ({}, VERTICAL)),
])
def test_one_pixel_a_clock(labels, width, fused):
    """Inside a line no clock is lost, between lines as many as the census takes; latency is within its bound and not far below it."""
    dut = Matcher(config_of(labels, width, **fused))
    height = 8
    cycles = {}
    run_stream(dut, pixel_words(*noise(width, height, 1)), rng=np.random.default_rng(1), cycles=cycles)
    gaps = np.diff(cycles["o"])
    inside = np.delete(gaps, slice(width - 1, None, width))
    assert np.count_nonzero(inside != 1) <= 2  # the last lines are read from other memories
    assert cycles["o"][-1] - cycles["o"][0] <= height * (width + dut.line_clocks) + 8
    latency = np.subtract(cycles["o"], cycles["i"]).max() - dut.latency_lines * width
    assert dut.latency_clocks - 40 - 3 * dut.config.lead <= latency <= dut.latency_clocks


# Slow: 13 labels, of which 3 show the same; no lead and no vertical support, of which each other case lacks one at least; windows of the
# census between the greatest and the smallest one.
@pytest.mark.parametrize("config", [
    config_of(6, 8), config_of(3, 33, **VERTICAL), config_of(3, 33, minimum=-7),
    config_of(3, 34, census_rows=7, census_columns=5, census_weight=20),
    *(pytest.param(config, marks=pytest.mark.slow) for config in (
        config_of(3, 33), config_of(6, 60, minimum=-3, **VERTICAL), config_of(3, 30, census_columns=9),
        config_of(3, 31, census_rows=3, census_columns=1), config_of(13, 100), config_of(13, 100, **VERTICAL))),
], ids=lambda config: f"D{config.labels}-{config.max_width}-{config.method.cost.census_rows}x{config.method.cost.census_columns}")
def test_frame_clocks(config):
    """The distance of frames in a row is what builds and tables calculate with: exactly, but an upper bound for narrow lines."""
    dut = Matcher(config)
    width, height = config.max_width, 7
    cycles = {}
    run_stream(dut, [word for seed in range(3) for word in pixel_words(*noise(width, height, seed))], rng=np.random.default_rng(1),
               cycles=cycles)
    firsts = cycles["o"][::width * height]
    slack = 1 if width >= dut.full_rate_width else 1.7
    assert firsts[2] - firsts[1] <= dut.frame_clocks(width, height) <= slack * (firsts[2] - firsts[1])


@pytest.mark.parametrize("labels, fused", [(6, {}), (20, VERTICAL)])
def test_lines_as_long_as_the_labels_need_no_flush_cycles(labels, fused):
    """So that frames of them take less time than those of lines that are a pixel shorter."""
    dut = Matcher(config_of(labels, labels + 1, **fused))
    Fragment.get(dut, None)     # Amaranth complains of components that are not used
    bounds = [dut.frame_clocks(width, 5) for width in (labels - 1, labels, labels + 1)]
    assert bounds[1] < bounds[2] < bounds[0]


# Slow: fewer stages than with sub-pixel disparities.
@pytest.mark.parametrize("sub_pixel", [pytest.param(False, marks=pytest.mark.slow), True])
def test_settings(sub_pixel):
    """Built-in ones until the first pulse; new ones from the next frame on, even if they are set while a frame is output."""
    config = config_of(6, 24, refinement=Refinement(sub_pixel=sub_pixel))
    left, right, _ = scene(24, 6, 6, seed=1)
    sets = [{}, {"minimum": 2}, {"check": 0, "fill": 0}, {"fill": 0}, {"median": 0}, {"u1": 63, "u2": 0, "in_use": 3}, {"minimum": 255}]
    expected = [fused_words(left, right, config.with_settings(settings)) for settings in sets]
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
        other = config.defaults | {"u1": 33, "in_use": 2, "minimum": 9, "check": 0, "median": 0}
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


@pytest.mark.parametrize("cases, fused", [
    (list(RAGGED)[1::2], {}), (list(RAGGED)[::4], VERTICAL),
    ([case for case in list(RAGGED)[::3] if case not in TOO_LONG], {"minimum": -2}),
    pytest.param(list(RAGGED), {}, marks=pytest.mark.slow),  # the other matchers have them all
], ids=["half", "vertical", "minimum", "all"])
def test_ragged(cases, fused):
    """Each ``error`` is raised; frames around a ragged one are bit-exact, and that one is output rectangular, bit-exact with golden."""
    dut = Matcher(config_of(3, MAX_WIDTH, **fused))
    words = in_a_row(cases)
    frames, pulses = repaired(words)
    expected = [word for pair in frames for word in fused_words(*as_bytes(pair), dut.config)]

    async def script(ctx, send_words, given):
        ctx.set(dut.clear, 1)   # an error is seen for one clock
        await send_words(words)

    given, errors = run_script(dut, script, len(expected), stall=0.2)
    assert given == expected
    assert sum(errors) == pulses >= len(cases)


# Slow: cuts between those.
@pytest.mark.parametrize("cut", [1, 130, 279, *(pytest.param(cut, marks=pytest.mark.slow) for cut in (40, 75, 200))])
def test_reset_in_mid_frame(cut):
    """Nothing of the frame before a reset is output; the next one is bit-exact."""
    config = config_of(6, 40)
    left, right, _ = scene(40, 7, 6, seed=1)
    given, _ = after_reset(Matcher(config), left, right, cut)
    assert given == fused_words(left, right, config)


