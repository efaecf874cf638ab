"""Basic energy calculation."""

from typing import ClassVar

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import IN_USE_BITS, MatcherConfig

from ..stage import Stage
from ..stream import BecWord, ColumnWord, copy_flags
from .argmin import ComparatorTree
from .cost import CostEnergy, Edata, SubPixelBuffers, SubPixels


__all__ = ["Bec"]


class Bec(Stage):
    """Basic energy calculation (thesis figure 19): matching cost of every label, and the local disparity.

    The golden models are :func:`golden.matcher.cost.matching_cost` and :func:`golden.matcher.cost.local_disparity`.

    Timing: a pixel each :attr:`clocks_per_pixel` cycles, once its right neighbour has been accepted.

    Members
    -------
    i : In(stream.Signature(ColumnWord()))
    o : Out(stream.Signature(BecWord(config)))
    in_use : In(IN_USE_BITS)
        Labels in use; sampled as the first pixel of a frame passes.
    """
    name = "bec"
    settings: ClassVar = {"in_use": "in_use"}

    def __init__(self, config: MatcherConfig):
        self.config = config
        self.tree = ComparatorTree(config.matching_cost.bits, config.labels)
        super().__init__({
            "i": In(stream.Signature(ColumnWord())),
            "o": Out(stream.Signature(BecWord(config))),
            "in_use": In(IN_USE_BITS),
        })

    @property
    def latency(self) -> int:
        """Cycles from a pixel's column to its word when the next column follows at once and nothing stalls."""
        return SubPixels.LATENCY + SubPixelBuffers.LATENCY + CostEnergy.LATENCY + Edata.LATENCY + self.tree.latency

    @property
    def clocks_per_pixel(self) -> int:
        """Cycles between words when the consumer never stalls."""
        return self.tree.latency + 1

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.sub_pixels = sub_pixels = SubPixels(self.config)
        m.submodules.buffers = buffers = SubPixelBuffers(self.config)
        m.submodules.cost_energy = cost_energy = CostEnergy(self.config)
        m.submodules.edata = edata = Edata(self.config)
        m.submodules.comparison = tree = self.tree
        wiring.connect(m, wiring.flipped(self.i), sub_pixels.i)
        wiring.connect(m, sub_pixels.o, buffers.i)
        m.d.comb += buffers.in_use.eq(self.in_use)
        wiring.connect(m, buffers.o, cost_energy.i)
        wiring.connect(m, cost_energy.o, edata.i)

        # The costs are held in one register while the tree works on them, so that no delay line of `D` costs is needed; `age` is a shift
        # register that tells when the tree's output is theirs.
        age = Signal(tree.latency)
        accepted = Signal()
        m.d.comb += [
            accepted.eq(self.o.valid & self.o.ready),
            tree.i.eq(edata.o.p.cost), tree.enable.eq(1),
            self.o.valid.eq(edata.o.valid & age[-1]), edata.o.ready.eq(accepted),
            self.o.p.cost.eq(edata.o.p.cost), self.o.p.local.eq(tree.o.index),
            self.o.p.pixel.eq(edata.o.p.pixel), self.o.p.upper.eq(edata.o.p.upper), *copy_flags(self.o.p, edata.o.p),
        ]
        m.d.sync += age.eq(Mux(accepted, 0, Cat(edata.o.valid, age)))
        return m
