"""The fused cost at one pixel a cycle, summed over supports: an array of cells, one a label, laid out as
:mod:`hdl.matcher.streaming.bec_array`."""

from collections.abc import Sequence

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import Fused, MatcherConfig

from ...parts.delay import NO_COLLISION, Delay, data_register
from ..stage import CostArray
from ..stream import CensusWord, Least
from .bec_array import BecCell
from .labels import TREE, LabelMemory, Queued, groups_of, least_of, seen_along
from .right_view import RightCell, RightWave
from .support import Ends, SumWave, SupportSource
from .vertical import VerticalSupport
from .waves import ColumnSums, Issue, Pixel, VerticalWave, Wave


__all__ = ["FusedArray", "FusedCell", "FusedGroup"]


def signed_digits(constant: int) -> list[tuple[int, int]]:
    """``(sign, shift)`` of the fewest powers of two that add up to a constant, no two of them adjacent.

    Examples
    --------
    >>> signed_digits(47)
    [(-1, 0), (-1, 4), (1, 6)]
    """
    digits, shift = [], 0
    while constant:
        if constant & 1:
            sign = 2 - (constant & 3)
            digits.append((sign, shift))
            constant -= sign
        constant >>= 1
        shift += 1
    return digits


def _sum(terms: Sequence[tuple[int, Value]]) -> Value:
    """Sum of ``(sign, value)``, positive ones first; 0 of none."""
    total = Const(0, 1)
    for n, (sign, value) in enumerate(sorted(terms, key=lambda term: -term[0])):
        total = total + value if sign > 0 else total - value
        if n == 0 and sign > 0:
            total = value
    return total


