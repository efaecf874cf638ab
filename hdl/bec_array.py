"""BEC at one pixel a cycle: an array of cells, one a label.

A group of labels works one cycle after the group below it, so nothing is broadcast: all that a cell needs comes from its neighbour's
registers or from a memory with an address of its own. The cells never stop; which waves are real is told beside them.
"""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, PIXEL_MAX, MatcherConfig

from .delay import Delay, add_with_carry, data_register
from .stream import Column, Least


__all__ = ["BecArray", "BecCell", "BecGroup", "BecWave"]


class BecWave(data.StructLayout):
    """A column on its way along the labels: left at ``x``, right at ``x - d``.

    ``inside``: ``d <= x``; ``pre``: it is the column before the line. ``in_use``: labels in use, with or without ``valid``.
    """
    def __init__(self, config: MatcherConfig):
        super().__init__({
            "valid": 1, "pre": 1, "inside": 1, "left": Column(), "right": Column(), "in_use": range(config.disparities + 1),
        })


class BecCell(wiring.Component):
    """Matching cost (2-12) of one label, ``LINEAR`` arithmetic.

    Nothing is halved, so the five differences come from ``e = left(x) - right(x - d)`` of three lines: ``|2e|``, ``|e + e_above|``,
    ``|e + e_below|``, ``|e + e(x-1)|`` and, when the next column comes, ``|e + e(x+1)|``. The golden model is
    :func:`golden.cost.matching_cost`.

    ``cost`` is the one's complement of ``E``: outside the picture it is 0, the greatest cost, which a synchronous clear gives for nothing.

    Width: exact. ``|v|`` is ``(v ^ sign) + sign``; the signs enter the sums as carries.

    Timing: :attr:`LATENCY` cycles after column ``x`` the cell shows the cost of ``x - 1``.

    Members
    -------
    left, right : In(Column())
        At ``x`` and at ``x - d``.
    inside : In(1)
        The right column is one, and the label is in use.
    valid1, valid4 : In(1)
        Whether there was a column one and four cycles ago.
    cost : Out(cost_bits)
        Complement of ``E``.
    """
    LATENCY = 5

    def __init__(self, config: MatcherConfig):
        self.config = config
        super().__init__({
            "left": In(Column()), "right": In(Column()), "inside": In(1),
            "valid1": In(1), "valid4": In(1),
            "cost": Out(config.cost_bits),
        })

    def elaborate(self, platform):
        m = Module()

        # Stage 1: differences.
        inside = [self.inside]
        for stage in range(1, 5):
            inside.append(Signal(name=f"inside{stage}", reset_less=True))
            m.d.sync += inside[stage].eq(inside[stage - 1])
        difference = {}
        for part in ("minus", "line", "plus"):
            difference[part] = Signal(signed(PIXEL_BITS + 1), name=f"difference_{part}", reset_less=True)
            m.d.sync += difference[part].eq(self.left[part] - self.right[part])

        # Stage 2: sums of neighbours. `own` holds e of the latest real column: of x - 1 for this stage, of x for the next.
        own     = Signal(signed(PIXEL_BITS + 1), reset_less=True)
        above   = Signal(signed(PIXEL_BITS + 2), reset_less=True)
        below   = Signal(signed(PIXEL_BITS + 2), reset_less=True)
        beside  = Signal(signed(PIXEL_BITS + 2), reset_less=True)
        with m.If(self.valid1):
            m.d.sync += own.eq(difference["line"])
        m.d.sync += [
            above.eq(difference["line"] + difference["minus"]),
            below.eq(difference["line"] + difference["plus"]),
            beside.eq(difference["line"] + own),
        ]

        # Stage 3: signs out.
        sign, size = {}, {}
        for name, value in (("own", own), ("above", above), ("below", below), ("beside", beside)):
            sign[name] = Signal(name=f"sign_{name}", reset_less=True)
            size[name] = Signal(len(value) - 1, name=f"size_{name}", reset_less=True)
            m.d.sync += [sign[name].eq(value[-1]), size[name].eq(value[:-1] ^ value[-1].replicate(len(value) - 1))]

        # Stage 4: sums, each with one sign; `side` is |e + e(x-1)| itself, for it serves two pixels.
        vertical  = Signal(range(4 * PIXEL_MAX + 1), reset_less=True)
        sideways  = Signal(range(4 * PIXEL_MAX + 1), reset_less=True)
        side      = Signal(range(2 * PIXEL_MAX + 1), reset_less=True)
        sign_side = Signal(reset_less=True)
        sign_last = Signal(reset_less=True)
        m.d.sync += [
            vertical.eq(add_with_carry(size["above"], size["below"], sign["above"])),
            sideways.eq(add_with_carry(Cat(sign["own"], size["own"]), size["beside"], sign["own"])),  # 2 * (size + sign) + beside
            side.eq(size["beside"] + sign["beside"]),
            sign_side.eq(sign["beside"]), sign_last.eq(sign["below"]),
        ]

        # Stage 5: the pixel before is completed by this one's left difference, then this one takes its place.
        total        = Signal(range(8 * PIXEL_MAX + 1), reset_less=True)
        total_sign   = Signal(reset_less=True)
        total_inside = Signal(reset_less=True)
        with m.If(self.valid4):
            m.d.sync += [
                total.eq(add_with_carry(vertical, sideways, sign_last)),
                total_sign.eq(sign_side), total_inside.eq(inside[4]),
            ]
        # ~(total + side + sign) == ~total + ~side + ~sign in as many bits.
        bits = self.config.cost_bits
        complement = [Cat(~part, Const(-1, bits - len(part))) for part in (total, side)]
        m.d.sync += data_register(m, self.cost).eq(Mux(total_inside, add_with_carry(*complement, ~total_sign)[:bits], 0))
        return m


