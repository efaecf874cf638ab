"""The costs of a few labels, spread over the labels beside: what is carried to another line."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig, Recursive

from ...parts.delay import data_register


__all__ = ["Limits", "SpreadGroup"]


class Limits(data.StructLayout):
    """Of a pixel: its least cost, and the greatest that is carried, ``least + spread_jump``."""
    def __init__(self, config: MatcherConfig, cost_max: int):
        jump = config.method_as(Recursive).propagation.spread_jump
        super().__init__({"least": range(cost_max + 1), "limit": range(cost_max + jump + 1)})


class SpreadGroup(wiring.Component):
    """``Q`` of a few neighbouring labels; golden: :func:`golden.matcher.recursive.spread.spread`.

    Width: exact.

    Timing, from ``cost``: ``lower_o`` and ``upper_o`` in the same cycle; ``lower_i``, of the group below, which is a cycle earlier, is due
    a cycle before, ``upper_i`` and ``limits`` a cycle after it; ``o`` :attr:`LATENCY` cycles after it.

    Parameters
    ----------
    config : MatcherConfig
    labels : range
    cost_max : int
        Greatest cost.

    Members
    -------
    cost : In(ArrayLayout(range(cost_max + 1), n))
    limits : In(Limits(config, cost_max))
    lower_i, lower_o : range(cost_max + 1)
        Cost of the label below the group's, and of its top label for the group above.
    upper_i, upper_o : range(cost_max + 1)
        Cost of the label above the group's, and of its bottom label for the group below.
    o : Out(ArrayLayout(range(carried_max + 1), n))
    """
    LATENCY = 4

    def __init__(self, config: MatcherConfig, labels: range, cost_max: int):
        self.config = config
        self.labels = labels
        self.cost_max = cost_max
        cost, carried = range(cost_max + 1), range(config.method_as(Recursive).carried_max + 1)
        super().__init__({
            "cost": In(data.ArrayLayout(cost, len(labels))), "limits": In(Limits(config, cost_max)),
            "lower_i": In(cost), "lower_o": Out(cost), "upper_i": In(cost), "upper_o": Out(cost),
            "o": Out(data.ArrayLayout(carried, len(labels))),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        propagation = self.config.method_as(Recursive).propagation

        # 1: in step with the group above.
        costs = Signal(self.cost.shape(), reset_less=True)
        early = Signal.like(self.lower_i, reset_less=True)      # of the group below, which is a cycle earlier
        lower = Signal.like(self.lower_i, reset_less=True)
        m.d.sync += [costs.eq(self.cost), early.eq(self.lower_i), lower.eq(early)]
        m.d.comb += [self.lower_o.eq(self.cost[len(self.labels) - 1]), self.upper_o.eq(self.cost[0])]

        # 2 to 4: the least of four, less the least of all labels.
        least = [self.limits.least]
        for stage in (2, 3):
            later = Signal.like(least[-1], name=f"least_{stage}", reset_less=True)
            m.d.sync += later.eq(least[-1])
            least.append(later)
        spread = data_register(m, self.o)
        for n, label in enumerate(self.labels):
            neighbours = []
            if label > 0:
                neighbours.append(costs[n - 1] if n else lower)
            if label + 1 < self.config.labels:
                neighbours.append(costs[n + 1] if n + 1 < len(self.labels) else self.upper_i)
            beside = neighbours[0] if len(neighbours) == 1 else Mux(neighbours[0] < neighbours[1], *neighbours)
            own, other = (Signal(range(self.cost_max + propagation.spread_jump + propagation.spread_step + 1), name=f"{name}_{n}",
                                 reset_less=True) for name in ("own", "other"))
            smaller = Signal.like(own, name=f"smaller_{n}", reset_less=True)
            m.d.sync += [
                own.eq(Mux(costs[n] < self.limits.limit, costs[n], self.limits.limit)), other.eq(beside + propagation.spread_step),
                smaller.eq(Mux(own < other, own, other)), spread[n].eq(smaller - least[2]),
            ]
        return m
