"""Labelling at one pixel a cycle: an array of cells, one a label; its upward and its downward pass.

It is laid out as the arrays of costs, see :mod:`hdl.matcher.streaming.bec_array`.
"""

from itertools import pairwise

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig

from ...parts.delay import CountedDelay, Delay, data_register
from ..stream import Least


__all__ = ["DownCell", "DownWave", "LabelArray", "UpCell", "UpWave", "vertex_rise"]


class UpWave(data.StructLayout):
    """The cones of a pixel in the upward pass: their value at this label, their step to the next one, and how it changes at their vertices.

    ``cone`` at label ``d`` is ``w2*|d - f_up| + w3*|d - b_low| - w1*d``, plus ``smooth_max``, so that it is never negative and energies
    compare as unsigned numbers. ``step`` leads to the next label. It becomes ``2 * low_rise`` greater at the lower vertex, ``low``, and
    ``2 * high_rise`` at the upper one, ``high``; where they coincide ``low_rise`` is that of both.

    Prepared ahead: ``rise`` is half of what the next label's step is greater by; ``at_low`` and ``at_high`` tell whether the label after
    the next one is a vertex.
    """
    def __init__(self, config: MatcherConfig):
        slope = config.rule.slope_max
        super().__init__({
            "cone": range(3 * config.smooth_max + 1),
            "step": range(-3 * slope, 2 * slope + 1),
            "rise": range(2 * slope + 1),
            "low_rise": range(2 * slope + 1),
            "high_rise": range(slope + 1),
            "low": range(config.labels),
            "high": range(config.labels),
            "at_low": 1,
            "at_high": 1,
        })


def vertex_rise(wave: data.View, at_low: Value, at_high: Value) -> Value:
    """Half of what the step becomes greater by at a label that is, or is not, a vertex."""
    return Mux(at_low, wave.low_rise, Mux(at_high, wave.high_rise, 0))


def _is_label(value: Value, label: int, config: MatcherConfig) -> Value:
    """Whether ``value`` is this label; it is never one that does not exist."""
    return Value.cast(value == label) if label < config.labels else Const(0)


def up_bits(config: MatcherConfig) -> int:
    """Bits of an energy in the upward pass: data term and cones, less ``w1 * d``, plus ``smooth_max``; at most ``energy_max``."""
    return config.energy_bits


def down_bits(config: MatcherConfig) -> int:
    """Bits of an energy in the downward pass: an energy with ``p = 0``, plus ``smooth_max``."""
    return (config.energy_max + config.smooth_max).bit_length()


