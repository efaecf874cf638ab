"""Consecutive frames through a component whose plain inputs change from frame to frame."""

from collections.abc import Mapping, Sequence
from typing import Any

from amaranth.sim import Simulator

from .streams import TIMEOUT, Random, check_rules, receive, send


__all__ = ["run_frames"]


def run_frames(dut: Any, frames: Sequence[tuple[Sequence[Any], Mapping[str, int]]], *, rng: Random, stall_i: float = 0.0,
               stall_o: float = 0.0, drain: int = 64, timeout: int = TIMEOUT, cycles: dict[str, list[int]] | None = None) -> list[Any]:
    """Send frames through ``dut``; return all payloads of the output, extra ones too.

    The plain inputs of a frame hold while its first word is valid; at all other times they are noise.

    Parameters
    ----------
    frames : sequence of (list of payloads, dict)
        Words of a frame and its plain inputs, by member name; the same names for all frames.
    stall_i, stall_o, drain, timeout, cycles
        As in :func:`sim.kit.streams.run_stream`.
    """
    count = sum(len(words) for words, _ in frames)
    taken: list = []
    given: list = []
    cycles = {} if cycles is None else cycles
    cycles["i"], cycles["o"] = [], []

    async def source(ctx):
        for words, inputs in frames:
            for word in words:
                # Set in the cycle in which the word becomes valid, not before: an idle cycle has noise.
                while rng.random() < stall_i:
                    await ctx.tick()
                if word is words[0]:
                    for name, value in inputs.items():
                        ctx.set(getattr(dut, name), value)
                await send(ctx, dut.i, [word], rng=rng, timeout=timeout)
                for name in inputs:
                    port = getattr(dut, name)
                    ctx.set(port, int(rng.random() * 2**len(port)))

    async def sink(ctx):
        await receive(ctx, dut.o, count, rng=rng, stall=stall_o, timeout=timeout)
        ctx.set(dut.o.ready, 1)
        await ctx.tick().repeat(drain)

    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_testbench(source)
    sim.add_testbench(sink)
    sim.add_testbench(check_rules(dut.i, taken, cycles["i"], name="i"), background=True)
    sim.add_testbench(check_rules(dut.o, given, cycles["o"], name="o"), background=True)
    sim.run()
    assert len(taken) == count
    return given
