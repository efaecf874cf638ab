"""Costs of a few neighbouring labels in the same cycle, from the columns of both pictures to ``A``."""

from amaranth import *
from amaranth.hdl import ShapeLike
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig, Propagation, Recursive

from ...parts.delay import NO_COLLISION, Delay, data_register
from ..stream import CensusWord, Least
from ..streaming.fused_array import FusedCell
from ..streaming.labels import groups_of, least_of, seen_along, tree_of
from ..streaming.right_view import RightCell, RightWave
from ..streaming.waves import Completion, Wave
from .carried import CarriedGroup, Taps
from .from_below import FromBelowGroup, FromBelowSource, LowerFinal, LowerGate, OwnSlot
from .line_below import LineBelowGroup, LineBelowWave
from .mean import MeanGroup
from .source import SLOTS
from .support import JOINING, Mean, Summand, Supports, share_of


__all__ = ["LABELS_PER_GROUP", "TREE", "Final", "LeastBeside", "RecursiveGroup", "recursive_groups"]


#: Labels that work in the same cycle: twice as many as in the other arrays, because the words of the rings then fill memory blocks better.
LABELS_PER_GROUP = 8

#: Levels of a group's tree.
TREE = tree_of(LABELS_PER_GROUP)


def recursive_groups(config: MatcherConfig) -> list[range]:
    """The labels of each group."""
    return groups_of(config, LABELS_PER_GROUP)


class Beside(data.StructLayout):
    """Complements of the costs of the labels before and after one; ``open``: the one after is the first of the group above."""
    def __init__(self, config: MatcherConfig):
        super().__init__({"before": config.data_bits, "after": config.data_bits, "open": 1})


class LeastBeside(data.StructLayout):
    """As :class:`hdl.matcher.stream.Least`, with the costs beside it if disparities have fraction bits."""
    def __init__(self, config: MatcherConfig):
        beside = {"beside": Beside(config)} if config.method_as(Recursive).refinement.sub_pixel else {}
        super().__init__({"value": config.data_bits, "index": range(config.labels), **beside})


class Final(data.StructLayout):
    """A pixel whose costs are there, or padding: its completion, in its column; ``write``: they are kept for the next line."""
    def __init__(self, config: MatcherConfig):
        super().__init__({"completion": Completion(config), "column": range(config.max_width), "write": 1})


def passed_words(config: MatcherConfig) -> dict[str, ShapeLike]:
    """Words that are passed from group to group, by name."""
    method = config.method_as(Recursive)
    share, slot = range(Propagation.SHARE_MAX + 1), range(SLOTS)
    words: dict[str, ShapeLike] = {
        "below": LineBelowWave(config), "address": range(config.max_width), "pixel_least": range(method.data_max + 1),
        "place": range(method.propagation.fan), "taps": Taps(config), "share": share, "eighths": Summand(config),
        "sums": Summand(config), "ends": Mean(config), "centre": range(Supports.ring_of(config)), "final": Final(config),
    }
    if method.propagation.from_below:
        words |= {
            "lower_sums": Summand(config), "lower_ends": Mean(config), "lower_final": LowerFinal(config), "own_write": OwnSlot(config),
            "lower_address": slot, "lower_pixel_least": range(method.own_max + 1), "lower_gate": LowerGate(config), "own_address": slot,
            "lower_share": share,
        }
    return words


def beside_costs(config: MatcherConfig) -> dict[str, range]:
    """Costs of neighbouring labels that are passed between groups, by name."""
    method = config.method_as(Recursive)
    return {"": range(method.data_max + 1), **({"mean_": range(method.own_max + 1)} if method.propagation.from_below else {})}


