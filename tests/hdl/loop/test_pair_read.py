# amaranth: UnusedElaboratable=no
"""hdl.loop.pair_read with memory blocks: pixels in order, with their flags, a pixel a clock unless the matcher waits."""

import numpy as np
import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.sim import Simulator

from golden.config import MatcherConfig
from hdl.loop.pair_read import PairScan
from hdl.loop.store import BlockStores
from sim.kit.cases import comparable, noise, pixel_words
from sim.kit.streams import check_rules


WIDTH, HEIGHT = 9, 5


@pytest.mark.parametrize("size, stall", [((9, 5), 0.0), ((9, 5), 0.4), ((6, 3), 0.0), ((1, 1), 0.0), ((1, 4), 0.4)])
def test_pixels(size, stall):
    """Twice, and nothing else."""
    width, height = size
    config = MatcherConfig(4, WIDTH)
    stores = BlockStores(config, HEIGHT)
    scan = PairScan(config, HEIGHT, stores.ahead)
    m = Module()
    m.submodules.scan, m.submodules.stores = scan, stores
    wiring.connect(m, scan.read, stores.scan)
    left, right = noise(WIDTH, HEIGHT, 7)
    expected = pixel_words(left[:height, :width], right[:height, :width])
    rng = np.random.default_rng(1)
    words: list = []
    cycles: list = []
    starts = []

    async def testbench(ctx):
        cycle = 0

        async def tick(count=1):
            nonlocal cycle
            cycle += count
            await ctx.tick().repeat(count)
        ctx.set(stores.write.valid, 1)
        for plane, picture in enumerate((left, right)):
            for place in range(WIDTH * HEIGHT):
                ctx.set(stores.write.p, {"plane": plane, "address": place, "level": int(picture.flat[place])})
                await tick()
        ctx.set(stores.write.valid, 0)
        ctx.set(stores.busy, 1)
        ctx.set(scan.width, width)
        ctx.set(scan.lines, height)
        for turn in range(2):
            starts.append(cycle)
            ctx.set(scan.start, 1)
            await tick()
            ctx.set(scan.start, 0)
            while len(words) < (turn + 1) * len(expected):
                ctx.set(scan.o.ready, int(rng.random() >= stall))
                await tick()
                assert cycle < 1000
            ctx.set(scan.o.ready, 1)
            await tick(20)

    simulator = Simulator(m)
    simulator.add_clock(1e-6)
    simulator.add_testbench(check_rules(scan.o, words, cycles), background=True)
    simulator.add_testbench(testbench)
    simulator.run()
    assert [comparable(word) for word in words] == 2 * expected
    if not stall:
        assert [cycle - starts[0] for cycle in cycles[:len(expected)]] == list(range(6, 6 + len(expected)))
