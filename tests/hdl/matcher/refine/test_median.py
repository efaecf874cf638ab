import itertools
from dataclasses import replace

import numpy as np
import pytest
from amaranth import Module
from amaranth.hdl import Fragment
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator

from golden.config import FUSED_1, Fused, MatcherConfig, changed
from golden.matcher.fused import labelling, match
from golden.matcher.refine import median
from golden.matcher.sub_pixel import sub_pixel_labels
from golden.matcher.support import arms, fused_cost, support_sizes, support_sums
from golden.pictures.scenes import scene
from hdl.matcher.refine.fill import Fill
from hdl.matcher.refine.median import Median, MedianColumns
from hdl.matcher.stream import DisparityWord, LabelWord
from sim.kit.cases import comparable, label_words, refined_words
from sim.kit.frames import run_frames
from sim.kit.streams import run_stream, send

from ...parts.networks import evaluate


def config_of(disparities=80, max_width=40, *, window=5, sub_pixel=False):
    return MatcherConfig(labels=disparities, max_width=max_width, method=changed(FUSED_1, median_size=window, sub_pixel=sub_pixel))


def picture(rng, config, width, height, share=0.6):
    """Labels of which some are near one another, which passed (about ``share`` of them), and sizes of supports."""
    greatest = config.labels * config.method.disparity_scale - 1
    labels = rng.integers(0, greatest + 1, (height, width))
    two = 2 * config.method.disparity_scale
    near = np.clip(rng.integers(0, greatest + 1) + rng.integers(-two, two + 1, labels.shape), 0, greatest)
    labels = np.where(rng.random(labels.shape) < 0.6, near, labels)
    labels = np.where(rng.random(labels.shape) < 0.2, rng.choice([0, greatest], labels.shape), labels)
    return labels, rng.random((height, width)) < share, rng.integers(1, config.method_as(Fused).arms.support_max + 1, (height, width))


def check(config, sizes, *, seed=1, stall_i=0.0, stall_o=0.0):
    """Frames in a row, the median on for two of three, all with minima of their own; each is exact."""
    rng = np.random.default_rng(seed)
    frames, expected = [], []
    for number, size in enumerate(sizes):
        labels, passed, n = picture(rng, config, *size, rng.choice([0.0, 0.6, 1.0]))
        inputs = {"enable": int(number % 3 != 1), "minimum": int(rng.choice([0, 1, 255, rng.integers(256)]))}
        frames.append((label_words(labels, passed, n), inputs))
        expected += refined_words(labels, passed, n, config, **inputs)
    given = run_frames(Median(config), frames, rng=rng, stall_i=stall_i, stall_o=stall_o, timeout=500)
    assert [comparable(word) for word in given] == expected


STALLS = [(0.0, 0.0), (0.4, 0.0), (0.0, 0.4), (0.3, 0.3)]


# Slow: with one window and stall what is seen with the others, by turns.
@pytest.mark.parametrize("window, stall_i, stall_o", [
    pytest.param(window, *stalls, marks=pytest.mark.slow if (n + number) % 2 else [])
    for n, window in enumerate((5, 3)) for number, stalls in enumerate(STALLS)])
def test_matches_golden(window, stall_i, stall_o):
    rng = np.random.default_rng(2)
    sizes = [(1, 1), (40, 3), (1, 8), (40, 1), *((int(rng.integers(1, 41)), int(rng.integers(1, 9))) for _ in range(5))]
    check(config_of(window=window), sizes, stall_i=stall_i, stall_o=stall_o)


@pytest.mark.parametrize("window", [3, 5])
def test_small_frames(window):
    """All sizes of one to five lines and columns, narrow frames hard behind wide ones."""
    sizes = [(width, height) for height in range(1, 6) for width in (5, 1, 4, 2, 3)]
    check(config_of(max_width=5, window=window), sizes)


def test_narrowest_memory():
    check(config_of(max_width=1), [(1, 1), (1, 5), (1, 2), (1, 3)], stall_o=0.2)


@pytest.mark.parametrize("disparities, sub_pixel, window", [(2, False, 5), (128, False, 3), (80, True, 5), (3, True, 3), (128, True, 5)])
def test_labels(disparities, sub_pixel, window):
    check(config_of(disparities, 9, window=window, sub_pixel=sub_pixel), [(9, 4), (3, 6), (9, 1)], stall_i=0.2, stall_o=0.2)


@pytest.mark.parametrize("window", [3, 5])
@pytest.mark.parametrize("width", [1, 2, 3, 12, 50])
def test_rate_and_latency(width, window):
    """Lines of a frame pass without a pause but for replicated columns and lines; the frame's end does not wait for the next frame."""
    config = config_of(max_width=50, window=window)
    rng = np.random.default_rng(1)
    dut = Median(config)
    line = width + dut.line_clocks
    cycles = {}
    heights = (4, 1, 2)
    frames = [(label_words(*picture(rng, config, width, height)), {"enable": n % 2, "minimum": n}) for n, height in enumerate(heights)]
    run_frames(dut, frames, rng=rng, cycles=cycles)
    tops = np.cumsum([0, *(height + dut.frame_lines for height in heights)])
    places = [(top + y) * line + x for top, height in zip(tops, heights) for y in range(height) for x in range(width)]
    assert (np.array(cycles["i"]) - cycles["i"][0]).tolist() == places
    assert np.unique(np.subtract(cycles["o"], cycles["i"])).tolist() == [dut.lines * line + dut.latency]


