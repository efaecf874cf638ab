# amaranth: UnusedElaboratable=no
"""hdl.rig.rectifier: bit-exact with golden.rig, whatever the map, the stalls and the frames before."""

import dataclasses
from itertools import pairwise

import numpy as np
import pytest
from amaranth.sim import Simulator

from golden.rig.lines import lines_needed
from golden.rig.maps import grid, identity, pack
from golden.rig.rectify import rectify
from hdl.rig.rectifier import Rectifier
from sim.kit.cases import comparable, noise, pixel_words
from sim.kit.ragged import MAX_WIDTH, RAGGED, in_a_row, repaired
from sim.kit.rig_cases import camera_map, noise_map, rectified_words
from sim.kit.streams import check_rules, run_stream, send


SIDES = ("left", "right")
LEFT = ("left", "first", "last", "end")


def rectifier(width, height, maps=(), lines=22):
    return Rectifier(width, height, lines, maps={side: pack(which) for side, which in zip(SIDES, maps)})


def left_words(picture):
    """Payloads of a rectifier of one camera."""
    return [{name: word[name] for name in LEFT} for word in pixel_words(picture, picture)]


def left_rectifier(which, lines=22):
    return Rectifier(which.width, which.height, lines, sides=("left",), maps={"left": pack(which)})


def run(dut, words, *, enable=1, stall=0.0, **options):
    out = run_stream(dut, words, rng=np.random.default_rng(1), inputs={"enable": enable}, stall_i=stall, stall_o=stall, drain=60, **options)
    return [comparable(word) for word in out]


def both(width, height, *cameras):
    maps = [camera_map(width, height, **camera) for camera in cameras]
    assert lines_needed(maps) <= 22
    return maps


# Sizes of a picture, and a map for each camera. One fits in a cell; one ends where a cell does; one has a cell of a single pixel, and row.
CASES = {
    "a cell": ((20, 9), both(20, 9, {"roll": 3, "aside": 2.3}, {"offset": -2.4, "gain": 255})),
    "whole cells": ((64, 17), both(64, 17, {"lens": -0.3, "offset": 3}, {"roll": -4, "lens": 0.2, "gain": 200})),
    "a pixel more": ((65, 33), [noise_map(65, 33, 150, 1), noise_map(65, 33, 150, 2)]),
    "narrow": ((3, 34), [noise_map(3, 34, 100, 3), noise_map(3, 34, 100, 4)]),
    "far outside": ((33, 9), [noise_map(33, 9, 2000, 5), noise_map(33, 9, 100, 6)]),
    "smallest": ((2, 2), [noise_map(2, 2, 40, 7), noise_map(2, 2, 40, 8)]),
}


# Slow: what the others have, too.
@pytest.mark.parametrize("name", [pytest.param(name, marks=pytest.mark.slow if name in ("narrow", "whole cells") else [])
                                  for name in CASES])
def test_matches_golden(name):
    """Two frames; small ones also with stalls."""
    (width, height), maps = CASES[name]
    pairs = [noise(width, height, seed) for seed in (1, 2)]
    stalls = [0.0] if width * height > 400 else [0.0, 0.4]
    for stall in stalls:
        words = [word for pair in pairs[:len(stalls)] for word in pixel_words(*pair)]
        assert run(rectifier(width, height, maps), words, stall=stall) == [word for pair in pairs[:len(stalls)]
                                                                          for word in rectified_words(pair, maps)]


def test_lines_that_end_while_the_map_is_read():
    """A map for pictures of 18 columns does for fewer, too: the words for the cell beyond are given up at any place."""
    which = noise_map(18, 3, 90, 1)
    words, wanted = [], []
    for width in range(10, 19):
        picture, = noise(width, 3, width, pictures=1)
        words += left_words(picture)
        wanted += left_words(rectify(picture, dataclasses.replace(which, width=width)))
    assert run(left_rectifier(which), words) == wanted


def test_latency_and_rate():
    """A line leaves when the row below it has arrived; the last lines at a pixel a clock and the clocks of a line."""
    width, height = 37, 5
    cycles = {}
    run(left_rectifier(identity(width, height)), left_words(*noise(width, height, 1, pictures=1)), cycles=cycles)
    starts = cycles["o"][::width]
    assert starts[0] == cycles["i"][2 * width - 1] + Rectifier.latency
    assert {b - a for a, b in pairwise(starts[:-1])} == {width + Rectifier.line_clocks}
    assert cycles["o"][-1] - starts[-1] == width - 1


