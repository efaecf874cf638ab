"""BEC at one pixel a cycle: an array of cells, one a label.

A group of labels works one cycle after the group below it, so nothing is broadcast: all that a cell needs comes from its neighbour's
registers or from a memory with an address of its own. The cells never stop; which waves are real is told beside them.
"""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, PIXEL_MAX, MatcherConfig

from ...parts.arithmetic import add_with_carry
from ...parts.delay import NO_COLLISION, Delay, data_register
from ..stream import Column, Least
from .waves import BecWave, Pixel


__all__ = ["BecArray", "BecCell", "BecGroup", "LabelMemory", "Queued", "groups_of", "least_of", "seen_along"]


class BecCell(wiring.Component):
    """Matching cost (2-12) of one label, ``LINEAR`` arithmetic.

    Nothing is halved, so the five differences come from ``e = left(x) - right(x - d)`` of three lines: ``|2e|``, ``|e + e_above|``,
    ``|e + e_below|``, ``|e + e(x-1)|`` and, when the next column comes, ``|e + e(x+1)|``. The golden model is
    :func:`golden.matcher.cost.matching_cost`.

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
    inside_later : Out(1)
        ``inside``, :attr:`INSIDE_LATER` cycles later.
    cost : Out(cost_bits)
        Complement of ``E``.
    cost_inside : Out(1)
        Whether it is that of a candidate inside the picture.
    """
    LATENCY = 5
    INSIDE_LATER = 3

    def __init__(self, config: MatcherConfig):
        self.config = config
        super().__init__({
            "left": In(Column()), "right": In(Column()), "inside": In(1),
            "valid1": In(1), "valid4": In(1),
            "inside_later": Out(1),
            "cost": Out(config.method.matching_cost.bits), "cost_inside": Out(1),
        })

    def elaborate(self, platform):
        m = Module()

        # Stage 1: differences.
        inside = [self.inside]
        for stage in range(1, 5):
            inside.append(Signal(name=f"inside{stage}", reset_less=True))
            m.d.sync += inside[stage].eq(inside[stage - 1])
        m.d.comb += self.inside_later.eq(inside[self.INSIDE_LATER])
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
        bits = self.config.method.matching_cost.bits
        complement = [Cat(~part, Const(-1, bits - len(part))) for part in (total, side)]
        m.d.sync += data_register(m, self.cost).eq(Mux(total_inside, add_with_carry(*complement, ~total_sign)[:bits], 0))
        m.d.sync += data_register(m, self.cost_inside).eq(total_inside)
        return m


def seen_along(m, labels, i, o):
    """What the labels of a group see of the right picture; hands the wave on to the group above, a cycle later.

    Parameters
    ----------
    m : Module
    labels : range
    i, o : View of BecWave
        The wave as it comes in, and where it goes.

    Yields
    ------
    label : int
    seen : dict of str to Value
        The wave's fields of the right picture at ``x - label``.
    inside : Value
        Whether there is one, and the label is in use.
    """
    shape = i.shape()
    seen, inside = {name: i[name] for name in shape.members if name.startswith("right")}, i.inside
    for label in labels:
        yield label, seen, inside & (i.in_use > label)
        # The next label looks one pixel further left: at the right column of the wave before.
        before = {name: Signal.like(value, name=f"{name}_{label}", reset_less=True) for name, value in seen.items()}
        before_inside = Signal(name=f"inside_{label}", reset_less=True)
        with m.If(i.valid):
            m.d.sync += [register.eq(seen[name]) for name, register in before.items()]
            m.d.sync += before_inside.eq(inside)
        seen, inside = before, before_inside & ~i.pre
    m.d.sync += o.valid.eq(i.valid)
    moved = {name: i[name] for name in shape.members if name != "valid"} | seen | {"inside": inside}
    m.d.sync += [data_register(m, o[name], f"o_{name}").eq(value) for name, value in moved.items()]


#: Levels of a group's tree, each a register.
TREE = 2