class FusedCell(wiring.Component):
    """Fused cost of one label, ``C = (cost_factor * min(E, truncation) + census_weight * H) >> cost_shift``, floor,
    at most ``cost.cap``.

    ``H`` counts the bits in which the censuses differ. The golden models are :func:`golden.matcher.support.fuse` and
    :func:`golden.matcher.support.fused_cost`; outside the picture ``C`` is ``cost_outside``.

    Width: exact.

    Timing: ``cost`` is that of ``x - 1`` :attr:`LATENCY` cycles after column ``x``.

    Members
    -------
    left, right : In(ColumnSums())
        At ``x`` and at ``x - d``.
    left_census, right_census : In(census bits)
        At ``x - 1`` and at ``x - 1 - d``.
    inside : In(1)
        The right column is inside the picture, and the label is in use.
    valid3 : In(1)
        Whether ``left`` was valid three cycles ago.
    cost : Out(range(cost_max + 1))
    """
    LATENCY = BecCell.LATENCY + 2

    def __init__(self, config: MatcherConfig):
        self.config = config
        bits = config.refined.cost.neighbours
        super().__init__({
            "left": In(ColumnSums()), "right": In(ColumnSums()), "left_census": In(bits), "right_census": In(bits), "inside": In(1),
            "valid3": In(1),
            "cost": Out(range(config.refined.cost.maximum + 1)),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        parameters = self.config.refined.cost
        m.submodules.matching_cost = matching_cost = BecCell(self.config)
        m.d.comb += [
            matching_cost.left.eq(self.left), matching_cost.right.eq(self.right), matching_cost.inside.eq(self.inside),
            matching_cost.valid3.eq(self.valid3),
        ]

        # Stages 1 to 3: the Hamming distance; first of pairs of bits, which fit a table of four inputs as their sums do, then two sums a
        # stage.
        bits = range(0, parameters.neighbours, 2)
        differ = self.left_census ^ self.right_census
        counts = [differ[n] + differ[n + 1] if n + 1 < parameters.neighbours else differ[n] for n in bits]
        for stage, levels in enumerate((1, 2, 2), 1):
            for _ in range(levels):
                counts = [counts[n] + counts[n + 1] if n + 1 < len(counts) else counts[n] for n in range(0, len(counts), 2)]
            registers = [Signal.like(Value.cast(count), name=f"differ_{stage}_{n}", reset_less=True) for n, count in enumerate(counts)]
            m.d.sync += [register.eq(count) for register, count in zip(registers, counts)]
            counts = registers
        distance, = counts or [Const(0, 1)]

        # Stages 4 and 5: its weight, 0 outside the picture.
        terms = [(sign, distance << shift) for sign, shift in signed_digits(parameters.census_weight)][::-1]
        pairs = []
        for n in range(0, len(terms), 2):
            pair = Signal.like(_sum(terms[n:n + 2]), name=f"weighted_{n // 2}", reset_less=True)
            m.d.sync += pair.eq(_sum(terms[n:n + 2]))
            pairs.append((1, pair))
        weighted = Signal(range(parameters.census_weight * parameters.neighbours + 1), reset_less=True)
        m.d.sync += weighted.eq(_sum(pairs))
        with m.If(~matching_cost.cost_inside):
            m.d.sync += weighted.eq(0)

        # Stage 5: the first term; outside the picture `cost_outside`.
        energy = (~matching_cost.cost).as_unsigned()[:len(matching_cost.cost)]
        outside = Const(parameters.cost_outside << parameters.cost_shift)
        counted = [(sign, energy << shift) for sign, shift in signed_digits(parameters.cost_factor)]
        largest = max(parameters.cost_factor * parameters.truncation, parameters.cost_outside << parameters.cost_shift)
        first = Signal(range(largest + 1), reset_less=True)
        with m.If(~matching_cost.cost_inside):
            m.d.sync += first.eq(outside)
        with m.Elif(energy > parameters.truncation):
            m.d.sync += first.eq(parameters.cost_factor * parameters.truncation)
        with m.Else():
            m.d.sync += first.eq(_sum(counted))

        # Stage 6: both.
        total: Value = (first + weighted) >> parameters.cost_shift
        if parameters.cap < parameters.inside_max:
            total = Mux(total > parameters.cap, parameters.cap, total)
        m.d.sync += data_register(m, self.cost).eq(total)
        return m


class FusedGroup(wiring.Component):
    """Fused costs of a few neighbouring labels in the same cycle, their running sums, and the least sum so far.

    Golden: :func:`golden.matcher.support.fused_cost`, :func:`golden.matcher.vertical.vertical_support`,
    :func:`golden.matcher.support.support_sums`, :func:`golden.matcher.refine.right_view`.

    Width: a running sum is kept modulo the power of two above the greatest support sum; differences are exact.

    Timing: ``vertical`` of a wave is due with the costs of cells, :attr:`FusedCell.LATENCY` cycles after it, its ``sums`` with those that
    are joined, :meth:`cost_latency` cycles after it; ``total`` :attr:`TOTAL` cycles after ``ends``, ``least_i``
    :data:`hdl.matcher.streaming.labels.TREE` cycles after that, ``least_o`` one later; every other ``_o`` a cycle after its ``_i``.

    Memory: two rings of running sums for all labels of the group, one for each end of a support; that of :class:`VerticalSupport`.

    Members
    -------
    i : In(Wave(config, CensusWord(config))), o : Out(Wave(config, CensusWord(config)))
    vertical_i : In(VerticalWave(config)), vertical_o : Out(VerticalWave(config))
        With vertical support only.
    sums_i : In(SumWave(config)), sums_o : Out(SumWave(config))
    ends_i : In(Ends(config)), ends_o : Out(Ends(config))
    right_i : In(RightWave(config)), right_o : Out(RightWave(config))
    total : Out(ArrayLayout(data_bits, n))
        Complements of ``S``.
    least_i : In(Least(data_bits, D)), least_o : Out(Least(data_bits, D))
        Complement of the least sum; the smaller label on a tie.
    """
    TOTAL = 3

    def __init__(self, config: MatcherConfig, labels: range):
        self.config = config
        self.labels = labels
        least = Least(config.data_bits, config.labels)
        vertical = {"vertical_i": In(VerticalWave(config)), "vertical_o": Out(VerticalWave(config))}
        super().__init__({
            "i": In(Wave(config, CensusWord(config))), "o": Out(Wave(config, CensusWord(config))),
            **(vertical if config.method_as(Fused).vertical else {}),
            "sums_i": In(SumWave(config)), "sums_o": Out(SumWave(config)),
            "ends_i": In(Ends(config)), "ends_o": Out(Ends(config)),
            "right_i": In(RightWave(config)), "right_o": Out(RightWave(config)),
            "total": Out(data.ArrayLayout(config.data_bits, len(labels))),
            "least_i": In(least), "least_o": Out(least),
        })

    @staticmethod
    def cost_latency(config: MatcherConfig) -> int:
        """Cycles from a wave to the costs of the pixel that it completes."""
        return FusedCell.LATENCY + (VerticalSupport.LATENCY if config.method_as(Fused).vertical else 0)

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config, bits = self.config, self.config.data_bits
        valid = [self.i.valid]
        for stage in range(1, 4):
            valid.append(Signal(name=f"valid{stage}"))
            m.d.sync += valid[stage].eq(valid[stage - 1])

        costs = []
        for label, seen, inside in seen_along(m, self.labels, self.i, self.o):
            m.submodules[f"label_{label}"] = cell = FusedCell(config)
            m.d.comb += [
                cell.left.eq(self.i.left), cell.left_census.eq(self.i.left_census),
                cell.right.eq(seen["right"]), cell.right_census.eq(seen["right_census"]), cell.inside.eq(inside),
                cell.valid3.eq(valid[3]),
            ]
            costs.append(cell.cost)
        if config.method_as(Fused).vertical:
            m.submodules.vertical = vertical = VerticalSupport(config, self.labels)
            m.d.comb += [vertical.i.eq(self.vertical_i), self.vertical_o.eq(vertical.o), vertical.cost.eq(Cat(costs))]
            costs = list(vertical.joined)

        # The right view passes the costs.
        completion, right = self.sums_i.completion, self.right_i
        for label, cost in zip(self.labels, costs):
            m.submodules[f"right_{label}"] = right_cell = RightCell(config, label)
            m.d.comb += [right_cell.completion.eq(completion), right_cell.cost.eq(cost), right_cell.i.eq(right)]
            right = right_cell.o
        # To the group above, a cycle later: the state of the top label before this wave.
        m.d.sync += self.right_o.eq(right)

        # Running sums, each written before its pixel's cost is added.
        sums = Signal(data.ArrayLayout(bits, len(costs)), reset_less=True)
        enter = completion.clear | completion.complete
        with m.If(enter):
            m.d.sync += [total.eq(Mux(completion.clear, 0, total + cost)) for total, cost in zip(sums, costs)]
        ends = {}
        for name in ("low", "high"):
            m.submodules[name] = ring = Memory(
                shape=sums.shape(), depth=SupportSource.ring_of(config), init=[], attrs=NO_COLLISION)
            write, read = ring.write_port(), ring.read_port()
            m.d.comb += [
                write.addr.eq(self.sums_i.place), write.data.eq(sums), write.en.eq(enter),
                read.addr.eq(self.ends_i[name]), read.en.eq(1),
            ]
            ends[name] = Signal(sums.shape(), name=f"sum_{name}", reset_less=True)
            m.d.sync += ends[name].eq(read.data)
        # ~(high - low) == low + ~high in as many bits.
        total = data_register(m, self.total)
        m.d.sync += [value.eq(low + ~high) for value, low, high in zip(total, ends["low"], ends["high"])]
        m.d.sync += [self.sums_o.eq(self.sums_i), data_register(m, self.ends_o).eq(self.ends_i)]
        least_of(m, list(self.total), self.labels[0], self.least_i, self.least_o)
        return m


class FusedArray(CostArray):
    """Support sums of the fused cost, laid out along the labels, with the labels of the right picture.

    Golden: :func:`golden.matcher.support.support_sums`, :func:`golden.matcher.refine.right_view`, on joined costs with vertical support.
    The sums of a group of labels are written to a line memory of the group, which the labelling reads at a different time.

    Memory: ``D * depth`` sums, two rings of running sums a group, ``depth`` sizes.

    Members
    -------
    As of :class:`hdl.matcher.stage.CostArray`, and in ``sideband``:

    right : Out(range(D)), right_valid : Out(1)
        Labels of the right picture, in the order of its pixels.
    cost : Out(ArrayLayout(data_bits, D))
        ``cost`` again.
    """
    settings = ("minimum",)

    @staticmethod
    def columns_of(config: MatcherConfig) -> data.StructLayout:
        return CensusWord(config)

    @staticmethod
    def join_threshold_of(config: MatcherConfig) -> int | None:
        vertical = config.method_as(Fused).vertical
        return vertical.vertical_threshold if vertical else None

    @staticmethod
    def flush_waves_of(config: MatcherConfig) -> int:
        # A support needs pixels to the right of its centre, and a label of the right picture D of them.
        return max(config.labels, SupportSource.lag_of(config))

    @staticmethod
    def size_max_of(config: MatcherConfig) -> int:
        return config.method_as(Fused).arms.support_max

    @staticmethod
    def lag_of(config: MatcherConfig) -> int:
        return SupportSource.lag_of(config)

    @staticmethod
    def latency_of(config: MatcherConfig) -> int:
        return FusedGroup.cost_latency(config) + 1 + FusedGroup.TOTAL + TREE + len(groups_of(config))

    @staticmethod
    def sideband_of(config: MatcherConfig) -> wiring.Signature:
        return wiring.Signature({
            "right": Out(range(config.labels)), "right_valid": Out(1), "cost": Out(data.ArrayLayout(config.data_bits, config.labels)),
        })

    def __init__(self, config: MatcherConfig, depth: int):
        self.config = config
        self.depth = depth
        super().__init__({
            "i": In(Issue(config, FusedArray)),
            "queued": Out(Queued(config)),
            "queued_valid": Out(1),
            "address": In(range(depth)),
            "cost": Out(data.ArrayLayout(config.data_bits, config.labels)),
            "take": In(1),
            "size": Out(range(self.size_max_of(config) + 1)),
            "sideband": Out(self.sideband_of(config)),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        m.submodules.support = support = SupportSource(config, FusedGroup.cost_latency(config))
        m.d.comb += [
            support.completion.eq(self.i.completion), support.pixel.eq(self.i.pixel), support.pixel_valid.eq(self.i.pixel_valid),
        ]
        slot = support.slot

        m.submodules.memory = memory = LabelMemory(config, self.depth)
        m.submodules.store_delay = store_delay = Delay(1, FusedGroup.TOTAL, clean=True)
        m.d.comb += [
            store_delay.i.eq(slot.in_picture), memory.write.eq(store_delay.o), memory.address.eq(self.address),
            self.cost.eq(memory.o), self.sideband.cost.eq(memory.o),
        ]

        vertical = None
        if config.method_as(Fused).vertical:
            m.submodules.vertical = later = Delay(VerticalWave(config), FusedCell.LATENCY, clean=True)
            m.d.comb += later.i.eq(self.i.vertical)
            vertical = later.o
        wave, sums, ends = self.i.wave, support.sums, support.ends
        # Nothing enters the lowest group from below.
        right, least = Signal(RightWave(config)), Signal(Least(config.data_bits, config.labels))
        for labels in groups_of(config):
            m.submodules[f"group_{labels[0]}"] = group = FusedGroup(config, labels)
            m.d.comb += [
                group.i.eq(wave), group.sums_i.eq(sums), group.ends_i.eq(ends),
                *(memory.words[label].eq(group.total[n]) for n, label in enumerate(labels)),
            ]
            if vertical is not None:
                m.d.comb += group.vertical_i.eq(vertical)
                vertical = group.vertical_o
            m.d.comb += [group.least_i.eq(least), group.right_i.eq(right)]
            wave, sums, ends, right, least = group.o, group.sums_o, group.ends_o, group.right_o, group.least_o

        # The label of a right pixel is final once it has passed the top label: `right` as the next pixel advances.
        completed = Signal()
        completion = group.sums_i.completion
        m.d.sync += completed.eq(completion.complete | completion.leads if config.lead else completion.complete)
        m.d.comb += [self.sideband.right.eq(right.least.index), self.sideband.right_valid.eq(completed & right.in_picture)]

        waiting = data.StructLayout({"pixel": Pixel(), "valid": 1})
        m.submodules.pixel_delay = pixel_delay = Delay(waiting, FusedGroup.TOTAL + TREE + len(groups_of(config)), clean=True)
        m.d.comb += [
            pixel_delay.i.pixel.eq(slot.pixel), pixel_delay.i.valid.eq(slot.pixel_valid),
            self.queued.pixel.eq(pixel_delay.o.pixel), self.queued.local.eq(least.index),
            self.queued_valid.eq(pixel_delay.o.valid),
        ]

        # Sizes are kept until their pixel is admitted, a line later.
        m.submodules.sizes = sizes = Memory(shape=slot.support_size.shape(), depth=self.depth, init=[], attrs=NO_COLLISION)
        write, read = sizes.write_port(), sizes.read_port()
        write_index, read_index = Signal(range(self.depth)), Signal(range(self.depth))
        for index, step in ((write_index, slot.in_picture), (read_index, self.take)):
            with m.If(step):
                m.d.sync += index.eq(Mux(index == self.depth - 1, 0, index + 1))
        m.d.comb += [
            write.addr.eq(write_index), write.data.eq(slot.support_size), write.en.eq(slot.in_picture),
            read.addr.eq(read_index), read.en.eq(self.take), self.size.eq(read.data),
        ]
        return m
