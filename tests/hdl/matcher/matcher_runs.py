"""Runs of a whole matcher in Amaranth's simulator: scripts, resets, and the words that golden gives."""

import numpy as np
from amaranth import *
from amaranth.sim import Simulator

from golden.matcher.labelling import match
from sim.kit.cases import comparable, disparity_words, pixel_words
from sim.kit.streams import check_rules, receive, send


__all__ = ["after_reset", "golden_words", "run_script"]


def golden_words(left, right, config):
    return disparity_words(match(left, right, config))


def run_script(dut, script, count=None, *, stall=0.0, elaboratable=None):
    """Run ``await script(ctx, send_words, given)`` with a sink; return the words given and ``error`` in each cycle.

    Without ``count`` the sink accepts words until the script ends.
    """
    rng = np.random.default_rng(1)
    given, errors = [], []

    async def source(ctx):
        await script(ctx, lambda words: send(ctx, dut.i, words, rng=rng, stall=stall), given)

    async def sink(ctx):
        if count is not None:
            await receive(ctx, dut.o, count, rng=rng, stall=stall, timeout=3000)
        ctx.set(dut.o.ready, 1)
        await ctx.tick().repeat(200)

    async def watch(ctx):
        async for _, _, error in ctx.tick().sample(dut.error):
            errors.append(error)

    sim = Simulator(elaboratable or dut)
    sim.add_clock(1e-6)
    sim.add_testbench(source)
    sim.add_testbench(sink)
    sim.add_testbench(check_rules(dut.o, given), background=True)
    sim.add_testbench(watch, background=True)
    sim.run()
    return [comparable(word) for word in given], errors


def after_reset(dut, left, right, cut, start=None):
    """Output for a pair after a reset behind the first ``cut`` pixels of the same one, and ``error`` in each cycle.

    ``await start(ctx)`` goes before all.
    """
    reset = Signal()
    before = []

    async def script(ctx, send_words, given):
        if start:
            await start(ctx)
        await send_words(pixel_words(left, right)[:cut])
        ctx.set(reset, 1)
        await ctx.tick()
        ctx.set(reset, 0)
        before.extend(given)
        await send_words(pixel_words(left, right))
        while len(given) < len(before) + left.size:
            await ctx.tick()
        await ctx.tick().repeat(100)

    given, errors = run_script(dut, script, elaboratable=ResetInserter(reset)(dut))
    return given[len(before):], errors