def least_of(m, values, first, least_i, least_o):
    """The least of a group and of those below it; all are complements, hence the greatest. The smaller label stays on a tie.

    ``least_i`` is due :data:`TREE` cycles after ``values``, ``least_o`` comes a cycle later.
    """
    # The lower label stands first.
    rivals = [(value, Const(0, 0)) for value in values]
    for level in range(TREE):
        winners = []
        for n in range(0, len(rivals), 2):
            value = Signal.like(values[0], name=f"least_{level}_{n // 2}", reset_less=True)
            index = Signal(level + 1, name=f"label_{level}_{n // 2}", reset_less=True)
            (low, low_index), (high, high_index) = rivals[n], rivals[min(n + 1, len(rivals) - 1)]
            above = high > low
            m.d.sync += [value.eq(Mux(above, high, low)), index.eq(Mux(above, Cat(high_index, Const(1, 1)), low_index))]
            winners.append((value, index))
        rivals = winners
    (value, index), = rivals
    register = data_register(m, least_o)
    if first == 0:
        m.d.sync += [register.value.eq(value), register.index.eq(index)]
    else:
        with m.If(value > least_i.value):
            m.d.sync += [register.value.eq(value), register.index.eq(first + index)]
        with m.Else():
            m.d.sync += register.eq(least_i)


#: Labels that work in the same cycle.
GROUP = 4


def groups_of(config: MatcherConfig):
    """The labels of each group."""
    return [range(low, min(low + GROUP, config.labels)) for low in range(0, config.labels, GROUP)]


class BecGroup(wiring.Component):
    """Matching costs of a few neighbouring labels in the same cycle, and the least cost so far.

    Within a group the left column is shared and the right one moves on by a register a label; between groups all moves on by one more.
    Golden: :func:`golden.matcher.cost.matching_cost`, :func:`golden.matcher.cost.local_disparity`.

    Timing: ``cost`` as of :class:`BecCell`, ``least_i`` :data:`TREE` cycles after it, ``least_o`` one later; ``o`` one after ``i``.

    Members
    -------
    i : In(BecWave(config)), o : Out(BecWave(config))
        From the group below, to the group above.
    cost : Out(ArrayLayout(cost_bits, n))
        Complements of ``E``.
    least_i : In(Least(cost_bits, D)), least_o : Out(Least(cost_bits, D))
        Complement of the least cost; the smaller label on a tie.
    """
    def __init__(self, config: MatcherConfig, labels: range):
        self.config = config
        self.labels = labels
        least = Least(config.method.matching_cost.bits, config.labels)
        super().__init__({
            "i": In(BecWave(config)), "o": Out(BecWave(config)),
            "cost": Out(data.ArrayLayout(config.method.matching_cost.bits, len(labels))),
            "least_i": In(least), "least_o": Out(least),
        })

    def elaborate(self, platform):
        m = Module()
        valid = [self.i.valid]
        for stage in range(1, 5):
            valid.append(Signal(name=f"valid{stage}"))
            m.d.sync += valid[stage].eq(valid[stage - 1])

        costs = []
        for label, seen, inside in seen_along(m, self.labels, self.i, self.o):
            m.submodules[f"label_{label}"] = cell = BecCell(self.config)
            m.d.comb += [
                cell.left.eq(self.i.left), cell.right.eq(seen["right"]), cell.inside.eq(inside),
                cell.valid1.eq(valid[1]), cell.valid4.eq(valid[4]), self.cost[len(costs)].eq(cell.cost),
            ]
            costs.append(cell.cost)
        least_of(m, costs, self.labels[0], self.least_i, self.least_o)
        return m


class Queued(data.StructLayout):
    """A pixel to be labelled, and the local disparity of the one below it."""
    def __init__(self, config: MatcherConfig):
        super().__init__({"pixel": Pixel(), "local": range(config.labels)})


