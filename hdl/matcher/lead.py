"""Negative disparities: the right picture ahead of the left one."""

from amaranth import *
from amaranth.lib import data, stream
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig

from ..parts.delay import data_register
from .shift import delayed_pixel
from .stage import Stage
from .stream import PixelPair, copy_flags


__all__ = ["Lead"]


class Lead(Stage):
    """Makes each line wider by ``config.lead`` columns: the left picture begins so many columns later, the right one ends as many earlier.

    Edges are replicated. Golden: :func:`golden.matcher.cost.aligned` with that lead, and with the least disparity ``-config.lead``. The
    flag ``first`` is set in the first column of the lead, ``last`` and ``end`` in the last pixel of the left picture.

    Frames may be ragged: a line ends with a word with ``last`` or ``end``, and before ``first``; in that case without a flag. Of a line
    that is longer than its frame's first one, surplus pixels of the right picture take the place of replicated ones: the line store cuts
    the frame there.

    Timing: a line of ``W`` words takes ``W + lead`` cycles; a left pixel is output :attr:`latency` cycles after it was accepted, if
    neither ``i`` nor ``o`` stalls. ``i.ready`` depends combinationally on ``o.ready``.

    Memory: ``8 << lead.bit_length()`` bits.

    Parameters
    ----------
    config : :class:`MatcherConfig`
        With a lead.

    Members
    -------
    i : In(stream.Signature(PixelPair()))
    o : Out(stream.Signature(PixelPair()))
    """
    name = "lead"
    STAGES = 4

    def __init__(self, config: MatcherConfig):
        if not config.lead:
            raise ValueError(f"a lead is for negative disparities, and the least one is {config.minimum}")
        self.config = config
        self.line_clocks = config.lead
        super().__init__({"i": In(stream.Signature(PixelPair())), "o": Out(stream.Signature(PixelPair()))})

    @property
    def latency(self) -> int:
        """Cycles from a left pixel to its output."""
        return self.STAGES + self.config.lead

    def elaborate(self, platform: object) -> Module:
        m = Module()
        lead = self.config.lead
        advance = Signal()
        m.d.comb += advance.eq(~self.o.valid | self.o.ready)

        # Stage 1: the word, or, once its line has been accepted, the line's last one again.
        s1       = Signal(PixelPair(), reset_less=True)
        s1_valid = Signal()
        s1_starts_line = Signal(reset_less=True)
        open_line = Signal()           # a word of this line has been accepted
        remaining = Signal(range(lead + 1))
        ending    = Signal(data.StructLayout({"last": 1, "end": 1}), reset_less=True)  # flags of the line's last column
        cut       = Signal()
        m.d.comb += cut.eq(open_line & self.i.p.first)
        with m.If(remaining == 0):
            m.d.comb += self.i.ready.eq(advance & ~cut)
            with m.If(advance):
                m.d.sync += s1_valid.eq(self.i.valid & ~cut)
                with m.If(self.i.valid & cut):
                    m.d.sync += [remaining.eq(lead), ending.eq(0)]
                with m.Elif(self.i.valid):
                    m.d.sync += [s1.eq(self.i.p), s1.last.eq(0), s1.end.eq(0), s1_starts_line.eq(~open_line), open_line.eq(1)]
                    with m.If(self.i.p.last | self.i.p.end):
                        m.d.sync += [remaining.eq(lead), ending.last.eq(self.i.p.last), ending.end.eq(self.i.p.end)]
        with m.Elif(advance):
            m.d.sync += [s1_valid.eq(1), s1.first.eq(0), s1_starts_line.eq(0), remaining.eq(remaining - 1)]
            with m.If(remaining == 1):
                m.d.sync += [s1.last.eq(ending.last), s1.end.eq(ending.end), open_line.eq(0)]

        # Stages 2 and 3: the left pixel of `lead` columns before.
        s3_valid, s3, left = delayed_pixel(m, advance, s1_valid, s1, s1_starts_line, s1.left, Const(lead))

        # Stage 4.
        payload = data_register(m, self.o.payload)
        with m.If(advance):
            m.d.sync += [self.o.valid.eq(s3_valid), payload.left.eq(left), payload.right.eq(s3.right), *copy_flags(payload, s3)]
        return m