@pytest.mark.parametrize("enable", [0, 1])
def test_slow_consumer(enable):
    """Much less than a pixel a clock is accepted: what is in flight finds room."""
    picture, = noise(30, 4, 1, pictures=1)
    out = run_stream(left_rectifier(identity(30, 4)), left_words(picture), rng=np.random.default_rng(1), inputs={"enable": enable},
                     stall_o=0.9)
    assert [comparable(word) for word in out] == left_words(picture)


def test_off_copies_anything():
    """Words of any flags, from the first ``first`` on."""
    rng = np.random.default_rng(3)
    words = [{"left": int(rng.integers(256)), "right": int(rng.integers(256)),
              **{flag: int(rng.random() < 0.2) for flag in ("first", "last", "end")}} for _ in range(200)]
    words[0]["first"] = 1
    for stall in (0.0, 0.4):
        assert run(rectifier(4, 4), words, enable=0, stall=stall) == words


def drive(dut, frames, *, drain=400, stall=0.0):
    """Send frames, each with what is set as its first word is offered; return the output and what was counted.

    A frame is its words and a dictionary of inputs; ``"load"`` is a pair of maps that is written before, and ``"swap"`` swaps.
    """
    rng = np.random.default_rng(5)
    given, taken, told = [], [], {"error": 0}

    async def source(ctx):
        for words, inputs in frames:
            for number, which in enumerate(inputs.get("load", ())):
                for address, word in enumerate(pack(which)):
                    ctx.set(dut.map_write, 1 << number)
                    ctx.set(dut.map_address, address)
                    ctx.set(dut.map_data, word)
                    await ctx.tick()
            ctx.set(dut.map_write, 0)
            ctx.set(dut.swap, inputs.get("swap", 0))
            await ctx.tick()
            ctx.set(dut.swap, 0)
            ctx.set(dut.enable, inputs.get("enable", 1))
            await send(ctx, dut.i, words[:1], rng=rng, stall=stall)
            if sum(word["first"] for word in words) == 1:
                ctx.set(dut.enable, int(rng.integers(2)))
            await send(ctx, dut.i, words[1:], rng=rng, stall=stall)

    async def sink(ctx):
        idle = 0
        while idle < drain:
            ctx.set(dut.o.ready, rng.random() >= stall)
            _, _, valid = await ctx.tick().sample(dut.o.valid)
            idle = 0 if valid else idle + 1
        told.update(fault=ctx.get(dut.fault), abandoned=ctx.get(dut.abandoned), swapping=ctx.get(dut.swapping))
        ctx.set(dut.clear, 1)
        await ctx.tick()
        ctx.set(dut.clear, 0)
        told["cleared"] = (ctx.get(dut.fault), ctx.get(dut.abandoned))

    async def errors(ctx):
        async for _, _, error in ctx.tick().sample(dut.error):
            told["error"] += error

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(source)
    simulator.add_testbench(sink)
    for testbench in (errors, check_rules(dut.i, taken), check_rules(dut.o, given)):
        simulator.add_testbench(testbench, background=True)
    simulator.run()
    assert len(taken) == sum(len(words) for words, _ in frames)
    return [comparable(word) for word in given], told


# Slow: without stalls, which leaves less to go wrong.
@pytest.mark.parametrize("stall", [pytest.param(0.0, marks=pytest.mark.slow), 0.4])
def test_settings_change_between_frames(stall):
    """On and off, a map that is loaded but not swapped, swapped in the next frame, and another size."""
    width, height = 35, 8
    one, two = ([noise_map(width, height, 90, seed) for seed in seeds] for seeds in ((1, 2), (3, 4)))
    pairs = [noise(width, height, seed) for seed in range(6)]
    small, plain = noise(3, 5, 9), [identity(3, 5)] * 2
    words = [pixel_words(*pair) for pair in pairs]
    frames = [
        (words[0], {}), (words[1], {"enable": 0}), (words[2], {"load": two}), (words[3], {"swap": 1}), (words[4], {"enable": 0}),
        (words[5], {}), (pixel_words(*small), {"load": plain, "swap": 1}),
    ]
    expected = [*rectified_words(pairs[0], one), *words[1], *rectified_words(pairs[2], one), *rectified_words(pairs[3], two), *words[4],
                *rectified_words(pairs[5], two), *pixel_words(*small)]
    given, told = drive(rectifier(width, height, one), frames, stall=stall)
    assert given == expected
    assert told == {"error": 0, "fault": 0, "abandoned": 0, "swapping": 0, "cleared": (0, 0)}


