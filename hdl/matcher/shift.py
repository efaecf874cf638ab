"""Minimum disparity: the right picture shifted, so that the match of label 0 is at the same ``x``."""

from typing import ClassVar

from amaranth import *
from amaranth.lib import stream
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, MatcherConfig

from ..parts.delay import data_register
from .stage import Stage
from .stream import PixelPair, copy_flags


__all__ = ["RightShift"]


class RightShift(Stage):
    """Shifts the right picture to the right by ``minimum`` pixels; the first pixel of a line is replicated.

    The golden model is :func:`golden.matcher.cost.delayed`. The left pixel and the flags are not changed.

    Frames may be ragged, as this stage is in front of the line store: a line begins after a word with ``last`` or ``end``, and at
    ``first`` whatever precedes it.

    Timing: latency :attr:`latency` cycles; a word a cycle; ``i.ready`` depends combinationally on ``o.ready``.

    Memory: ``256 * 8`` bits.

    Parameters
    ----------
    config : :class:`MatcherConfig`

    Members
    -------
    i : In(stream.Signature(PixelPair()))
    o : Out(stream.Signature(PixelPair()))
    minimum : In(range(256))
        Pixels; sampled with the word marked ``first``.
    """
    name = "shift"
    settings: ClassVar = {"minimum": "minimum"}
    latency = 4

    def __init__(self, config: MatcherConfig):
        self.config = config
        super().__init__({
            "i": In(stream.Signature(PixelPair())),
            "o": Out(stream.Signature(PixelPair())),
            "minimum": In(range(config.MINIMUMS.stop)),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        minimums = range(self.config.MINIMUMS.stop)
        advance = Signal()
        m.d.comb += [advance.eq(~self.o.valid | self.o.ready), self.i.ready.eq(advance)]

        # Stage 1: the word, whether it is the first of a line, and the frame's minimum.
        starts_line    = Signal()
        s1_valid       = Signal()
        s1_starts_line = Signal(reset_less=True)
        s1             = Signal(PixelPair(), reset_less=True)
        minimum        = Signal(minimums)
        with m.If(advance):
            m.d.sync += [s1_valid.eq(self.i.valid), s1.eq(self.i.p), s1_starts_line.eq(starts_line | self.i.p.first)]
            with m.If(self.i.valid):
                m.d.sync += starts_line.eq(self.i.p.last | self.i.p.end)
                with m.If(self.i.p.first):
                    m.d.sync += minimum.eq(self.minimum)

        # Stage 2: a ring of the line's latest pixels. Before `minimum` of them are in it, the first one is output, so that no stale word
        # is. Without a shift the word itself counts as first: a word cannot be read in the cycle that writes it.
        m.submodules.ring = ring = Memory(shape=PIXEL_BITS, depth=len(minimums), init=[])
        read = ring.read_port()
        write = ring.write_port()
        place      = Signal(minimums)
        remaining  = Signal(minimums, reset_less=True)  # pixels of this line that still replicate the first one
        s2_valid   = Signal()
        s2         = Signal(PixelPair(), reset_less=True)
        s2_first   = Signal(PIXEL_BITS, reset_less=True)
        s2_repeats = Signal(reset_less=True)
        none = minimum == 0
        m.d.comb += [
            write.addr.eq(place), write.data.eq(s1.right), write.en.eq(advance),
            read.addr.eq(place - minimum), read.en.eq(advance),
        ]
        with m.If(advance):
            m.d.sync += [s2_valid.eq(s1_valid), s2.eq(s1), s2_repeats.eq(s1_starts_line | none | (remaining != 0))]
            with m.If(s1_valid):
                m.d.sync += [place.eq(place + 1), remaining.eq(Mux(s1_starts_line, minimum, remaining - (remaining != 0)))]
                with m.If(s1_starts_line | none):
                    m.d.sync += s2_first.eq(s1.right)

        # Stage 3: a register behind the memory, whose read is slow.
        s3_valid   = Signal()
        s3         = Signal(PixelPair(), reset_less=True)
        s3_first   = Signal(PIXEL_BITS, reset_less=True)
        s3_repeats = Signal(reset_less=True)
        s3_old     = Signal(PIXEL_BITS, reset_less=True)
        with m.If(advance):
            m.d.sync += [s3_valid.eq(s2_valid), s3.eq(s2), s3_first.eq(s2_first), s3_repeats.eq(s2_repeats), s3_old.eq(read.data)]

        # Stage 4: that word or the first pixel.
        payload = data_register(m, self.o.payload)
        with m.If(advance):
            m.d.sync += [self.o.valid.eq(s3_valid), payload.left.eq(s3.left), *copy_flags(payload, s3)]
            m.d.sync += payload.right.eq(Mux(s3_repeats, s3_first, s3_old))
        return m