def test_output_may_wait():
    """While nothing is taken, no more is let in than the output queue has room for; then all is there."""
    config = config_of(max_width=12)
    rng = np.random.default_rng(1)
    dut = Median(config)
    labels, passed, n = picture(rng, config, 12, 12)
    given = []

    async def sink(ctx):
        await ctx.tick().repeat(200)
        ctx.set(dut.o.ready, 1)
        async for _, _, valid, payload in ctx.tick().sample(dut.o.valid, dut.o.payload):
            given.extend([comparable(payload)] if valid else [])
            if len(given) == labels.size:
                break

    async def source(ctx):
        ctx.set(dut.enable, 1)
        await send(ctx, dut.i, label_words(labels, passed, n), rng=rng)

    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_testbench(source)
    sim.add_testbench(sink)
    sim.run_until(5e-3)
    assert given == refined_words(labels, passed, n, config)


@pytest.mark.parametrize("window", [3, 5])
def test_median_of_columns(window):
    """Between the columns there is noise; what is not a column is not ``done``."""
    config = config_of(window=window)
    rng = np.random.default_rng(1)
    labels, *_ = picture(rng, config, 20, 4)
    dut = MedianColumns(config)
    columns = np.pad(labels, ((2, 2), (0, 2)), mode="edge")
    given, valids, done = [], [], []

    async def testbench(ctx):
        async def step(valid, opens, column):
            valids.append(valid)
            ctx.set(dut.valid, valid)
            ctx.set(dut.opens, opens)
            ctx.set(dut.i, column)
            done.append(ctx.get(dut.done))
            if done[-1]:
                given.append(ctx.get(dut.o))
            await ctx.tick()

        for y in range(labels.shape[0]):
            for x in range(columns.shape[1]):
                while rng.random() < 0.4:
                    await step(0, int(rng.integers(2)), rng.integers(0, 80, 5).tolist())
                await step(1, int(x == 0), columns[y:y + 5, x].tolist())
        for _ in range(dut.latency):
            await step(0, 0, [0] * 5)

    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_testbench(testbench)
    sim.run()
    assert done == [0] * dut.latency + valids[:-dut.latency]
    assert np.reshape(given, (4, 22))[:, 2:].tolist() == median(labels, window).tolist()


class Chain(wiring.Component):
    """Fill and median, as they follow the rule."""
    def __init__(self, config):
        self.fill, self.median = Fill(config), Median(config)
        super().__init__({"i": In(stream.Signature(LabelWord(config))),
                          "o": Out(stream.Signature(DisparityWord(config))), "minimum": In(8)})

    def elaborate(self, platform):
        m = Module()
        m.submodules.fill, m.submodules.median = self.fill, self.median
        wiring.connect(m, wiring.flipped(self.i), self.fill.i)
        wiring.connect(m, self.fill.o, self.median.i)
        wiring.connect(m, self.median.o, wiring.flipped(self.o))
        m.d.comb += [self.fill.enable.eq(1), self.median.enable.eq(1), self.median.minimum.eq(self.minimum)]
        return m


@pytest.mark.parametrize("sub_pixel", [False, True])
def test_behind_the_rule(sub_pixel):
    """A scene's labels through both stages are bit-exact with the whole golden model."""
    config = replace(config_of(6, sub_pixel=sub_pixel), minimum=2)
    left, right, _ = scene(36, 9, 6, seed=5)
    expected = match(left, right, config)
    assert 0 < expected.passed.sum() < expected.passed.size
    both_arms = arms(left, config.method.arms)
    sizes = support_sizes(*both_arms)
    sums = support_sums(fused_cost(left, right, config), *both_arms)
    labels = labelling(sums, sizes, left, config)
    if sub_pixel:
        labels = sub_pixel_labels(sums, labels, expected.passed)
    given = run_stream(Chain(config), label_words(labels, expected.passed, sizes), rng=np.random.default_rng(1), inputs={"minimum": 2})
    for name in ("disparity", "passed", "confidence"):
        assert [word[name] for word in given] == getattr(expected, name).ravel().tolist()


def columns_of(side):
    """All windows of sorted columns of zeros and ones, by the zero-one principle as good as all windows."""
    return np.array(list(itertools.product(range(side + 1), repeat=side)))[:, :, None] > np.arange(side - 1, -1, -1)


@pytest.mark.parametrize("side", [3, 5])
def test_networks_select_the_median(side):
    """Every window of zeros and ones through the networks behind the sorted columns."""
    dut = MedianColumns(config_of(window=side))
    Fragment.get(dut, None)  # used, as far as Amaranth is concerned
    windows = columns_of(side).astype(int)
    assert len(windows) == (side + 1)**side
    columns = [windows[:, n] for n in range(side)]
    pairs = [evaluate(dut.pair, np.hstack(columns[n:n + 2])) for n in range(0, side - 1, 2)]
    left = evaluate(dut.pairs, np.hstack(pairs)) if dut.pairs else pairs[0]
    median = evaluate(dut.select, np.hstack([left, columns[-1]]))
    assert median[:, 0].tolist() == np.median(windows.reshape(len(windows), -1), axis=1).tolist()
    # Nothing is computed in vain.
    networks = [dut.sort, dut.pair, *([dut.pairs] if dut.pairs else []), dut.select]
    assert [sum(map(len, network.levels)) for network in networks] == {3: [3, 6, 6], 5: [9, 13, 25, 10]}[side]
    # And the columns are sorted.
    columns = np.array(list(itertools.product(range(2), repeat=side)))
    assert evaluate(dut.sort, columns).tolist() == np.sort(columns).tolist()
