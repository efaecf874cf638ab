"""All blocks of the matcher in one design, which is emitted and compiled once for the benches of all of them."""

from typing import Any

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import Out

from golden.config import Arithmetic, MatcherConfig, OnePass
from hdl.matcher.frame_timing import FrameTiming
from hdl.matcher.lines import EdataMemory, LineStore
from hdl.matcher.sequential.argmin import ComparatorTree
from hdl.matcher.sequential.bec import Bec
from hdl.matcher.sequential.cost import CostEnergy, Edata, SubPixelBuffers, SubPixels
from hdl.matcher.sequential.engine import CostSummation, SequentialEngine
from hdl.matcher.sequential.smooth import Smooth
from hdl.matcher.stream import BecWord


__all__ = ["CONFIGS", "Blocks"]


#: By arithmetic.
CONFIGS = {
    "thesis": MatcherConfig(labels=6, max_width=13, method=OnePass(Arithmetic.THESIS)),
    "linear": MatcherConfig(labels=6, in_use=5, max_width=13, method=OnePass(Arithmetic.LINEAR)),
}


class Blocks(wiring.Component):
    """Ports of a block are called ``block_member``.

    Members
    -------
    *block* : Out(signature of the block)
    """
    TIMING_DEPTH = 8

    def __init__(self, config: MatcherConfig):
        self.blocks: dict[str, wiring.Component] = {
            "line_store": LineStore(config),
            "sub_pixels": SubPixels(config),
            "sub_pixel_buffers": SubPixelBuffers(config),
            "cost_energy": CostEnergy(config),
            "edata": Edata(config),
            "comparator_tree": ComparatorTree(config.energy_bits, 13),
            "bec": Bec(config),
            "edata_memory": EdataMemory(BecWord(config), config.max_width),
            "smooth": Smooth(config),
            "cost_summation": CostSummation(config),
            "sequential_engine": SequentialEngine(config),
            "frame_timing": FrameTiming(self.TIMING_DEPTH),
        }
        super().__init__({name: Out(block.signature) for name, block in self.blocks.items()})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        for name, block in self.blocks.items():
            m.submodules[name] = block
            wiring.connect(m, block, wiring.flipped(getattr(self, name)))
        return m
