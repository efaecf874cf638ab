"""Labelling at one pixel a cycle: an array of cells, one a label; its upward and its downward pass.

It is laid out as the arrays of costs, see :mod:`hdl.matcher.streaming.bec_array`.
"""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig

from ...parts.delay import Delay, data_register
from ..stream import Least


__all__ = ["DownCell", "DownWave", "LabelArray", "UpCell", "UpWave", "chosen_step"]


class UpWave(data.StructLayout):
    """The cones of a pixel in the upward pass: their value at this label, their vertices, their steps from label to label.

    ``cone`` at label ``d`` is ``w2*|d - f_up| + w3*|d - b_low| - w1*d``. The step to the next label is ``falling`` below both vertices,
    ``between`` from the lower vertex on, ``rising`` from the upper one on. It is chosen a label ahead: ``step`` is the one from this label,
    ``below_low`` and ``below_high`` tell whether this label is below the vertices.
    """
    def __init__(self, config: MatcherConfig):
        slope = config.rule.slope_max
        super().__init__({
            "cone": range(-config.smooth_max, 2 * config.smooth_max + 1),
            "falling": range(-3 * slope, 1),
            "between": range(-2 * slope, slope + 1),
            "rising": range(-slope, 2 * slope + 1),
            "low": range(config.labels),
            "high": range(config.labels),
            "below_low": 1,
            "below_high": 1,
            "step": range(-3 * slope, 2 * slope + 1),
        })


def chosen_step(wave: data.View, below_low: Value, below_high: Value) -> Value:
    """Step of the cones from a label to the next one."""
    return Mux(below_low, wave.falling, Mux(below_high, wave.between, wave.rising))


def up_values(config: MatcherConfig) -> range:
    """Range of an energy in the upward pass: data term and cones, less ``w1 * d``."""
    return range(-config.smooth_max, (config.method.data_max << config.rule.energy_shift) + 2 * config.smooth_max + 1)


