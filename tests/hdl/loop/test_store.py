# amaranth: UnusedElaboratable=no
"""hdl.loop.store: reads and writes of the system, and a display's reads, whatever shares a memory."""

import random

import pytest
from amaranth.hdl import ClockDomain, Module
from amaranth.sim import Simulator

from hdl.loop.store import FrameStore, slice_bits


DEPTH, BITS = 50, 8


@pytest.mark.parametrize("shared", [1, 3, 8])
def test_random(shared, monkeypatch):
    """A word is that of the last write before its address was given; the display's is, unless it is being written."""
    monkeypatch.setattr("hdl.loop.store.slice_bits", lambda depth, bits: shared)
    rng = random.Random(shared)
    dut = FrameStore(DEPTH, BITS, display=True)
    port = dut.port
    words, asked = [0] * DEPTH, []
    shown = {"right": 0, "all": 0}

    async def access(ctx):
        for address in range(DEPTH):    # what a memory holds at first does not count
            ctx.set(port.address, address)
            ctx.set(port.data, words[address])
            ctx.set(port.write, 1)
            await ctx.tick()
        for cycle in range(1500):
            if cycle >= FrameStore.LATENCY and (wanted := asked[cycle - FrameStore.LATENCY]) is not None:
                assert ctx.get(port.found) == wanted
            address, data, write = rng.randrange(DEPTH), rng.randrange(256), rng.random() < 0.4
            ctx.set(port.address, address)
            ctx.set(port.data, data)
            ctx.set(port.write, write)
            asked.append(None if write else words[address])
            if write:
                words[address] = data
            await ctx.tick()

    async def display(ctx):
        while True:
            address = rng.randrange(DEPTH)
            before = words[address]
            ctx.set(dut.display_address, address)
            await ctx.tick("pixel")
            shown["all"] += 1
            shown["right"] += ctx.get(dut.display_found) in (before, words[address])
    m = Module()
    m.domains += [ClockDomain("sync"), ClockDomain("pixel")]
    m.submodules.dut = dut
    sim = Simulator(m)
    sim.add_clock(1e-6)
    sim.add_clock(3e-6, domain="pixel", phase=0.3e-6)
    sim.add_testbench(access)
    sim.add_testbench(display, background=True)
    sim.run()
    # A write reaches the memory a clock after it was given.
    assert shown["all"] > 400 and shown["right"] > 0.95 * shown["all"]


@pytest.mark.parametrize("depth, bits, shared", [
    (76_800, 8, 1), (76_800, 20, 1), (110_592, 8, 1), (3000, 8, 4), (2049, 8, 4), (2048, 9, 9), (1000, 17, 17), (54, 20, 18), (1, 1, 1)])
def test_slices(depth, bits, shared):
    """By hand: 40 blocks of 16384x1 in place of 38 of 2048x9; 2 of 4096x4, not 4 of 8192x2, in place of 2 of 2048x9."""
    assert slice_bits(depth, bits) == shared