class RecursiveGroup(wiring.Component):
    """Costs ``A`` of a few neighbouring labels, the least so far, and the right view.

    Golden: :func:`golden.matcher.recursive.method.recursion`.

    Width: exact.

    Timing, in cycles after a step at the group: the wave is due after :attr:`WAVE`, ``below`` after :attr:`BELOW`, ``address``,
    ``pixel_least``, ``place`` and ``taps`` as :class:`hdl.matcher.recursive.carried.CarriedGroup` states, ``share`` and ``eighths`` after
    :attr:`SHARE`, ``sums`` after :attr:`SUMS`. ``ends`` is due a cycle after the sums of the last pixel of the support; :meth:`total_of`
    cycles after it ``final``, and ``centre`` :attr:`CENTRE` cycles before. Every ``_o`` of these is due at the group above, a cycle later.
    The group registers them all first: the costs are there :attr:`LATENCY` cycle after ``final``; ``least_i`` is due :data:`TREE` cycles
    after those, ``least_o`` one more; ``right_i``, ``top_i`` and the costs of labels beside are in step with these.

    With costs from below: ``lower_sums`` and ``own_write`` are due after :attr:`LOWER_SUMS`, ``lower_address``, ``lower_pixel_least``,
    ``lower_gate``, ``own_address`` and ``lower_share`` as :class:`hdl.matcher.recursive.from_below.FromBelowGroup` states, ``lower_ends``
    as ``ends``; ``lower_final`` is due with the means, less the registers; ``lower_least_i`` and ``lower_least_o`` after those as
    ``least_i`` and ``least_o``.

    Memory: those of :class:`LineBelowGroup`, :class:`CarriedGroup`, :class:`MeanGroup` and :class:`FromBelowGroup`; a ring of shares of
    the costs from above.

    Members
    -------
    i, o : Wave(config, CensusWord(config))
    below_i, address_i, pixel_least_i, place_i, taps_i, share_i, eighths_i, sums_i, ends_i, centre_i, final_i, and each with _o
        Of :func:`passed_words`; ``share``: eighths of the costs from above. ``eighths``: where an eighth of them is kept; ``centre``: where
        that of the pixel is.
    lower_i, lower_o, upper_i, upper_o : range(data_max + 1)
        As of :class:`hdl.matcher.recursive.spread.SpreadGroup`. With costs from below, the same of the means: ``mean_lower_i`` and so on.
    right_i, right_o : RightWave(config)
    top_i, top_o : data_bits
        With fraction bits only: complement of the cost of the label below the group's, due with the costs, and that of its top label.
    least_i, least_o : LeastBeside(config)
        Complement of the least cost; the smaller label on a tie. With costs from below ``lower_least_i`` and ``lower_least_o`` of means.
    costs : Out(ArrayLayout(range(data_max + 1), n))
        ``A``, in step with ``final_o``.
    """
    # Of the registers for all words that are passed on.
    LATENCY = 1
    # The costs of two lines, with the share of those from below, and the share of the costs from above meet two cycles after these are
    # there.
    SHARE = CarriedGroup.ABOVE
    SUMS = SHARE + JOINING
    CENTRE = 3
    LOWER_SUMS = SUMS - 1
    BELOW = LOWER_SUMS - LineBelowGroup.LATENCY
    WAVE = BELOW + LineBelowGroup.COST - FusedCell.LATENCY
    LOWER_ADDRESS = LOWER_SUMS - FromBelowGroup.LATENCY

    def __init__(self, config: MatcherConfig, labels: range):
        self.config = config
        self.labels = labels
        method = config.method_as(Recursive)
        wave, cost = Wave(config, CensusWord(config)), range(method.data_max + 1)
        leasts: dict[str, ShapeLike] = {"least": LeastBeside(config)}
        if method.refinement.sub_pixel:
            leasts["top"] = config.data_bits
        if method.propagation.from_below:
            leasts["lower_least"] = Least(method.own_max.bit_length(), config.labels)
        passed = passed_words(config) | leasts | {"right": RightWave(config)}
        super().__init__({
            "i": In(wave), "o": Out(wave),
            **{f"{name}_i": In(shape) for name, shape in passed.items()}, **{f"{name}_o": Out(shape) for name, shape in passed.items()},
            **{f"{name}{side}_i": In(shape) for name, shape in beside_costs(config).items() for side in ("lower", "upper")},
            **{f"{name}{side}_o": Out(shape) for name, shape in beside_costs(config).items() for side in ("lower", "upper")},
            "costs": Out(data.ArrayLayout(cost, len(labels))),
        })

    @staticmethod
    def total_of(config: MatcherConfig) -> int:
        """Cycles from the ends of a support to the costs, both in the group's registers."""
        return MeanGroup.latency_of(config) + 1

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        method = config.method_as(Recursive)
        from_below = method.propagation.from_below
        count = len(self.labels)
        # The group works with registers of its own: each of their bits reaches hundreds of cells here, but only one of the next group.
        for name in passed_words(config):
            here, onward = getattr(self, f"{name}_i"), getattr(self, f"{name}_o")
            later = Signal.like(here, name=f"{name}_later")     # with a reset: there are control bits among them
            m.d.sync += later.eq(here)
            m.d.comb += onward.eq(later)
        wave  = Signal(Wave(config, CensusWord(config)))
        valid = [Signal(name=f"valid{stage}") for stage in range(4)]
        m.d.comb += wave.valid.eq(valid[0])
        m.d.sync += Cat(valid).eq(Cat(self.i.valid, *valid))
        for name in wave.shape().members:
            if name != "valid":
                m.d.sync += data_register(m, wave[name], f"wave_{name}").eq(self.i[name])

        # The costs of the cells, and those of the line below.
        m.submodules.below = below = LineBelowGroup(config, self.labels)
        m.d.comb += below.i.eq(self.below_o)
        for n, (label, seen, inside) in enumerate(seen_along(m, self.labels, wave, self.o, registered=False)):
            m.submodules[f"label_{label}"] = cell = FusedCell(config)
            m.d.comb += [
                cell.left.eq(wave.left), cell.left_census.eq(wave.left_census),
                cell.right.eq(seen["right"]), cell.right_census.eq(seen["right_census"]), cell.inside.eq(inside),
                cell.valid3.eq(valid[3]), below.cost[n].eq(cell.cost),
            ]
        own = self._add_from_below(m, below) if from_below else below.own

        # Those from the line above.
        m.submodules.carried = carried = CarriedGroup(config, self.labels)
        m.d.comb += [
            carried.address.eq(self.address_o), carried.least.eq(self.pixel_least_o), carried.place.eq(self.place_o),
            carried.taps.eq(self.taps_o), carried.lower_i.eq(self.lower_i), carried.upper_i.eq(self.upper_i),
            self.lower_o.eq(carried.lower_o), self.upper_o.eq(carried.upper_o),
        ]

        # Their share, and the mean of the sum with a pixel's own over its support.
        bits, joined_max = Propagation.SHARE_BITS, method.joined_max
        m.submodules.mean = mean = MeanGroup(config, self.labels, joined_max)
        for n in range(count):
            joined = Signal(range(joined_max + 1), name=f"joined_{n}", reset_less=True)
            m.d.sync += joined.eq(own[n] + share_of(m, config, f"above_{n}", carried.above[n], self.share_o))
            m.d.comb += mean.cost[n].eq(joined)
        m.d.comb += [mean.sums.eq(self.sums_o), mean.ends.eq(self.ends_o)]

        # An eighth of them is added to the mean.
        eighths = data.ArrayLayout((method.carried_max >> bits).bit_length(), count)
        m.submodules.eighths = kept = Memory(shape=eighths, depth=Supports.ring_of(config), init=[], attrs=NO_COLLISION)
        write, read = kept.write_port(), kept.read_port()
        m.d.comb += [
            write.addr.eq(self.eighths_o.place), write.data.eq(Cat(above[bits:] for above in carried.above)),
            write.en.eq(self.eighths_o.enter), read.addr.eq(self.centre_o), read.en.eq(1),
        ]
        costs = data_register(m, self.costs)
        eighth = Signal(eighths, reset_less=True)
        m.d.sync += [eighth.eq(read.data), *(costs[n].eq(mean.o[n] + eighth[n]) for n in range(count))]
        m.d.comb += [
            carried.write.eq(self.final_o.write), carried.column.eq(self.final_o.column), carried.cost.eq(self.costs),
        ]

        # The right view passes the costs.
        right = self.right_i
        for n, label in enumerate(self.labels):
            m.submodules[f"right_{label}"] = cell = RightCell(config, label)
            m.d.comb += [cell.completion.eq(self.final_o.completion), cell.cost.eq(self.costs[n]), cell.i.eq(right)]
            right = cell.o
        # To the group above, a cycle later: the state of the top label before this wave.
        m.d.sync += self.right_o.eq(right)
        values = [~cost for cost in self.costs]
        if not method.refinement.sub_pixel:
            least_of(m, values, self.labels[0], self.least_i, self.least_o, LABELS_PER_GROUP)
            return m

        # The costs beside each label go along with it; the one after the top label of the group below is the first one here.
        m.d.sync += data_register(m, self.top_o).eq(values[-1])
        beside = []
        for n in range(count):
            word = Signal(Beside(config), name=f"beside_{n}")
            m.d.comb += [word.before.eq(values[n - 1] if n else self.top_i), word.open.eq(n == count - 1)]
            m.d.comb += word.after.eq(values[n + 1] if n + 1 < count else 0)
            beside.append(word)
        m.submodules.first = first = Delay(config.data_bits, TREE)
        least = Signal(LeastBeside(config))
        m.d.comb += [first.i.eq(values[0]), least.eq(self.least_i)]
        with m.If(self.least_i.beside.open):
            m.d.comb += [least.beside.after.eq(first.o), least.beside.open.eq(0)]
        least_of(m, values, self.labels[0], least, self.least_o, LABELS_PER_GROUP, beside=beside)
        return m

    def _add_from_below(self, m: Module, below: LineBelowGroup) -> data.View:
        """Means of the line below; a pixel's own costs with their share."""
        config = self.config
        m.submodules.lower_mean = mean = MeanGroup(config, self.labels, config.method_as(Recursive).own_max)
        m.submodules.from_below = group = FromBelowGroup(config, self.labels)
        m.d.comb += [
            mean.sums.eq(self.lower_sums_o), mean.cost.eq(below.own), mean.ends.eq(self.lower_ends_o),
            group.write.eq(self.lower_final_o), group.mean.eq(mean.o), group.own_write.eq(self.own_write_o), group.own.eq(below.upper_own),
            group.address.eq(self.lower_address_o), group.least.eq(self.lower_pixel_least_o), group.gate.eq(self.lower_gate_o),
            group.own_address.eq(self.own_address_o), group.share.eq(self.lower_share_o),
            group.lower_i.eq(self.mean_lower_i), group.upper_i.eq(self.mean_upper_i),
            self.mean_lower_o.eq(group.lower_o), self.mean_upper_o.eq(group.upper_o),
        ]
        least_of(m, [~value for value in mean.o], self.labels[0], self.lower_least_i, self.lower_least_o, LABELS_PER_GROUP, "lower_")
        return group.o


assert RecursiveGroup.LOWER_ADDRESS == FromBelowSource.ADDRESS
