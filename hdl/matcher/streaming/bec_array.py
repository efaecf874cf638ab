"""BEC at one pixel a cycle: an array of cells, one a label.

A group of labels works one cycle after the group below it, so nothing is broadcast: all inputs of a cell are registers of its neighbour or
the group's memory. The cells never stall; flags that travel with the waves tell which are valid.
"""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_MAX, MatcherConfig

from ...parts.arithmetic import add_with_carry
from ...parts.delay import Delay, data_register
from ..stage import CostArray
from ..stream import ColumnWord, Least
from .labels import TREE, LabelMemory, Queued, groups_of, least_of, seen_along
from .waves import ColumnSums, Issue, Pixel, Wave


__all__ = ["BecArray", "BecCell", "BecGroup"]


class BecCell(wiring.Component):
    """Matching cost (2-12) of one label, ``LINEAR`` arithmetic.

    Nothing is halved, so the five differences follow from ``e = left(x) - right(x - d)`` of three lines: ``|2e|``, ``|e + e_above|``,
    ``|e + e_below|``, ``|e + e(x-1)|`` and, with the next column, ``|e + e(x+1)|``. A column has the sums of its pixel with its neighbours,
    so that ``e + e_above`` is one difference. The golden model is :func:`golden.matcher.cost.matching_cost`.

    ``cost`` is the one's complement of ``E``: outside the picture it is 0, the greatest cost, by a synchronous clear.

    Width: exact. ``|v|`` is ``(v ^ sign) + sign``; the signs enter the sums as carries.

    Timing: ``cost`` is that of ``x - 1`` :attr:`LATENCY` cycles after column ``x``.

    Members
    -------
    left, right : In(ColumnSums())
        At ``x`` and at ``x - d``.
    inside : In(1)
        The right column is inside the picture, and the label is in use.
    valid3 : In(1)
        Whether ``left`` was valid three cycles ago.
    cost : Out(cost_bits)
        Complement of ``E``.
    cost_inside : Out(1)
        Whether it is that of a candidate inside the picture.
    """
    LATENCY = 4

    def __init__(self, config: MatcherConfig):
        self.config = config
        super().__init__({
            "left": In(ColumnSums()), "right": In(ColumnSums()), "inside": In(1), "valid3": In(1),
            "cost": Out(config.matching_cost.bits), "cost_inside": Out(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()

        # Stage 1: differences, `centre` of pixels, the others of sums with their neighbours: e + e_above and so on.
        inside = [self.inside]
        for stage in range(1, 4):
            inside.append(Signal(name=f"inside{stage}", reset_less=True))
            m.d.sync += inside[stage].eq(inside[stage - 1])
        difference = {}
        for name, part in (("centre", "line"), ("above", "above"), ("below", "below"), ("across", "across")):
            difference[name] = Signal(signed(len(self.left[part]) + 1), name=f"difference_{name}", reset_less=True)
            m.d.sync += difference[name].eq(self.left[part] - self.right[part])

        # Stage 2: signs out.
        sign, size = {}, {}
        for name, value in difference.items():
            sign[name] = Signal(name=f"sign_{name}", reset_less=True)
            size[name] = Signal(len(value) - 1, name=f"size_{name}", reset_less=True)
            m.d.sync += [sign[name].eq(value[-1]), size[name].eq(value[:-1] ^ value[-1].replicate(len(value) - 1))]

        # Stage 3: sums, each with one sign; `side` is |e + e(x-1)| itself, as two pixels use it.
        vertical  = Signal(range(4 * PIXEL_MAX + 1), reset_less=True)
        sideways  = Signal(range(4 * PIXEL_MAX + 1), reset_less=True)
        side      = Signal(range(2 * PIXEL_MAX + 1), reset_less=True)
        sign_side = Signal(reset_less=True)
        sign_last = Signal(reset_less=True)
        m.d.sync += [
            vertical.eq(add_with_carry(size["above"], size["below"], sign["above"])),
            sideways.eq(add_with_carry(Cat(sign["centre"], size["centre"]), size["across"], sign["centre"])),  # 2 * (size + sign) + across
            side.eq(size["across"] + sign["across"]),
            sign_side.eq(sign["across"]), sign_last.eq(sign["below"]),
        ]

        # Stage 4: this pixel's left difference completes the pixel before, which this one then replaces.
        total        = Signal(range(8 * PIXEL_MAX + 1), reset_less=True)
        total_sign   = Signal(reset_less=True)
        total_inside = Signal(reset_less=True)
        with m.If(self.valid3):
            m.d.sync += [
                total.eq(add_with_carry(vertical, sideways, sign_last)),
                total_sign.eq(sign_side), total_inside.eq(inside[3]),
            ]
        # ~(total + side + sign) == ~total + ~side + ~sign in as many bits.
        bits = self.config.matching_cost.bits
        not_total, not_side = (Cat(~part, Const(-1, bits - len(part))) for part in (total, side))
        m.d.sync += data_register(m, self.cost).eq(Mux(total_inside, add_with_carry(not_total, not_side, ~total_sign)[:bits], 0))
        m.d.sync += data_register(m, self.cost_inside).eq(total_inside)
        return m


class BecGroup(wiring.Component):
    """Matching costs of a few neighbouring labels in the same cycle, and the least cost so far.

    Within a group the left column is shared and the right one is delayed by a register a label; between groups both by one more.
    Golden: :func:`golden.matcher.cost.matching_cost`, :func:`golden.matcher.cost.local_disparity`.

    Timing: ``cost`` as of :class:`BecCell`, ``least_i`` :data:`TREE` cycles after it, ``least_o`` one later; ``o`` one after ``i``.

    Members
    -------
    i : In(Wave(config, ColumnWord())), o : Out(Wave(config, ColumnWord()))
        From the group below, to the group above.
    cost : Out(ArrayLayout(cost_bits, n))
        Complements of ``E``.
    least_i : In(Least(cost_bits, D)), least_o : Out(Least(cost_bits, D))
        Complement of the least cost; the smaller label on a tie.
    """
    def __init__(self, config: MatcherConfig, labels: range):
        self.config = config
        self.labels = labels
        least = Least(config.matching_cost.bits, config.labels)
        super().__init__({
            "i": In(Wave(config, ColumnWord())), "o": Out(Wave(config, ColumnWord())),
            "cost": Out(data.ArrayLayout(config.matching_cost.bits, len(labels))),
            "least_i": In(least), "least_o": Out(least),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        valid = [self.i.valid]
        for stage in range(1, 4):
            valid.append(Signal(name=f"valid{stage}"))
            m.d.sync += valid[stage].eq(valid[stage - 1])

        costs: list[Value] = []
        for label, seen, inside in seen_along(m, self.labels, self.i, self.o):
            m.submodules[f"label_{label}"] = cell = BecCell(self.config)
            m.d.comb += [
                cell.left.eq(self.i.left), cell.right.eq(seen["right"]), cell.inside.eq(inside),
                cell.valid3.eq(valid[3]), self.cost[len(costs)].eq(cell.cost),
            ]
            costs.append(cell.cost)
        least_of(m, costs, self.labels[0], self.least_i, self.least_o)
        return m


class BecArray(CostArray):
    """Basic energy calculation, laid out along the labels.

    Golden: :func:`golden.matcher.cost.matching_cost`, :func:`golden.matcher.cost.local_disparity`. The costs of a group of labels go to
    a line memory of the group, which the labelling reads at its centre pace.

    Memory: ``D * depth`` costs, 48 bits for four labels, see :class:`LabelMemory`.

    Members
    -------
    As of :class:`hdl.matcher.stage.CostArray`.
    """
    @staticmethod
    def columns_of(config: MatcherConfig) -> data.StructLayout:
        return ColumnWord()

    @staticmethod
    def latency_of(config: MatcherConfig) -> int:
        return BecCell.LATENCY + TREE + len(groups_of(config))

    def __init__(self, config: MatcherConfig, depth: int):
        self.config = config
        self.depth = depth
        super().__init__({
            "i": In(Issue(config, BecArray)),
            "queued": Out(Queued(config)),
            "queued_valid": Out(1),
            "address": In(range(depth)),
            "cost": Out(data.ArrayLayout(config.data_bits, config.labels)),
            "sideband": Out(self.sideband_of(config)),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        m.submodules.edata = edata = LabelMemory(config, self.depth)
        m.submodules.store_delay = store_delay = Delay(1, BecCell.LATENCY, clean=True)
        m.d.comb += [
            store_delay.i.eq(self.i.store), edata.write.eq(store_delay.o), edata.address.eq(self.address), self.cost.eq(edata.o),
        ]

        wave, least = self.i.wave, Signal(Least(config.data_bits, config.labels))  # the lowest group has none below and ignores it
        for labels in groups_of(config):
            m.submodules[f"group_{labels[0]}"] = group = BecGroup(config, labels)
            m.d.comb += [group.i.eq(wave), *(edata.words[label].eq(group.cost[n]) for n, label in enumerate(labels))]
            m.d.comb += group.least_i.eq(least)
            wave, least = group.o, group.least_o

        waiting = data.StructLayout({"pixel": Pixel(), "valid": 1})
        m.submodules.pixel_delay = pixel_delay = Delay(waiting, self.latency_of(config), clean=True)
        m.d.comb += [
            pixel_delay.i.pixel.eq(self.i.pixel), pixel_delay.i.valid.eq(self.i.pixel_valid),
            self.queued.pixel.eq(pixel_delay.o.pixel), self.queued.local.eq(least.index),
            self.queued_valid.eq(pixel_delay.o.valid),
        ]
        return m
