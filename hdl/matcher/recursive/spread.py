"""The costs of a few labels, spread over the labels beside: what is carried to another line."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig, Recursive

from ...parts.delay import data_register


__all__ = ["SpreadGroup"]


class SpreadGroup(wiring.Component):
    """``Q`` of a few neighbouring labels; golden: :func:`golden.matcher.recursive.spread.spread`.

    Width: exact. The least cost is taken off first, and what is left is limited to ``spread_jump``, so that all that follows has its few
    bits: ``Q(d) = min(B(d), B(d - 1) + step, B(d + 1) + step)`` with ``B(d) = min(A(d) - least, jump)``.

    Timing, from ``cost``: ``least`` and ``lower_i``, of the group below, which is a cycle earlier, in the same cycle; ``lower_o`` and
    ``upper_o`` a cycle after it; ``upper_i`` is due two cycles after it; ``o`` :attr:`LATENCY` cycles after it.

    Parameters
    ----------
    config : MatcherConfig
    labels : range
    cost_max : int
        Greatest cost.

    Members
    -------
    cost : In(ArrayLayout(range(cost_max + 1), n)), least : In(range(cost_max + 1))
    lower_i, lower_o : range(cost_max + 1)
        ``A - least`` of the label below the group's, and of its top label for the group above.
    upper_i, upper_o : range(cost_max + 1)
        ``A - least`` of the label above the group's, and of its bottom label for the group below.
    o : Out(ArrayLayout(range(carried_max + 1), n))
    """
    LATENCY = 5

    def __init__(self, config: MatcherConfig, labels: range, cost_max: int):
        self.config = config
        self.labels = labels
        self.cost_max = cost_max
        cost, carried = range(cost_max + 1), range(config.method_as(Recursive).carried_max + 1)
        super().__init__({
            "cost": In(data.ArrayLayout(cost, len(labels))), "least": In(cost),
            "lower_i": In(cost), "lower_o": Out(cost), "upper_i": In(cost), "upper_o": Out(cost),
            "o": Out(data.ArrayLayout(carried, len(labels))),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        propagation = self.config.method_as(Recursive).propagation
        jump, labels = propagation.spread_jump, len(self.labels)

        def limited_to_jump(rest: Value) -> Value:
            return Mux(rest > jump, jump, rest)

        # 1: less the least. 2: limited. 3: in step with what is limited of the labels beside; the way from the groups there takes a cycle.
        rest  = Signal(self.cost.shape(), reset_less=True)
        early = Signal.like(self.lower_i, reset_less=True)      # of the group below, which is a cycle earlier
        ends  = Signal(data.StructLayout(dict.fromkeys(("lower", "upper"), range(jump + 1))), reset_less=True)
        lower = Signal.like(ends.lower, reset_less=True)
        limited, own = (Signal(self.o.shape(), name=name, reset_less=True) for name in ("limited", "own"))
        m.d.sync += [early.eq(self.lower_i), lower.eq(limited_to_jump(early)), ends.lower.eq(lower),
                     ends.upper.eq(limited_to_jump(self.upper_i)), own.eq(limited)]
        for n in range(labels):
            m.d.sync += [rest[n].eq(self.cost[n] - self.least), limited[n].eq(limited_to_jump(rest[n]))]
        m.d.comb += [self.lower_o.eq(rest[labels - 1]), self.upper_o.eq(rest[0])]

        # 4 and 5: the least of three.
        spread = data_register(m, self.o)
        for n, label in enumerate(self.labels):
            neighbours = []
            if label > 0:
                neighbours.append(own[n - 1] if n else ends.lower)
            if label + 1 < self.config.labels:
                neighbours.append(own[n + 1] if n + 1 < labels else ends.upper)
            beside = neighbours[0] if len(neighbours) == 1 else Mux(neighbours[0] < neighbours[1], *neighbours)
            later = Signal(range(jump + 1), name=f"later_{n}", reset_less=True)
            other = Signal(range(jump + propagation.spread_step + 1), name=f"other_{n}", reset_less=True)
            m.d.sync += [
                later.eq(own[n]), other.eq(beside + propagation.spread_step), spread[n].eq(Mux(later < other, later, other)),
            ]
        return m
