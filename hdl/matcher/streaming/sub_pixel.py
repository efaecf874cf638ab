"""Sub-pixel disparity: where between two labels the support sums would be least, at every label, and that of the label chosen."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig
from golden.matcher.sub_pixel import SUB_PIXEL_SCALE

from ...parts.arithmetic import choose
from ...parts.delay import Delay, data_register


__all__ = ["FractionCell", "SubPixel"]


#: Eighths of a pixel from a label, half a pixel at most.
FRACTION = range(-SUB_PIXEL_SCALE // 2, SUB_PIXEL_SCALE // 2 + 1)


class FractionCell(wiring.Component):
    """Equiangular interpolation between three neighbouring sums; golden: :func:`golden.matcher.sub_pixel.fraction`.

    With ``m`` the greater of the neighbours less ``centre``, the fraction is the number of ``m, 3m, 5m, 7m`` that eight times the
    neighbours' difference reaches, towards the smaller neighbour; 0 where ``m`` is not positive.

    Width: exact.

    Timing: :attr:`LATENCY` cycles, one a cycle.

    Members
    -------
    before, centre, after : In(data_bits)
        Complements of the sums of the label before, of the label itself, of the label after.
    fraction : Out(FRACTION)
        Eighths of a pixel.
    """
    LATENCY = 5

    def __init__(self, config: MatcherConfig):
        self.config = config
        bits = config.data_bits
        super().__init__({"before": In(bits), "centre": In(bits), "after": In(bits), "fraction": Out(FRACTION)})

    def elaborate(self, platform: object) -> Module:
        m = Module()
        most = self.config.method.data_max

        # Stages 1 and 2: which neighbour is less, by how much, and how far the greater one is above the label. Complements: signs turn.
        before, centre, after = (
            Signal.like(port, name=f"{port.name}_1", reset_less=True) for port in (self.before, self.centre, self.after))
        towards_less = [Signal(name=f"towards_less_{stage}", reset_less=True) for stage in range(1, 5)]
        m.d.sync += [
            before.eq(self.before), centre.eq(self.centre), after.eq(self.after), towards_less[0].eq(self.before > self.after),
            *(later.eq(sooner) for later, sooner in zip(towards_less[1:], towards_less)),
        ]
        apart  = Signal(range(most + 1), reset_less=True)
        height = Signal(range(-most, most + 1), reset_less=True)
        m.d.sync += [
            apart.eq(Mux(towards_less[0], before - after, after - before)),
            height.eq(centre - Mux(towards_less[0], after, before)),
        ]

        # Stage 3: odd multiples; a height below 1 reaches none.
        eightfold = Signal(range(SUB_PIXEL_SCALE * most + 1), reset_less=True)
        positive  = Signal(reset_less=True)
        heights   = [Signal(signed(len(height) + 3), name=f"height_{odd}", reset_less=True) for odd in (1, 3, 5, 7)]
        m.d.sync += [
            eightfold.eq(apart * SUB_PIXEL_SCALE), positive.eq(height > 0),
            heights[0].eq(height), heights[1].eq(height + (height << 1)), heights[2].eq(height + (height << 2)),
            heights[3].eq((height << 3) - height),
        ]

        # Stages 4 and 5: how many are reached; each only where all below it are.
        reached = Signal(len(heights), reset_less=True)
        m.d.sync += reached.eq(Cat(positive & (eightfold >= multiple) for multiple in heights))
        steps = Signal(range(FRACTION[-1] + 1))
        m.d.comb += steps.eq(Mux(reached[3], 4, Mux(reached[2], 3, Mux(reached[1], 2, reached[0]))))
        m.d.sync += data_register(m, self.fraction).eq(Mux(towards_less[3], -steps, steps))
        return m


class SubPixel(wiring.Component):
    """Fractions of all labels, and that of the label chosen; golden: :func:`golden.matcher.sub_pixel.sub_pixel_labels`, before the check.

    The first and the last label have none.

    Timing: label ``d`` is read ``d`` cycles after label 0; ``fraction`` a cycle after ``label``, which is due ``latency`` cycles
    after label 0.

    Memory: delays of four bits a label, of ``latency - d - 6`` cycles.

    Members
    -------
    sums : In(ArrayLayout(data_bits, D))
        Complements.
    label : In(range(D))
    fraction : Out(FRACTION)
    """
    #: Labels whose fractions are delayed in one memory.
    LABELS_PER_MEMORY = 8

    def __init__(self, config: MatcherConfig, latency: int):
        self.config = config
        self.latency = latency
        labels = config.labels
        super().__init__({
            "sums": In(data.ArrayLayout(config.data_bits, labels)), "label": In(range(labels)), "fraction": Out(FRACTION),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        labels = config.labels
        bits = Shape.cast(FRACTION).width
        inner = range(1, labels - 1)
        later = [Signal(config.data_bits, name=f"sum_{label}", reset_less=True) for label in range(labels)]
        m.d.sync += [register.eq(value) for register, value in zip(later, self.sums)]
        fractions = [Const(0, bits)] * labels
        for low in range(inner.start, inner.stop, self.LABELS_PER_MEMORY):
            group = range(low, min(low + self.LABELS_PER_MEMORY, inner.stop))
            # The group's top label is the last; it is delayed by the memory only, the others by registers before.
            rest = self.latency - 1 - FractionCell.LATENCY - group[-1]
            m.submodules[f"align_{low}"] = align = Delay(data.ArrayLayout(bits, len(group)), rest)
            for place, label in enumerate(group):
                m.submodules[f"cell_{label}"] = cell = FractionCell(config)
                before = Signal(config.data_bits, name=f"before_{label}", reset_less=True)
                m.d.sync += before.eq(later[label - 1])
                m.submodules[f"skew_{label}"] = skew = Delay(bits, group[-1] - label)
                m.d.comb += [
                    cell.before.eq(before), cell.centre.eq(later[label]), cell.after.eq(self.sums[label + 1]),
                    skew.i.eq(cell.fraction), align.i[place].eq(skew.o),
                ]
                fractions[label] = align.o[place]
        m.d.sync += data_register(m, self.fraction).eq(choose(fractions, self.label).as_signed())
        return m
