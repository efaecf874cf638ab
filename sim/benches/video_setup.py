"""The set-ups of both video chips in one design, for a bench on their Verilog."""

from typing import Any

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import Out

from golden.video.setup_steps import TFP410, TVP5154
from hdl.video.setup import ChipSetup


__all__ = ["CLOCK_HZ", "VideoSetup"]


#: Low, so that a second has few clocks; the set-up counts in clocks, and its ports have no rate.
CLOCK_HZ = 500_000


class VideoSetup(wiring.Component):
    """With the tables of the board; ports are called ``decoder_member`` and ``transmitter_member``.

    Members
    -------
    decoder, transmitter : Out(signature of :class:`ChipSetup`)
    """
    def __init__(self):
        self.parts = {"decoder": ChipSetup(TVP5154, CLOCK_HZ), "transmitter": ChipSetup(TFP410, CLOCK_HZ, pause_seconds=0.005)}
        super().__init__({name: Out(part.signature) for name, part in self.parts.items()})

    def elaborate(self, platform: Any) -> Module:
        m = Module()
        for name, part in self.parts.items():
            m.submodules[name] = part
            wiring.connect(m, part, wiring.flipped(getattr(self, name)))
        return m
