"""To the monitor: timing of DVI, and the picture in it."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, MatcherConfig
from golden.video.display import DisplayMode, placement
from golden.video.formats import DisplayFormat

from ..parts.queue import AsyncQueue
from .picture import DisplaySettings, PictureGate, PictureScan, QueuedPixel
from .words import ShownPixel


__all__ = ["COUNT_BITS", "DisplayOutput", "DviTiming"]


#: Of the counters that the monitor's side keeps.
COUNT_BITS = 16


class DviTiming(wiring.Component):
    """Counters of columns and lines, and what they say of the pixel they point to.

    Both syncs are low active. ``vsync`` changes with a line's first pixel, so it is low for whole lines. Golden:
    :class:`golden.video.formats.DisplayFormat`.

    Timing: all outputs are of the same pixel; those but ``x`` and ``y`` are combinational. The first pixel after reset is the last one
    before vertical blanking: ``frame_start`` follows at once.

    Parameters
    ----------
    display : :class:`DisplayFormat`

    Members
    -------
    x, y : Out
        Column and line, counted from the first active ones.
    de : Out(1)
        The pixel is an active one.
    hsync, vsync : Out(1)
    frame_start : Out(1)
        First pixel of vertical blanking.
    frame_end : Out(1)
        Last pixel of vertical blanking.
    """
    def __init__(self, display: DisplayFormat):
        self.display = display
        super().__init__({
            "x": Out(range(display.h_total)),
            "y": Out(range(display.v_total)),
            "de": Out(1),
            "hsync": Out(1),
            "vsync": Out(1),
            "frame_start": Out(1),
            "frame_end": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        display = self.display
        x = Signal(range(display.h_total), init=display.h_total - 1)
        y = Signal(range(display.v_total), init=display.height - 1)
        line_end, last_line = Signal(), Signal()
        m.d.comb += [line_end.eq(x == display.h_total - 1), last_line.eq(y == display.v_total - 1)]
        m.d.sync += x.eq(x + 1)
        with m.If(line_end):
            m.d.sync += [x.eq(0), y.eq(Mux(last_line, 0, y + 1))]
        m.d.comb += [
            self.x.eq(x), self.y.eq(y),
            self.de.eq((x < display.width) & (y < display.height)),
            self.hsync.eq((x < display.h_sync.start) | (x >= display.h_sync.stop)),
            self.vsync.eq((y < display.v_sync.start) | (y >= display.v_sync.stop)),
            self.frame_start.eq((x == 0) & (y == display.height)),
            self.frame_end.eq(line_end & last_line),
        ]
        return m


def _tell(m, name, event, *, source, target):
    """Take a one-cycle event from the domain ``source`` to ``target``: its toggle, the toggle as known there, the event there.

    Events must be further apart than three cycles of ``target``. A reset of ``target`` alone is no event: what it knows is not reset. A
    reset of ``source`` alone is one if the toggle was high.
    """
    toggle, synced = Signal(name=f"{name}_toggle"), Signal(name=f"{name}_synced")
    known = Signal(name=f"{name}_known", reset_less=True)
    m.submodules[f"{name}_crossing"] = FFSynchronizer(toggle, synced, o_domain=target)
    m.d[source] += toggle.eq(toggle ^ event)
    m.d[target] += known.eq(synced)
    return toggle, known, synced ^ known


class DisplayOutput(wiring.Component):
    """Pictures from the frame store to the monitor.

    The golden model of the active area is :func:`golden.video.display.monitor_picture`. The syncs and ``de`` never depend on the input:
    they
    come from :class:`DviTiming` alone.

    **Fetching.** At the beginning of vertical blanking the display asks for a picture: ``fetch`` is high for a cycle. Words taken in that
    cycle and the next are of the picture before, and ``shown_valid`` is sampled in the next. If it is high, the picture reader sends the
    new picture, beginning with ``first``; of the old one it must not offer another ``first`` from then on, but may offer other words,
    which are discarded. If it is low, the screen is black, and that is not an underflow.

    **Underflow.** A picture that was announced and whose next pixel is not there when the display needs it, because it is late or because
    the picture is ragged or of another size, is black from that pixel on, and ``underflows`` counts one. The next frame begins anew:
    words of pictures before it are told by their tag, and drained as fast as they come out of the FIFO.

    **Settings.** ``mode`` and ``colour`` are sampled with ``fetch`` and stand until the next one; two flip-flops take each to the
    display's domain, which samples them in the last cycle of vertical blanking. Events cross both ways as toggles through two flip-flops.

    **Resets.** Of ``sync`` alone: the rest of the picture is black. Of ``display`` alone: timing begins anew, with vertical blanking, and
    one ``fetch`` and one underflow may be counted that were none. The next picture is exact in either case.

    **FIFO.** A line of the picture takes a pixel each display cycle, ``f`` = 65 Mpixel/s at most, while the reader delivers up to one each
    cycle of ``sync`` (75 MHz) and gets ahead again in horizontal blanking. A full FIFO bridges ``depth / f``: 7.9 us, 590 cycles at 75
    MHz, with the 512 words of one M9K block. That must cover the reader's longest wait for memory: the arbiter's worst case, a refresh
    (about 20 cycles) and the read latency (30 cycles); so the arbiter may take up to 540 cycles. A longer stall costs the rest of that
    frame. In the long run the reader must deliver :attr:`pixel_rate`. On 1024x768 that is 35 Mpixel/s, and in mode ``both``, of which
    three quarters are thrown away, 70 of the 75 that a stream at 75 MHz can carry; with ``reader_skips`` it is 35 in all modes.

    Timing: two display cycles from the counters to the pins; all pins are registered together. Outside ``de`` colours are 0.

    Memory: ``depth * (label bits + 10)`` bits of FIFO, ``labels * 32`` of shades, ``width // 2 * 8`` of line memory.

    Parameters
    ----------
    config : :class:`MatcherConfig`
    display : :class:`DisplayFormat`
    width, height : int
        Of the picture, in pixels; at most the display's.
    depth : int
        Words of the FIFO's memory, a power of two from 16 on; vertical blanking must be 64 pixels longer, for it to be drained.
    reader_skips : bool
        While ``halves`` is high, the reader sends the lines 0, 2, 4, ... of the picture only, as many as the half picture has.

    Members
    -------
    i : In(stream.Signature(ShownPixel(config)))
    fetch : Out(1)
    shown_valid : In(1)
    halves : Out(1)
        Mode ``both`` was sampled; from the cycle after ``fetch`` to the next ``fetch``.
    mode : In(2)
        :attr:`DisplayMode.code`; 3 is as ``both``.
    colour : In(1)
    underflows : Out(16)
        Frames; stays at its greatest value.
    frames : Out(16)
        Display frames, begun with ``fetch``; wraps.
    clear : In(1)
        Both counters begin anew.
    red, green, blue : Out(8)
        Domain ``display``, as all that follow.
    de, hsync, vsync : Out(1)
    fill : Out(range(depth + 2))
        Lowest number of words in the FIFO, since reset, as the display took a pixel while more were still to come; for benches.
    """
    def __init__(self, config: MatcherConfig, display: DisplayFormat, width, height, *, depth=512, reader_skips=False):
        if depth < 16 or depth & (depth - 1):
            raise ValueError(f"the display's FIFO must have a power of two from 16 on as its depth, not {depth!r}")
        blanking = (display.v_total - display.height) * display.h_total
        if blanking < depth + 64:
            raise ValueError(f"vertical blanking of {blanking} pixels is too short to drain the display's FIFO of {depth} words; "
                             f"give it {blanking - 64} or less")
        placement(display, width, height, DisplayMode.BOTH)  # does it fit?
        self.config = config
        self.display = display
        self.width = width
        self.height = height
        self.depth = depth
        self.reader_skips = reader_skips
        super().__init__({
            "i": In(stream.Signature(ShownPixel(config))),
            "fetch": Out(1),
            "shown_valid": In(1),
            "halves": Out(1),
            "mode": In(2),
            "colour": In(1),
            "underflows": Out(COUNT_BITS),
            "frames": Out(COUNT_BITS),
            "clear": In(1),
            "red": Out(PIXEL_BITS),
            "green": Out(PIXEL_BITS),
            "blue": Out(PIXEL_BITS),
            "de": Out(1),
            "hsync": Out(1),
            "vsync": Out(1),
            "fill": Out(range(depth + 2), init=depth + 1),
        })

    @property
    def pixel_rate(self):
        """Pixels a second at ``i`` that the lines of the picture need, in the mode that needs most."""
        lines = 1 if self.reader_skips else 2  # of the picture in a line of the display: every second one is thrown away
        return lines * self.width * self.display.pixel_clock_hz / self.display.h_total

    def elaborate(self, platform):
        m = Module()
        m.submodules.timing = timing = DomainRenamer("display")(DviTiming(self.display))
        m.submodules.gate = gate = PictureGate(self.config, self.width, self.height, reader_skips=self.reader_skips)
        m.submodules.scan = scan = DomainRenamer("display")(PictureScan(self.config, self.display, self.width, self.height))
        m.submodules.queue = queue = AsyncQueue(QueuedPixel(self.config), self.depth, o_domain="display")
        frame_tag, gate_tag, fetch = _tell(m, "request", timing.frame_start, source="display", target="sync")
        _, _, underflow = _tell(m, "underflow", scan.underflow, source="display", target="sync")

        # Domain sync: settings of this frame, words into the FIFO, counters.
        settings = Signal(DisplaySettings())
        m.d.comb += settings.announced.eq(gate.announced)
        with m.If(fetch):
            m.d.sync += [
                settings.halves.eq(self.mode >= DisplayMode.BOTH.code),
                settings.only_left.eq(self.mode == DisplayMode.LEFT.code),
                settings.colour.eq(self.colour),
                self.frames.eq(self.frames + 1),
            ]
        with m.If(underflow & ~self.underflows.all()):
            m.d.sync += self.underflows.eq(self.underflows + 1)
        with m.If(self.clear):
            m.d.sync += [self.frames.eq(fetch), self.underflows.eq(underflow)]
        wiring.connect(m, wiring.flipped(self.i), gate.i)
        m.d.comb += [
            self.fetch.eq(fetch), self.halves.eq(settings.halves),
            gate.fetch.eq(fetch), gate.shown_valid.eq(self.shown_valid), gate.halves.eq(settings.halves), gate.tag.eq(gate_tag),
            queue.i.p.eq(gate.word), queue.i.valid.eq(gate.write), gate.ready.eq(queue.i.ready),
        ]

        # Domain display: settings of this frame, words out of the FIFO.
        synced, current = Signal(DisplaySettings()), Signal(DisplaySettings())
        coming = Signal()
        m.submodules.settings_crossing = FFSynchronizer(settings.as_value(), synced.as_value(), o_domain="display")
        m.submodules.coming_crossing = FFSynchronizer(gate.coming, coming, o_domain="display")
        with m.If(timing.frame_end):
            m.d.display += current.eq(synced)
        m.d.comb += [
            scan.x.eq(timing.x), scan.y.eq(timing.y), scan.frame_start.eq(timing.frame_start),
            scan.settings.eq(current), scan.tag.eq(frame_tag),
            scan.head.eq(queue.o.p), scan.there.eq(queue.o.valid), queue.o.ready.eq(scan.take),
            self.red.eq(scan.red), self.green.eq(scan.green), self.blue.eq(scan.blue),
        ]
        with m.If(scan.needed & coming & (queue.level < self.fill)):
            m.d.display += self.fill.eq(queue.level)

        # The timing goes as many registers as the colours.
        pins = Cat(timing.de, timing.hsync, timing.vsync)
        for stage in range(PictureScan.LATENCY):
            delayed = Signal(3, init=0b110, name=f"pins_{stage}")
            m.d.display += delayed.eq(pins)
            pins = delayed
        m.d.comb += Cat(self.de, self.hsync, self.vsync).eq(pins)
        return m
