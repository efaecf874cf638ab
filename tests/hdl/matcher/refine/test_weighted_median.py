from dataclasses import replace

import numpy as np
import pytest
from amaranth import Module
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator

from golden.config import RECURSIVE_1, MatcherConfig, changed
from golden.matcher.recursive.method import match, stages
from golden.matcher.recursive.weighted_median import votes, weighted_median
from golden.pictures.scenes import scene
from hdl.matcher.refine.border_fill import BorderFill
from hdl.matcher.refine.weighted_median import Votes, WeightedMedian, WeightedMedianColumns
from hdl.matcher.stream import DisparityWord, LabelWord
from sim.kit.cases import comparable, label_words, weighted_words
from sim.kit.frames import run_frames
from sim.kit.streams import run_stream


def config_of(labels=6, max_width=20, *, minimum=0, sub_pixel=False):
    return MatcherConfig(labels=labels, max_width=max_width, minimum=minimum, method=changed(RECURSIVE_1, sub_pixel=sub_pixel))


def grey_levels(rng, height, width):
    """Grey levels whose differences reach and miss each threshold by one."""
    near = rng.integers(0, 256) + rng.choice([0, 16, 17, 32, 33, 64, 65, -16, -17, -32, -33, -64, -65, 30, -30], (height, width))
    return np.where(rng.random((height, width)) < 0.1, rng.choice([0, 255], (height, width)), np.clip(near, 0, 255))


def picture(rng, config, width, height):
    """Labels of which some are near one another, which passed, sizes of supports, and grey levels."""
    greatest = (config.labels - 1) * config.method.disparity_scale
    labels = rng.integers(0, greatest + 1, (height, width))
    two = 2 * config.method.disparity_scale
    near = np.clip(rng.integers(0, greatest + 1) + rng.integers(-two, two + 1, labels.shape), 0, greatest)
    labels = np.where(rng.random(labels.shape) < rng.choice([0.3, 0.8]), near, labels)
    labels = np.where(rng.random(labels.shape) < 0.2, rng.choice([0, greatest], labels.shape), labels)
    return (labels, rng.random((height, width)) < rng.choice([0.0, 0.6, 1.0]),
            rng.integers(1, config.refined.arms.support_max + 1, (height, width)), grey_levels(rng, height, width))


def check(config, sizes, *, seed=1, stall_i=0.0, stall_o=0.0):
    """Frames in a row, the median on for two of three, all with minima of their own; each is exact."""
    rng = np.random.default_rng(seed)
    frames, expected = [], []
    for number, size in enumerate(sizes):
        part = picture(rng, config, *size)
        inputs = {"enable": int(number % 3 != 1), "minimum": int(rng.choice([min(config.minimum, 0), 0, 1, 255, rng.integers(256)]))}
        frames.append((label_words(*part), inputs))
        expected += weighted_words(*part, config, **inputs)
    given = run_frames(WeightedMedian(config), frames, rng=rng, stall_i=stall_i, stall_o=stall_o, timeout=500)
    assert [comparable(word) for word in given] == expected


# Slow: one stall at a time, where the last has both.
@pytest.mark.parametrize("stall_i, stall_o", [
    (0.0, 0.0), *(pytest.param(*stalls, marks=pytest.mark.slow) for stalls in ((0.4, 0.0), (0.0, 0.4))), (0.3, 0.3)])
def test_matches_golden(stall_i, stall_o):
    """Frames of all sizes in a row, the narrowest behind the widest."""
    check(config_of(), [(1, 1), (20, 4), (1, 8), (20, 1), (13, 9), (2, 3), (7, 7)], stall_i=stall_i, stall_o=stall_o)


def test_small_frames():
    """All sizes of one to five lines and columns, narrow frames hard behind wide ones."""
    check(config_of(3, 5), [(width, height) for height in range(1, 6) for width in (5, 1, 4, 2, 3)])


def test_narrowest_memory():
    check(config_of(max_width=1), [(1, 1), (1, 9), (1, 2), (1, 3)], stall_o=0.2)


@pytest.mark.parametrize("labels, minimum, sub_pixel", [(2, 0, False), (2, -3, True), (80, -64, False), (256, 0, False), (256, -1, True)])
def test_labels(labels, minimum, sub_pixel):
    check(config_of(labels, 9, minimum=minimum, sub_pixel=sub_pixel), [(9, 4), (3, 6), (9, 1), (8, 3)], stall_i=0.2, stall_o=0.2)


@pytest.mark.parametrize("width", [1, 2, 3, 12])
def test_rate_and_latency(width):
    """Lines of a frame pass without a pause but for replicated columns and lines; the frame's end does not wait for the next frame."""
    config = config_of(3, 12)
    rng = np.random.default_rng(1)
    dut = WeightedMedian(config)
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
    """While little is taken, no more is let in than the output queue has room for; then all is there."""
    config = config_of(2, 12)
    rng = np.random.default_rng(1)
    part = picture(rng, config, 12, 6)
    inputs = {"enable": 1, "minimum": 0}
    given = run_stream(WeightedMedian(config), label_words(*part), rng=rng, stall_o=0.97, inputs=inputs)
    assert [comparable(word) for word in given] == weighted_words(*part, config)


