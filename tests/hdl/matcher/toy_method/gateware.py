"""The toy method's array of costs."""

from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS
from hdl.matcher.stage import CostArray
from hdl.matcher.stream import ColumnWord, Least
from hdl.matcher.streaming.labels import TREE, LabelMemory, Queued, groups_of, least_of, seen_along
from hdl.matcher.streaming.waves import Issue, Pixel, Wave
from hdl.parts.delay import Delay


class ToyGroup(wiring.Component):
    """Costs of a few labels, a cycle after the wave that completes their pixel, and the least so far."""
    def __init__(self, config, labels):
        self.labels = labels
        wave, least = Wave(config, ColumnWord()), Least(config.data_bits, config.labels)
        super().__init__({
            "i": In(wave), "o": Out(wave), "cost": Out(data.ArrayLayout(config.data_bits, len(labels))),
            "least_i": In(least), "least_o": Out(least),
        })

    def elaborate(self, platform):
        m = Module()
        for number, (label, seen, inside) in enumerate(seen_along(m, self.labels, self.i, self.o)):
            difference = self.i.left.line - seen["right"].line
            held = Signal(PIXEL_BITS, name=f"held_{label}", reset_less=True)  # complement of the latest column's cost
            with m.If(self.i.valid):
                m.d.sync += held.eq(Mux(inside, ~Mux(difference < 0, -difference, difference), 0))
            m.d.sync += self.cost[number].eq(held)
        least_of(m, list(self.cost), self.labels[0], self.least_i, self.least_o)
        return m


class ToyArray(CostArray):
    """As :class:`hdl.matcher.streaming.bec_array.BecArray`, with cells of one cycle."""
    @staticmethod
    def columns_of(config):
        return ColumnWord()

    @staticmethod
    def latency_of(config):
        return 1 + TREE + len(groups_of(config))

    def __init__(self, config, depth):
        self.config = config
        self.depth = depth
        super().__init__({
            "i": In(Issue(config, ToyArray)), "queued": Out(Queued(config)), "queued_valid": Out(1), "address": In(range(depth)),
            "cost": Out(data.ArrayLayout(config.data_bits, config.labels)), "sideband": Out(self.sideband_of(config)),
        })

    def elaborate(self, platform):
        m = Module()
        m.submodules.memory = memory = LabelMemory(self.config, self.depth)
        store = Signal()
        m.d.sync += store.eq(self.i.store)
        m.d.comb += [memory.write.eq(store), memory.address.eq(self.address), self.cost.eq(memory.o)]
        wave, least = self.i.wave, Signal(Least(self.config.data_bits, self.config.labels))
        for labels in groups_of(self.config):
            m.submodules[f"group_{labels[0]}"] = group = ToyGroup(self.config, labels)
            m.d.comb += [group.i.eq(wave), group.least_i.eq(least)]
            m.d.comb += [memory.words[label].eq(group.cost[number]) for number, label in enumerate(labels)]
            wave, least = group.o, group.least_o
        waiting = data.StructLayout({"pixel": Pixel(), "valid": 1})
        m.submodules.pixels = pixels = Delay(waiting, self.latency_of(self.config), clean=True)
        m.d.comb += [
            pixels.i.pixel.eq(self.i.pixel), pixels.i.valid.eq(self.i.pixel_valid), self.queued.pixel.eq(pixels.o.pixel),
            self.queued.local.eq(least.index), self.queued_valid.eq(pixels.o.valid),
        ]
        return m