def test_ragged_frames():
    """Every kind between good frames: what the line store's model makes of them, and as many errors."""
    words = in_a_row()
    frames, errors = repaired(words)
    given, told = drive(left_rectifier(identity(MAX_WIDTH, 6)), [([{name: word[name] for name in LEFT} for word in words], {})])
    assert given == [word for pair in frames for word in left_words(pair[0])]
    assert told["error"] == errors > len(RAGGED) - 2 and not told["fault"]


def test_too_many_lines():
    high, good = noise(4, 7, 1), noise(4, 5, 2)
    given, told = drive(Rectifier(4, 5, 22), [(pixel_words(*high) + pixel_words(*good), {})])
    assert given == pixel_words(*(side[:5] for side in high)) + pixel_words(*good)
    assert told["error"] == 1


def steep(width, height, dy, bound):
    """A map that reads ``dy`` lines further down in column 32, with these row bounds."""
    which = identity(width, height)
    shift = np.zeros(grid(width, height), int)
    shift[:, 1:] = 32 * dy
    return dataclasses.replace(which, dy=shift, bounds=np.full(len(which.bounds), bound))


@pytest.mark.parametrize("dy, bound", [(20, 0), (0, -20)])
def test_as_many_lines_as_there_are(dy, bound):
    which = steep(34, 30, dy, bound)
    assert lines_needed([which]) == 22
    picture, = noise(34, 30, 1, pictures=1)
    assert run(left_rectifier(which), left_words(picture)) == left_words(rectify(picture, which))


def test_rows_in_flight_are_kept():
    """The last pixels of a line read its first row, at its start, and wait for a slow consumer: the row must not be free before."""
    which = steep(34, 24, 0, 0)
    dx, dy = np.zeros_like(which.dx), np.zeros_like(which.dy)
    dx[:, 1:], dy[:, :1] = -32 * 32, 20 * 32
    which = dataclasses.replace(which, dx=dx, dy=dy)
    assert lines_needed([which]) == 22
    picture, = noise(34, 24, 1, pictures=1)
    out = run_stream(left_rectifier(which), left_words(picture), rng=np.random.default_rng(1), inputs={"enable": 1}, stall_o=0.9)
    assert [comparable(word) for word in out] == left_words(rectify(picture, which))


# Slow: a row that is far away blocks as one that is near.
@pytest.mark.parametrize("dy, bound", [(21, 0), (0, -21), pytest.param(-60, -60, marks=pytest.mark.slow)])
def test_map_of_too_many_lines(dy, bound):
    """A row is missing for a pixel, or for a line: what was output stays, the rest is black, and the next frame is exact."""
    width, height = 34, 30
    bad, good = steep(width, height, dy, bound), noise_map(width, height, 60, 1)
    assert lines_needed([bad]) > 22
    pictures = noise(width, height, 1)
    frames = [(left_words(pictures[0]), {}), (left_words(pictures[1]), {"load": [good], "swap": 1})]
    given, told = drive(left_rectifier(bad), frames)
    size = width * height
    assert given[size:] == left_words(rectify(pictures[1], good))
    wanted = left_words(rectify(pictures[0], bad))
    first = next((n for n, (word, other) in enumerate(zip(given, wanted)) if word != other), size)
    assert 0 < first < size - width
    flags = ("first", "last", "end")
    assert [[word[flag] for flag in flags] for word in given[:size]] == [[word[flag] for flag in flags] for word in wanted]
    assert {word["left"] for word in given[first:size]} == {0}
    assert told == {"error": 0, "fault": 1, "abandoned": 1, "swapping": 0, "cleared": (0, 0)}


@pytest.mark.parametrize("lines", [0, 21, 24, 35])
def test_lines_refused(lines):
    with pytest.raises(ValueError, match=f"a rectifier can hold 22, 34, 44, 56, 68 lines, not {lines}"):
        Rectifier(64, 48, lines)


def test_sizes_refused():
    with pytest.raises(ValueError, match="max_width of a rectifier must be from 2 to 4096, not 1"):
        Rectifier(1, 48)
    with pytest.raises(ValueError, match="max_height of a rectifier must be from 2 to 4096, not 5000"):
        Rectifier(64, 5000)


def test_one_camera():
    which = noise_map(20, 9, 90, 1)
    picture, = noise(20, 9, 1, pictures=1)
    assert run(left_rectifier(which), left_words(picture)) == left_words(rectify(picture, which))
