"""The costs of a line joined with those of the line below."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig, Recursive

from ...parts.arithmetic import times
from ...parts.delay import Delay, data_register
from ...parts.line_memory import LineMemory


__all__ = ["LineBelowGroup", "LineBelowWave"]


class LineBelowWave(data.StructLayout):
    """``column`` of a pixel whose cost is kept if ``write``; ``below``: it joins that of the pixel above it.

    ``upper_below``, with costs from below only: that of the pixel above it joins that of the one two lines above.
    """
    def __init__(self, config: MatcherConfig):
        upper = {"upper_below": 1} if config.method_as(Recursive).propagation.from_below else {}
        super().__init__({"column": range(config.max_width), "write": 1, "below": 1, **upper})


class LineBelowGroup(wiring.Component):
    """Joins the costs of a line with those of the line below; golden: :func:`golden.matcher.recursive.line_below.line_below`.

    As the cost of a pixel arrives, that of the pixel above it is joined. The memory holds the costs of the line above; with costs from
    below, of two lines, and those of the upper one are joined too, a second time.

    Width: exact.

    Timing: ``cost`` is due :attr:`COST` cycles after ``i``; ``own`` and ``upper_own`` :attr:`LATENCY` cycles after ``i``. A column is read
    no sooner than four cycles after it was read before.

    Memory: ``max_width`` costs a label, or twice as many.

    Members
    -------
    i : In(LineBelowWave(config))
    cost : In(ArrayLayout(range(cost_max + 1), n))
    own : Out(ArrayLayout(range(own_max + 1), n))
        ``V`` of the line above that of ``cost``.
    upper_own : Out(ArrayLayout(range(own_max + 1), n))
        ``V`` of the line above that one; with costs from below only.
    """
    COST = LineMemory.LATENCY
    LATENCY = COST + 2

    def __init__(self, config: MatcherConfig, labels: range):
        self.config = config
        self.labels = labels
        method = config.method_as(Recursive)
        own = Out(data.ArrayLayout(range(method.own_max + 1), len(labels)))
        super().__init__({
            "i": In(LineBelowWave(config)), "cost": In(data.ArrayLayout(range(method.cost_max + 1), len(labels))), "own": own,
            **({"upper_own": own} if method.propagation.from_below else {}),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        method = self.config.method_as(Recursive)
        shares, from_below = method.line_below, method.propagation.from_below
        costs = self.cost.shape()
        kept = data.StructLayout({"above": costs, **({"upper": costs} if from_below else {})})
        m.submodules.memory = memory = LineMemory(kept, self.config.max_width)
        m.submodules.wave = wave = Delay(self.i.shape(), self.COST, clean=True)
        m.d.comb += [
            memory.address.eq(self.i.column), wave.i.eq(self.i),
            memory.column.eq(wave.o.column), memory.write.eq(wave.o.write), memory.i.above.eq(self.cost),
        ]
        joins = [(self.own, memory.o.above, self.cost, wave.o.below)]
        if from_below:
            m.d.comb += memory.i.upper.eq(memory.o.above)
            joins.append((self.upper_own, memory.o.upper, memory.o.above, wave.o.upper_below))
        for line, (port, cost, lower_cost, joined) in enumerate(joins):
            own = data_register(m, port)
            for n in range(len(self.labels)):
                centre, lower = (Signal(range(max(share, 1) * method.cost_max + 1), name=f"{name}_{line}_{n}", reset_less=True)
                                 for name, share in (("centre", shares.own_share), ("lower", shares.lower_share)))
                m.d.sync += [
                    centre.eq(times(cost[n], shares.own_share)),
                    lower.eq(times(Mux(joined, lower_cost[n], cost[n]), shares.lower_share)),
                    own[n].eq(centre + lower),
                ]
        return m
