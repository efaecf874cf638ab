"""Cells of the streaming engine: what one label does, at the pace of one pixel a cycle.

Label ``d`` works one cycle after label ``d - 1`` (going down: after ``d + 1``; in BEC, group after group), so nothing is broadcast: all that
a cell needs comes from its neighbour's registers or from a memory with an address of its own. The cells never stop; which waves are real
is told beside them.
"""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, PIXEL_MAX, MatcherConfig

from .stream import Column


__all__ = ["BecCell", "BecGroup", "BecWave", "DownCell", "DownWave", "Least", "UpCell", "UpWave"]


def add_with_carry(a, b, carry):
    """``a + b + carry`` in one carry chain: the bit below the lowest makes the carry."""
    return (Cat(Const(1, 1), a) + Cat(carry, b)) >> 1


class Least(data.StructLayout):
    """A least energy so far, and its label."""
    def __init__(self, value, labels):
        super().__init__({"value": value, "index": range(labels)})


class BecWave(data.StructLayout):
    """A column on its way along the labels: left at ``x``, right at ``x - d``; ``inside``: ``d <= x``; ``pre``: the column before the line."""
    def __init__(self):
        super().__init__({"valid": 1, "pre": 1, "inside": 1, "left": Column(), "right": Column()})


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
        m.d.sync += self.cost.eq(Mux(total_inside, add_with_carry(*complement, ~total_sign)[:bits], 0))
        return m


