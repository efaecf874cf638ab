# amaranth: UnusedElaboratable=no

import numpy as np
import pytest
from amaranth.hdl import Fragment

from golden.config import FUSED_1, FUSED_2, WEIGHT_MAX, Arithmetic, Engine, MatcherConfig, OnePass, changed
from golden.matcher.labelling import match
from golden.pictures.scenes import discriminates, scene
from hdl.matcher.matcher import Matcher
from sim.kit.cases import comparable, noise, pixel_words
from sim.kit.ragged import MAX_WIDTH, RAGGED, frame, in_a_row, repaired
from sim.kit.streams import run_stream
from tests.kit import by_turns

from .matcher_runs import after_reset, golden_words, run_script


# Labels, arithmetic, fraction bits, width, height, longest line.
CASES = [
    (2, "thesis", 0, 1, 1, 1),
    (2, "thesis", 0, 4, 3, 4),
    (2, "linear", 0, 4, 3, 9),
    (2, "linear", 3, 5, 3, 5),
    (5, "thesis", 0, 11, 4, 16),
    (6, "linear", 0, 12, 5, 12),
    (6, "linear", 1, 13, 1, 16),
    (6, "linear", 4, 12, 3, 12),
    (13, "thesis", 0, 27, 5, 27),
    (13, "thesis", 0, 5, 3, 27),      # narrower than its labels
    (13, "linear", 3, 1, 9, 3),       # one column
    (13, "linear", 2, 26, 2, 26),
    (26, "thesis", 0, 53, 2, 64),
    (26, "linear", 3, 9, 3, 9),
]