class LabelMemory(wiring.Component):
    """A line of data terms: written as they come, a group of labels after the other, read a label after the other.

    Timing: ``words`` of a group are due a cycle after those of the group below it, those of label 0 with ``write``. What was written
    ``n``-th is read at ``address`` ``n % depth``; label ``d`` shows it in ``o[d]`` ``d + 2`` cycles after ``address``.

    Memory: ``D * depth`` words; a word of a memory holds those of a group.

    Members
    -------
    write : In(1)
    words : In(ArrayLayout(data_bits, D))
    address : In(range(depth))
    o : Out(ArrayLayout(data_bits, D))
    """
    def __init__(self, config: MatcherConfig, depth):
        self.config = config
        self.depth = depth
        words = data.ArrayLayout(config.data_bits, config.labels)
        super().__init__({"write": In(1), "words": In(words), "address": In(range(depth)), "o": Out(words)})

    def elaborate(self, platform):
        m = Module()
        bits, depth = self.config.data_bits, self.depth

        # Where the next words go; the order walks from group to group as the waves do.
        place = Signal(range(depth))
        with m.If(self.write):
            m.d.sync += place.eq(Mux(place == depth - 1, 0, place + 1))
        write, write_place, read_place = self.write, place, self.address
        for labels in groups_of(self.config):
            if labels[0]:
                later       = Signal(name=f"write_{labels[0]}")
                later_place = Signal(range(depth), name=f"write_place_{labels[0]}", reset_less=True)
                m.d.sync += [later.eq(write), later_place.eq(write_place)]
                write, write_place = later, later_place
                # A group reads as many cycles after the one below it as that one has labels.
                for stage in range(GROUP):
                    before, read_place = read_place, Signal(range(depth), name=f"read_place_{labels[0]}_{stage}", reset_less=True)
                    m.d.sync += read_place.eq(before)
            m.submodules[f"memory_{labels[0]}"] = memory = Memory(
                shape=data.ArrayLayout(bits, len(labels)), depth=depth, init=[], attrs=NO_COLLISION)
            write_port = memory.write_port()
            read_port = memory.read_port()
            m.d.comb += [
                write_port.en.eq(write), write_port.addr.eq(write_place),
                *(write_port.data[n].eq(self.words[label]) for n, label in enumerate(labels)),
                read_port.en.eq(1), read_port.addr.eq(read_place),
            ]
            for n, label in enumerate(labels):
                m.submodules[f"skew_{label}"] = skew = Delay(bits, 1 + n)
                m.d.comb += [skew.i.eq(read_port.data[n]), self.o[label].eq(skew.o)]
        return m


class BecArray(wiring.Component):
    """Basic energy calculation, laid out along the labels; golden: :func:`golden.matcher.cost.matching_cost`,
    :func:`golden.matcher.cost.local_disparity`.

    The costs of a group of labels go to a line memory of the group, which the labelling reads at its own pace.

    Timing: ``queued`` :meth:`latency_of` cycles after the wave that completed its pixel. The cost that was ``store``-th is read at
    ``address`` ``store % depth``; label ``d`` shows it in ``cost[d]`` ``d + 2`` cycles after ``address``.

    Memory: ``D * depth`` costs, 48 bits for four labels, see :class:`LabelMemory`.

    Members
    -------
    wave : In(BecWave(config)), store : In(1)
    pixel : In(Pixel()), pixel_valid : In(1)
        The pixel to be labelled that the wave's pixel is below of.
    queued : Out(Queued(config)), queued_valid : Out(1)
    address : In(range(depth))
    cost : Out(ArrayLayout(cost_bits, D))
        Complements.
    """
    def __init__(self, config: MatcherConfig, depth):
        self.config = config
        self.depth = depth
        super().__init__({
            "wave": In(BecWave(config)),
            "store": In(1),
            "pixel": In(Pixel()),
            "pixel_valid": In(1),
            "queued": Out(Queued(config)),
            "queued_valid": Out(1),
            "address": In(range(depth)),
            "cost": Out(data.ArrayLayout(config.method.matching_cost.bits, config.labels)),
        })

    @staticmethod
    def latency_of(config: MatcherConfig):
        """Cycles from a wave to the local disparity that it completes."""
        return BecCell.LATENCY + TREE + len(groups_of(config))

    @staticmethod
    def lag_of(config: MatcherConfig):
        """Pixels that come in before the costs of one are known: none."""
        return 0

    def elaborate(self, platform):
        m = Module()
        config = self.config
        m.submodules.edata = edata = LabelMemory(config, self.depth)
        m.submodules.store_delay = store_delay = Delay(1, BecCell.LATENCY, clean=True)
        m.d.comb += [
            store_delay.i.eq(self.store), edata.write.eq(store_delay.o), edata.address.eq(self.address), self.cost.eq(edata.o),
        ]

        wave, least = self.wave, None
        for labels in groups_of(config):
            m.submodules[f"group_{labels[0]}"] = group = BecGroup(config, labels)
            m.d.comb += [group.i.eq(wave), *(edata.words[label].eq(group.cost[n]) for n, label in enumerate(labels))]
            if least is not None:
                m.d.comb += group.least_i.eq(least)
            wave, least = group.o, group.least_o

        beside = data.StructLayout({"pixel": Pixel(), "valid": 1})
        m.submodules.beside = beside_delay = Delay(beside, self.latency_of(config), clean=True)
        m.d.comb += [
            beside_delay.i.pixel.eq(self.pixel), beside_delay.i.valid.eq(self.pixel_valid),
            self.queued.pixel.eq(beside_delay.o.pixel), self.queued.local.eq(least.index),
            self.queued_valid.eq(beside_delay.o.valid),
        ]
        return m
