"""All writers and readers of the memory at one arbiter, for benches with a memory model."""

from typing import Any

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import Out

from golden.config import MatcherConfig
from golden.video.memory_map import MemoryMap, Plane
from hdl.video.arbiter import Arbiter
from hdl.video.frame_read import PairReader, PictureReader
from hdl.video.frame_write import FrameWriter, PictureWriter
from hdl.video.words import LocalBus


__all__ = ["MemoryPath"]


class MemoryPath(wiring.Component):
    """The writers ``left``, ``right``, ``disparity``, ``shown_left`` and the readers ``pair``, ``shown``, each under its name.

    Members
    -------
    bus : Out(LocalBus())
    *block* : Out(signature of the block, but for its ``port``)
    """
    def __init__(self, memory_map: MemoryMap, config: MatcherConfig, *, burst: int = 16, size: int = 1, depth: int = 48):
        options = {"burst": burst, "depth": depth}
        self.arbiter = Arbiter(4, 2, burst=burst, size=size)
        self.writers = {
            "left": FrameWriter(memory_map, Plane.LEFT, **options),
            "right": FrameWriter(memory_map, Plane.RIGHT, **options),
            "disparity": PictureWriter(memory_map, Plane.DISPARITY, **options),
            "shown_left": PictureWriter(memory_map, Plane.SHOWN_LEFT, **options),
        }
        self.readers = {
            "pair": PairReader(memory_map, burst=burst, depth=depth),
            "shown": PictureReader(memory_map, config, **options),
        }
        self.blocks: dict[str, wiring.Component] = {**self.writers, **self.readers}
        super().__init__({
            "bus": Out(LocalBus(size_bits=size.bit_length())),
            **{name: Out(wiring.Signature({member: flow for member, flow in block.signature.members.items() if member != "port"}))
               for name, block in self.blocks.items()},
        })

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        m.submodules.arbiter = self.arbiter
        wiring.connect(m, self.arbiter.bus, wiring.flipped(self.bus))
        for name, block in self.blocks.items():
            m.submodules[name] = block
            for member, flow in block.signature.members.items():
                if member == "port":
                    continue
                inner, outer = getattr(block, member), getattr(getattr(self, name), member)
                if flow.is_signature:
                    wiring.connect(m, inner, wiring.flipped(outer))
                else:
                    m.d.comb += outer.eq(inner) if flow.flow is Out else inner.eq(outer)
        for block, port in zip(self.writers.values(), self.arbiter.write):
            wiring.connect(m, block.port, port)
        for block, port in zip(self.readers.values(), self.arbiter.read):
            wiring.connect(m, block.port, port)
        return m
