"""Vertical support of the labels of a group: two lines of costs in one memory."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import Fused, MatcherConfig

from ...parts.delay import NO_COLLISION, Delay, data_register
from .waves import VerticalWave


__all__ = ["VerticalSupport"]


class VerticalSupport(wiring.Component):
    """Joins costs with those of the lines above and below; golden: :func:`golden.matcher.vertical.vertical_support`.

    As the costs of a pixel arrive, those of the pixel above it are joined. The memory holds the costs of the two lines above.

    Width: exact.

    Timing: ``joined`` :attr:`LATENCY` cycles after ``cost``; ``o`` a cycle after ``i``. A column is read no sooner than three cycles after
    it was read before: lines start and end with a wave of padding.

    Memory: ``max_width`` words of two costs a label.

    Members
    -------
    i : In(VerticalWave(config)), o : Out(VerticalWave(config))
        ``i`` with the costs.
    cost : In(ArrayLayout(range(cost_max + 1), n))
        ``C`` of the line below the one that is joined.
    joined : Out(ArrayLayout(range(joined_max + 1), n))
        ``V``.
    """
    LATENCY = 5

    def __init__(self, config: MatcherConfig, labels: range):
        self.config = config
        self.labels = labels
        super().__init__({
            "i": In(VerticalWave(config)), "o": Out(VerticalWave(config)),
            "cost": In(data.ArrayLayout(range(config.method_as(Fused).cost.maximum + 1), len(labels))),
            "joined": Out(data.ArrayLayout(range(config.method_as(Fused).joined_max + 1), len(labels))),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        costs = self.cost.shape()
        stored = data.StructLayout({"above": costs, "centre": costs})
        m.submodules.memory = memory = Memory(shape=stored, depth=self.config.max_width, init=[], attrs=NO_COLLISION)
        read = memory.read_port()
        write = memory.write_port()
        m.d.sync += data_register(m, self.o).eq(self.i)

        # Stages 1 and 2: the memory, and a register behind it.
        word = Signal(stored, reset_less=True)
        m.submodules.wave = wave = Delay(self.i.shape(), 2, clean=True)
        m.submodules.below = below = Delay(costs, 2)
        m.d.comb += [
            read.addr.eq(self.i.column), read.en.eq(1), wave.i.eq(self.i), below.i.eq(self.cost),
            write.addr.eq(wave.o.column), write.en.eq(wave.o.write), write.data.above.eq(word.centre), write.data.centre.eq(below.o),
        ]
        m.d.sync += word.eq(read.data)

        # Stages 3 to 5: a neighbour that is not alike is replaced by the pixel itself.
        joined = data_register(m, self.joined)
        for n in range(len(self.labels)):
            centre, up, down, twice = (
                Signal.like(word.centre[n], name=f"{name}_{n}", reset_less=True) for name in ("centre", "up", "down", "twice"))
            both = Signal(range(2 * self.config.method_as(Fused).cost.maximum + 1), name=f"both_{n}", reset_less=True)
            m.d.sync += [
                centre.eq(word.centre[n]), up.eq(Mux(wave.o.above, word.above[n], word.centre[n])),
                down.eq(Mux(wave.o.below, below.o[n], word.centre[n])),
                both.eq(up + down), twice.eq(centre),
                joined[n].eq(both + (twice << 1)),
            ]
        return m
