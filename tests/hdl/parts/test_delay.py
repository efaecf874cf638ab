# amaranth: UnusedElaboratable=no

import numpy as np
import pytest
from amaranth import *
from amaranth.sim import Simulator

from hdl.parts.delay import Delay, SkidRegister, StreamRegister
from sim.kit.clocked import run_clocked
from sim.kit.streams import run_stream


@pytest.mark.parametrize("clean", [False, True])
@pytest.mark.parametrize("clocks, registers", [*((clocks, False) for clocks in (0, 1, 4, 5, 6, 8, 9, 31)), (2, True), (9, True)])
def test_delay(clocks, registers, clean):
    words = np.random.default_rng(1).integers(0, 256, 100).tolist()
    delay = Delay(8, clocks, clean=clean, registers=registers)
    assert delay.in_registers == (registers or clocks <= 4)
    out = [cycle["o"] for cycle in run_clocked(delay, [{"i": word} for word in words], ["o"])]
    assert out[clocks:] == words[:len(words) - clocks]
    if clean:
        assert out[:clocks] == [0] * clocks


@pytest.mark.parametrize("clocks", [1, 4, 5, 6, 9, 31])
def test_clean_after_reset(clocks):
    """Words that a memory holds from before a reset do not appear after it."""
    reset = Signal()
    delay = Delay(8, clocks, clean=True)

    async def testbench(ctx):
        ctx.set(delay.i, 0xFF)
        await ctx.tick().repeat(2 * clocks + 2)
        assert ctx.get(delay.o) == 0xFF
        ctx.set(reset, 1)
        await ctx.tick()
        ctx.set(reset, 0)
        for word in range(1, clocks + 2):
            ctx.set(delay.i, word)
            assert ctx.get(delay.o) == max(0, word - clocks)
            await ctx.tick()

    simulator = Simulator(ResetInserter(reset)(delay))
    simulator.add_clock(1e-6)
    simulator.add_testbench(testbench)
    simulator.run()


def test_bad_delay():
    with pytest.raises(ValueError, match="at least 0 cycles, not -1"):
        Delay(8, -1)


@pytest.mark.parametrize("kind", [StreamRegister, SkidRegister])
@pytest.mark.parametrize("stall", [0.0, 0.4])
def test_stream_register(stall, kind):
    """Every word once, in order; without stalls one a cycle, a cycle later."""
    words = np.random.default_rng(3).integers(0, 256, 60).tolist()
    cycles = {}
    dut = kind(8)
    assert run_stream(dut, words, rng=np.random.default_rng(4), stall_i=stall, stall_o=stall, cycles=cycles) == words
    if not stall:
        assert np.subtract(cycles["o"], cycles["i"]).tolist() == [dut.LATENCY] * len(words)
        assert np.diff(cycles["o"]).tolist() == [1] * (len(words) - 1)


def test_skid_register_ends_the_path_of_ready():
    """It takes one word more than it offers, and its own ``ready`` does not follow that of the output within a cycle."""
    dut = SkidRegister(8)

    async def testbench(ctx):
        ctx.set(dut.i.valid, 1)
        for word, ready in ((1, 1), (2, 1), (3, 0)):
            assert ctx.get(dut.i.ready) == ready
            ctx.set(dut.i.payload, word)
            await ctx.tick()
        ctx.set(dut.o.ready, 1)
        assert (ctx.get(dut.i.ready), ctx.get(dut.o.payload)) == (0, 1)
        await ctx.tick()
        assert (ctx.get(dut.i.ready), ctx.get(dut.o.payload)) == (1, 2)

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(testbench)
    simulator.run()
