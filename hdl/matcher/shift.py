"""Minimum disparity: the right picture shifted, so that the match of label 0 is at the same ``x``."""

from typing import ClassVar

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, MatcherConfig

from ..parts.delay import data_register
from .settings import minimum_shape
from .stage import Stage
from .stream import PixelPair, copy_flags


__all__ = ["RightShift", "delayed_pixel"]


def delayed_pixel(m: Module, advance: Value, valid: Value, word: data.View, starts_line: Value, pixel: Value,
                  delay: Value) -> tuple[Value, data.View, Value]:
    """Two pipeline stages that replace a pixel by the one ``delay`` words before it on its line; the line's first pixel is replicated.

    Parameters
    ----------
    m : Module
        To which they are added.
    advance : Value
        The stages advance in this cycle.
    valid, word, starts_line : Value
        The word, and whether it is the first of a line.
    pixel : Value
        The pixel of that word which is delayed.
    delay : Value
        Words; constant within a line.

    Returns
    -------
    valid, word, pixel : Value
        Two stages later.
    """
    # Stage 2: a ring of the line's latest pixels. Before `delay` of them are in it, the first one is output, so that no stale word is.
    # Without a delay the word itself counts as first: a word cannot be read in the cycle that writes it.
    place      = Signal(len(delay))
    remaining  = Signal(len(delay), reset_less=True)  # pixels of this line that still replicate the first one
    m.submodules.ring = ring = Memory(shape=PIXEL_BITS, depth=1 << len(delay), init=[])
    read = ring.read_port()
    write = ring.write_port()
    s2_valid   = Signal()
    s2         = Signal(PixelPair(), reset_less=True)
    s2_first   = Signal(PIXEL_BITS, reset_less=True)
    s2_repeats = Signal(reset_less=True)
    none = delay == 0
    m.d.comb += [
        write.addr.eq(place), write.data.eq(pixel), write.en.eq(advance),
        read.addr.eq(place - delay), read.en.eq(advance),
    ]
    with m.If(advance):
        m.d.sync += [s2_valid.eq(valid), s2.eq(word), s2_repeats.eq(starts_line | none | (remaining != 0))]
        with m.If(valid):
            m.d.sync += [place.eq(place + 1), remaining.eq(Mux(starts_line, delay, remaining - (remaining != 0)))]
            with m.If(starts_line | none):
                m.d.sync += s2_first.eq(pixel)

    # Stage 3: a register behind the memory, whose read is slow.
    s3_valid   = Signal()
    s3         = Signal(PixelPair(), reset_less=True)
    s3_first   = Signal(PIXEL_BITS, reset_less=True)
    s3_repeats = Signal(reset_less=True)
    s3_old     = Signal(PIXEL_BITS, reset_less=True)
    with m.If(advance):
        m.d.sync += [s3_valid.eq(s2_valid), s3.eq(s2), s3_first.eq(s2_first), s3_repeats.eq(s2_repeats), s3_old.eq(read.data)]
    return s3_valid, s3, Mux(s3_repeats, s3_first, s3_old)


class RightShift(Stage):
    """Shifts the right picture to the right by ``minimum`` pixels, and by ``config.lead`` more; the first pixel of a line is replicated.

    The golden model is :func:`golden.matcher.cost.aligned`. The left pixel and the flags are not changed.

    Frames may be ragged, as this stage is in front of the line store: a line begins after a word with ``last`` or ``end``, and at
    ``first`` whatever precedes it.

    Timing: latency :attr:`latency` cycles; a word a cycle; ``i.ready`` depends combinationally on ``o.ready``.

    Memory: ``256 * 8`` bits, with a lead ``512 * 8``.

    Parameters
    ----------
    config : :class:`MatcherConfig`

    Members
    -------
    i : In(stream.Signature(PixelPair()))
    o : Out(stream.Signature(PixelPair()))
    minimum : In(minimum_shape(config))
        Pixels, at least ``-config.lead``; sampled with the word marked ``first``.
    """
    name = "shift"
    settings: ClassVar = {"minimum": "minimum"}
    latency = 4

    def __init__(self, config: MatcherConfig):
        self.config = config
        super().__init__({
            "i": In(stream.Signature(PixelPair())),
            "o": Out(stream.Signature(PixelPair())),
            "minimum": In(minimum_shape(config)),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        lead = self.config.lead
        advance = Signal()
        m.d.comb += [advance.eq(~self.o.valid | self.o.ready), self.i.ready.eq(advance)]

        # Stage 1: the word, whether it is the first of a line, and the frame's minimum.
        starts_line    = Signal()
        s1_valid       = Signal()
        s1_starts_line = Signal(reset_less=True)
        s1             = Signal(PixelPair(), reset_less=True)
        minimum        = Signal(range(self.config.MINIMUMS.stop + lead))  # less the lead's: at least 0
        with m.If(advance):
            m.d.sync += [s1_valid.eq(self.i.valid), s1.eq(self.i.p), s1_starts_line.eq(starts_line | self.i.p.first)]
            with m.If(self.i.valid):
                m.d.sync += starts_line.eq(self.i.p.last | self.i.p.end)
                with m.If(self.i.p.first):
                    m.d.sync += minimum.eq(self.minimum + lead if lead else self.minimum)

        # Stages 2 and 3: the right pixel of `minimum` pixels before.
        s3_valid, s3, right = delayed_pixel(m, advance, s1_valid, s1, s1_starts_line, s1.right, minimum)

        # Stage 4.
        payload = data_register(m, self.o.payload)
        with m.If(advance):
            m.d.sync += [self.o.valid.eq(s3_valid), payload.left.eq(s3.left), *copy_flags(payload, s3)]
            m.d.sync += payload.right.eq(right)
        return m
