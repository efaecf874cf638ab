"""A stored left picture and its disparities for a monitor: addresses, timing, colours."""

import numpy as np
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.data import StructLayout
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS
from golden.video.display import colour_table, grey_level
from golden.video.formats import DisplayFormat
from golden.video.side_by_side import layout

from .dvi import DviTiming


__all__ = ["SideBySide"]


class SideBySide(wiring.Component):
    """Reads a picture memory as a monitor shows it. Golden: :func:`golden.video.side_by_side.side_by_side`.

    Timing: all outputs to the monitor belong to the same pixel and are registered; the memory has a clock from ``address`` to its answer.
    The first frame begins with vertical blanking.

    Memory: ``labels * 24`` bits of colours.

    Parameters
    ----------
    display : :class:`DisplayFormat`
    width, height : int
        Of the stored pictures, in pixels; :class:`ValueError` if they cannot be shown.
    labels : int

    Members
    -------
    address : Out(range(width * height)), column : Out
        ``y * width + x``, and ``x``.
    frame, line : Out(1)
        For a memory that reads a line ahead: one cycle in vertical blanking; one cycle before the first ``column`` of each shown line.
    left : In(8), label : In(range(labels)), known : In(1)
        What is there, in the cycle after ``address``; a label that is not known is black.
    red, green, blue : Out(8)
        0 outside ``de``.
    de, hsync, vsync : Out(1)
        A pixel of the active area; the sync signals, low active.
    """
    #: Cycles from the counters to the outputs: address, memory, colours, and a register for all of them.
    LATENCY = 4

    def __init__(self, display: DisplayFormat, width: int, height: int, labels: int):
        self.display = display
        self.width = width
        self.labels = labels
        self.layout = layout(display, width, height)
        super().__init__({
            "address": Out(range(width * height)), "column": Out(range(self.layout.width * self.layout.step)),
            "frame": Out(1), "line": Out(1),
            "left": In(PIXEL_BITS), "label": In(range(labels)), "known": In(1),
            "red": Out(PIXEL_BITS), "green": Out(PIXEL_BITS), "blue": Out(PIXEL_BITS),
            "de": Out(1), "hsync": Out(1, init=1), "vsync": Out(1, init=1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        step, columns, lines = self.layout
        m.submodules.timing = timing = DviTiming(self.display)

        def delayed(value: Value, clocks: int, init: int = 0) -> Signal:
            for stage in range(clocks):
                later = Signal(value.shape(), init=init, name=f"{getattr(value, 'name', 'value')}_{stage}")
                m.d.sync += later.eq(value)
                value = later
            return value

        # Where the counters are: in a shown line, in the left half of it or in the right one; the pixel's place in the stored picture.
        in_line, in_left, in_right = Signal(), Signal(), Signal()
        middle = columns.start + self.layout.width
        m.d.comb += [
            in_line.eq(_within(timing.y, lines)),
            in_left.eq(in_line & _within(timing.x, range(columns.start, middle))),
            in_right.eq(in_line & _within(timing.x, range(middle, columns.stop))),
        ]
        line = Signal.like(self.address)        # address of the line's first pixel
        column = Signal(range(self.layout.width * step))
        with m.If(in_left | in_right):
            m.d.sync += column.eq(Mux((timing.x == middle - 1) | (timing.x == columns.stop - 1), 0, column + step))
        with m.If(timing.frame_start):
            m.d.sync += line.eq(0)
        with m.Elif(in_line & (timing.x == columns.stop - 1)):
            m.d.sync += line.eq(line + step * self.width)
        m.d.sync += [self.address.eq(line + column), self.column.eq(column)]
        m.d.comb += [self.frame.eq(timing.frame_start), self.line.eq(in_line & (timing.x == columns.start))]

        colours = colour_table()[grey_level(np.arange(self.labels), self.labels)]
        shape = StructLayout(dict.fromkeys(("red", "green", "blue"), PIXEL_BITS))
        table = [{"red": int(red), "green": int(green), "blue": int(blue)} for red, green, blue in colours]
        m.submodules.colours = memory = Memory(shape=shape, depth=self.labels, init=table)
        read = memory.read_port()
        m.d.comb += read.addr.eq(self.label)

        before = self.LATENCY - 1
        left_pixel = delayed(in_left, before)
        disparity = delayed(in_right, before) & delayed(self.known, 1)
        grey = delayed(self.left, 1)
        for colour in ("red", "green", "blue"):
            m.d.sync += getattr(self, colour).eq(Mux(left_pixel, grey, Mux(disparity, getattr(read.data, colour), 0)))
        m.d.sync += [
            self.de.eq(delayed(timing.de, before)),
            self.hsync.eq(delayed(timing.hsync, before, 1)), self.vsync.eq(delayed(timing.vsync, before, 1)),
        ]
        return m


def _within(at: Value, limits: range) -> Value:
    """Without a comparison with 0, a constant, which tools warn of."""
    below = Value.cast(at < limits.stop)
    return below if limits.start == 0 else below & (at >= limits.start)
