"""Video input: the bytes of a camera's decoder, after BT.656, as a stream of whole frames."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.video.bt656 import lost_bytes
from golden.video.formats import CameraFormat

from .camera_fifo import CameraFifo
from .crossing import ClockWatch, EventCrossing
from .timing_codes import TimingCode, TimingCodes
from .words import CameraWord


__all__ = ["ActivePixels", "CameraInput"]


class ActivePixels(wiring.Component):
    """Luma of the frames in bytes whose timing codes have been found; golden: :func:`golden.video.bt656.decode`.

    Each line of active video must be as long as the format has it, and closed by an EAV that can be read, which tells by V whether the
    field goes on; the next SAV must follow without another code between. The top field comes first, each field is complete. What is not so
    costs the frame: a ``drop`` word, and a new start at the next top field. Lengths of blanking do not matter.

    The last pixel of a line waits for the EAV that closes it: ``end`` is told of good frames only.

    Timing: latency :attr:`LATENCY` cycle after the byte, 4 more for the last pixel of a line. At most a word each two cycles, but for a
    ``drop`` word, which may follow a pixel at once.

    Parameters
    ----------
    format : CameraFormat

    Members
    -------
    byte, found, valid, code
        As :class:`TimingCodes` gives them.
    o : Out(CameraWord())
    strobe : Out(1)
        ``o`` is a word. Nothing can hold it up.
    complete : Out(1)
        One cycle: a frame is whole.
    skipped : Out(1)
        One cycle: a bottom field came without its top field.
    fault : Out(1)
        One cycle: something was wrong, be there a frame in progress or not: also a signal without codes for
        :func:`golden.video.bt656.lost_bytes`, or without a whole frame for three frames' time.
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

    def elaborate(self, platform):
        m = Module()
        line_bytes = 2 * self.format.width
        eav_at = line_bytes + 3     # XY of the EAV that closes a line, counted from the first byte after SAV

        position  = Signal(range(eav_at + 1), reset_less=True)
        line      = Signal(range(self.format.field_lines), reset_less=True)
        bottom    = Signal(reset_less=True)
        last_line = Signal()
        m.d.comb += last_line.eq(line == self.format.field_lines - 1)

        # A field begins with the first active line after a blank one.
        sav, opens = Signal(), Signal()
        blank = Signal()
        m.d.comb += [sav.eq(self.valid & ~self.code.h & ~self.code.v), opens.eq(sav & blank)]
        with m.If(self.valid & self.code.v):
            m.d.sync += blank.eq(1)
        with m.Elif(sav):
            m.d.sync += blank.eq(0)

        # Loss of signal: no code, or codes and no frames. From one whole frame to the next there are two frames if one is dropped.
        useless_lines = 3 * self.format.frame_lines
        lost, useless = Signal(), Signal()
        bytes_since = Signal(range(lost_bytes(self.format) + 1))
        lines_since = Signal(range(useless_lines + 1))
        m.d.comb += lost.eq((bytes_since == lost_bytes(self.format) - 1) & ~self.valid)
        m.d.comb += useless.eq((lines_since == useless_lines - 1) & self.valid & self.code.h)
        with m.If(self.valid):
            m.d.sync += bytes_since.eq(0)
        with m.Elif(bytes_since != lost_bytes(self.format)):
            m.d.sync += bytes_since.eq(bytes_since + 1)
        with m.If(self.complete):
            m.d.sync += lines_since.eq(0)
        with m.Elif(self.valid & self.code.h & (lines_since != useless_lines)):
            m.d.sync += lines_since.eq(lines_since + 1)

        # The bottom field that comes next is the rest of a frame that was dropped, or that nobody saw begin.
        excused = Signal(init=1)
        start   = Signal()
        give_up = Signal()
        m.d.sync += [self.strobe.eq(0), self.o.first.eq(0), self.o.last.eq(0), self.o.end.eq(0), self.o.drop.eq(0)]
        with m.FSM():
            with m.State("between frames"):
                with m.If(opens & ~self.code.f):
                    m.d.comb += start.eq(1)
                    m.next = "line"
                with m.Elif(opens):
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
                        m.d.comb += give_up.eq(1)
                        m.next = "between frames"

            with m.State("next line"):
                m.d.sync += position.eq(0)
                with m.If(sav & (self.code.f == bottom)):
                    m.next = "line"
                with m.Elif(self.found | lost):
                    m.d.comb += give_up.eq(1)
                    m.next = "between frames"

            with m.State("between fields"):
                m.d.sync += [position.eq(0), line.eq(0)]
                with m.If(opens & self.code.f):
                    m.d.sync += bottom.eq(1)
                    m.next = "line"
                with m.Elif(opens):
                    m.d.comb += [give_up.eq(1), start.eq(1)]
                    m.next = "line"
                with m.Elif(lost):
                    m.d.comb += give_up.eq(1)
                    m.next = "between frames"

        with m.If(give_up):
            m.d.sync += [self.strobe.eq(1), self.o.drop.eq(1), excused.eq(~bottom)]
        with m.If(start):
            m.d.sync += [position.eq(0), line.eq(0), bottom.eq(0), excused.eq(0)]
        with m.If(lost):
            m.d.sync += excused.eq(1)
        m.d.comb += self.fault.eq(give_up | self.skipped | lost | useless)
        return m


