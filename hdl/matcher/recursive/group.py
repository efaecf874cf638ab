"""Costs of a few neighbouring labels in the same cycle, from the columns of both pictures to ``A``."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import GradedArms, MatcherConfig, Propagation, Recursive

from ...parts.delay import NO_COLLISION, Delay, data_register
from ..stream import CensusWord, Least
from ..streaming.fused_array import FusedCell
from ..streaming.labels import least_of, seen_along
from ..streaming.right_view import RightCell, RightWave
from ..streaming.waves import Completion, Wave
from .carried import CarriedGroup, Limits, Taps
from .support import Mean, Summand, Supports


__all__ = ["Final", "LineBelowGroup", "LineBelowWave", "RecursiveGroup"]


class Final(data.StructLayout):
    """A pixel whose costs are there, or padding: its completion, in its column; ``write``: they are kept for the next line."""
    def __init__(self, config: MatcherConfig):
        super().__init__({"completion": Completion(config), "column": range(config.max_width), "write": 1})


class LineBelowWave(data.StructLayout):
    """``column`` of a pixel whose cost is kept if ``write``; ``below``: it joins that of the pixel above it."""
    def __init__(self, config: MatcherConfig):
        super().__init__({"column": range(config.max_width), "write": 1, "below": 1})


class LineBelowGroup(wiring.Component):
    """Joins the costs of a line with those of the line below; golden: :func:`golden.matcher.recursive.line_below.line_below`.

    As the cost of a pixel arrives, that of the pixel above it is joined. The memory holds the costs of the line above.

    Width: exact.

    Timing: ``own`` :attr:`LATENCY` cycles after ``cost`` and ``i``. A column is read no sooner than three cycles after it was read before.

    Memory: ``max_width`` costs a label.

    Members
    -------
    i : In(LineBelowWave(config))
    cost : In(ArrayLayout(range(cost_max + 1), n))
    own : Out(ArrayLayout(range(own_max + 1), n))
        ``V``.
    """
    LATENCY = 4

    def __init__(self, config: MatcherConfig, labels: range):
        self.config = config
        self.labels = labels
        method = config.method_as(Recursive)
        super().__init__({
            "i": In(LineBelowWave(config)), "cost": In(data.ArrayLayout(range(method.cost_max + 1), len(labels))),
            "own": Out(data.ArrayLayout(range(method.own_max + 1), len(labels))),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        method = self.config.method_as(Recursive)
        shares = method.line_below
        costs = self.cost.shape()
        m.submodules.memory = memory = Memory(shape=costs, depth=self.config.max_width, init=[], attrs=NO_COLLISION)
        read, write = memory.read_port(), memory.write_port()
        above = Signal(costs, reset_less=True)
        m.submodules.wave = wave = Delay(self.i.shape(), 2, clean=True)
        m.submodules.here = here = Delay(costs, 2)
        m.d.comb += [
            read.addr.eq(self.i.column), read.en.eq(1), wave.i.eq(self.i), here.i.eq(self.cost),
            write.addr.eq(wave.o.column), write.en.eq(wave.o.write), write.data.eq(here.o),
        ]
        m.d.sync += above.eq(read.data)
        own = data_register(m, self.own)
        for n in range(len(self.labels)):
            centre, lower = (Signal(range(max(share, 1) * method.cost_max + 1), name=f"{name}_{n}", reset_less=True)
                             for name, share in (("centre", shares.own_share), ("lower", shares.lower_share)))
            m.d.sync += [
                centre.eq(above[n] * shares.own_share), lower.eq(Mux(wave.o.below, here.o[n], above[n]) * shares.lower_share),
                own[n].eq(centre + lower),
            ]
        return m


class RecursiveGroup(wiring.Component):
    """Costs ``A`` of a few neighbouring labels, the least so far, and the right view.

    Golden: :func:`golden.matcher.recursive.method.recursion`.

    Width: exact; a running sum is kept modulo the power of two above the greatest sum of a support.

    Timing, in cycles after a step at the group: the wave is due after :attr:`WAVE`, ``below`` after :attr:`BELOW`, ``limits``, ``place``
    and ``taps`` as :class:`hdl.matcher.recursive.carried.CarriedGroup` states, ``share`` after :attr:`SHARE`, ``sums`` after :attr:`SUMS`.
    ``mean`` is due a cycle after the sums of the last pixel of the support; :attr:`TOTAL` cycles after it ``write``, ``column`` and
    ``completion``, with the costs; ``least_i`` :data:`hdl.matcher.streaming.labels.TREE` cycles after those, ``least_o`` one more. Every
    ``_o`` is due at the group above, a cycle later.

    Memory: those of :class:`LineBelowGroup` and :class:`hdl.matcher.recursive.carried.CarriedGroup`; two rings of running sums, one of
    shares of the costs from above.

    Members
    -------
    i, o : Wave(config, CensusWord(config))
    below_i, below_o : LineBelowWave(config)
    address_i, address_o, limits_i, limits_o, place_i, place_o, taps_i, taps_o
        As of :class:`hdl.matcher.recursive.carried.CarriedGroup`.
    share_i, share_o : range(16)
        Eighths of the costs from above.
    sums_i, sums_o : Summand(config)
    mean_i, mean_o : Mean(config)
    final_i, final_o : Final(config)
    lower_i, lower_o, upper_i, upper_o : range(data_max + 1)
        As of :class:`hdl.matcher.recursive.carried.CarriedGroup`.
    right_i, right_o : RightWave(config)
    least_i, least_o : Least(data_bits, D)
        Complement of the least cost; the smaller label on a tie.
    costs : Out(ArrayLayout(range(data_max + 1), n))
        ``A``, in step with ``final_i``.
    """
    # `V` and the share of the costs from above meet two cycles after these are there.
    SHARE = CarriedGroup.ABOVE
    SUMS = CarriedGroup.ABOVE + 3
    BELOW = SUMS - 1 - LineBelowGroup.LATENCY
    WAVE = BELOW - FusedCell.LATENCY
    TOTAL = 7

    def __init__(self, config: MatcherConfig, labels: range):
        self.config = config
        self.labels = labels
        method = config.method_as(Recursive)
        passed = {
            "below": LineBelowWave(config), "address": range(config.max_width), "limits": Limits(config),
            "place": range(method.propagation.fan), "taps": Taps(config), "share": range(Propagation.SHARE_MAX + 1),
            "sums": Summand(config), "mean": Mean(config), "final": Final(config),
        }
        wave, cost = Wave(config, CensusWord(config)), range(method.data_max + 1)
        least = Least(method.data_max.bit_length(), config.labels)
        super().__init__({
            "i": In(wave), "o": Out(wave),
            **{f"{name}_i": In(shape) for name, shape in passed.items()}, **{f"{name}_o": Out(shape) for name, shape in passed.items()},
            "lower_i": In(cost), "lower_o": Out(cost), "upper_i": In(cost), "upper_o": Out(cost),
            "right_i": In(RightWave(config)), "right_o": Out(RightWave(config)), "least_i": In(least), "least_o": Out(least),
            "costs": Out(data.ArrayLayout(cost, len(labels))),
        })
        self._passed = tuple(passed)

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        method = config.method_as(Recursive)
        count = len(self.labels)
        for name in self._passed:
            here, onward = getattr(self, f"{name}_i"), getattr(self, f"{name}_o")
            later = Signal.like(here, name=f"{name}_later")     # with a reset: there are control bits among them
            m.d.sync += later.eq(here)
            m.d.comb += onward.eq(later)

        # The costs of the cells, and those of the line below.
        valid = [self.i.valid]
        for stage in range(1, 7):
            valid.append(Signal(name=f"valid{stage}"))
            m.d.sync += valid[stage].eq(valid[stage - 1])
        m.submodules.below = below = LineBelowGroup(config, self.labels)
        m.d.comb += below.i.eq(self.below_i)
        for n, (label, seen, inside) in enumerate(seen_along(m, self.labels, self.i, self.o)):
            m.submodules[f"label_{label}"] = cell = FusedCell(config)
            m.d.comb += [
                cell.left.eq(self.i.left), cell.left_census.eq(self.i.left_census),
                cell.right.eq(seen["right"]), cell.right_census.eq(seen["right_census"]), cell.inside.eq(inside),
                cell.valid1.eq(valid[1]), cell.valid4.eq(valid[4]), cell.valid6.eq(valid[6]), below.cost[n].eq(cell.cost),
            ]

        # Those from the line above.
        m.submodules.carried = carried = CarriedGroup(config, self.labels)
        m.d.comb += [
            carried.address.eq(self.address_i), carried.limits.eq(self.limits_i), carried.place.eq(self.place_i),
            carried.taps.eq(self.taps_i), carried.lower_i.eq(self.lower_i), carried.upper_i.eq(self.upper_i),
            self.lower_o.eq(carried.lower_o), self.upper_o.eq(carried.upper_o),
        ]

        # Their share, and the sum with a pixel's own.
        bits = Propagation.SHARE_BITS
        joined, extra = [], []
        for n in range(count):
            above = carried.above[n]
            low, high = (Signal(range(3 * method.carried_max + 1), name=f"{name}_{n}", reset_less=True) for name in ("low", "high"))
            share = Signal(range((Propagation.SHARE_MAX * method.carried_max >> bits) + 1), name=f"share_{n}", reset_less=True)
            join  = Signal(range(method.joined_max + 1), name=f"joined_{n}", reset_less=True)
            m.d.sync += [
                low.eq(Mux(self.share_i[0], above, 0) + Mux(self.share_i[1], above << 1, 0)),
                high.eq(Mux(self.share_i[2], above, 0) + Mux(self.share_i[3], above << 1, 0)),
                share.eq((low + (high << 2)) >> bits), join.eq(below.own[n] + share),
            ]
            joined.append(join)
            m.submodules[f"extra_{n}"] = eighth = Delay(range((method.carried_max >> bits) + 1), 3)
            m.d.comb += eighth.i.eq(above >> bits)
            extra.append(eighth.o)

        # Running sums, each written before its pixel's cost is added.
        total_max = method.arms.support_max * method.joined_max
        sums = Signal(data.ArrayLayout(total_max.bit_length(), count), reset_less=True)
        with m.If(self.sums_i.enter):
            m.d.sync += [total.eq(Mux(self.sums_i.clear, 0, total + cost)) for total, cost in zip(sums, joined)]
        ends = {}
        for name in ("low", "high"):
            m.submodules[f"ring_{name}"] = ring = Memory(shape=sums.shape(), depth=Supports.ring_of(config), init=[], attrs=NO_COLLISION)
            write, read = ring.write_port(), ring.read_port()
            m.d.comb += [
                write.addr.eq(self.sums_i.place), write.data.eq(sums), write.en.eq(self.sums_i.enter),
                read.addr.eq(self.mean_i[name]), read.en.eq(1),
            ]
            ends[name] = Signal(sums.shape(), name=f"sum_{name}", reset_less=True)
            m.d.sync += ends[name].eq(read.data)
        eighths = data.ArrayLayout((method.carried_max >> bits).bit_length(), count)
        m.submodules.eighths = kept = Memory(shape=eighths, depth=Supports.ring_of(config), init=[], attrs=NO_COLLISION)
        write, read = kept.write_port(), kept.read_port()
        m.d.comb += [
            write.addr.eq(self.sums_i.place), write.data.eq(Cat(extra)), write.en.eq(self.sums_i.enter),
            read.addr.eq(self.mean_i.centre), read.en.eq(1),
        ]

        # 3: the sum of the support. 4 to 6: its mean, through the registers of a multiplier. 7: `A`.
        m.submodules.reciprocal = reciprocal = Delay(self.mean_i.reciprocal.shape(), 3)
        m.submodules.share_later = share_later = Delay(eighths, 5)
        m.d.comb += [reciprocal.i.eq(self.mean_i.reciprocal), share_later.i.eq(read.data)]
        costs = data_register(m, self.costs)
        for n in range(count):
            total   = Signal(range(total_max + 1), name=f"total_{n}", reset_less=True)
            factor  = Signal.like(total, name=f"factor_{n}", reset_less=True)
            other   = Signal(self.mean_i.reciprocal.shape(), name=f"other_{n}", reset_less=True)
            product = Signal(len(total) + len(other), name=f"product_{n}", reset_less=True)
            mean    = Signal(range(method.joined_max + 1), name=f"mean_{n}", reset_less=True)
            m.d.sync += [
                total.eq(ends["high"][n] - ends["low"][n]), factor.eq(total), other.eq(reciprocal.o), product.eq(factor * other),
                mean.eq(product >> GradedArms.RECIPROCAL_BITS), costs[n].eq(mean + share_later.o[n]),
            ]
        m.d.comb += [
            carried.write.eq(self.final_i.write), carried.column.eq(self.final_i.column), carried.cost.eq(self.costs),
        ]

        # The right view passes the costs.
        right = self.right_i
        for n, label in enumerate(self.labels):
            m.submodules[f"right_{label}"] = cell = RightCell(config, label)
            m.d.comb += [cell.completion.eq(self.final_i.completion), cell.cost.eq(self.costs[n]), cell.i.eq(right)]
            right = cell.o
        # To the group above, a cycle later: the state of the top label before this wave.
        m.d.sync += self.right_o.eq(right)
        least_of(m, [~cost for cost in self.costs], self.labels[0], self.least_i, self.least_o)
        return m
