"""Video input: from the BT.656 bytes of a camera's decoder to a stream of whole frames."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.video.bt656 import lost_bytes
from golden.video.formats import CameraFormat

from ..parts.counters import count_events
from ..parts.crossing import ClockWatch, EventCrossing
from .camera_fifo import CameraFifo
from .timing_codes import TimingCode, TimingCodes
from .words import CameraWord


__all__ = ["ActivePixels", "CameraInput"]


class ActivePixels(wiring.Component):
    """Extracts the luma of frames from bytes and their timing codes; golden: :func:`golden.video.bt656.decode`.

    Each line of active video must have the length of the format, and be closed by a valid EAV, whose V tells whether the field goes on;
    the next code must be the next line's SAV. The top field is first, each field is complete. Otherwise the frame is abandoned with a
    ``drop`` word, and reception begins again at the next top field. Lengths of blanking do not matter.

    The last pixel of a line is held back until the EAV that closes it: ``end`` is set for good frames only.

    Timing: latency :attr:`LATENCY` cycle from the byte, 4 more for the last pixel of a line. At most one word in two cycles, except for a
    ``drop`` word, which may follow a pixel in the next cycle.

    Parameters
    ----------
    format : CameraFormat

    Members
    -------
    byte, found, valid, code
        Outputs of :class:`TimingCodes`.
    o : Out(CameraWord())
    strobe : Out(1)
        ``o`` is a word. There is no back-pressure.
    complete : Out(1)
        One cycle: a frame is complete.
    skipped : Out(1)
        One cycle: a bottom field without its top field.
    fault : Out(1)
        One cycle: a violation of the format, within a frame or not; also no codes for :func:`golden.video.bt656.lost_bytes`, or no
        complete frame for the time of three.
    """
    LATENCY = 1

    def __init__(self, format: CameraFormat):
        self.format = format
        super().__init__({
            "byte": In(8),
            "found": In(1),
            "valid": In(1),
            "code": In(TimingCode()),
            "o": Out(CameraWord()),
            "strobe": Out(1),
            "complete": Out(1),
            "skipped": Out(1),
            "fault": Out(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        line_bytes = 2 * self.format.width
        eav_at = line_bytes + 3     # XY of the EAV that closes a line, counted from the first byte after SAV

        position  = Signal(range(eav_at + 1), reset_less=True)
        line      = Signal(range(self.format.field_lines), reset_less=True)
        bottom    = Signal(reset_less=True)
        last_line = Signal()
        m.d.comb += last_line.eq(line == self.format.field_lines - 1)

        # A field begins with the first active line after a blank one.
        sav, field_start = Signal(), Signal()
        blank = Signal()
        m.d.comb += [sav.eq(self.valid & ~self.code.h & ~self.code.v), field_start.eq(sav & blank)]
        with m.If(self.valid & self.code.v):
            m.d.sync += blank.eq(1)
        with m.Elif(sav):
            m.d.sync += blank.eq(0)

        # Loss of signal: no codes, or codes without complete frames. Three frames' time, because two pass where a frame is dropped.
        no_frame_lines = 3 * self.format.frame_lines
        lost, no_frame = Signal(), Signal()
        bytes_since = Signal(range(lost_bytes(self.format) + 1))
        lines_since = Signal(range(no_frame_lines + 1))
        m.d.comb += lost.eq((bytes_since == lost_bytes(self.format) - 1) & ~self.valid)
        m.d.comb += no_frame.eq((lines_since == no_frame_lines - 1) & self.valid & self.code.h)
        with m.If(self.valid):
            m.d.sync += bytes_since.eq(0)
        with m.Elif(bytes_since != lost_bytes(self.format)):
            m.d.sync += bytes_since.eq(bytes_since + 1)
        with m.If(self.complete):
            m.d.sync += lines_since.eq(0)
        with m.Elif(self.valid & self.code.h & (lines_since != no_frame_lines)):
            m.d.sync += lines_since.eq(lines_since + 1)

        # The next bottom field belongs to a frame that was dropped, or that began before reception did: not counted as skipped.
        excused = Signal(init=1)
        start   = Signal()
        abandon = Signal()
        m.d.sync += [self.strobe.eq(0), self.o.first.eq(0), self.o.last.eq(0), self.o.end.eq(0), self.o.drop.eq(0)]
        with m.FSM():
            with m.State("between frames"):
                with m.If(field_start & ~self.code.f):
                    m.d.comb += start.eq(1)
                    m.next = "line"
                with m.Elif(field_start):
                    m.d.comb += self.skipped.eq(~excused)
                    m.d.sync += excused.eq(0)

            with m.State("line"):
                m.d.sync += position.eq(position + 1)
                with m.If(position[0] & (position < line_bytes)):
                    m.d.sync += [self.o.luma.eq(self.byte), self.strobe.eq(position != line_bytes - 1)]
                    m.d.sync += self.o.first.eq((position == 1) & (line == 0) & ~bottom)
                with m.If(self.found | (position == eav_at)):
                    with m.If(self.valid & self.code.h & (self.code.f == bottom) & (self.code.v == last_line) & (position == eav_at)):
                        m.d.sync += [self.strobe.eq(1), self.o.last.eq(1), self.o.end.eq(last_line & bottom), line.eq(line + 1)]
                        with m.If(~last_line):
                            m.next = "next line"
                        with m.Elif(~bottom):
                            m.next = "between fields"
                        with m.Else():
                            m.d.comb += self.complete.eq(1)
                            m.next = "between frames"
                    with m.Else():
                        m.d.comb += abandon.eq(1)
                        m.next = "between frames"

            with m.State("next line"):
                m.d.sync += position.eq(0)
                with m.If(sav & (self.code.f == bottom)):
                    m.next = "line"
                with m.Elif(self.found | lost):
                    m.d.comb += abandon.eq(1)
                    m.next = "between frames"

            with m.State("between fields"):
                m.d.sync += [position.eq(0), line.eq(0)]
                with m.If(field_start & self.code.f):
                    m.d.sync += bottom.eq(1)
                    m.next = "line"
                with m.Elif(field_start):
                    m.d.comb += [abandon.eq(1), start.eq(1)]
                    m.next = "line"
                with m.Elif(lost):
                    m.d.comb += abandon.eq(1)
                    m.next = "between frames"

        with m.If(abandon):
            m.d.sync += [self.strobe.eq(1), self.o.drop.eq(1), excused.eq(~bottom)]
        with m.If(start):
            m.d.sync += [position.eq(0), line.eq(0), bottom.eq(0), excused.eq(0)]
        with m.If(lost):
            m.d.sync += excused.eq(1)
        m.d.comb += self.fault.eq(abandon | self.skipped | lost | no_frame)
        return m


class CameraInput(wiring.Component):
    """A camera's input: from the bytes of its decoder to a stream of frames, each complete or closed by a ``drop`` word.

    Y is kept, Cb and Cr are discarded; pixels pass as they arrive, field by field. Golden: :func:`golden.video.bt656.decode`. An error
    costs the frame that it is in, and the next good frame is bit-exact: codes with more than one wrong bit, lines too short, too long,
    missing or too many, fields missing or swapped, no codes, a byte clock that stops, a reset of its domain, a full FIFO.

    Timing: a pixel is offered :attr:`BYTE_LATENCY` clocks of the camera and then up to 5 cycles of ``sync`` after its byte; the last one
    of a line 4 clocks of the camera later. A pixel in two bytes. ``sync`` must be at least half as fast as the bytes. ``o.valid`` does not
    depend on ``o.ready``.

    Memory: ``depth * 12`` bits: one M9K block at the depth of 512, which bridges a stall of :meth:`stall_cycles`.
    Logic: about 500 logic elements of a Cyclone III at PAL, 160 of them for the four counters.

    Clock domain crossings are two-stage synchronisers and the memory of the FIFO. Paths between the two clocks are false paths; the skew
    between the bits of the FIFO's Gray-coded pointers must be below a period of the faster clock.

    Parameters
    ----------
    format : CameraFormat
    domain : str
        Clock domain of the bytes.
    depth : int
        Words of the FIFO, a power of two, at least 8.

    Members
    -------
    data : In(8)
        In ``domain``: a byte every clock.
    o : Out(stream.Signature(CameraWord()))
    present : Out(1)
        The camera sends good frames: high from the end of a complete frame until an error of the format, or until its clock stops for
        :attr:`ClockWatch.TIMEOUT` cycles. A full FIFO has no effect.
    corrected, rejected : Out(16)
        Timing codes with one wrong bit, and with more.
    dropped : Out(16)
        Frames dropped: those closed by a ``drop`` word, bottom fields without a top field, and frames lost to a full FIFO.
    overflow : Out(16)
        Frames lost to a full FIFO; they are counted in ``dropped`` too.
    clear : In(1)
        Sets the counters to 0; an event in the same cycle is counted after it. They hold their greatest value.
    """
    BYTE_LATENCY = TimingCodes.LATENCY + ActivePixels.LATENCY

    def __init__(self, format: CameraFormat, domain: str, *, depth: int = 512):
        CameraFifo.check_depth(depth)
        self.format = format
        self.domain = domain
        self.depth = depth
        super().__init__({
            "data": In(8),
            "o": Out(stream.Signature(CameraWord())),
            "present": Out(1),
            "corrected": Out(16),
            "rejected": Out(16),
            "dropped": Out(16),
            "overflow": Out(16),
            "clear": In(1),
        })

    @staticmethod
    def stall_cycles(format: CameraFormat, depth: int, sync_hz: float) -> int:
        """Cycles of ``sync`` for which ``o.ready`` may be low without loss, if the FIFO was empty: of 512 words 2822 at 75 MHz, 38 us.

        A pixel is two bytes; four words of the FIFO cover the latency of its pointers' crossing.
        """
        return int((depth - 4) * 2 * sync_hz / format.byte_clock_hz)

    def elaborate(self, platform: object) -> Module:
        m = Module()
        codes, pixels = TimingCodes(), ActivePixels(self.format)
        m.submodules.codes = DomainRenamer(self.domain)(codes)
        m.submodules.pixels = DomainRenamer(self.domain)(pixels)
        m.submodules.fifo = fifo = CameraFifo(self.domain, self.depth)
        m.submodules.watch = watch = ClockWatch(self.domain)
        names = ("corrected", "rejected", "complete", "fault", "skipped", "overflow")
        m.submodules.events = events = EventCrossing(self.domain, len(names))
        m.d.comb += [
            codes.data.eq(self.data),
            pixels.byte.eq(codes.byte), pixels.found.eq(codes.found), pixels.valid.eq(codes.valid), pixels.code.eq(codes.code),
            fifo.i.eq(pixels.o), fifo.strobe.eq(pixels.strobe), fifo.cut.eq(watch.stopped),
            events.i.eq(Cat(codes.corrected, codes.found & ~codes.valid, pixels.complete, pixels.fault, pixels.skipped | fifo.skipped,
                            fifo.overflow)),
        ]
        wiring.connect(m, fifo.o, wiring.flipped(self.o))

        seen = dict(zip(names, events.o))
        with m.If(watch.stopped | seen["fault"]):
            m.d.sync += self.present.eq(0)
        with m.Elif(seen["complete"]):
            m.d.sync += self.present.eq(1)

        # A `drop` word and a frame without one may end in the same cycle: the second one is counted a cycle later.
        deferred, without_word = Signal(), Signal()
        m.d.comb += without_word.eq(seen["skipped"] | deferred)
        m.d.sync += deferred.eq(without_word & fifo.dropped)
        for counter, event in ((self.corrected, seen["corrected"]), (self.rejected, seen["rejected"]),
                               (self.dropped, fifo.dropped | without_word), (self.overflow, seen["overflow"])):
            count_events(m, counter, event, self.clear)
        return m
