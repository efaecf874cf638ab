"""hdl.matcher.streaming.waves: what waves carry on lines longer than its counter of columns counts; the arrays' tests show the rest."""

import numpy as np
import pytest
from amaranth.sim import Simulator

from golden.config import FUSED_1, MatcherConfig, changed
from golden.matcher.vertical import alike
from hdl.matcher.streaming.fused_array import FusedArray
from hdl.matcher.streaming.waves import WaveSource
from sim.kit.cases import engine_words, noise
from sim.kit.streams import send


@pytest.mark.parametrize("minimum, vertical", [(0, 0), (3, 0), (255, 0), (3, 1)])
def test_long_lines(minimum, vertical):
    """A right column is there from the least disparity to the end of the line; waves without a pixel follow the frame alone."""
    width, height = 600, 2
    config = MatcherConfig(2, width, minimum, method=changed(FUSED_1, census_rows=1, census_columns=1, vertical_lines=vertical))
    dut = WaveSource(config, FusedArray)
    words = engine_words(*noise(width, height, seed=1).astype(np.uint8), config)
    inside = []

    async def source(ctx):
        ctx.set(dut.go, 1)
        ctx.set(dut.in_use, 2)
        ctx.set(dut.minimum, minimum)
        await send(ctx, dut.i, words, rng=np.random.default_rng(1))
        await ctx.tick().repeat(dut.flush_waves + 10)

    async def watch(ctx):
        async for _, _, wave in ctx.tick().sample(dut.o.wave):
            if wave.valid:
                inside.append(wave.inside)

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(source)
    simulator.add_testbench(watch, background=True)
    simulator.run()
    line = [0, *(int(x >= minimum) for x in range(width)), 0]
    assert inside == line * (height + 1 + vertical) + [0] * dut.flush_waves


@pytest.mark.parametrize("threshold", [0, 10, 255])
def test_vertical_neighbours(threshold):
    """Which neighbours of the pixel above are alike, at the threshold and next to it, at the picture's edges and beyond a frame's end."""
    config = MatcherConfig(2, 9, method=changed(FUSED_1, census_rows=1, census_columns=1, vertical_lines=1, vertical_threshold=threshold))
    dut = WaveSource(config, FusedArray)
    rng = np.random.default_rng(1)
    levels = [0, 10, 21, 31, 245, 255]
    pictures = [rng.choice(levels, size).astype(np.uint8) for size in ((7, 9), (1, 4), (2, 1), (6, 8))]
    words = [word for picture in pictures for word in engine_words(picture, picture, config)]
    given = []

    async def source(ctx):
        ctx.set(dut.go, 1)
        ctx.set(dut.in_use, 2)
        await send(ctx, dut.i, words, rng=rng, stall=0.2)
        await ctx.tick().repeat(dut.flush_waves + 10)

    async def watch(ctx):
        async for _, _, vertical in ctx.tick().sample(dut.o.vertical):
            if vertical.write:
                given.append((vertical.column, vertical.above, vertical.below))

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(source)
    simulator.add_testbench(watch, background=True)
    simulator.run()
    at = iter(given)
    for picture in pictures:
        height, width = picture.shape
        lines = [[next(at) for _ in range(width)] for _ in range(height + 2)]
        assert all([column for column, *_ in line] == list(range(width)) for line in lines)
        flags = np.array(lines[1:height + 1])[..., 1:]
        above, below = alike(picture, config.method.vertical)
        assert flags[..., 0].tolist() == above.tolist() and flags[..., 1].tolist() == below.tolist()
    assert not list(at)