class BecGroup(wiring.Component):
    """Matching costs of a few neighbouring labels in the same cycle, and the least cost so far.

    Within a group the left column is shared and the right one moves on by a register a label; between groups all moves on by one more.
    Golden: :func:`golden.cost.matching_cost`, :func:`golden.cost.local_disparity`.

    Timing: ``cost`` as of :class:`BecCell`, ``least_i`` :attr:`TREE` cycles after it, ``least_o`` one later; ``o`` one after ``i``.

    Members
    -------
    i : In(BecWave(config)), o : Out(BecWave(config))
        From the group below, to the group above.
    cost : Out(ArrayLayout(cost_bits, n))
        Complements of ``E``.
    least_i : In(Least(cost_bits, D)), least_o : Out(Least(cost_bits, D))
        Complement of the least cost; the smaller label on a tie.
    """
    SIZE = 4
    TREE = (SIZE - 1).bit_length()

    def __init__(self, config: MatcherConfig, labels: range):
        self.config = config
        self.labels = labels
        least = Least(config.cost_bits, config.disparities)
        super().__init__({
            "i": In(BecWave(config)), "o": Out(BecWave(config)),
            "cost": Out(data.ArrayLayout(config.cost_bits, len(labels))),
            "least_i": In(least), "least_o": Out(least),
        })

    def elaborate(self, platform):
        m = Module()
        valid = [self.i.valid]
        for stage in range(1, 5):
            valid.append(Signal(name=f"valid{stage}"))
            m.d.sync += valid[stage].eq(valid[stage - 1])

        # A label looks one pixel further left than the label below it: at the right column of the wave before.
        right, inside = self.i.right, self.i.inside
        costs = []
        for n, label in enumerate(self.labels):
            m.submodules[f"label_{label}"] = cell = BecCell(self.config)
            m.d.comb += [
                cell.left.eq(self.i.left), cell.right.eq(right), cell.inside.eq(inside & (self.i.in_use > label)),
                cell.valid1.eq(valid[1]), cell.valid4.eq(valid[4]), self.cost[n].eq(cell.cost),
            ]
            costs.append(cell.cost)
            before        = Signal(Column(), name=f"right_{label}", reset_less=True)
            before_inside = Signal(name=f"inside_{label}", reset_less=True)
            with m.If(self.i.valid):
                m.d.sync += [before.eq(right), before_inside.eq(inside)]
            right, inside = before, before_inside & ~self.i.pre
        m.d.sync += self.o.valid.eq(self.i.valid)
        m.d.sync += [data_register(m, self.o[field], f"o_{field}").eq(value) for field, value in (
            ("pre", self.i.pre), ("left", self.i.left), ("right", right), ("inside", inside), ("in_use", self.i.in_use))]

        # The least of the group; the greatest complement. The lower label stands first and stays on a tie.
        rivals = [(cost, Const(0, 0)) for cost in costs]
        for level in range(self.TREE):
            winners = []
            for n in range(0, len(rivals), 2):
                value = Signal(self.config.cost_bits, name=f"least_{level}_{n // 2}", reset_less=True)
                index = Signal(level + 1, name=f"label_{level}_{n // 2}", reset_less=True)
                (low, low_index), (high, high_index) = rivals[n], rivals[min(n + 1, len(rivals) - 1)]
                above = high > low
                m.d.sync += [value.eq(Mux(above, high, low)), index.eq(Mux(above, Cat(high_index, Const(1, 1)), low_index))]
                winners.append((value, index))
            rivals = winners
        (value, index), = rivals
        first = self.labels[0]
        least_o = data_register(m, self.least_o)
        if first == 0:
            m.d.sync += [least_o.value.eq(value), least_o.index.eq(index)]
        else:
            with m.If(value > self.least_i.value):
                m.d.sync += [least_o.value.eq(value), least_o.index.eq(first + index)]
            with m.Else():
                m.d.sync += least_o.eq(self.least_i)
        return m


