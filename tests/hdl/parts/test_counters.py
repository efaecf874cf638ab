import numpy as np
import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hdl.parts.counters import count_events
from sim.kit.clocked import run_clocked


class Counters(wiring.Component):
    """``plain`` counts ``event``, ``cleared`` too but for ``clear``; ``within`` counts the cycles of a condition."""
    def __init__(self):
        super().__init__({"event": In(1), "clear": In(1), "plain": Out(3), "cleared": Out(3), "within": Out(3)})

    def elaborate(self, platform):
        m = Module()
        count_events(m, self.plain, self.event)
        count_events(m, self.cleared, self.event, self.clear)
        with m.If(self.event & self.clear):
            count_events(m, self.within)
        return m


@pytest.mark.parametrize("event, clear", [(0.5, 0.1), (1.0, 0.0), (0.2, 0.5)])
def test_counters(event, clear):
    """They hold their greatest value; an event in the cycle of a clear is counted after it."""
    rng = np.random.default_rng(1)
    inputs = [{"event": int(rng.random() < event), "clear": int(rng.random() < clear)} for _ in range(60)]
    plain = cleared = within = 0
    for cycle, seen in zip(inputs, run_clocked(Counters(), inputs, ["plain", "cleared", "within"])):
        assert seen == {"plain": plain, "cleared": cleared, "within": within}
        plain = min(plain + cycle["event"], 7)
        cleared = cycle["event"] if cycle["clear"] else min(cleared + cycle["event"], 7)
        within = min(within + (cycle["event"] & cycle["clear"]), 7)
