"""Display output: DVI timing, and the picture within it."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out

from golden.config import PIXEL_BITS, MatcherConfig
from golden.video.display import DisplayMode, placement
from golden.video.formats import DisplayFormat

from ..parts.counters import count_events
from ..parts.queue import AsyncQueue
from .picture import DisplaySettings, PictureGate, PictureScan, QueuedPixel
from .words import ShownPixel


__all__ = ["COUNT_BITS", "DisplayOutput", "DviTiming"]


#: Width of the counters in :class:`DisplayOutput`.
COUNT_BITS = 16


class DviTiming(wiring.Component):
    """Counters of columns and lines, and the sync signals of the pixel that they point to.

    Both syncs are low active. ``vsync`` changes with a line's first pixel, so it is low for whole lines. Golden:
    :class:`golden.video.formats.DisplayFormat`.

    Timing: all outputs belong to the same pixel; all but ``x`` and ``y`` are combinational. The first pixel after reset is the last one
    before vertical blanking: ``frame_start`` follows in the next cycle.

    Parameters
    ----------
    display : :class:`DisplayFormat`

    Members
    -------
    x, y : Out
        Column and line, counted from the first active ones.
    de : Out(1)
        The pixel is in the active area.
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

    def elaborate(self, platform: object) -> Module:
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


def _toggle_crossing(m: Module, name: str, event: Value, *, source: str, target: str) -> tuple[Signal, Signal, Value]:
    """Takes a one-cycle event from the domain ``source`` to ``target``: its toggle, the toggle as known there, the event there.

    Events must be more than three cycles of ``target`` apart. A reset of ``target`` alone makes no event, because ``known`` is not reset.
    A reset of ``source`` alone makes one if the toggle was high.
    """
    toggle, synced = Signal(name=f"{name}_toggle"), Signal(name=f"{name}_synced")
    known = Signal(name=f"{name}_known", reset_less=True)
    m.submodules[f"{name}_crossing"] = FFSynchronizer(toggle, synced, o_domain=target)
    m.d[source] += toggle.eq(toggle ^ event)
    m.d[target] += known.eq(synced)
    return toggle, known, synced ^ known


