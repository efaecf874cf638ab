"""hdl.matcher.recursive.gates: the tables hold the golden model's gates, at first and after each start with other settings."""

import pytest
from amaranth import *
from amaranth.sim import Simulator

from golden.config import RECURSIVE_1, MatcherConfig, changed
from hdl.matcher.recursive.gates import GateFill, GateTable
from sim.kit.clocked import run_clocked


def gates_of(jump, settings):
    return list(changed(RECURSIVE_1, spread_jump=jump, **settings).propagation.gate)


def filled(out):
    """The table that was written, whole, in order."""
    words = [word["o"] for word in out if word["o"]["write"]]
    assert [word["difference"] for word in words] == list(range(256))
    return [word["gate"] for word in words]


@pytest.mark.parametrize("jump", [1, 78, 127])
@pytest.mark.parametrize("numerator, offset, floor", [(312, 4, 10), (4095, 1, 0), (4095, 255, 127), (1, 1, 0), (1, 255, 5), (2000, 16, 3)])
def test_fill(jump, numerator, offset, floor):
    """For the settings of the cycle of ``start``, if they are others than those built in, or than the last ones."""
    sets = [dict(zip(GateFill.SETTINGS, values)) for values in ((numerator, offset, floor), (77, 3, 2))]
    config = MatcherConfig(2, 8, method=changed(RECURSIVE_1, spread_jump=jump))
    clocks = GateFill.CLOCKS + 3
    built_in = {name: config.defaults[name] for name in GateFill.SETTINGS}
    inputs = [{**built_in, "start": 1}] * 9 + [{**sets[0], "start": 1}, *([{**sets[1], "start": 0}] * clocks)]
    inputs += [{**sets[0], "start": 1}] * 10 + [{**sets[1], "start": 1}, *([{**sets[0], "start": 0}] * clocks)]
    out = run_clocked(GateFill(config), inputs, ["o", "busy"])
    first, same, other = out[10:10 + clocks], [*out[:10], *out[10 + clocks:20 + clocks]], out[21 + clocks:]
    assert filled(other) == gates_of(jump, sets[1])
    if sets[0] != built_in:
        assert filled(first) == gates_of(jump, sets[0]) and first[0]["busy"] and not first[-1]["busy"]
    assert not any(word["busy"] or word["o"]["write"] for word in same)
    # Busy as long as it writes; at most for the time that is stated.
    assert other[0]["busy"] and sum(word["busy"] for word in other) <= GateFill.CLOCKS
    assert all(word["busy"] for word in other if word["o"]["write"])


def test_reset_while_it_fills():
    """The tables are filled again, although the settings are those that were being filled in."""
    config = MatcherConfig(2, 8, method=RECURSIVE_1)
    settings = {"gate_numerator": 77, "gate_offset": 3, "gate_floor": 2}
    reset = Signal()
    fill = GateFill(config)
    written = []

    async def testbench(ctx):
        for name, value in settings.items():
            ctx.set(getattr(fill, name), value)
        ctx.set(fill.start, 1)
        await ctx.tick().repeat(50)
        ctx.set(reset, 1)
        await ctx.tick()
        ctx.set(reset, 0)
        for _ in range(GateFill.CLOCKS + 3):
            written.append({"o": {name: ctx.get(fill.o[name]) for name in ("write", "difference", "gate")}})
            await ctx.tick()
            ctx.set(fill.start, 0)

    simulator = Simulator(ResetInserter(reset)(fill))
    simulator.add_clock(1e-6)
    simulator.add_testbench(testbench)
    simulator.run()
    assert filled(written) == gates_of(RECURSIVE_1.propagation.spread_jump, settings)


def test_table():
    config = MatcherConfig(2, 8, method=RECURSIVE_1)
    assert [word["gate"] for word in run_clocked(GateTable(config), [{"difference": n} for n in range(256)], ["gate"], drain=1)[1:]] \
        == list(RECURSIVE_1.propagation.gate)
    gate = gates_of(50, {"gate_numerator": 77, "gate_offset": 3, "gate_floor": 2})
    idle = {"write": 0, "difference": 0, "gate": 1}
    inputs = [{"i": {"write": 1, "difference": n, "gate": value}, "difference": 255 if n < 255 else 0} for n, value in enumerate(gate)]
    inputs += [{"i": idle, "difference": n} for n in range(256)]
    out = run_clocked(GateTable(config), inputs, ["gate"], drain=1, idle={"i": idle, "difference": 0})
    assert [word["gate"] for word in out[257:]] == list(gate)