@pytest.mark.parametrize("labels, arithmetic, fraction_bits, width, height, max_width, stall", by_turns(CASES, (0.0, 0.3)))
def test_matches_golden(labels, arithmetic, fraction_bits, width, height, max_width, stall):
    """A scene, and noise of other sizes before and after it, in a row; where it is wide enough all labels win."""
    config = MatcherConfig(labels=labels, max_width=max_width, method=OnePass(arithmetic, fraction_bits))
    left, right, _ = scene(width, height, labels, seed=5)
    if width >= 2 * labels:
        assert discriminates(match(left, right, config), config)
    pairs = [noise(max(1, width // 2), 2, seed=1), (left, right), noise(min(3, max_width), 1, seed=2)]
    out = run_stream(Matcher(config), [word for pair in pairs for word in pixel_words(*pair)], rng=np.random.default_rng(1),
                     stall_i=stall, stall_o=stall)
    assert [comparable(word) for word in out] == [word for pair in pairs for word in golden_words(*pair, config)]


@pytest.mark.parametrize("config", [
    MatcherConfig(labels=6, max_width=20, method=OnePass(Arithmetic.THESIS)),
    MatcherConfig(labels=6, max_width=20, method=OnePass(Arithmetic.LINEAR)),
    MatcherConfig(labels=26, max_width=20, method=OnePass(Arithmetic.THESIS)),
], ids=str)
def test_latency_and_rate(config):
    dut = Matcher(config)
    width, height = 20, 5
    cycles = {}
    run_stream(dut, pixel_words(*noise(width, height, 1)), rng=np.random.default_rng(1), cycles=cycles)
    latency = np.subtract(cycles["o"], cycles["i"])
    bound = 2 * width * dut.clocks_per_pixel + dut.latency_clocks
    assert latency.max() <= bound
    assert dut.latency_clocks <= 400
    gaps = np.diff(cycles["o"])
    in_line = np.delete(gaps, slice(width - 1, None, width))
    assert in_line.tolist() == [dut.clocks_per_pixel] * len(in_line)


async def apply_settings(ctx, dut, weights, in_use=None, *, pulse=True):
    for name, value in zip(("u1", "u2", "u3", "in_use"), (*weights, in_use or dut.config.labels)):
        ctx.set(getattr(dut, name), value)
    ctx.set(dut.apply_settings, pulse)
    await ctx.tick()
    ctx.set(dut.apply_settings, 0)


ENGINES = [MatcherConfig(labels=6, max_width=16, engine=engine, method=OnePass(arithmetic)) for arithmetic, engine in (
    (Arithmetic.THESIS, Engine.SEQUENTIAL), (Arithmetic.LINEAR, Engine.SEQUENTIAL), (Arithmetic.LINEAR, Engine.STREAMING))]


@pytest.mark.parametrize("config", ENGINES, ids=lambda config: f"{config.engine}-{config.method.arithmetic}")
def test_parameters(config):
    """Built-in ones until the first pulse; new ones from the next frame on, even if they are set while a frame is output."""
    left, right, _ = scene(14, 5, 6, seed=1)
    sets = [(*config.rule.weights, 6), (0, WEIGHT_MAX, 0, 6), (WEIGHT_MAX, 0, 1, 3), (*config.rule.weights, 5), (3, 0, WEIGHT_MAX, 1)]
    expected = [golden_words(left, right, config.with_settings(dict(zip(("u1", "u2", "u3", "in_use"), values)))) for values in sets]
    assert all(a != b for n, a in enumerate(expected) for b in expected[:n])  # each set gives another picture
    dut = Matcher(config)

    async def script(ctx, send_words, given):
        await apply_settings(ctx, dut, (33, 44, 55), 2, pulse=False)  # inputs alone change nothing
        for number, (*weights, in_use) in enumerate(sets):
            await send_words(pixel_words(left, right))
            while len(given) < number * left.size + 1:          # the frame has begun to leave
                await ctx.tick()
            if number + 1 < len(sets):
                await apply_settings(ctx, dut, sets[number + 1][:3], sets[number + 1][3])
                await apply_settings(ctx, dut, weights, in_use, pulse=False)

    given, errors = run_script(dut, script, len(sets) * left.size)
    assert given == [word for words in expected for word in words]
    assert not any(errors)


@pytest.mark.parametrize("stall", [0.0, 0.3])
def test_ragged(stall):
    """Each ``error`` is raised; frames around a ragged one are bit-exact, and that one is output rectangular, bit-exact too."""
    dut = Matcher(MatcherConfig(labels=3, max_width=MAX_WIDTH, method=OnePass(Arithmetic.LINEAR)))
    words = in_a_row()
    frames, pulses = repaired(words)
    expected = [word for pair in frames for word in golden_words(*pair, dut.config)]

    async def script(ctx, send_words, given):
        ctx.set(dut.clear, 1)   # an error is seen for one clock
        await send_words(words)

    given, errors = run_script(dut, script, len(expected), stall=stall)
    assert given == expected
    assert sum(errors) == pulses >= len(RAGGED)


def test_error_stays_until_clear():
    config = MatcherConfig(labels=3, max_width=MAX_WIDTH, method=OnePass(Arithmetic.LINEAR))
    dut = Matcher(config)
    good, ragged = frame(5, 3, seed=9), frame(5, 3)[:8]
    told = []

    async def tell(ctx):
        await ctx.tick().repeat(5)
        told.append(ctx.get(dut.error))

    async def clear(ctx):
        ctx.set(dut.clear, 1)
        await ctx.tick()
        ctx.set(dut.clear, 0)
        await tell(ctx)

    async def script(ctx, send_words, given):
        await send_words(good)
        await ctx.tick().repeat(300)
        await tell(ctx)                 # 0
        await send_words([*ragged, *good])
        await ctx.tick().repeat(300)
        await tell(ctx)                 # 1
        await clear(ctx)                # 0
        await send_words(good)
        await ctx.tick().repeat(300)
        await tell(ctx)                 # 0
        ctx.set(dut.clear, 1)           # an error in the cycle of `clear` is not lost
        await send_words([*ragged, *good])
        ctx.set(dut.clear, 0)

    given, errors = run_script(dut, script, 4 * 15 + 2 * 10)
    assert told == [0, 1, 0, 0]
    rises = [n for n in range(1, len(errors)) if errors[n] and not errors[n - 1]]
    assert len(rises) == 2
    assert len(given) == 4 * 15 + 2 * 10


@pytest.mark.parametrize("cut", [1, 7, 40, 61])
def test_reset_in_mid_frame(cut):
    """Nothing of the frame before a reset is output; the next one is bit-exact, with the built-in weights."""
    config = MatcherConfig(labels=6, max_width=16, method=OnePass(Arithmetic.THESIS))
    left, right, _ = scene(14, 5, 6, seed=1)
    dut = Matcher(config)
    given, errors = after_reset(dut, left, right, cut, lambda ctx: apply_settings(ctx, dut, (1, 2, 3)))
    assert given == golden_words(left, right, config)
    assert not any(errors)


@pytest.mark.parametrize("config", ENGINES, ids=lambda config: f"{config.engine}-{config.method.arithmetic}")
def test_more_labels_in_use_than_there_are(config):
    """As many as there are, whatever of the number the labels' own bits would hold."""
    left, right, _ = scene(14, 5, 6, seed=1)
    dut = Matcher(config)

    async def script(ctx, send_words, given):
        await apply_settings(ctx, dut, config.rule.weights, 256)
        await send_words(pixel_words(left, right))

    given, _ = run_script(dut, script, left.size)
    assert given == golden_words(left, right, config)


@pytest.mark.parametrize("config, message", [
    (MatcherConfig(method=OnePass(Arithmetic.FLOAT)), "the arithmetic float has no gateware; choose thesis or linear"),
    (MatcherConfig(minimum=3), "the method thesis has gateware for the least disparity 0 only, not 3"),
])
def test_refuses(config, message):
    with pytest.raises(ValueError, match=message):
        Matcher(config)


@pytest.mark.parametrize("config, clocks", [
    (MatcherConfig(6, engine=Engine.STREAMING, method=OnePass(Arithmetic.LINEAR)), 2),  # a wave before a line and one past it
    (MatcherConfig(6, method=FUSED_1), 4),                                  # half a census window of seven columns, and the line store
    (MatcherConfig(6, method=FUSED_2), 3),
    (MatcherConfig(6, method=changed(FUSED_1, census_columns=9)), 5),
    (MatcherConfig(6, method=changed(FUSED_1, census_columns=1)), 2),
])
def test_line_clocks(config, clocks):
    """What a line takes beyond its pixels, of each part and of all; frames are counted with it, see test_frame_clocks."""
    dut = Matcher(config)
    Fragment.get(dut, None)  # Amaranth complains of a component that is not used
    assert dut.line_clocks == clocks
    width, height = 100, 7
    assert dut.frame_clocks(width, height + 1) - dut.frame_clocks(width, height) == width + clocks
