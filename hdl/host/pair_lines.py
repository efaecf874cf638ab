"""Which lines of the host's pair are stored."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.host.blocks import SENT_PLANES


__all__ = ["PairLines"]


class PairLines(wiring.Component):
    """Accepts the lines of a pair in their order, from any that is stored on, and tells when both pictures are whole.

    Golden: :class:`golden.host.blocks.PairLines`.

    Timing: ``accepts`` depends combinationally on ``plane`` and ``line``; ``whole`` is a register's.

    Parameters
    ----------
    height : int
        Lines of a picture.

    Members
    -------
    plane : In(1), line : In(range(height))
    accepts : Out(1)
        All lines before this one are stored.
    stored : In(1)
        One cycle: this line is stored.
    whole : Out(1)
        All lines of both pictures are.
    """
    def __init__(self, height: int):
        self.height = height
        super().__init__({"plane": In(1), "line": In(range(height)), "accepts": Out(1), "stored": In(1), "whole": Out(1)})

    def elaborate(self, platform: object) -> Module:
        m = Module()
        # The first line that is not stored; of the plane after the last one if there is none.
        line, plane = Signal.like(self.line), Signal(range(len(SENT_PLANES) + 1))
        last = self.line == self.height - 1
        m.d.comb += [
            self.accepts.eq(Cat(self.line, self.plane) <= Cat(line, plane)),
            self.whole.eq(plane == len(SENT_PLANES)),
        ]
        with m.If(self.stored):
            m.d.sync += [line.eq(Mux(last, 0, self.line + 1)), plane.eq(self.plane + last)]
        return m