class CameraInput(wiring.Component):
    """A camera: from the bytes of its decoder to a stream of frames, each whole or closed by a ``drop`` word.

    Y is kept, Cb and Cr are dropped; a frame is passed on while it comes, field by field. Golden: :func:`golden.video.bt656.decode`. What
    may go
    wrong costs the frame it is in, and the next good one is exact: codes with more than one wrong bit, lines too short, too long, missing
    or too many, fields missing or swapped, no codes, a byte clock that stops, a reset of its domain, a full FIFO.

    Timing: the first pixel of a line leaves :attr:`BYTE_LATENCY` clocks of the camera and then up to 5 cycles of ``sync`` after its byte;
    the last one of a line 4 clocks of the camera later. A pixel each two bytes. ``sync`` must be at least half as fast as the bytes.
    A word that is offered stays; ``o.valid`` does not depend on ``o.ready``.

    Memory: ``depth * 12`` bits: one M9K at the depth of 512, which rides out a stall of the consumer of :meth:`stall_cycles`.
    Logic: about 500 logic elements of a Cyclone III at PAL, of which the four counters take 160.

    Crossings between the domains are registers followed by two more, and the memory of the FIFO. Paths between the two clocks are false
    ones; the bits of the FIFO's Gray-coded pointers must not be apart by a period of the faster clock.

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
        The camera sends frames: high from the end of a frame whose lines are all right until something is wrong, or the clock stops for
        :attr:`ClockWatch.TIMEOUT` cycles. A full FIFO is no matter of the camera.
    corrected, rejected : Out(16)
        Timing codes with one wrong bit, and with more.
    dropped : Out(16)
        Frames that were not passed on: closed by a ``drop`` word, bottom fields without a top field, and what a full FIFO lost.
    overflow : Out(16)
        Frames lost to a full FIFO; they are counted in ``dropped`` too.
    clear : In(1)
        Sets the counters to 0; what is counted in the same cycle stays. They hold their greatest value.
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

        A pixel comes each two bytes; four words of the FIFO are what is on the way between the clocks.
        """
        return int((depth - 4) * 2 * sync_hz / format.byte_clock_hz)

    def elaborate(self, platform):
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

        # A `drop` word and a frame that has none may meet: the second is counted a cycle later.
        waiting, again = Signal(), Signal()
        m.d.comb += again.eq(seen["skipped"] | waiting)
        m.d.sync += waiting.eq(again & fifo.dropped)
        for counter, event in ((self.corrected, seen["corrected"]), (self.rejected, seen["rejected"]),
                               (self.dropped, fifo.dropped | again), (self.overflow, seen["overflow"])):
            with m.If(self.clear):
                m.d.sync += counter.eq(event)
            with m.Elif(event & ~counter.all()):
                m.d.sync += counter.eq(counter + 1)
        return m
