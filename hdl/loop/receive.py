"""Places of the bytes of a line that the host has sent."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from ..host.blocks import LineByte
from .store import row_start
from .words import SentPixel


__all__ = ["LinePlacer"]


class LinePlacer(wiring.Component):
    """Gives the pixels of a line their places in the store.

    Timing: combinational; ``line`` and ``plane`` hold from the cycle before the line's first byte to its last one, and no byte of another
    line is in the cycle after that.

    Parameters
    ----------
    max_width, height : int
        Of a store, pixels.

    Members
    -------
    plane : In(8), line : In(16)
        As of :class:`hdl.host.blocks.BlockWritePort`.
    i : In(stream.Signature(LineByte()))
    o : Out(stream.Signature(SentPixel(max_width * height)))
        To the store.
    """
    def __init__(self, max_width: int, height: int):
        self.max_width, self.height = max_width, height
        super().__init__({
            "plane": In(8), "line": In(16),
            "i": In(stream.Signature(LineByte())),
            "o": Out(stream.Signature(SentPixel(max_width * height))),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        line = self.line[:max(1, (self.height - 1).bit_length())]
        address = Signal.like(self.o.p.address, reset_less=True)
        m.d.comb += [
            self.o.valid.eq(self.i.valid), self.i.ready.eq(self.o.ready),
            self.o.p.plane.eq(self.plane), self.o.p.level.eq(self.i.p.value), self.o.p.address.eq(address),
        ]
        with m.If(~self.i.valid):
            m.d.sync += address.eq(row_start(line, self.max_width))
        with m.Elif(self.o.ready):
            m.d.sync += address.eq(address + 1)
        return m
