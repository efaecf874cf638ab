"""Means of the costs of a few labels over supports: rings of running sums, and a product with the reciprocal."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import GradedArms, MatcherConfig, Recursive

from ...parts.arithmetic import multiply
from ...parts.delay import NO_COLLISION, Delay
from .support import TOTAL, Mean, Summand, Supports, mean_latency


__all__ = ["MeanGroup"]


class MeanGroup(wiring.Component):
    """Means of the costs of a few neighbouring labels; golden: :func:`golden.matcher.recursive.arms.support_means`.

    Width: exact; a running sum is kept modulo the power of two above the greatest sum of a support.

    Timing: a cost is added a cycle after ``sums``. ``ends`` is due a cycle after the ``sums`` of the last pixel of the support at the
    earliest; ``o`` :meth:`latency_of` cycles after it.

    Memory: two rings of running sums.

    Parameters
    ----------
    config : MatcherConfig
    labels : range
    cost_max : int
        Greatest cost.

    Members
    -------
    sums : In(Summand(config)), cost : In(ArrayLayout(range(cost_max + 1), n))
    ends : In(Mean(config))
    o : Out(ArrayLayout(range(cost_max + 1), n))
    """
    def __init__(self, config: MatcherConfig, labels: range, cost_max: int):
        self.config = config
        self.labels = labels
        self.cost_max = cost_max
        costs = data.ArrayLayout(range(cost_max + 1), len(labels))
        super().__init__({"sums": In(Summand(config)), "cost": In(costs), "ends": In(Mean(config)), "o": Out(costs)})

    @staticmethod
    def latency_of(config: MatcherConfig) -> int:
        """Cycles from the ends of a support to its mean."""
        return mean_latency(config)

    def elaborate(self, platform: object) -> Module:
        m = Module()
        method = self.config.method_as(Recursive)
        total_max = method.arms.support_max * self.cost_max

        # Running sums, each written before its pixel's cost is added.
        sums = Signal(data.ArrayLayout(total_max.bit_length(), len(self.labels)), reset_less=True)
        with m.If(self.sums.enter):
            m.d.sync += [total.eq(Mux(self.sums.clear, 0, total + cost)) for total, cost in zip(sums, self.cost)]
        ends = {}
        for name in ("low", "high"):
            m.submodules[f"ring_{name}"] = ring = Memory(shape=sums.shape(), depth=Supports.ring_of(self.config), init=[],
                                                         attrs=NO_COLLISION)
            write, read = ring.write_port(), ring.read_port()
            m.d.comb += [
                write.addr.eq(self.sums.place), write.data.eq(sums), write.en.eq(self.sums.enter),
                read.addr.eq(self.ends[name]), read.en.eq(1),
            ]
            ends[name] = Signal(sums.shape(), name=f"sum_{name}", reset_less=True)
            m.d.sync += ends[name].eq(read.data)

        # 3: the sum of the support. Then its product with the reciprocal, through the registers of a multiplier or a tree of sums.
        m.submodules.reciprocal = reciprocal = Delay(self.ends.reciprocal.shape(), TOTAL)
        m.d.comb += reciprocal.i.eq(self.ends.reciprocal)
        for n in range(len(self.labels)):
            total = Signal(range(total_max + 1), name=f"total_{n}", reset_less=True)
            m.d.sync += total.eq(ends["high"][n] - ends["low"][n])
            if method.soft_multipliers:
                product, _ = multiply(m, f"product_{n}", total, reciprocal.o)
                m.d.comb += self.o[n].eq(product >> GradedArms.RECIPROCAL_BITS)
                continue
            factor  = Signal.like(total, name=f"factor_{n}", reset_less=True)
            other   = Signal(self.ends.reciprocal.shape(), name=f"other_{n}", reset_less=True)
            product = Signal(len(total) + len(other), name=f"product_{n}", reset_less=True)
            m.d.sync += [factor.eq(total), other.eq(reciprocal.o), product.eq(factor * other)]
            m.d.comb += self.o[n].eq(product >> GradedArms.RECIPROCAL_BITS)
        return m
