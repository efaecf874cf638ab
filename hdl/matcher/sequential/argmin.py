"""Comparator tree."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out


__all__ = ["ComparatorTree", "Minimum"]


class Minimum(data.StructLayout):
    """The least of ``inputs`` values below ``2**bits``, and its index."""
    def __init__(self, bits: int, inputs: int):
        super().__init__({"value": bits, "index": range(inputs)})


class ComparatorTree(wiring.Component):
    """Least of many values, in stages of 5-input comparators (thesis figure 24); ties go to the smaller index.

    80 values become 16, then 3 + 1 (a group of one passes), then 1. The golden model is :func:`golden.matcher.argmin.comparator_tree`.

    Width: the value is one of the inputs; nothing is rounded.

    Timing: latency :attr:`latency` cycles with ``enable`` high, one set of values a cycle; a low ``enable`` freezes all stages.

    Parameters
    ----------
    bits : int
        Bits of a value.
    inputs : int
        Number of values, at least 1.

    Members
    -------
    i : In(ArrayLayout(bits, inputs))
    enable : In(1)
    o : Out(Minimum(bits, inputs))
    """
    FAN_IN = 5

    def __init__(self, bits: int, inputs: int):
        self.bits = bits
        self.inputs = inputs
        super().__init__({
            "i": In(data.ArrayLayout(bits, inputs)),
            "enable": In(1),
            "o": Out(Minimum(bits, inputs)),
        })

    @property
    def latency(self) -> int:
        """Stages, one cycle each."""
        stages, count = 0, self.inputs
        while count > 1:
            count = -(-count // self.FAN_IN)
            stages += 1
        return max(stages, 1)

    def elaborate(self, platform: object) -> Module:
        m = Module()
        layout = Minimum(self.bits, self.inputs)

        values = [Signal(layout, name=f"input_{n}") for n in range(self.inputs)]
        for n, value in enumerate(values):
            m.d.comb += [value.value.eq(self.i[n]), value.index.eq(n)]

        for stage in range(self.latency):
            winners = []
            for group in range(0, len(values), self.FAN_IN):
                rivals = values[group:group + self.FAN_IN]
                winner = Signal(layout, name=f"stage{stage}_{group // self.FAN_IN}", reset_less=True)
                with m.If(self.enable):
                    m.d.sync += winner.eq(self._least(m, rivals, f"stage{stage}_{group // self.FAN_IN}"))
                winners.append(winner)
            values = winners
        m.d.comb += self.o.eq(values[0])
        return m

    @staticmethod
    def _least(m: Module, rivals: list[data.View], name: str) -> Value:
        """All pairs are compared at once, then a one-hot choice: two steps of logic instead of a chain of four."""
        not_above = {}
        for low in range(len(rivals)):
            for high in range(low + 1, len(rivals)):
                not_above[low, high] = Signal(name=f"{name}_not_above_{low}{high}")
                m.d.comb += not_above[low, high].eq(rivals[low].value <= rivals[high].value)
        chosen: Value = Const(0)
        for n, rival in enumerate(rivals):
            wins = Const(1)
            for other in range(len(rivals)):
                if other > n:
                    wins &= not_above[n, other]
                elif other < n:
                    wins &= ~not_above[other, n]
            chosen |= Mux(wins, rival.as_value(), 0)
        return chosen
