"""Blocks without streams in Amaranth's simulator: inputs of each cycle in, outputs of each cycle out."""

from collections.abc import Iterable, Mapping, Sequence
from typing import Any

from amaranth.hdl import ClockDomain, Module
from amaranth.sim import Simulator


__all__ = ["run_clocked"]


def run_clocked(dut: Any, inputs: Iterable[Mapping[str, Any]], outputs: Sequence[str], *, idle: Mapping[str, Any] | None = None,
                drain: int = 0) -> list[dict[str, Any]]:
    """Drive ``dut`` for a cycle with each of ``inputs``; return the values of its ``outputs``.

    Parameters
    ----------
    inputs : sequence of dict
        Member name to value; members without a value in a cycle keep theirs.
    outputs : sequence of str
        Members to sample in each cycle, after its inputs are set.
    idle : dict
        Inputs of the drain cycles.
    drain : int
        Cycles after the last of ``inputs``.

    Returns
    -------
    list of dict
        One for each cycle.
    """
    given: list[dict[str, Any]] = []

    async def testbench(ctx):
        for cycle in [*inputs, *[idle or {}] * drain]:
            for name, value in cycle.items():
                ctx.set(getattr(dut, name), value)
            given.append({name: ctx.get(getattr(dut, name)) for name in outputs})
            await ctx.tick()

    m = Module()
    m.domains.sync = ClockDomain()  # a block without registers has no clock domain
    m.submodules.dut = dut
    simulator = Simulator(m)
    simulator.add_clock(1e-6)
    simulator.add_testbench(testbench)
    simulator.run()
    return given
