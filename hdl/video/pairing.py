"""Control of the frame store: which two frames are a pair, and when it is read."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from golden.video.pairing import LIVES

from ..parts.counters import count_events
from .buffers import CameraBuffers, Fetch, PairRead, PictureSlots, Writing


__all__ = ["BufferControl"]


class BufferControl(wiring.Component):
    """Decides which buffer each camera fills, which two frames are a pair, and which picture is shown.

    Golden: :class:`golden.video.pairing.Pairing`. Its module states the rule, the reasons and what it guarantees;
    :meth:`golden.video.pairing.Pairing.clock` states the order of events in one cycle.

    A slow memory only delays: the buffers of a pair stay locked for as long as it is read. A picture that is not finished ``life_clocks``
    after its pair was read is given up, so that a missing picture does not stop the system.

    While ``keep`` is high, the first pair that starts is kept: its buffers and its slot are not written again. ``kept`` tells that they can
    be read from memory. A pair whose picture is abandoned is let go, and the next one is kept instead. So that no frame is skipped
    meanwhile, there must be a buffer more of each kind.

    While ``host`` is high, no pair of the cameras starts, and their frames expire. The host's pair, whose two buffers are none of the
    cameras', starts once for each ``put``, as soon as no pair is being read and a slot is free.

    Timing: a pair starts 2 cycles after the event that made it possible: one to decide, and ``start`` is registered. A setting sampled
    at ``start`` applies to the whole pair. ``hold``, ``keep``, ``host`` and ``put`` take effect in the next cycle.
    ``kept`` and the numbers of its buffers are registers.

    Parameters
    ----------
    buffers : int
        For each of the four kinds of pictures, from 2; :func:`golden.video.pairing.buffers_needed`, and one more to keep a pair. Also the
        number of the host's buffer.
    window_clocks : int
        Greatest number of cycles between the beginnings of a pair's frames.
    life_clocks : int
        Age at which a frame expires; ``4 * window_clocks`` by default.

    Members
    -------
    left_camera, right_camera : In(Writing(buffers))
        Frames.
    disparity_plane, left_plane : In(Writing(buffers))
        Planes of the shown pictures.
    reader : In(PairRead(buffers + 1))
    display : In(Fetch(buffers))
    hold : In(1)
        No new pair starts; the shown picture freezes.
    keep : In(1)
        The next pair is kept, until this falls.
    kept : Out(1)
        A pair is kept, has been read, and its picture is complete.
    kept_left, kept_right : Out(range(buffers + 1)), kept_slot : Out(range(buffers))
        Its buffers and its slot; hold while ``kept``.
    host : In(1)
        Pairs are the host's.
    put : In(1)
        One cycle: the host's pair is to be matched; without effect unless ``host``, or while one waits.
    putting : Out(1)
        The host's pair waits, or is being read: its buffers must not be written.
    clear : In(1)
        Sets the counters to zero, or to one if they count in this cycle.
    pairs : Out(16)
        Pairs started. All counters hold their greatest value, and show an event 2 cycles after it.
    left_skipped, right_skipped : Out(16)
        Frames for which no buffer was free.
    left_unpaired, right_unpaired : Out(16)
        Complete frames that expired, or were replaced by a newer one, without a partner.
    pictures_dropped, pictures_abandoned : Out(16)
        Complete pictures replaced by the next one before a fetch; pictures that were not completed.
    """
    COUNTERS = ("pairs", "left_skipped", "right_skipped", "left_unpaired", "right_unpaired", "pictures_dropped", "pictures_abandoned")

    def __init__(self, buffers: int, window_clocks: int, life_clocks: int | None = None):
        if buffers < 2:
            raise ValueError(f"a frame store has at least 2 buffers for each picture, not {buffers!r}")
        if window_clocks < 1:
            raise ValueError(f"the window of a pair must be at least 1 cycle, not {window_clocks!r}")
        self.buffers = buffers
        self.window_clocks = window_clocks
        self.life_clocks = LIVES * window_clocks if life_clocks is None else life_clocks
        if self.life_clocks <= window_clocks:
            raise ValueError(f"a frame must live longer than the window of {window_clocks} cycles, not {life_clocks!r}")
        super().__init__({
            "left_camera": In(Writing(buffers)),
            "right_camera": In(Writing(buffers)),
            "disparity_plane": In(Writing(buffers)),
            "left_plane": In(Writing(buffers)),
            "reader": In(PairRead(buffers + 1)),
            "display": In(Fetch(buffers)),
            "hold": In(1),
            "keep": In(1),
            "kept": Out(1),
            **dict.fromkeys(("kept_left", "kept_right"), Out(range(buffers + 1))),
            "kept_slot": Out(range(buffers)),
            **dict.fromkeys(("host", "put"), In(1)),
            "putting": Out(1),
            "clear": In(1),
            **{name: Out(16) for name in self.COUNTERS},
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.left = left = CameraBuffers(self.buffers, self.life_clocks)
        m.submodules.right = right = CameraBuffers(self.buffers, self.life_clocks)
        m.submodules.slots = slots = PictureSlots(self.buffers, self.life_clocks)
        wiring.connect(m, wiring.flipped(self.left_camera), left.writer)
        wiring.connect(m, wiring.flipped(self.right_camera), right.writer)
        for name in ("disparity_plane", "left_plane", "display"):
            wiring.connect(m, wiring.flipped(getattr(self, name)), getattr(slots, name))

        # Neither age saturates while its frame is available: the difference of the ages is that of the beginnings.
        hold    = Signal()
        reading = Signal()
        start   = Signal()
        done    = Signal()
        near    = Signal()
        host    = Signal()
        waits   = Signal()      # the host's pair
        hosted  = Signal()      # the pair that is being read is the host's
        m.d.sync += [hold.eq(self.hold), host.eq(self.host)]
        m.d.comb += [
            near.eq((left.age <= right.age + self.window_clocks) & (right.age <= left.age + self.window_clocks)),
            start.eq(Mux(host, waits, left.available & right.available & near) & slots.free & ~reading & ~hold),
            self.putting.eq(waits | (reading & hosted)),
            done.eq(reading & self.reader.done),
            slots.start.eq(start), slots.reading.eq(reading), slots.done.eq(done),
        ]
        m.d.sync += self.reader.start.eq(start)
        with m.If(done):
            m.d.sync += reading.eq(0)
        with m.If(start):
            m.d.sync += [reading.eq(1), hosted.eq(host)]
        m.d.sync += waits.eq(self.host & (self.put | (waits & ~start)))
        for camera, buffer in ((left, self.reader.left_buffer), (right, self.reader.right_buffer)):
            m.d.comb += [
                camera.take.eq(start & ~host), camera.locked.eq(reading & ~done & ~hosted),
                buffer.eq(Mux(hosted, self.buffers, camera.reading)),
            ]

        # A kept pair: from its start on; has been read; its picture is complete.
        keep     = Signal()
        held     = Signal()
        read     = Signal()
        complete = Signal()
        to_keep  = Signal()     # the pair that starts in this cycle is kept
        let_go   = Signal()
        of_host  = Signal()     # the pair that is kept is the host's
        m.d.comb += [
            to_keep.eq(start & keep & ~held),
            let_go.eq(~self.keep | (held & ~complete & slots.abandoned)),
            self.kept.eq(read & complete),
            self.kept_left.eq(Mux(of_host, self.buffers, left.kept)), self.kept_right.eq(Mux(of_host, self.buffers, right.kept)),
            self.kept_slot.eq(slots.kept), slots.keep.eq(to_keep), slots.held.eq(held),
        ]
        m.d.sync += keep.eq(self.keep)
        with m.If(let_go):
            m.d.sync += [held.eq(0), read.eq(0), complete.eq(0)]
        with m.Else():
            m.d.sync += [held.eq(held | to_keep), read.eq(held & (read | done)), complete.eq(held & (complete | slots.complete))]
        with m.If(to_keep):
            m.d.sync += of_host.eq(host)
        for camera in (left, right):
            m.d.comb += [camera.keep.eq(to_keep & ~host), camera.held.eq(held & ~of_host)]

        # The counters are a cycle late: the events that they count are at the end of long paths.
        events = (start, left.skipped, right.skipped, left.unpaired, right.unpaired, slots.dropped, slots.abandoned)
        for name, event in zip(self.COUNTERS, events, strict=True):
            counter = getattr(self, name)
            counted = Signal(name=f"{name}_counted")
            m.d.sync += counted.eq(event)
            count_events(m, counter, counted, self.clear)
        return m
