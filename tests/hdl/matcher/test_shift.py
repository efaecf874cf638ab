from itertools import pairwise

import numpy as np
import pytest
from amaranth.sim import Simulator

from golden.config import MatcherConfig
from golden.matcher.cost import aligned
from hdl.matcher.shift import RightShift
from sim.kit.cases import comparable, noise, pixel_words
from sim.kit.streams import check_rules, receive, run_stream, send


def shift(lead=0):
    return RightShift(MatcherConfig(labels=2, minimum=-lead))


def shifted(words, minimum):
    """What the component's docstring makes of any sequence of words, of whole frames or not."""
    starts = [True, *(bool(word["last"] or word["end"]) for word in words[:-1])]
    line: list = []
    result = []
    for word, start in zip(words, starts):
        if start or word["first"]:
            line = []
        line.append(word["right"])
        result.append({**word, "right": line[max(0, len(line) - 1 - minimum)]})
    return result


def run(words, minimum, **options):
    out = run_stream(shift(), words, rng=np.random.default_rng(1), inputs={"minimum": minimum}, **options)
    return [comparable(word) for word in out]


@pytest.mark.parametrize("stall", [0.0, 0.4])
@pytest.mark.parametrize("minimum", [0, 1, 2, 3, 8, 255])
def test_matches_golden(minimum, stall):
    """Frames of several sizes in a row, narrower and wider than the shift."""
    pairs = [noise(*size, seed) for seed, size in enumerate([(12, 3), (1, 1), (3, 2), (1, 4), (4, 2), (2, 3)])]
    words = [word for pair in pairs for word in pixel_words(*pair)]
    expected = [word for left, right in pairs for word in pixel_words(*aligned(left, right, minimum))]
    assert run(words, minimum, stall_i=stall, stall_o=stall) == expected


@pytest.mark.parametrize("minimum", [0, 1, 200, 254, 255])
def test_wide(minimum):
    """Lines longer than the ring."""
    left, right = noise(600, 2, 1)
    assert run(pixel_words(left, right), minimum) == pixel_words(*aligned(left, right, minimum))


@pytest.mark.parametrize("minimum", [-64, -63, -1, 0, 1, 255])
def test_behind_a_lead(minimum):
    """Lines that are wider by a lead of 64: the right picture is shifted by 64 more."""
    pair = noise(400, 2, 1)
    ahead, expected = (pixel_words(*aligned(*pair, least, 64)) for least in (-64, minimum))
    out = run_stream(shift(64), ahead, rng=np.random.default_rng(1), inputs={"minimum": minimum})
    assert [comparable(word) for word in out] == expected


def test_latency_and_rate():
    cycles = {}
    run_stream(shift(), pixel_words(*noise(9, 3, 1)), rng=np.random.default_rng(1), inputs={"minimum": 2}, cycles=cycles)
    assert cycles["o"] == [cycle + RightShift.latency for cycle in cycles["i"]]
    assert all(b - a == 1 for a, b in pairwise(cycles["o"]))


@pytest.mark.parametrize("stall", [0.0, 0.4])
def test_minimum_is_sampled_at_first(stall):
    """Any value between: each frame keeps that of its first pixel."""
    minimums = [3, 0, 5, 1, 2, 0, 255, 4]
    pairs = [noise(7, 2, seed) for seed in range(len(minimums))]
    dut = shift()
    rng = np.random.default_rng(2)
    taken, given = [], []
    words = [word for pair in pairs for word in pixel_words(*pair)]

    async def source(ctx):
        coming = iter(minimums)
        for word in words:
            ctx.set(dut.minimum, next(coming) if word["first"] else int(rng.integers(256)))
            await send(ctx, dut.i, [word], rng=rng)
            ctx.set(dut.minimum, int(rng.integers(256)))
            while rng.random() < stall:
                await ctx.tick()

    async def sink(ctx):
        await receive(ctx, dut.o, len(words), rng=rng, stall=stall, timeout=100)

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(source)
    simulator.add_testbench(sink)
    simulator.add_testbench(check_rules(dut.i, taken), background=True)
    simulator.add_testbench(check_rules(dut.o, given), background=True)
    simulator.run()
    expected = [word for (left, right), minimum in zip(pairs, minimums) for word in pixel_words(*aligned(left, right, minimum))]
    assert [comparable(word) for word in given] == expected


@pytest.mark.parametrize("stall", [0.0, 0.3])
@pytest.mark.parametrize("minimum", [0, 1, 3, 6])
def test_ragged(minimum, stall):
    """Flags at random: every word is output, and each good frame between is bit-exact."""
    rng = np.random.default_rng(minimum)
    words, good = [], []
    for seed in range(20):
        left, right = noise(int(rng.integers(1, 9)), int(rng.integers(1, 4)), seed)
        frame = pixel_words(left, right)
        words += [{**word, **{flag: word[flag] ^ (rng.random() < 0.15) for flag in ("first", "last", "end")}} for word in frame]
        good.append((len(words), pixel_words(*aligned(left, right, minimum))))
        words += frame
    # Before the first word marked `first` the minimum is not known.
    words[0]["first"] = 1
    out = run(words, minimum, stall_i=stall, stall_o=stall)
    assert out == shifted(words, minimum)
    for start, frame in good:
        assert out[start:start + len(frame)] == frame


def test_model_of_ragged_frames():
    """The oracle above, by hand: a line ends with ``last``, with ``end``, or before ``first``."""
    plain = {"left": 0, "first": 0, "last": 0, "end": 0}
    words = [{**plain, "right": right, **flags} for right, flags in (
        (1, {"first": 1}), (2, {}), (3, {"last": 1}), (4, {}), (5, {}), (6, {"end": 1}), (7, {}), (8, {}), (9, {"first": 1}), (10, {}))]
    assert [word["right"] for word in shifted(words, 1)] == [1, 1, 2, 4, 4, 5, 7, 7, 9, 9]