class UpCell(wiring.Component):
    """One label of the upward pass, ``F(d) = min(A(d), F(d-1) + w1)``; the label below wins a tie.

    ``A(d) = (E << q) + w2*|d - f_up| + w3*|d - b_low|``, where ``E`` is the data term: a matching cost or, with supports, a sum ``S``. All
    energies are kept less ``w1 * d``, so that the recursion is a comparison and a choice, ``G(d) = min(A(d) - w1*d, G(d-1))``.

    Width: exact, :func:`up_values`.

    Timing: ``least_o`` 2 cycles after ``i``, ``least_i`` 1 cycle after ``i``; ``o`` follows ``i`` by a cycle.

    Members
    -------
    i : In(UpWave(config)), o : Out(UpWave(config))
    cost : In(data_bits)
        Complement of the data term, in the cycle of ``i``.
    least_i, least_o : Least(up_values(config), D)
    """
    LATENCY = 2

    def __init__(self, config: MatcherConfig, label: int):
        self.config = config
        self.label = label
        least = Least(up_values(config), config.labels)
        super().__init__({
            "i": In(UpWave(config)), "o": Out(UpWave(config)),
            "cost": In(config.data_bits),
            "least_i": In(least), "least_o": Out(least),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        # Stage 1: the cones at the next label, and their step from there; this label's energy.
        below_low = self.i.below_low & (self.i.low != self.label + 1)
        below_high = self.i.below_high & (self.i.high != self.label + 1)
        energy = Signal(up_values(self.config), reset_less=True)
        o, least_o = data_register(m, self.o), data_register(m, self.least_o)
        m.d.sync += [
            o.eq(self.i), o.cone.eq(self.i.cone + self.i.step),
            o.below_low.eq(below_low), o.below_high.eq(below_high), o.step.eq(chosen_step(self.i, below_low, below_high)),
        ]
        m.d.sync += energy.eq(((~self.cost).as_unsigned()[:len(self.cost)] << self.config.rule.energy_shift) + self.i.cone)

        # Stage 2: the recursion.
        if self.label == 0:
            m.d.sync += [least_o.value.eq(energy), least_o.index.eq(0)]
        else:
            with m.If(self.least_i.value <= energy):
                m.d.sync += least_o.eq(self.least_i)
            with m.Else():
                m.d.sync += [least_o.value.eq(energy), least_o.index.eq(self.label)]
        return m


class DownWave(data.StructLayout):
    """Terms of the downward pass: ``ramp = 2 * w1 * d`` at this label, and ``2 * w1``."""
    def __init__(self, config: MatcherConfig):
        super().__init__({"ramp": range(2 * config.smooth_max + 1), "step": range(2 * config.rule.slope_max + 1)})


class DownCell(wiring.Component):
    """One label of the downward pass, ``M(d) = min(F(d), M(d+1) + w1)``; ``F`` wins a tie.

    Its label is ``T(d)``, the result if the left neighbour's disparity is ``d``. All energies are kept plus ``w1 * d``: ``H(d) = min(G(d) +
    2*w1*d, H(d+1))``.

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

    def __init__(self, config: MatcherConfig, label: int):
        self.config = config
        self.label = label
        least = Least(config.energy_bits, config.labels)
        super().__init__({
            "i": In(DownWave(config)), "o": Out(DownWave(config)),
            "up": In(Least(up_values(config), config.labels)),
            "least_i": In(least), "least_o": Out(least),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        # Stage 1.
        here = Signal(Least(self.config.energy_bits, self.config.labels), reset_less=True)
        o, least_o = data_register(m, self.o), data_register(m, self.least_o)
        m.d.sync += [
            o.step.eq(self.i.step), o.ramp.eq(self.i.ramp - self.i.step),
            here.value.eq(self.up.value + self.i.ramp), here.index.eq(self.up.index),
        ]
        # Stage 2: the recursion.
        if self.label == self.config.labels - 1:
            m.d.sync += least_o.eq(here)
        else:
            with m.If(self.least_i.value < here.value):
                m.d.sync += least_o.eq(self.least_i)
            with m.Else():
                m.d.sync += least_o.eq(here)
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
    #: Labels whose results are delayed in one memory.
    LABELS_PER_MEMORY = 5
    #: Registers on the routes from the memories, spread over a device, to the one multiplexer of all results.
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
        """Cycles from ``up`` to ``transition``."""
        turn = self.config.labels - 1 + UpCell.LATENCY
        return turn + self.config.labels - 1 + DownCell.LATENCY + 1 + self.HOPS

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

        # Down. The top label's upward result is used at once, that of each label below two cycles later: one of each pass.
        m.submodules.down_delay = down_delay = Delay(DownWave(config), labels - 1 + UpCell.LATENCY)
        m.d.comb += down_delay.i.eq(self.down)
        results = [None] * labels
        wave, least = down_delay.o, None
        for label in reversed(range(labels)):
            cell = DownCell(config, label)
            m.submodules[f"down_{label}"] = cell
            m.submodules[f"wait_{label}"] = wait = Delay(ups[label].shape(), 2 * (labels - 1 - label))
            m.d.comb += [wait.i.eq(ups[label]), cell.up.eq(wait.o), cell.i.eq(wave)]
            if least is not None:
                m.d.comb += cell.least_i.eq(least)
            wave, least = cell.o, cell.least_o
            results[label] = least.index

        together = Signal.like(self.transition)
        transition = together
        for hop in range(self.HOPS + 1):
            later = Signal.like(self.transition, name=f"transition_{hop}", reset_less=True)
            m.d.sync += later.eq(transition)
            transition = later
        m.d.comb += self.transition.eq(transition)
        # Alignment. Label 0 is last; the others of a group are delayed up to its lowest by registers, the group up to label 0 by a memory.
        for low in range(0, labels, self.LABELS_PER_MEMORY):
            group = range(low, min(low + self.LABELS_PER_MEMORY, labels))
            shape = data.ArrayLayout(range(labels), len(group))
            m.submodules[f"align_{low}"] = align = Delay(shape, low)
            for label in group:
                m.submodules[f"align_{low}_{label}"] = skew = Delay(range(labels), label - low)
                m.d.comb += [skew.i.eq(results[label]), align.i[label - low].eq(skew.o)]
                m.d.comb += together[label].eq(align.o[label - low])
        return m