class BecArray(wiring.Component):
    """Basic energy calculation, laid out along the labels; golden: :func:`golden.cost.matching_cost`, :func:`golden.cost.local_disparity`.

    The costs of a group of labels go to a line memory of the group, which the labelling reads at its own pace; a few registers make the
    skew of one cycle a label within the group.

    Timing: ``local`` :meth:`latency_of` cycles after the wave that completed its pixel. The cost that was ``store``-th is read at
    ``address`` ``store % depth``; label ``d`` shows it in ``cost[d]`` ``d + 2`` cycles after ``address``.

    Memory: ``D * depth`` costs; a word of a memory holds those of a group, 48 bits for four labels.

    Members
    -------
    wave : In(BecWave(config)), store : In(1)
    local : Out(range(D))
    address : In(range(depth))
    cost : Out(ArrayLayout(cost_bits, D))
        Complements.
    """
    def __init__(self, config: MatcherConfig, depth):
        self.config = config
        self.depth = depth
        self.groups = self.groups_of(config)
        super().__init__({
            "wave": In(BecWave(config)),
            "store": In(1),
            "local": Out(range(config.disparities)),
            "address": In(range(depth)),
            "cost": Out(data.ArrayLayout(config.cost_bits, config.disparities)),
        })

    @staticmethod
    def groups_of(config: MatcherConfig):
        """The labels of each group."""
        return [range(low, min(low + BecGroup.SIZE, config.disparities)) for low in range(0, config.disparities, BecGroup.SIZE)]

    @staticmethod
    def latency_of(config: MatcherConfig):
        """Cycles from a wave to the local disparity that it completes."""
        return BecCell.LATENCY + BecGroup.TREE + len(BecArray.groups_of(config))

    def elaborate(self, platform):
        m = Module()
        config, depth = self.config, self.depth

        # Where the next cost goes; the order walks from group to group as the waves do.
        place = Signal(range(depth))
        m.submodules.store_delay = store_delay = Delay(1, BecCell.LATENCY - 1, clean=True)
        m.d.comb += store_delay.i.eq(self.store)
        with m.If(store_delay.o):
            m.d.sync += place.eq(Mux(place == depth - 1, 0, place + 1))
        write, write_place = store_delay.o, place
        read_place = self.address

        wave, least = self.wave, None
        for labels in self.groups:
            later       = Signal(name=f"write_{labels[0]}")
            later_place = Signal(range(depth), name=f"write_place_{labels[0]}", reset_less=True)
            m.d.sync += [later.eq(write), later_place.eq(write_place)]
            write, write_place = later, later_place

            m.submodules[f"group_{labels[0]}"] = group = BecGroup(config, labels)
            m.d.comb += group.i.eq(wave)
            if least is not None:
                m.d.comb += group.least_i.eq(least)
            wave, least = group.o, group.least_o

            m.submodules[f"edata_{labels[0]}"] = memory = Memory(shape=group.cost.shape(), depth=depth, init=[])
            write_port = memory.write_port()
            read_port = memory.read_port()
            # A group reads as many cycles after the one below it as that one has labels.
            if labels[0]:
                for stage in range(BecGroup.SIZE):
                    before, read_place = read_place, Signal(range(depth), name=f"read_place_{labels[0]}_{stage}", reset_less=True)
                    m.d.sync += read_place.eq(before)
            m.d.comb += [
                write_port.en.eq(write), write_port.addr.eq(write_place), write_port.data.eq(group.cost),
                read_port.en.eq(1), read_port.addr.eq(read_place),
            ]
            for n, label in enumerate(labels):
                m.submodules[f"skew_{label}"] = skew = Delay(config.cost_bits, 1 + n)
                m.d.comb += [skew.i.eq(read_port.data[n]), self.cost[label].eq(skew.o)]
        m.d.comb += self.local.eq(least.index)
        return m
