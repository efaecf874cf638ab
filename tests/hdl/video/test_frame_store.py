# amaranth: UnusedElaboratable=no
"""All writers and readers at one memory: cameras, matcher and monitor at work at the same time."""

import numpy as np
import pytest
from amaranth.sim import Simulator

from golden.config import MatcherConfig
from golden.video.memory_map import MemoryMap
from sim.benches.memory_path import MemoryPath
from sim.kit.cases import comparable, noise
from sim.kit.streams import check_rules, receive, send
from sim.kit.video_cases import camera_words, plane_words, shown_words
from sim.models.ddr2 import Ddr2Timing, LocalMemory, serve


HOSTILE = Ddr2Timing(busy=0.4, refresh=(200, 20), stalls=((700, 200), (2000, 100)))
TIMEOUT = 20_000


async def until(ctx, condition):
    for _ in range(TIMEOUT):
        if condition():
            return
        await ctx.tick()
    raise TimeoutError


@pytest.mark.parametrize("width, height, burst, size, depth, stall", [(20, 6, 16, 1, 32, 0.3), (37, 4, 2, 4, 6, 0.0)])
def test_everything_at_once(width, height, burst, size, depth, stall):
    """While a pair is read and its results are written, the cameras fill the other buffers and the monitor shows the other slot.

    The matcher of this test gives the sum of both grey levels, modulo 256.
    """
    frames = 4
    memory_map = MemoryMap(width, height)
    dut = MemoryPath(memory_map, MatcherConfig(labels=256), burst=burst, size=size, depth=depth)
    memory = LocalMemory(memory_map.total_words, size=size, timing=HOSTILE)
    rng = np.random.default_rng(1)
    pictures = [noise(width, height, number) for number in range(frames)]
    sums = [(left + right) % 256 for left, right in pictures]
    complete = dict.fromkeys(("left", "right", "disparity", "shown_left"), 0)
    count = {"read": 0, "shown": -1}
    pairs: list = []
    shown: list = []

    async def accept(ctx):
        for name in complete:
            ctx.set(getattr(dut, name).control.accept, 1)
        async for *_, left, right, disparity, shown_left in ctx.tick().sample(*[getattr(dut, name).control.complete for name in complete]):
            for name, pulse in zip(complete, (left, right, disparity, shown_left)):
                complete[name] += pulse

    def camera(side, name):
        block = getattr(dut, name)

        async def testbench(ctx):
            for number in range(frames):
                await until(ctx, lambda: count["read"] >= number - 1 and complete[name] == number)
                ctx.set(block.control.buffer, number % 2)
                await send(ctx, block.i, camera_words(pictures[number][side]), rng=rng, stall=stall)
        return testbench

    async def start(ctx):
        for number in range(frames):
            await until(ctx, lambda: min(complete["left"], complete["right"]) > number and count["shown"] >= number - 1)
            ctx.set(dut.pair.control.left_buffer, number % 2)
            ctx.set(dut.pair.control.right_buffer, number % 2)
            ctx.set(dut.pair.control.start, 1)
            await ctx.tick()
            ctx.set(dut.pair.control.start, 0)
            for _ in range(TIMEOUT):
                *_, done = await ctx.tick().sample(dut.pair.control.done)
                if done:
                    break
            count["read"] += 1

    async def matcher(ctx):
        await receive(ctx, dut.pair.o, frames * width * height, rng=rng, stall=stall)

    def results(name, values):
        block = getattr(dut, name)

        async def testbench(ctx):
            for number in range(frames):
                await until(ctx, lambda: len(pairs) > number * width * height and complete[name] == number)
                ctx.set(block.control.buffer, number % 2)
                for at, word in enumerate(plane_words(values(number))):
                    await until(ctx, lambda: len(pairs) > number * width * height + at)
                    await send(ctx, block.i, [word], rng=rng, stall=stall)
        return testbench

    async def monitor(ctx):
        for number in range(frames):
            await until(ctx, lambda: min(complete["disparity"], complete["shown_left"]) > number)
            ctx.set(dut.shown.fetch, 1)
            await ctx.tick()
            ctx.set(dut.shown.fetch, 0)
            ctx.set(dut.shown.shown_valid, 1)
            ctx.set(dut.shown.shown_buffer, number % 2)
            await ctx.tick()
            ctx.set(dut.shown.shown_buffer, 1 - number % 2)
            count["shown"] = number
            await receive(ctx, dut.shown.o, width * height, rng=rng, stall=stall)
        for name in ("left", "right", "disparity", "shown_left", "pair", "shown"):
            fill = ctx.get(getattr(dut, name).fill)
            assert min(burst, memory_map.line_words) <= fill <= depth, name

    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_process(serve(dut.bus, memory))
    sim.add_process(accept)
    for testbench in (camera(0, "left"), camera(1, "right"), start, matcher, results("disparity", lambda n: sums[n]),
                      results("shown_left", lambda n: pictures[n][0]), monitor):
        sim.add_testbench(testbench)
    sim.add_testbench(check_rules(dut.pair.o, pairs), background=True)
    sim.add_testbench(check_rules(dut.shown.o, shown), background=True)
    sim.run()
    size_of_all = frames * width * height
    assert len(pairs) == len(shown) == size_of_all
    wanted = np.array(pictures).transpose(0, 2, 3, 1).reshape(-1, 2).tolist()
    assert [[word["left"], word["right"]] for word in map(comparable, pairs)] == wanted
    assert [comparable(word) for word in shown] == [word for n in range(frames) for word in shown_words(sums[n], pictures[n][0])]
    assert memory.words_written == memory.words_read == 4 * frames * height * memory_map.line_words