class DisplayOutput(wiring.Component):
    """Pictures from the frame store to the monitor.

    The golden model of the active area is :func:`golden.video.display.monitor_picture`. The syncs and ``de`` never depend on the input,
    only on :class:`DviTiming`.

    **Fetching.** At the beginning of vertical blanking ``fetch`` is high for a cycle: the display requests a picture. Words accepted in
    that cycle and the next belong to the picture before, and ``shown_valid`` is sampled in the next. If it is high, the picture reader
    sends the new picture, beginning with ``first``; it may still offer words of the old one, which are discarded, but no ``first`` of it.
    If it is low, the screen is black, and that is not an underflow.

    **Underflow.** If a picture was announced, and its next pixel is not available when the display needs it, because it is late, or
    because the picture is ragged or of another size, the picture is black from that pixel on, and ``underflows`` counts one. The next
    frame starts clean: words of earlier pictures are recognised by their tag, and drained.

    **Settings.** ``mode`` and ``colour`` are sampled with ``fetch`` and hold until the next one. Each crosses to the display's domain in a
    two-stage synchroniser, and is sampled there in the last cycle of vertical blanking. Events cross in both directions as toggles.

    **Resets.** Of ``sync`` alone: the rest of the picture is black. Of ``display`` alone: timing begins with vertical blanking, and one
    ``fetch`` and one underflow too many may be counted. The next picture is bit-exact in either case.

    **FIFO.** A line of the picture consumes a pixel each display cycle, ``f`` = 65 Mpixel/s at most, while the reader delivers up to one
    each cycle of ``sync`` (75 MHz) and catches up in horizontal blanking. A full FIFO bridges ``depth / f``: 7.9 us, 590 cycles at 75 MHz,
    with the 512 words of one M9K block. That must cover the reader's longest wait for memory: the arbiter's worst case, a refresh (about
    20 cycles) and the read latency (30 cycles); so the arbiter may take up to 540 cycles. A longer stall costs the rest of that frame. In
    the long run the reader must deliver :attr:`pixel_rate`. On 1024x768 that is 35 Mpixel/s, and in mode ``both``, where three quarters
    are discarded, 70 of the 75 that a stream at 75 MHz can carry; with ``reader_skips`` it is 35 in all modes.

    Timing: two display cycles from the counters to the pins; all pins are registered together. Outside ``de`` colours are 0.

    Memory: ``depth * (label bits + 10)`` bits of FIFO, ``labels * 32`` of shades, ``width // 2 * 8`` of line buffer.

    Parameters
    ----------
    config : :class:`MatcherConfig`
    display : :class:`DisplayFormat`
    width, height : int
        Of the picture, in pixels; at most the display's.
    depth : int
        Words of the FIFO's memory, a power of two, at least 16; vertical blanking must be 64 pixels longer, so that it can be drained.
    reader_skips : bool
        While ``halves`` is high, the reader sends the lines 0, 2, 4, ... of the picture only, as many as the half picture has.

    Members
    -------
    i : In(stream.Signature(ShownPixel(config)))
    fetch : Out(1)
    shown_valid : In(1)
    halves : Out(1)
        Mode ``both`` was sampled; changes in the cycle after ``fetch`` only.
    mode : In(2)
        :attr:`DisplayMode.code`; 3 means ``both`` too.
    colour : In(1)
    underflows : Out(16)
        Frames; holds its greatest value.
    frames : Out(16)
        Frames of the display, counted with ``fetch``; wraps.
    clear : In(1)
        Sets both counters to 0, or to 1 if they count in this cycle.
    red, green, blue : Out(8)
        In ``display``, as all that follow.
    de, hsync, vsync : Out(1)
    fill : Out(range(depth + 2))
        Lowest level of the FIFO since reset as the display consumed a pixel while words were still expected; for benches.
    """
    def __init__(self, config: MatcherConfig, display: DisplayFormat, width: int, height: int, *, depth: int = 512,
                 reader_skips: bool = False):
        if depth < 16 or depth & (depth - 1):
            raise ValueError(f"the depth of the display's FIFO must be a power of two of at least 16, not {depth!r}")
        blanking = (display.v_total - display.height) * display.h_total
        if blanking < depth + 64:
            raise ValueError(f"vertical blanking of {blanking} pixels is too short to drain the display's FIFO of {depth} words; "
                             f"give it {blanking - 64} or less")
        placement(display, width, height, DisplayMode.BOTH)  # raises ValueError unless the picture fits
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
    def pixel_rate(self) -> float:
        """Pixels a second at ``i`` within the lines of the picture, in the mode that needs most."""
        lines = 1 if self.reader_skips else 2  # of the picture in a line of the display: every second one is discarded
        return lines * self.width * self.display.pixel_clock_hz / self.display.h_total

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.timing = timing = DomainRenamer("display")(DviTiming(self.display))
        m.submodules.gate = gate = PictureGate(self.config, self.width, self.height, reader_skips=self.reader_skips)
        m.submodules.scan = scan = DomainRenamer("display")(PictureScan(self.config, self.display, self.width, self.height))
        m.submodules.queue = queue = AsyncQueue(QueuedPixel(self.config), self.depth, o_domain="display")
        frame_tag, gate_tag, fetch = _toggle_crossing(m, "request", timing.frame_start, source="display", target="sync")
        _, _, underflow = _toggle_crossing(m, "underflow", scan.underflow, source="display", target="sync")

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
        with m.If(self.clear):
            m.d.sync += self.frames.eq(fetch)
        count_events(m, self.underflows, underflow, self.clear)
        wiring.connect(m, wiring.flipped(self.i), gate.i)
        m.d.comb += [
            self.fetch.eq(fetch), self.halves.eq(settings.halves),
            gate.fetch.eq(fetch), gate.shown_valid.eq(self.shown_valid), gate.halves.eq(settings.halves), gate.tag.eq(gate_tag),
            queue.i.p.eq(gate.word), queue.i.valid.eq(gate.write), gate.ready.eq(queue.i.ready),
        ]

        # Domain display: settings of this frame, words out of the FIFO.
        synced, current = Signal(DisplaySettings()), Signal(DisplaySettings())
        unfinished = Signal()
        m.submodules.settings_crossing = FFSynchronizer(settings.as_value(), synced.as_value(), o_domain="display")
        m.submodules.unfinished_crossing = FFSynchronizer(gate.unfinished, unfinished, o_domain="display")
        with m.If(timing.frame_end):
            m.d.display += current.eq(synced)
        wiring.connect(m, queue.o, scan.i)
        m.d.comb += [
            scan.x.eq(timing.x), scan.y.eq(timing.y), scan.frame_start.eq(timing.frame_start),
            scan.settings.eq(current), scan.tag.eq(frame_tag),
            self.red.eq(scan.red), self.green.eq(scan.green), self.blue.eq(scan.blue),
        ]
        with m.If(scan.needed & unfinished & (queue.level < self.fill)):
            m.d.display += self.fill.eq(queue.level)

        # The timing signals are delayed as much as the colours.
        pins = Cat(timing.de, timing.hsync, timing.vsync)
        for stage in range(PictureScan.LATENCY):
            delayed = Signal(3, init=0b110, name=f"pins_{stage}")
            m.d.display += delayed.eq(pins)
            pins = delayed
        m.d.comb += Cat(self.de, self.hsync, self.vsync).eq(pins)
        return m