class BecGroup(wiring.Component):
    """Matching costs of a few neighbouring labels in the same cycle, and the least cost so far.

    Within a group the left column is shared and the right one moves on by a register a label; between groups all moves on by one more.
    Golden: :func:`golden.cost.matching_cost`, :func:`golden.cost.local_disparity`.

    Timing: ``cost`` as of :class:`BecCell`, ``least_i`` :attr:`TREE` cycles after it, ``least_o`` one later. ``o`` follows ``i`` by a cycle.

    Members
    -------
    i : In(BecWave()), o : Out(BecWave())
        From the group below, to the group above.
    cost : Out(ArrayLayout(cost_bits, n))
        Complements of ``E``.
    least_i : In(Least(cost_bits, D)), least_o : Out(Least(cost_bits, D))
        Complement of the least cost; the smaller label on a tie.
    """
    SIZE = 4
    TREE = 2

    def __init__(self, config: MatcherConfig, labels: range):
        self.config = config
        self.labels = labels
        least = Least(config.cost_bits, config.disparities)
        super().__init__({
            "i": In(BecWave()), "o": Out(BecWave()),
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
                cell.left.eq(self.i.left), cell.right.eq(right), cell.inside.eq(inside),
                cell.valid1.eq(valid[1]), cell.valid4.eq(valid[4]), self.cost[n].eq(cell.cost),
            ]
            costs.append(cell.cost)
            before        = Signal(Column(), name=f"right_{label}", reset_less=True)
            before_inside = Signal(name=f"inside_{label}", reset_less=True)
            with m.If(self.i.valid):
                m.d.sync += [before.eq(right), before_inside.eq(inside)]
            right, inside = before, before_inside & ~self.i.pre
        m.d.sync += [
            self.o.valid.eq(self.i.valid), self.o.pre.eq(self.i.pre), self.o.left.eq(self.i.left),
            self.o.right.eq(right), self.o.inside.eq(inside),
        ]

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
        if first == 0:
            m.d.sync += [self.least_o.value.eq(value), self.least_o.index.eq(index)]
        else:
            with m.If(value > self.least_i.value):
                m.d.sync += [self.least_o.value.eq(value), self.least_o.index.eq(first + index)]
            with m.Else():
                m.d.sync += self.least_o.eq(self.least_i)
        return m


class UpWave(data.StructLayout):
    """The cones of a pixel on their way up: their value at this label, where their vertices are, and how they move.

    ``cone`` at label ``d`` is ``w2*|d - f_up| + w3*|d - b_low| - w1*d``. It moves by ``falling`` to the next label below both vertices, by
    ``between`` from the lower vertex on, by ``rising`` from the upper one on.
    """
    def __init__(self, config: MatcherConfig):
        slope = config.slope_max
        super().__init__({
            "cone": range(-config.smooth_max, 2 * config.smooth_max + 1),
            "falling": range(-3 * slope, 1),
            "between": range(-2 * slope, slope + 1),
            "rising": range(-slope, 2 * slope + 1),
            "low": range(config.disparities),
            "high": range(config.disparities),
        })


def up_values(config: MatcherConfig):
    """Range of an energy on the way up: matching cost and cones, less ``w1 * d``."""
    return range(-config.smooth_max, (config.cost_outside << config.energy_shift) + 2 * config.smooth_max + 1)


class UpCell(wiring.Component):
    """One label of the upward pass, ``F(d) = min(A(d), F(d-1) + w1)``; takes the label below on a tie.

    ``A(d) = (E << q) + w2*|d - f_up| + w3*|d - b_low|``. All is kept less ``w1 * d``: the recursion is then a comparison and a choice,
    ``G(d) = min(A(d) - w1*d, G(d-1))``.

    Width: exact, :func:`up_values`.

    Timing: ``least_o`` 2 cycles after ``i``, ``least_i`` 1 cycle after ``i``; ``o`` follows ``i`` by a cycle.

    Members
    -------
    i : In(UpWave(config)), o : Out(UpWave(config))
    cost : In(cost_bits)
        Complement of ``E``, in the cycle of ``i``.
    least_i, least_o : Least(up_values(config), D)
    """
    LATENCY = 2

    def __init__(self, config: MatcherConfig, label):
        self.config = config
        self.label = label
        least = Least(up_values(config), config.disparities)
        super().__init__({
            "i": In(UpWave(config)), "o": Out(UpWave(config)),
            "cost": In(config.cost_bits),
            "least_i": In(least), "least_o": Out(least),
        })

    def elaborate(self, platform):
        m = Module()
        # Stage 1: the cones' step to the next label; this label's energy.
        step = Mux(self.i.low > self.label, self.i.falling, Mux(self.i.high > self.label, self.i.between, self.i.rising))
        energy = Signal(up_values(self.config), reset_less=True)
        m.d.sync += [self.o.eq(self.i), self.o.cone.eq(self.i.cone + step)]
        m.d.sync += energy.eq(((~self.cost).as_unsigned()[:len(self.cost)] << self.config.energy_shift) + self.i.cone)

        # Stage 2: the recursion.
        if self.label == 0:
            m.d.sync += [self.least_o.value.eq(energy), self.least_o.index.eq(0)]
        else:
            with m.If(self.least_i.value <= energy):
                m.d.sync += self.least_o.eq(self.least_i)
            with m.Else():
                m.d.sync += [self.least_o.value.eq(energy), self.least_o.index.eq(self.label)]
        return m


class DownWave(data.StructLayout):
    """What the way down adds: ``ramp = 2 * w1 * d`` at this label, and ``2 * w1``."""
    def __init__(self, config: MatcherConfig):
        super().__init__({"ramp": range(2 * config.smooth_max + 1), "step": range(2 * config.slope_max + 1)})


class DownCell(wiring.Component):
    """One label of the downward pass, ``M(d) = min(F(d), M(d+1) + w1)``; keeps ``F`` on a tie. Its label is ``T(d)``, the answer if the left
    neighbour's disparity is ``d``.

    All is kept plus ``w1 * d``: ``H(d) = min(G(d) + 2*w1*d, H(d+1))``.

    Width: exact; ``H`` is an energy with ``p = 0``: ``config.energy_bits``.

    Timing: ``least_o`` 2 cycles after ``i``, ``least_i`` 1 cycle after ``i``; ``o`` follows ``i`` by a cycle.

    Members
    -------
    i : In(DownWave(config)), o : Out(DownWave(config))
    up : In(Least(up_values(config), D))
        Of the upward pass, in the cycle of ``i``.
    least_i, least_o : Least(energy_bits, D)
    """
    LATENCY = 2

    def __init__(self, config: MatcherConfig, label):
        self.config = config
        self.label = label
        least = Least(config.energy_bits, config.disparities)
        super().__init__({
            "i": In(DownWave(config)), "o": Out(DownWave(config)),
            "up": In(Least(up_values(config), config.disparities)),
            "least_i": In(least), "least_o": Out(least),
        })

    def elaborate(self, platform):
        m = Module()
        # Stage 1.
        here = Signal(Least(self.config.energy_bits, self.config.disparities), reset_less=True)
        m.d.sync += [
            self.o.step.eq(self.i.step), self.o.ramp.eq(self.i.ramp - self.i.step),
            here.value.eq(self.up.value + self.i.ramp), here.index.eq(self.up.index),
        ]
        # Stage 2: the recursion.
        if self.label == self.config.disparities - 1:
            m.d.sync += self.least_o.eq(here)
        else:
            with m.If(self.least_i.value < here.value):
                m.d.sync += self.least_o.eq(self.least_i)
            with m.Else():
                m.d.sync += self.least_o.eq(here)
        return m
