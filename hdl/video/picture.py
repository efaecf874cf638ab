"""The picture for the monitor: its way into the display's FIFO, and out of it."""

import numpy as np
from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, MatcherConfig
from golden.video.display import DisplayMode, colour_table, grey_level, placement
from golden.video.formats import DisplayFormat

from .words import ShownPixel


__all__ = ["DisplaySettings", "PictureGate", "PictureScan", "QueuedPixel"]


class QueuedPixel(data.StructLayout):
    """A :class:`ShownPixel` in the display's FIFO; ``tag`` alternates from one ``fetch`` to the next.

    17 bits for 80 disparities, 18 for 256: a word of an M9K block.
    """
    def __init__(self, config: MatcherConfig):
        super().__init__({"disparity": range(config.labels), "left": PIXEL_BITS, "first": 1, "tag": 1})


class PictureGate(wiring.Component):
    """Passes the pixels of the picture that was fetched last, and discards all others.

    After ``fetch`` words are discarded up to the first one with ``first``; all words if no picture was announced. Their flags are checked
    against the picture's size: from the first mismatch on the rest is discarded. In mode ``both`` every second pixel of every second line
    passes: only pixels that are shown enter the FIFO.

    Timing: combinational from ``i`` to ``word``; a word a cycle. ``i.ready`` depends combinationally on ``ready`` and on ``fetch``: in the
    cycle of ``fetch`` and in the next one words are accepted and discarded.

    Parameters
    ----------
    config : :class:`MatcherConfig`
    width, height : int
        Of the picture, in pixels.
    reader_skips : bool
        In mode ``both`` the source sends the lines 0, 2, 4, ... only, as many as the half picture has.

    Members
    -------
    fetch : In(1)
        One cycle: the current picture is given up.
    shown_valid : In(1)
        In the cycle after ``fetch``: a picture is announced.
    halves : In(1)
        Mode ``both``; changes with ``fetch`` only.
    tag : In(1)
        Tag of the words written; changes with ``fetch`` only.
    i : In(stream.Signature(ShownPixel(config)))
    word : Out(QueuedPixel(config))
    write : Out(1)
        ``word`` is offered; it is accepted if ``ready`` is high. Not a stream, because ``fetch`` withdraws an offer.
    ready : In(1)
    announced : Out(1)
        There is a picture to show; valid from two cycles after ``fetch`` on.
    unfinished : Out(1)
        Words of it are still expected.
    """
    def __init__(self, config: MatcherConfig, width: int, height: int, *, reader_skips: bool = False):
        self.width = width
        self.height = height
        self.reader_skips = reader_skips
        super().__init__({
            "fetch": In(1),
            "shown_valid": In(1),
            "halves": In(1),
            "tag": In(1),
            "i": In(stream.Signature(ShownPixel(config))),
            "word": Out(QueuedPixel(config)),
            "write": Out(1),
            "ready": In(1),
            "announced": Out(1),
            "unfinished": Out(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        pixel = self.i.p

        # Position of the next pixel in the picture.
        x = Signal(range(self.width))
        y = Signal(range(self.height))
        begun, line_end, last_line, flags_match = Signal(), Signal(), Signal(), Signal()
        m.d.comb += [
            begun.eq((x != 0) | (y != 0)),
            line_end.eq(x == self.width - 1),
            last_line.eq(y == self.height - 1),
            flags_match.eq((pixel.first != begun) & (pixel.last == line_end)),
        ]
        # The half picture has every second pixel; the last of an odd number of columns or lines is not in it.
        left_out = x[0] | (x == self.width // 2 * 2)
        if self.reader_skips:
            with m.If(self.halves):
                m.d.comb += last_line.eq(y == self.height // 2 - 1)
        else:
            left_out |= y[0] | (y == self.height // 2 * 2)

        wanted = Signal()
        m.d.comb += [
            wanted.eq(self.unfinished & (begun | pixel.first)),
            self.word.disparity.eq(pixel.disparity), self.word.left.eq(pixel.left),
            self.word.first.eq(pixel.first), self.word.tag.eq(self.tag),
            self.write.eq(self.i.valid & wanted & flags_match & ~(self.halves & left_out) & ~self.fetch),
            self.i.ready.eq(~self.unfinished | self.fetch | self.ready),
        ]
        with m.If(self.i.valid & self.i.ready & wanted):
            m.d.sync += x.eq(x + 1)
            with m.If(line_end):
                m.d.sync += [x.eq(0), y.eq(y + 1)]
            with m.If(~flags_match | (line_end & last_line)):
                m.d.sync += self.unfinished.eq(0)

        fetched = Signal()
        m.d.sync += fetched.eq(self.fetch)
        with m.If(fetched):
            m.d.sync += [self.announced.eq(self.shown_valid), self.unfinished.eq(self.shown_valid)]
        with m.If(self.fetch):
            m.d.sync += [self.unfinished.eq(0), x.eq(0), y.eq(0)]
        return m


class DisplaySettings(data.StructLayout):
    """Settings of a frame of the display: mode ``both``, mode ``left``, disparities in colour, and whether there is a picture."""
    def __init__(self) -> None:
        super().__init__({"halves": 1, "only_left": 1, "colour": 1, "announced": 1})


class PictureScan(wiring.Component):
    """Colours of the pixel that the display's counters point to; all in the display's clock domain.

    The golden model is :func:`golden.video.display.monitor_picture`. A picture pixel that is not available when it is needed is black, and
    so is the rest of the picture. Words with another tag than this frame's are drained, one a cycle, and so are words before the picture
    begins that are not its first: after a reset of the display alone a tag may repeat.

    A table of ``labels`` words of 32 bits holds a disparity's grey level and its red, green and blue. In mode ``both`` the left pixels of
    a line are kept in a line buffer until its disparities have been shown.

    Timing: latency :attr:`LATENCY` cycles from ``x`` and ``y`` to the colours, which are registered.

    Memory: ``labels * 32`` bits of shades, ``width // 2 * 8`` of line buffer.

    Parameters
    ----------
    config : :class:`MatcherConfig`
    display : :class:`DisplayFormat`
    width, height : int
        Of the picture, in pixels.

    Members
    -------
    x, y : In
        Column and line of :class:`hdl.video.dvi.DviTiming`.
    frame_start : In(1)
        In vertical blanking: from the next cycle on words of the next picture are expected.
    settings : In(DisplaySettings())
        Changes in vertical blanking only.
    tag : In(1)
        Tag of this frame's words; changes with ``frame_start`` only.
    i : In(stream.Signature(QueuedPixel(config)))
        From the FIFO. ``i.ready`` depends combinationally on ``i``.
    needed : Out(1)
        A word is to be shown in this cycle.
    underflow : Out(1)
        One cycle, once a frame: the word needed is not available. Only if a picture was announced.
    red, green, blue : Out(8)
    """
    LATENCY = 2

    def __init__(self, config: MatcherConfig, display: DisplayFormat, width: int, height: int):
        self.whole = placement(display, width, height, DisplayMode.DISPARITY)
        self.halves = placement(display, width, height, DisplayMode.BOTH)
        self.config = config
        self.width = width
        super().__init__({
            "x": In(range(display.h_total)),
            "y": In(range(display.v_total)),
            "frame_start": In(1),
            "settings": In(DisplaySettings()),
            "tag": In(1),
            "i": In(stream.Signature(QueuedPixel(config))),
            "needed": Out(1),
            "underflow": Out(1),
            "red": Out(PIXEL_BITS),
            "green": Out(PIXEL_BITS),
            "blue": Out(PIXEL_BITS),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        head, halves = self.i.p, self.settings.halves

        def within(place: tuple[range, range]) -> Value:
            # Without comparisons with 0: they are constants, which tools warn of.
            return Cat(at < limits.stop if limits.start == 0 else (at >= limits.start) & (at < limits.stop)
                       for at, limits in zip((self.x, self.y), place)).all()

        # Is this pixel in the picture, and is its word available?
        inside, good = Signal(), Signal()
        begun, failed = Signal(), Signal()
        column = Signal(range(self.width))  # of the picture, or of either half picture
        right_half = Signal()               # in the half picture to the right
        m.d.comb += [
            inside.eq(self.settings.announced & ~failed & Mux(halves, within(self.halves), within(self.whole))),
            self.needed.eq(inside & ~right_half),
            good.eq(self.i.valid & (head.tag == self.tag) & (head.first != begun)),
            self.underflow.eq(self.needed & ~good),
            self.i.ready.eq(self.needed & good | (head.tag != self.tag) | ~(begun | head.first)),
        ]
        with m.If(self.frame_start):
            m.d.sync += [begun.eq(0), failed.eq(0)]
        with m.If(self.needed):
            m.d.sync += [begun.eq(1), failed.eq(~good)]
        m.d.sync += column.eq(0)
        with m.If(inside):
            m.d.sync += column.eq(column + 1)
            with m.If(halves & (column == self.width // 2 - 1)):
                m.d.sync += [column.eq(0), right_half.eq(~right_half)]
        with m.Else():
            m.d.sync += right_half.eq(0)

        # Tables, and registers as deep as their latency.
        labels = self.config.labels
        greys = grey_level(np.arange(labels), labels)
        shades = [{"grey": int(grey), "red": int(red), "green": int(green), "blue": int(blue)}
                  for grey, (red, green, blue) in zip(greys, colour_table()[greys])]
        shade_shape = data.StructLayout(dict.fromkeys(shades[0], PIXEL_BITS))
        m.submodules.shades = shade_memory = Memory(shape=shade_shape, depth=labels, init=shades)
        m.submodules.line = line_memory = Memory(shape=PIXEL_BITS, depth=self.width // 2, init=[])
        shade, line_read, line_write = shade_memory.read_port(), line_memory.read_port(), line_memory.write_port()
        shown = Signal()
        shown_right = Signal(reset_less=True)
        level = Signal(PIXEL_BITS, reset_less=True)
        m.d.comb += [
            shade.addr.eq(head.disparity),
            line_write.addr.eq(column), line_write.data.eq(head.left), line_write.en.eq(self.needed & halves),
            line_read.addr.eq(column),
        ]
        m.d.sync += [shown.eq(inside & ~self.underflow), shown_right.eq(right_half), level.eq(head.left)]

        # Colours.
        for output, tint in ((self.red, shade.data.red), (self.green, shade.data.green), (self.blue, shade.data.blue)):
            with m.If(~shown):
                m.d.sync += output.eq(0)
            with m.Elif(shown_right):
                m.d.sync += output.eq(line_read.data)
            with m.Elif(self.settings.only_left):
                m.d.sync += output.eq(level)
            with m.Else():
                m.d.sync += output.eq(Mux(self.settings.colour, tint, shade.data.grey))
        return m