class UpCell(wiring.Component):
    """One label of the upward pass, ``F(d) = min(A(d), F(d-1) + w1)``; the label below wins a tie.

    ``A(d) = (E << q) + w2*|d - f_up| + w3*|d - b_low|``, where ``E`` is the data term: a matching cost or, with supports, a sum ``S``. All
    energies are kept less ``w1 * d``, so that the recursion is a comparison and a choice, ``G(d) = min(A(d) - w1*d, G(d-1))``.

    Width: exact, :func:`up_bits`.

    Timing: ``least_o`` 2 cycles after ``i``, ``least_i`` 1 cycle after ``i``, the index of either a cycle after its value, so that a
    comparison drives the value alone; ``o`` follows ``i`` by a cycle.

    Members
    -------
    i : In(UpWave(config)), o : Out(UpWave(config))
    cost : In(data_bits)
        Complement of the data term, in the cycle of ``i``.
    least_i, least_o : Least(up_bits(config), D)
    """
    LATENCY = 2

    def __init__(self, config: MatcherConfig, label: int):
        self.config = config
        self.label = label
        least = Least(up_bits(config), config.labels)
        super().__init__({
            "i": In(UpWave(config)), "o": Out(UpWave(config)),
            "cost": In(config.data_bits),
            "least_i": In(least), "least_o": Out(least),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        # Stage 1: the cones at the next label, and their step from there; this label's energy.
        energy = Signal(up_bits(self.config), reset_less=True)
        i, o, least_o = self.i, data_register(m, self.o), data_register(m, self.least_o)
        ahead = self.label + 3  # the label after the next one, seen from the next one
        m.d.sync += [
            o.eq(i), o.cone.eq(i.cone + i.step), o.step.eq(i.step + (i.rise << 1)), o.rise.eq(vertex_rise(i, i.at_low, i.at_high)),
            o.at_low.eq(_is_label(i.low, ahead, self.config)), o.at_high.eq(_is_label(i.high, ahead, self.config)),
        ]
        m.d.sync += energy.eq(((~self.cost).as_unsigned()[:len(self.cost)] << self.config.rule.energy_shift) + i.cone)

        # Stage 2: the recursion. Stage 3: its index.
        if self.label == 0:
            m.d.sync += [least_o.value.eq(energy), least_o.index.eq(0)]
        else:
            here  = Signal()
            chose = Signal(reset_less=True)
            m.d.comb += here.eq(energy < self.least_i.value)
            m.d.sync += [
                least_o.value.eq(Mux(here, energy, self.least_i.value)),
                chose.eq(here), least_o.index.eq(Mux(chose, self.label, self.least_i.index)),
            ]
        return m


class DownWave(data.StructLayout):
    """Terms of the downward pass: ``ramp = 2 * w1 * d`` at this label, and ``2 * w1``."""
    def __init__(self, config: MatcherConfig):
        super().__init__({"ramp": range(2 * config.smooth_max + 1), "step": range(2 * config.rule.slope_max + 1)})


class DownCell(wiring.Component):
    """One label of the downward pass, ``M(d) = min(F(d), M(d+1) + w1)``; ``F`` wins a tie.

    Its label is ``T(d)``, the result if the left neighbour's disparity is ``d``. All energies are kept plus ``w1 * d``: ``H(d) = min(G(d) +
    2*w1*d, H(d+1))``.

    Width: exact, :func:`down_bits`.

    Timing: ``least_o`` 2 cycles after ``i``, ``least_i`` 1 cycle after ``i``, the index of either, and of ``up``, a cycle after its value;
    ``o`` follows ``i`` by a cycle.

    Members
    -------
    i : In(DownWave(config)), o : Out(DownWave(config))
    up : In(Least(up_bits(config), D))
        Of the upward pass, in the cycle of ``i``.
    least_i, least_o : Least(down_bits(config), D)
    """
    LATENCY = 2

    def __init__(self, config: MatcherConfig, label: int):
        self.config = config
        self.label = label
        least = Least(down_bits(config), config.labels)
        super().__init__({
            "i": In(DownWave(config)), "o": Out(DownWave(config)),
            "up": In(Least(up_bits(config), config.labels)),
            "least_i": In(least), "least_o": Out(least),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        # Stage 1.
        here = Signal(Least(down_bits(self.config), self.config.labels), reset_less=True)
        o, least_o = data_register(m, self.o), data_register(m, self.least_o)
        m.d.sync += [
            o.step.eq(self.i.step), o.ramp.eq(self.i.ramp - self.i.step),
            here.value.eq(self.up.value + self.i.ramp), here.index.eq(self.up.index),
        ]
        # Stage 2: the recursion. Stage 3: its index.
        if self.label == self.config.labels - 1:
            m.d.sync += least_o.eq(here)
        else:
            above = Signal()
            chose = Signal(reset_less=True)
            m.d.comb += above.eq(self.least_i.value < here.value)
            m.d.sync += [
                least_o.value.eq(Mux(above, self.least_i.value, here.value)),
                chose.eq(above), least_o.index.eq(Mux(chose, self.least_i.index, here.index)),
            ]
        return m


class LabelArray(wiring.Component):
    """For every label ``p`` that the left neighbour may have, the disparity ``T(p) = argmin_d A(d) + w1*|d - p|``.

    An L1 distance transform with its argument: upward, then downward, one label a cycle each; delays in memory align every label's upward
    result with the downward pass, and the results at the end. Equal to evaluating (2-15) for each ``p``,
    ties to the smaller disparity. ``T`` is monotone and idempotent. Golden: :func:`golden.matcher.labelling.transition`.

    Timing: ``transition`` :attr:`latency` cycles after ``up``; a pixel a cycle.

    Memory: delays of ``2 * (D - 1 - d)`` cycles of an energy and a label, of ``d`` cycles of a label.

    Members
    -------
    up : In(UpWave(config))
    down : In(DownWave(config))
        In the cycle of ``up``, at label ``D - 1``.
    cost : In(ArrayLayout(data_bits, D))
        Complements; label ``d`` is read ``d`` cycles after ``up``.
    transition : Out(ArrayLayout(range(D), D))
    """
    #: Labels whose results are delayed in one memory, and whose delays share a register of the counter.
    LABELS_PER_MEMORY = 5
    #: Registers on the routes from the memories, spread over a device, to the one multiplexer of all results, and one more in front of it.
    HOPS = 2

    def __init__(self, config: MatcherConfig):
        self.config = config
        labels = config.labels
        super().__init__({
            "up": In(UpWave(config)),
            "down": In(DownWave(config)),
            "cost": In(data.ArrayLayout(config.data_bits, labels)),
            "transition": Out(data.ArrayLayout(range(labels), labels)),
        })

    @property
    def latency(self) -> int:
        """Cycles from ``up`` to ``transition``: both passes, the index behind its value, the registers in front of the multiplexer."""
        turn = self.config.labels - 1 + UpCell.LATENCY
        return turn + self.config.labels - 1 + DownCell.LATENCY + 1 + 1 + self.HOPS

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        labels = config.labels

        # Up.
        ups = []
        wave, least = self.up, None
        for label in range(labels):
            cell = UpCell(config, label)
            m.submodules[f"up_{label}"] = cell
            m.d.comb += [cell.i.eq(wave), cell.cost.eq(self.cost[label])]
            if least is not None:
                m.d.comb += cell.least_i.eq(least)
            wave, least = cell.o, cell.least_o
            ups.append(least)

        # A counter for the addresses of all delays in memory, passed along the labels: each delay may have any phase of it.
        count_bits = max(2 * labels - 4, 1).bit_length()
        counts = [Signal(count_bits, name=f"count_{low}", reset_less=True) for low in range(0, labels, self.LABELS_PER_MEMORY)]
        m.d.sync += [counts[0].eq(counts[0] + 1), *(above.eq(below) for below, above in pairwise(counts))]

        # Down. The top label's upward result is used at once, that of each label below two cycles later: one of each pass.
        m.submodules.down_delay = down_delay = Delay(DownWave(config), labels - 1 + UpCell.LATENCY)
        m.d.comb += down_delay.i.eq(self.down)
        results = [None] * labels
        wave, least = down_delay.o, None
        for label in reversed(range(labels)):
            cell = DownCell(config, label)
            m.submodules[f"down_{label}"] = cell
            m.submodules[f"wait_{label}"] = wait = CountedDelay(ups[label].shape(), 2 * (labels - 1 - label), count_bits)
            m.d.comb += [wait.count.eq(counts[label // self.LABELS_PER_MEMORY]), wait.i.eq(ups[label]), cell.up.eq(wait.o), cell.i.eq(wave)]
            if least is not None:
                m.d.comb += cell.least_i.eq(least)
            wave, least = cell.o, cell.least_o
            results[label] = least.index

        # Alignment. Label 0 is last. The others of a group are delayed by a memory up to its lowest, and by registers from there: as many
        # more as a label is above that one. These are on the way from the memory to the multiplexer.
        last = Signal.like(self.transition, name=f"transition_{self.HOPS}", reset_less=True)
        m.d.comb += self.transition.eq(last)
        for low in range(0, labels, self.LABELS_PER_MEMORY):
            group = range(low, min(low + self.LABELS_PER_MEMORY, labels))
            in_memory = low + 1 if low else 0
            shape = data.ArrayLayout(range(labels), len(group))
            m.submodules[f"align_{low}"] = align = CountedDelay(shape, in_memory, count_bits)
            m.d.comb += align.count.eq(counts[low // self.LABELS_PER_MEMORY])
            for label in group:
                m.submodules[f"align_{low}_{label}"] = hops = Delay(range(labels), label + self.HOPS - in_memory, registers=True)
                m.d.comb += [align.i[label - low].eq(results[label]), hops.i.eq(align.o[label - low])]
                m.d.sync += last[label].eq(hops.o)
        return m
