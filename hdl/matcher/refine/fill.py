"""The fill: pixels that failed the check are given a label from their line."""

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
    """Label of a pixel that passed, or ``none``: the line has no more. Nine bits up to 256 labels: the width of a memory block."""
    def __init__(self, config: MatcherConfig):
        super().__init__({"label": LabelWord(config)["label"].shape, "none": 1})


class Fill(Stage):
    """Replaces the label of a pixel that failed the check by the smaller of the nearest passing ones to its left and right on the line.

    If only one exists, by that one; on a line without any, labels are kept. Only ``label`` changes. The golden model is
    :func:`golden.matcher.refine.fill`.

    Frames must be rectangular, closed by ``end`` and at most ``max_width`` wide; they may differ in size. A wider line is never output.

    Timing: a pixel a cycle, and :attr:`line_clocks` more a line: none. A line is output once it is complete: if no earlier
    line is queued, its first pixel is valid :attr:`latency` and one cycles after its last one was accepted. A pixel whose line is sent
    without a pause is valid :attr:`lines` line of ``W`` cycles and :attr:`latency` cycles after it was accepted, whichever pixels passed.
    ``i.ready`` is registered.

    Memory: ``max_width + 2`` words of :class:`LabelWord` with the bit ``enable``, ``max_width + 4`` labels with a bit; ``pause`` more of
    each.

    Parameters
    ----------
    config : :class:`MatcherConfig`
        With a method that refines its labels.
    pause : int
        Cycles by which all is output later, for what else must be known of a line.

    Members
    -------
    i : In(stream.Signature(LabelWord(config)))
    o : Out(stream.Signature(LabelWord(config)))
    enable : In(1)
        Off: labels are unchanged, at the same latency. Sampled as the word marked ``first`` is accepted.
    """
    name = "fill"
    settings: ClassVar = {"enable": "fill"}
    lines = 1
    line_clocks = 0
    SETTLING = 3  # cycles from a word to the registers behind both queues

    def __init__(self, config: MatcherConfig, pause: int = 0):
        self.config = config
        self.settling = self.SETTLING + pause
        super().__init__({
            "i": In(stream.Signature(LabelWord(config))),
            "o": Out(stream.Signature(LabelWord(config))),
            "enable": In(1),
        })

    @property
    def latency(self) -> int:
        """Cycles beyond a line from a pixel to its result, if no earlier line is queued."""
        return self.settling + 1

    def elaborate(self, platform: object) -> Module:
        m = Module()
        # A line, and the pixels of the next one accepted before the first is known to be complete; one word is in the register behind. One
        # more, since room is decided a cycle ahead: the queue's level is far from all that depends on a word's acceptance.
        depth = self.config.max_width + self.settling
        queued = data.StructLayout({"pixel": LabelWord(self.config), "enable": 1})

        # Two queues: pixels, and the labels of those that passed. As a line is output, the head of the second one is the nearest passing
        # label to the right, or tells that there is none.
        m.submodules.pixels = pixels = Queue(queued, depth)
        m.submodules.pixel_head = pixel_head = StreamRegister(queued)
        accepted = Signal()
        room     = Signal(init=1)
        enable   = Signal(reset_less=True)
        joined   = Signal(queued)
        m.d.sync += room.eq(pixels.level < depth - 1)
        m.d.comb += [
            accepted.eq(self.i.valid & room), self.i.ready.eq(room),
            joined.pixel.eq(self.i.p), joined.enable.eq(Mux(self.i.p.first, self.enable, enable)),
            pixels.i.payload.eq(joined), pixels.i.valid.eq(accepted),
        ]
        wiring.connect(m, pixels.o, pixel_head.i)
        with m.If(accepted):
            m.d.sync += enable.eq(joined.enable)

        # Passing labels. There are never more than pixels, which are at most one more than their queue is deep: no back-pressure.
        m.submodules.passing = passing = Queue(Passing(self.config), depth + 2)
        m.submodules.passing_head = passing_head = StreamRegister(Passing(self.config))
        m.d.comb += [
            passing.i.p.label.eq(self.i.p.label), passing.i.p.none.eq(~self.i.p.passed),
            passing.i.valid.eq(accepted & (self.i.p.passed | self.i.p.last)),
        ]
        wiring.connect(m, passing.o, passing_head.i)

        # Complete lines. A line counts once its words have reached the registers behind the queues: no other condition is needed.
        lines     = Signal(range(depth + 2))
        more      = Signal.like(lines)
        complete  = Signal()
        ends      = Signal(self.settling - 1)
        done      = Signal()
        m.d.comb += more.eq(lines + ends[-1] - done)
        m.d.sync += [ends.eq(Cat(accepted & self.i.p.last, ends)), lines.eq(more), complete.eq(more != 0)]

        # A pixel is output with the labels to its left and right.
        advance   = Signal()
        output    = Signal()
        pixel     = pixel_head.o.p.pixel
        right     = passing_head.o.p
        from_left = Signal()
        left      = Signal.like(pixel.label, reset_less=True)
        keep      = Signal()
        m.d.comb += [
            advance.eq(~self.o.valid | self.o.ready), output.eq(complete & advance), done.eq(output & pixel.last),
            keep.eq(pixel.passed | ~pixel_head.o.p.enable | (right.none & ~from_left)),
            pixel_head.o.ready.eq(output), passing_head.o.ready.eq(output & (pixel.passed | pixel.last)),
        ]
        with m.If(output):
            m.d.sync += from_left.eq(~pixel.last & (from_left | pixel.passed))
            with m.If(pixel.passed):
                m.d.sync += left.eq(pixel.label)

        # The smaller of two: where there is one label only, it is compared with itself.
        is_between = Signal()
        between    = Signal(LabelWord(self.config), reset_less=True)
        other      = Signal.like(pixel.label, reset_less=True)
        payload    = data_register(m, self.o.payload)
        with m.If(advance):
            m.d.sync += [
                is_between.eq(output), between.eq(pixel), self.o.valid.eq(is_between), payload.eq(between),
                between.label.eq(Mux(keep, pixel.label, Mux(from_left, left, right.label))),
                other.eq(Mux(keep, pixel.label, Mux(right.none, left, right.label))),
                payload.label.eq(Mux(other < between.label, other, between.label)),
            ]
        return m
