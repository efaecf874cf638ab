"""Blocks without streams in Amaranth's own simulator: inputs for every cycle in, outputs of every cycle out."""

from amaranth.hdl import ClockDomain, Module
from amaranth.sim import Simulator


__all__ = ["run_clocked"]


def run_clocked(dut, inputs, outputs, *, idle=None, drain=0):
    """Drive ``dut`` for a cycle with each of ``inputs``; return what its ``outputs`` showed.

    Parameters
    ----------
    inputs : sequence of dict
        Member name to value; a member that a cycle does not name keeps its value.
    outputs : sequence of str
        Members to sample, in each cycle after its inputs have settled.
    idle : dict
        Inputs of the cycles after the last.
    drain : int
        Cycles after the last.

    Returns
    -------
    list of dict
        One for each cycle.
    """
    given = []

    async def testbench(ctx):
        for cycle in [*inputs, *[idle or {}] * drain]:
            for name, value in cycle.items():
                ctx.set(getattr(dut, name), value)
            given.append({name: ctx.get(getattr(dut, name)) for name in outputs})
            await ctx.tick()

    m = Module()
    m.domains.sync = ClockDomain()  # a block of no registers has none of its own
    m.submodules.dut = dut
    simulator = Simulator(m)
    simulator.add_clock(1e-6)
    simulator.add_testbench(testbench)
    simulator.run()
    return given
