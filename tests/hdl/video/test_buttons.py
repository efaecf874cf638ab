# amaranth: UnusedElaboratable=no
"""hdl.video.buttons: one pulse each time that it is pressed, however it bounces."""

import numpy as np
import pytest
from amaranth.sim import Simulator

from hdl.video.buttons import Button


CLOCKS = 10


def presses(levels):
    """The clocks in which ``pressed`` is high."""
    dut = Button(CLOCKS / Button.SECONDS)
    assert dut.clocks == CLOCKS
    pulses = []

    async def testbench(ctx):
        for clock, level in enumerate(levels):
            ctx.set(dut.i, level)
            await ctx.tick()
            if ctx.get(dut.pressed):
                pulses.append(clock)

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(testbench)
    simulator.run()
    return pulses


@pytest.mark.parametrize("levels, pulses", [
    # Clock 0 is low; a level of 10 clocks counts, one of 9 does not.
    ([0, *[1] * 30, *[0] * 30], [10]),
    ([0, *[1] * 9, *[0] * 30], []),
    ([0, *[1] * 10, *[0] * 30], [10]),
    ([*[1] * 15, *[0] * 9, *[1] * 30], [9]),
    ([*[1] * 15, *[0] * 10, *[1] * 30], [9, 34]),
    ([*[1] * 9, 0, *[1] * 9, 0, *[1] * 12], [29]),
])
def test_by_hand(levels, pulses):
    assert presses(levels) == pulses


def test_bouncing():
    """Four presses; every one and every release bounces for a while."""
    rng = np.random.default_rng(1)
    levels, ends = [0] * 20, []
    for _ in range(4):
        for level in (1, 0):
            for _ in range(6):
                levels += [level] * int(rng.integers(1, CLOCKS)) + [1 - level] * int(rng.integers(1, CLOCKS))
            if level:
                ends.append(len(levels) + CLOCKS - 1)
            levels += [level] * 40
    assert presses(levels) == ends


def test_time():
    assert Button(75_000_000).clocks == 750_000
    assert Button(1).clocks == 1
