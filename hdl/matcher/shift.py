"""Minimum disparity: the right picture moved, so that label 0 meets its match."""

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
    """Moves the right picture to the right by ``minimum`` pixels; the first pixel of a line is repeated.

    The golden model is :func:`golden.matcher.cost.delayed`. The left pixel and the flags are not changed.

    The last pixels of the right picture are in a ring of memory, which the oldest leaves as a new one comes. Before as many pixels of a
    line have come the first one is given, so nothing depends on what the memory held. This stands in front of the line store: a frame
    may be ragged. A line begins after a word with ``last`` or ``end`` and at ``first``, whatever came before.

    Timing: latency :attr:`latency` cycles; a word a cycle; ``i.ready`` depends combinationally on ``o.ready``. The memory's word passes
    through a register.

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

        # Stage 1: the word, whether it begins a line, and the frame's minimum.
        begins    = Signal()
        s1_valid  = Signal()
        s1_begins = Signal(reset_less=True)
        s1        = Signal(PixelPair(), reset_less=True)
        minimum   = Signal(minimums)
        with m.If(advance):
            m.d.sync += [s1_valid.eq(self.i.valid), s1.eq(self.i.p), s1_begins.eq(begins | self.i.p.first)]
            with m.If(self.i.valid):
                m.d.sync += begins.eq(self.i.p.last | self.i.p.end)
                with m.If(self.i.p.first):
                    m.d.sync += minimum.eq(self.minimum)

        # Stage 2: the ring. Without a shift the word itself counts as first: what is written can not be read at once.
        m.submodules.ring = ring = Memory(shape=PIXEL_BITS, depth=len(minimums), init=[])
        read = ring.read_port()
        write = ring.write_port()
        place      = Signal(minimums)
        remaining  = Signal(minimums, reset_less=True)  # pixels of this line that the first one still stands for
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
            m.d.sync += [s2_valid.eq(s1_valid), s2.eq(s1), s2_repeats.eq(s1_begins | none | (remaining != 0))]
            with m.If(s1_valid):
                m.d.sync += [place.eq(place + 1), remaining.eq(Mux(s1_begins, minimum, remaining - (remaining != 0)))]
                with m.If(s1_begins | none):
                    m.d.sync += s2_first.eq(s1.right)

        # Stage 3: the memory's word in a register.
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
