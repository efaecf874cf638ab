"""The fill: pixels that failed the check take a label from their line."""

from typing import ClassVar

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig

from ...parts.delay import StreamRegister, data_register
from ...parts.queue import Queue
from ..stage import Stage
from ..stream import LabelWord


__all__ = ["Fill"]


class Passing(data.StructLayout):
    """Label of a pixel that passed, or ``none``: the line ended with one that did not. Nine bits up to 256 labels: an M9K's width."""
    def __init__(self, config: MatcherConfig):
        super().__init__({"label": LabelWord(config)["label"].shape, "none": 1})


class Fill(Stage):
    """Gives a pixel that failed the check the smaller of the nearest passing labels to its left and to its right on the line.

    The one that exists if only one does; on a line without any a pixel keeps its own. Only ``label`` changes. The golden model is
    :func:`golden.matcher.refine.fill`.

    Lines wait in one queue until they are complete, the labels of their passing pixels in another, and of a last pixel that failed that
    there is none: as a line leaves, the head of the second queue is the nearest passing label to the right.

    Frames are rectangular, closed by ``end`` and at most ``max_width`` wide; each may have a size of its own. A line that is wider never
    leaves.

    Timing: a pixel a cycle, and :attr:`line_clocks` more a line: none. A line leaves as soon as it is complete: if nothing waits, its
    first pixel is offered :attr:`COMPLETE_CLOCKS` cycles after its last one was taken. A pixel whose line comes without a pause is
    therefore offered :attr:`lines` line of ``W`` cycles and :attr:`latency` cycles after it was taken, whatever passed. ``i.ready``
    comes from registers.

    Memory: ``max_width + 1`` words of :class:`LabelWord` with the bit ``enable``, ``max_width + 3`` labels with a bit.

    Parameters
    ----------
    config : :class:`MatcherConfig`
        Of the cost ``FUSED``.

    Members
    -------
    i : In(stream.Signature(LabelWord(config)))
    o : Out(stream.Signature(LabelWord(config)))
    enable : In(1)
        Off: labels leave unchanged, as late. Sampled with the word marked ``first`` as it is taken.
    """
    name = "fill"
    settings: ClassVar = {"enable": "fill"}
    lines = 1
    line_clocks = 0
    SETTLING = 3  # cycles from a word to the registers behind both queues
    COMPLETE_CLOCKS = SETTLING + 2

    def __init__(self, config: MatcherConfig):
        self.config = config
        super().__init__({
            "i": In(stream.Signature(LabelWord(config))),
            "o": Out(stream.Signature(LabelWord(config))),
            "enable": In(1),
        })

    @property
    def latency(self) -> int:
        """Cycles beyond a line from a pixel to itself, if nothing waits."""
        return self.COMPLETE_CLOCKS - 1

    def elaborate(self, platform: object) -> Module:
        m = Module()
        # A line, and what comes of the next one while the first's end settles; one word of all that is in the register behind.
        depth = self.config.max_width + self.SETTLING - 1
        queued = data.StructLayout({"pixel": LabelWord(self.config), "enable": 1})

        # Pixels.
        m.submodules.pixels = pixels = Queue(queued, depth)
        m.submodules.pixel_head = pixel_head = StreamRegister(queued)
        taken  = Signal()
        enable = Signal(reset_less=True)
        joined = Signal(queued)
        m.d.comb += [
            taken.eq(self.i.valid & self.i.ready), self.i.ready.eq(pixels.i.ready),
            joined.pixel.eq(self.i.p), joined.enable.eq(Mux(self.i.p.first, self.enable, enable)),
            pixels.i.payload.eq(joined), pixels.i.valid.eq(self.i.valid),
        ]
        wiring.connect(m, pixels.o, pixel_head.i)
        with m.If(taken):
            m.d.sync += enable.eq(joined.enable)

        # Passing labels. There are never more than pixels, which are at most one more than their queue is deep: none need wait.
        m.submodules.passing = passing = Queue(Passing(self.config), depth + 2)
        m.submodules.passing_head = passing_head = StreamRegister(Passing(self.config))
        m.d.comb += [
            passing.i.p.label.eq(self.i.p.label), passing.i.p.none.eq(~self.i.p.passed),
            passing.i.valid.eq(taken & (self.i.p.passed | self.i.p.last)),
        ]
        wiring.connect(m, passing.o, passing_head.i)

        # Complete lines. One counts when its words have reached the registers behind the queues: nothing else need be waited for.
        lines     = Signal(range(depth + 2))
        more      = Signal.like(lines)
        complete  = Signal()
        ends      = Signal(self.SETTLING - 1)
        done      = Signal()
        m.d.comb += more.eq(lines + ends[-1] - done)
        m.d.sync += [ends.eq(Cat(taken & self.i.p.last, ends)), lines.eq(more), complete.eq(more != 0)]

        # A pixel leaves between its neighbours.
        advance   = Signal()
        leave     = Signal()
        pixel     = pixel_head.o.p.pixel
        right     = passing_head.o.p
        from_left = Signal()
        left      = Signal.like(pixel.label, reset_less=True)
        own       = Signal()
        m.d.comb += [
            advance.eq(~self.o.valid | self.o.ready), leave.eq(complete & advance), done.eq(leave & pixel.last),
            own.eq(pixel.passed | ~pixel_head.o.p.enable | (right.none & ~from_left)),
            pixel_head.o.ready.eq(leave), passing_head.o.ready.eq(leave & (pixel.passed | pixel.last)),
        ]
        with m.If(leave):
            m.d.sync += from_left.eq(~pixel.last & (from_left | pixel.passed))
            with m.If(pixel.passed):
                m.d.sync += left.eq(pixel.label)

        # The smaller of two: one alone, or its own, is compared with itself.
        is_between = Signal()
        between    = Signal(LabelWord(self.config), reset_less=True)
        other      = Signal.like(pixel.label, reset_less=True)
        payload    = data_register(m, self.o.payload)
        with m.If(advance):
            m.d.sync += [
                is_between.eq(leave), between.eq(pixel), self.o.valid.eq(is_between), payload.eq(between),
                between.label.eq(Mux(own, pixel.label, Mux(from_left, left, right.label))),
                other.eq(Mux(own, pixel.label, Mux(right.none, left, right.label))),
                payload.label.eq(Mux(other < between.label, other, between.label)),
            ]
        return m
