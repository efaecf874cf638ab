"""The last stage of the refinement, whatever selects a label from its window: disparities with their confidence."""

from typing import Any, ClassVar

from amaranth import *
from amaranth.hdl import Mux, ValueLike
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig
from golden.matcher.confidence import WINDOW

from ...parts.delay import Delay, StreamRegister
from ...parts.queue import Queue
from ..settings import minimum_shape
from ..stage import Stage
from ..stream import DisparityWord, LabelWord, copy_flags
from .confidence import Confidence
from .window import LabelColumns, SlotWord, VoteColumn


__all__ = ["WindowStage"]


class WindowStage(Stage):
    """Selects a label from the window around each pixel, with which the pixel's disparity and confidence follow.

    Golden: the selection's, then ``disparity = label + minimum * config.method.disparity_scale``, and
    :func:`golden.matcher.confidence.confidence` of the label among those before the selection.

    Frames must be rectangular, closed by ``end`` and at most ``max_width`` wide; they may differ in size.

    Timing: a pixel a cycle, :attr:`line_clocks` cycles more a line, :attr:`frame_lines` lines more a frame, in which no pixel is
    accepted: the last lines are output without waiting for the next frame. If ``o`` does not stall, a pixel is valid :attr:`lines` lines
    of ``W + line_clocks`` cycles and :attr:`latency` cycles after it was accepted. ``i.ready`` and ``o`` are registered.

    Memory: that of :class:`LabelColumns`; a column and a result for the time that selection and votes take; an output queue of
    :attr:`latency` words.

    Parameters
    ----------
    config : :class:`MatcherConfig`
        With a method that refines its labels.

    Members
    -------
    i : In(stream.Signature(LabelWord(config)))
    o : Out(stream.Signature(DisparityWord(config)))
    enable : In(1)
        Off: labels are unchanged, at the same latency.
    minimum : In(minimum_shape(config))
        Disparity of the label 0, pixels. Both are sampled as the word marked ``first`` is accepted.

    Attributes
    ----------
    selection : type of component
        Constructed from the configuration. ``rows``: lines of the window, 5 or more. ``i``, ``valid``, ``opens``: what ``part_of`` gives of
        a column. ``o``, ``done``: the label selected for the pixel ``rows // 2`` columns before, ``latency`` cycles later.
    """
    name = "median"
    settings: ClassVar = {"enable": "median", "minimum": "minimum"}
    selection: ClassVar[Any]

    def __init__(self, config: MatcherConfig):
        self.config = config
        self.median = self.selection(config)
        self.columns = LabelColumns(config, self.median.rows)
        self.confidence = Confidence(config)
        super().__init__({
            "i": In(stream.Signature(LabelWord(config))),
            "o": Out(stream.Signature(DisparityWord(config))),
            "enable": In(1),
            "minimum": In(minimum_shape(config)),
        })

    @property
    def pipeline(self) -> int:
        """Cycles from a label to the disparity that its column completes."""
        return LabelColumns.LATENCY + self.median.latency + self.confidence.latency

    @property
    def latency(self) -> int:
        """Cycles beyond :attr:`lines` lines from a pixel to its disparity, if ``o`` does not stall."""
        return self.columns.reach + self.pipeline + 2 + StreamRegister.LATENCY

    def elaborate(self, platform: object) -> Module:
        m = Module()
        config = self.config
        m.submodules.columns, m.submodules.median, m.submodules.confidence = self.columns, self.median, self.confidence
        columns, median, confidence = self.columns, self.median, self.confidence
        wiring.connect(m, wiring.flipped(self.i), columns.i)
        m.d.comb += [
            columns.enable.eq(self.enable), columns.minimum.eq(self.minimum),
            median.i.eq(median.part_of(columns.o.column)), median.valid.eq(columns.valid), median.opens.eq(columns.o.opens),
        ]

        # The column in step with its median: of its lines those that vote.
        m.submodules.aside = slot_delay = Delay(SlotWord(config, VoteColumn(config)), median.latency)
        slot  = slot_delay.o
        label = Mux(slot.enable, median.o, confidence.center)
        column, opens = slot.column, slot.opens
        # A wider window is complete as many columns later as it has columns more on a side.
        for n in range(columns.reach - WINDOW // 2):
            later       = Signal.like(column, name=f"later_{n}", reset_less=True)
            later_opens = Signal(name=f"later_opens_{n}", reset_less=True)
            with m.If(median.done):
                m.d.sync += [later.eq(column), later_opens.eq(opens)]
            column, opens = later, later_opens
        m.d.comb += [
            slot_delay.i.eq(middle(columns.o)),
            confidence.i.eq(column), confidence.advance.eq(median.done), confidence.opens.eq(opens),
            confidence.disparity.eq(label),
        ]

        # The disparity in step with its confidence.
        word  = Signal(DisparityWord(config), reset_less=True)
        shown = Signal(confidence.latency)
        m.d.sync += [
            word.disparity.eq(label + slot.minimum * config.method.disparity_scale), word.passed.eq(confidence.center_passed),
            *copy_flags(word, slot), shown.eq(Cat(median.done & slot.shown, shown)),
        ]
        m.submodules.result = result = Delay(DisparityWord(config), confidence.latency - 1)
        m.d.comb += result.i.eq(word)

        # The pipeline never stalls: a column is issued only while the output queue has room for all in flight. This is decided a cycle
        # ahead, hence the margin of two columns.
        depth  = self.pipeline + 4
        unread = Signal(range(depth + 1))  # issued, not yet read from the queue
        final  = Signal(DisparityWord(config))
        m.submodules.output = output = Queue(DisparityWord(config), depth)
        m.submodules.register = register = StreamRegister(DisparityWord(config))
        wiring.connect(m, output.o, register.i)
        wiring.connect(m, register.o, wiring.flipped(self.o))
        m.d.sync += [
            unread.eq(unread + columns.issued - (output.o.valid & output.o.ready)), columns.go.eq(unread < depth - 1),
        ]
        m.d.comb += [
            final.eq(result.o), final.confidence.eq(confidence.o),
            output.i.payload.eq(final), output.i.valid.eq(shown[-1]),
        ]
        return m


def middle(slot: data.View) -> ValueLike:
    """A slot with the middle lines of its column only, as a :class:`VoteColumn`."""
    rows = len(slot.column.passed)
    lines = range(rows // 2 - WINDOW // 2, rows // 2 + WINDOW // 2 + 1)
    if len(lines) == rows:
        return slot
    column = Cat(*(slot.column.label[n] for n in lines), *(slot.column.passed[n] for n in lines), slot.column.size)
    return Cat(column, *(slot[name] for name in slot.shape().members if name != "column"))
