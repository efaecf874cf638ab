import numpy as np
import pytest
from amaranth import *
from amaranth.sim import Simulator

from hdl.parts.crossing import ClockWatch, EventCrossing


PERIOD = 1e-6


def run_between_clocks(dut, there, here, *, ratio):
    """Run testbenches ``there(ctx, tick, rst)``, where ``tick`` is a cycle of the other domain, and ``here(ctx, rst)``.

    ``ratio``: the period of ``sync`` to that of the other domain.
    """
    m = Module()
    m.domains.sync = sync = ClockDomain()
    m.domains.there = other = ClockDomain()
    m.submodules.dut = dut

    async def testbench(ctx):
        async def tick():
            await ctx.delay(PERIOD / 2)
            ctx.set(other.clk, 1)
            await ctx.delay(PERIOD / 2)
            ctx.set(other.clk, 0)
        await ctx.delay(PERIOD / 7)
        await there(ctx, tick, other.rst)

    async def watch(ctx):
        await here(ctx, sync.rst)

    sim = Simulator(m)
    sim.add_clock(PERIOD * ratio)
    sim.add_testbench(testbench)
    sim.add_testbench(watch, background=True)
    sim.run()


@pytest.mark.parametrize("ratio", [0.36, 0.99, 1.01, 1.9])
def test_events(ratio):
    """Each event is seen once, independent of other bits, with three cycles between two, as between timing codes."""
    dut = EventCrossing("there", 3)
    rng = np.random.default_rng(1)
    rare = (rng.random((60, 3)) < 0.5).astype(int)
    seen = []

    async def there(ctx, tick, rst):
        for bits in rare:
            for now in (bits @ [1, 2, 4], 0, 0):
                ctx.set(dut.i, int(now))
                await tick()
        await ctx.delay(5 * PERIOD * ratio)

    async def here(ctx, rst):
        while True:
            _, _, bits = await ctx.tick().sample(dut.o)
            seen.append([bits >> n & 1 for n in range(3)])

    run_between_clocks(dut, there, here, ratio=ratio)
    assert np.sum(seen, axis=0).tolist() == rare.sum(axis=0).tolist()


def test_reset_makes_no_event():
    """Nor loses one: resets of both domains after an odd number of events."""
    dut = EventCrossing("there", 1)
    seen = []

    async def there(ctx, tick, rst):
        # Event, reset of this domain, a pause in which the other one is reset.
        for event, reset in [(1, 0), (0, 0), (0, 1), (0, 1), *[(0, 0)] * 20, (1, 0), *[(0, 0)] * 5]:
            ctx.set(dut.i, event)
            ctx.set(rst, reset)
            await tick()

    async def here(ctx, rst):
        while True:
            ctx.set(rst, len(seen) in range(30, 40))
            _, _, bits = await ctx.tick().sample(dut.o)
            seen.append(bits)

    run_between_clocks(dut, there, here, ratio=0.36)
    assert len(seen) > 80
    assert sum(seen) == 2


@pytest.mark.parametrize("ratio", [27 / 148.5, 1.01, 8])
def test_clock_watch(ratio):
    """Stopped at first; seen within a divided cycle; a stop is seen after the time-out, and so is a domain held in reset."""
    dut = ClockWatch("there")
    half = ClockWatch.DIVISOR / ratio   # cycles of sync
    marks = {}
    now = []
    status = []

    async def there(ctx, tick, rst):
        async def run(name, count):
            for _ in range(count):
                await tick()
            marks[name] = len(now)
        marks["start"] = 0
        await run("ran", 500)
        await ctx.delay((dut.TIMEOUT + 20) * PERIOD * ratio)
        marks["stood"] = len(now)
        await run("ran again", 300)
        ctx.set(rst, 1)
        await run("reset", int(300 * max(1, ratio)))
        ctx.set(rst, 0)
        await run("ran at last", 300)

    async def here(ctx, rst):
        while True:
            _, _, stopped = await ctx.tick().sample(dut.stopped)
            now.append(0)
            status.append(stopped)

    run_between_clocks(dut, there, here, ratio=ratio)
    assert status[0] == 1
    begun = status.index(0)
    assert begun <= half + 6
    assert not any(status[begun:marks["ran"]])
    stopped = status.index(1, begun) - marks["ran"]
    assert dut.TIMEOUT - half - 2 <= stopped <= dut.TIMEOUT + 4
    assert not any(status[marks["stood"] + int(half) + 6:marks["ran again"]])