def test_votes():
    """Every pixel of the window, each difference about the thresholds, and the greatest ones."""
    rng = np.random.default_rng(1)
    width = 120
    grey, passed = grey_levels(rng, 7, width), rng.random((7, width)) < 0.5
    grey[:, :7], grey[3, 3] = 0, 255
    grey, passed = (np.pad(part, ((0, 0), (0, 3)), mode="edge") for part in (grey, passed))
    dut = Votes(config_of())

    async def testbench(ctx):
        for x in range(width + 3 + Votes.LATENCY):
            if x < width + 3:
                ctx.set(dut.grey, grey[:, x].tolist())
            ctx.set(dut.advance, 1)
            ctx.set(dut.opens, int(x == 0))
            ctx.set(dut.passed, sum(int(bit) << line for line, bit in enumerate(passed[:, min(max(x - 1, 0), width + 2)])))
            await ctx.tick()
            found.append([ctx.get(dut.o[n]) for n in range(49)])

    found: list[list[int]] = []
    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_testbench(testbench)
    sim.run()
    differences = set()
    for x in range(width):
        window = np.array([[max(x + n, 0), line] for n in range(3, -4, -1) for line in range(7)])
        difference = grey[window[:, 1], window[:, 0]].astype(int) - int(grey[3, x])
        differences |= {*difference.tolist()}
        expected = [int(vote).bit_length() for vote in votes(np.abs(difference), passed[window[:, 1], window[:, 0]])]
        assert found[x + 3 + Votes.LATENCY - 1] == expected
    assert differences >= {sign * (limit + n) for limit in (16, 32, 64) for n in (0, 1) for sign in (-1, 1)} | {-255, 255}


def test_median_of_columns():
    """Between the columns there is noise; what is not a column is not ``done``."""
    config = config_of(5)
    rng = np.random.default_rng(1)
    labels, passed, _, grey = picture(rng, config, 14, 3)
    expected = weighted_median(labels, passed, grey)
    parts = [np.pad(part, ((3, 3), (0, 3)), mode="edge").astype(int) for part in (labels, passed, grey)]
    dut = WeightedMedianColumns(config)
    given, valids, done = [], [], []

    async def testbench(ctx):
        async def step(valid, opens, y, x):
            valids.append(valid)
            ctx.set(dut.valid, valid)
            ctx.set(dut.opens, opens)
            label, which, grey = (part[y:y + 7, x].tolist() for part in parts)
            ctx.set(dut.i, {"label": label, "passed": sum(bit << line for line, bit in enumerate(which)), "size": 0, "grey": grey})
            done.append(ctx.get(dut.done))
            if done[-1]:
                given.append(ctx.get(dut.o))
            await ctx.tick()

        for y in range(3):
            for x in range(17):
                while rng.random() < 0.4:
                    await step(0, int(rng.integers(2)), int(rng.integers(3)), int(rng.integers(17)))
                await step(1, int(x == 0), y, x)
        for _ in range(dut.latency):
            await step(0, 0, 0, 0)

    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_testbench(testbench)
    sim.run()
    assert done == [0] * dut.latency + valids[:-dut.latency]
    assert np.reshape(given, (3, 17))[:, 3:].tolist() == expected.tolist()


class Chain(wiring.Component):
    """Fill and median, as they follow the costs."""
    def __init__(self, config):
        self.fill, self.median = BorderFill(config), WeightedMedian(config)
        super().__init__({"i": In(stream.Signature(LabelWord(config))), "o": Out(stream.Signature(DisparityWord(config))),
                          "minimum": In(self.median.minimum.shape())})

    def elaborate(self, platform):
        m = Module()
        m.submodules.fill, m.submodules.median = self.fill, self.median
        wiring.connect(m, wiring.flipped(self.i), self.fill.i)
        wiring.connect(m, self.fill.o, self.median.i)
        wiring.connect(m, self.median.o, wiring.flipped(self.o))
        m.d.comb += [self.fill.enable.eq(1), self.median.enable.eq(1), self.median.minimum.eq(self.minimum)]
        return m


@pytest.mark.parametrize("minimum, sub_pixel", [(2, False), (-2, True)])
def test_behind_the_costs(minimum, sub_pixel):
    """A scene's labels through both stages are bit-exact with the whole golden model."""
    config = replace(config_of(6, 36, sub_pixel=sub_pixel), minimum=minimum)
    left, right, _ = scene(36, 9, 6, seed=5)
    expected, found = match(left, right, config), stages(left, right, config)
    assert 0 < found.passed.sum() < found.passed.size
    words = label_words(found.found, found.passed, found.support_size, left)
    given = run_stream(Chain(config), words, rng=np.random.default_rng(1), inputs={"minimum": minimum})
    for name in ("disparity", "passed", "confidence"):
        assert [word[name] for word in given] == getattr(expected, name).ravel().tolist()
