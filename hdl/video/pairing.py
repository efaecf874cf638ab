"""Control of the frame store: which buffer a camera fills, which two frames are a pair, which picture is shown."""

from amaranth import *
from amaranth.lib import enum, wiring
from amaranth.lib.wiring import In, Out, Signature

from golden.pairing import LIVES


__all__ = ["BufferControl", "CameraBuffers", "Fetch", "PairRead", "PictureSlots", "Writing"]


class Writing(Signature):
    """How the writer of a frame, or of one plane of a shown picture, asks where to; as the writer sees it.

    ``begin``: one cycle, the first pixel of a frame has come. In the next cycle the writer samples ``buffer``, and ``accept``: if that is
    low the frame is to be skipped whole. ``complete``: one cycle, the frame's last word has been accepted by the memory. ``abandoned``:
    one cycle, the frame will not be completed. Either comes with or before the ``begin`` of the next frame; ``begin`` without either
    abandons the frame before. Of a frame that was not accepted neither means anything.
    """
    def __init__(self, buffers):
        super().__init__({
            "begin": Out(1),
            "complete": Out(1),
            "abandoned": Out(1),
            "buffer": In(range(buffers)),
            "accept": In(1),
        })


class PairRead(Signature):
    """How a pair's frames are read, as the reader sees it.

    ``start``: one cycle; ``left_buffer`` and ``right_buffer`` hold from then on to ``done``: one cycle, the last pixel of both has been
    read from memory, in the cycle of ``start`` at the earliest.
    """
    def __init__(self, buffers):
        super().__init__({
            "start": In(1),
            "left_buffer": In(range(buffers)),
            "right_buffer": In(range(buffers)),
            "done": Out(1),
        })


class Fetch(Signature):
    """How shown pictures are read, as the reader sees it.

    ``fetch``: one cycle, as a frame of the display begins. In the next cycle the reader samples ``shown_buffer``, and ``shown_valid``: low
    until there is a picture. Both hold to the next ``fetch``.
    """
    def __init__(self, buffers):
        super().__init__({
            "fetch": Out(1),
            "shown_buffer": In(range(buffers)),
            "shown_valid": In(1),
        })


def lowest_free(m, taken, name):
    """Whether one of the buffers is free, and the lowest that is; ``taken`` says of each whether it is not."""
    index = Signal(range(len(taken)), name=name)
    for number in reversed(range(len(taken))):
        with m.If(~taken[number]):
            m.d.comb += index.eq(number)
    return ~Cat(*taken).all(), index


def older(age, limit):
    """``age`` a cycle later; it stays at ``limit``."""
    return Mux(age == limit, limit, age + 1)


class CameraBuffers(wiring.Component):
    """The buffers of one camera: which one is filled, which one holds the latest frame. Golden: :class:`golden.pairing.Camera`.

    Ages: cycles since a frame began; they stay at ``life_clocks``, and the latest frame that gets there has expired: so ages never wrap
    around, and a frame that is too old is never taken for a new one.

    Timing: ``available``, ``latest``, ``reading`` and ``age`` depend on registers alone.

    Parameters
    ----------
    buffers, life_clocks : int
        As of :class:`BufferControl`.

    Members
    -------
    writer : In(Writing(buffers))
    take : In(1)
        The latest frame becomes the one that is read; only while ``available``.
    locked : In(1)
        The frame that was taken last is still being read.
    available : Out(1)
        There is a latest frame, not expired.
    latest, reading : Out(range(buffers))
        Where the latest frame is, and the one taken last.
    age : Out(range(life_clocks + 1))
        Of the latest frame.
    skipped, unpaired : Out(1)
        One cycle: a frame found no free buffer; a complete one has found no partner.
    """
    def __init__(self, buffers, life_clocks):
        self.buffers = buffers
        self.life_clocks = life_clocks
        super().__init__({
            "writer": In(Writing(buffers)),
            "take": In(1),
            "locked": In(1),
            "available": Out(1),
            "latest": Out(range(buffers)),
            "reading": Out(range(buffers)),
            "age": Out(range(life_clocks + 1)),
            "skipped": Out(1),
            "unpaired": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        filling     = self.writer.buffer
        filling_age = Signal.like(self.age, reset_less=True)
        waits       = Signal()              # there is a latest frame

        # The frame that fills a buffer ends; the latest one is taken, expires, or gives way.
        completed = Signal()
        gone      = Signal()
        m.d.comb += [
            completed.eq(self.writer.accept & self.writer.complete & ~self.writer.abandoned),
            self.available.eq(waits & (self.age != self.life_clocks)),
            gone.eq(~self.available | completed),
            self.unpaired.eq(waits & gone & ~self.take),
        ]
        m.d.sync += [filling_age.eq(older(filling_age, self.life_clocks)), self.age.eq(older(self.age, self.life_clocks))]
        with m.If(gone | self.take):
            m.d.sync += waits.eq(completed)
        with m.If(self.take):
            m.d.sync += self.reading.eq(self.latest)
        with m.If(completed):
            m.d.sync += [self.latest.eq(filling), self.age.eq(older(filling_age, self.life_clocks))]

        # A frame begins. What is taken in this cycle is read from the next one on.
        free, lowest = lowest_free(m, [
            self.locked & (self.reading == buffer) | (self.take | ~gone) & (self.latest == buffer) | completed & (filling == buffer)
            for buffer in range(self.buffers)], "lowest")
        m.d.comb += self.skipped.eq(self.writer.begin & ~free)
        with m.If(self.writer.begin):
            m.d.sync += [self.writer.accept.eq(free), filling_age.eq(1)]
            with m.If(free):
                m.d.sync += filling.eq(lowest)
        with m.Elif(self.writer.complete | self.writer.abandoned):
            m.d.sync += self.writer.accept.eq(0)
        return m


class Plane(enum.Enum, shape=2):
    """What has been seen of one plane of the picture that is written."""
    AWAITED = 0
    FILLING = 1
    COMPLETE = 2
    ABANDONED = 3


class PictureSlots(wiring.Component):
    """The slots of the shown pictures: which one is written, which is shown. Golden: :class:`golden.pairing.Pictures`.

    Timing: ``free`` and ``slot`` depend on registers alone.

    Parameters
    ----------
    buffers, life_clocks : int
        As of :class:`BufferControl`.

    Members
    -------
    disparity_plane, left_plane : In(Writing(buffers))
    display : In(Fetch(buffers))
    start : In(1)
        A pair starts, whose picture goes to ``slot``; only while ``free``.
    reading, done : In(1)
        A pair is being read; that ends.
    free : Out(1)
        No picture is written, and there is a slot for one.
    slot : Out(range(buffers))
    dropped, abandoned : Out(1)
        One cycle: a complete picture gives way to the next before it was shown; a picture will not become complete.
    """
    def __init__(self, buffers, life_clocks):
        self.buffers = buffers
        self.life_clocks = life_clocks
        super().__init__({
            "disparity_plane": In(Writing(buffers)),
            "left_plane": In(Writing(buffers)),
            "display": In(Fetch(buffers)),
            "start": In(1),
            "reading": In(1),
            "done": In(1),
            "free": Out(1),
            "slot": Out(range(buffers)),
            "dropped": Out(1),
            "abandoned": Out(1),
        })

    def elaborate(self, platform):
        m = Module()
        writing = Signal()
        written = Signal(range(self.buffers), reset_less=True)
        waits   = Signal()                  # there is a complete picture that is not shown yet
        latest  = Signal(range(self.buffers), reset_less=True)
        shown   = self.display.shown_buffer
        wait    = Signal(range(self.life_clocks + 1), reset_less=True)  # cycles since the pair was read

        free, lowest = lowest_free(m, [
            waits & (latest == slot) | self.display.shown_valid & (shown == slot) for slot in range(self.buffers)], "lowest")
        m.d.comb += [self.free.eq(~writing & free), self.slot.eq(lowest)]

        # Both planes side by side: what each has come to in this cycle.
        after = []
        for name in ("disparity_plane", "left_plane"):
            writer = getattr(self, name)
            plane = Signal(Plane, name=name)
            ended = Signal(Plane, name=f"{name}_ended")
            then  = Signal(Plane, name=f"{name}_then")
            m.d.comb += [
                ended.eq(plane), then.eq(ended),
                writer.buffer.eq(written), writer.accept.eq(writing & (plane == Plane.FILLING)),
            ]
            with m.If(plane == Plane.FILLING):
                with m.If(writer.abandoned | writer.begin & ~writer.complete):
                    m.d.comb += ended.eq(Plane.ABANDONED)
                with m.Elif(writer.complete):
                    m.d.comb += ended.eq(Plane.COMPLETE)
            with m.If(writer.begin & (ended == Plane.AWAITED)):
                m.d.comb += then.eq(Plane.FILLING)
            m.d.sync += plane.eq(Mux(writing, then, Plane.AWAITED))
            after.append(then)

        # The picture is finished as both planes are.
        give_up  = Signal()
        finished = Signal()
        complete = Signal()
        m.d.comb += [
            give_up.eq(writing & ~self.reading & (wait == self.life_clocks)),
            finished.eq(writing & Cat((then == Plane.COMPLETE) | (then == Plane.ABANDONED) for then in after).all()),
            complete.eq(finished & ~give_up & Cat(then == Plane.COMPLETE for then in after).all()),
            self.abandoned.eq((give_up | finished) & ~complete),
            self.dropped.eq(complete & waits),
        ]
        m.d.sync += wait.eq(Mux(self.done, 1, older(wait, self.life_clocks)))
        with m.If(self.start):
            m.d.sync += [writing.eq(1), written.eq(self.slot)]
        with m.Elif(give_up | finished):
            m.d.sync += writing.eq(0)

        # The display turns to the latest picture, also if that becomes complete in this very cycle.
        with m.If(self.display.fetch):
            m.d.sync += waits.eq(0)
            with m.If(waits | complete):
                m.d.sync += [self.display.shown_valid.eq(1), shown.eq(Mux(complete, written, latest))]
        with m.Elif(complete):
            m.d.sync += [waits.eq(1), latest.eq(written)]
        return m


class BufferControl(wiring.Component):
    """Which buffer each camera fills, which two frames are a pair, which picture is shown. Golden: :class:`golden.pairing.Pairing`, whose
    module states the rule, its reasons and its promises; :meth:`golden.pairing.Pairing.clock` states the order of what comes in one cycle.

    Whatever the memory does only delays: a pair is read for as long as it takes, and its buffers are left alone. A picture that is not
    finished ``life_clocks`` after its pair was read is given up, so that a picture that went missing does not stop the system.

    Timing: a pair starts 2 cycles after the event that made it possible: one to decide, and ``start`` comes from a register. A parameter
    sampled at ``start`` counts for the whole pair. ``hold`` counts from the next cycle on.

    Parameters
    ----------
    buffers : int
        For each of the four kinds of pictures, from 2; :func:`golden.pairing.buffers_needed`.
    window_clocks : int
        Greatest number of cycles between the beginnings of a pair's frames.
    life_clocks : int
        Age at which a frame is used no more; ``4 * window_clocks`` by default.

    Members
    -------
    left_camera, right_camera : In(Writing(buffers))
        Frames.
    disparity_plane, left_plane : In(Writing(buffers))
        The planes of the shown pictures.
    reader : In(PairRead(buffers))
    display : In(Fetch(buffers))
    hold : In(1)
        No new pair starts; the picture freezes.
    clear : In(1)
        Sets the counters to zero, or to one where they count in this cycle.
    pairs : Out(16)
        Pairs started. This and the other counters stay at their greatest value.
    left_skipped, right_skipped : Out(16)
        Frames for which no buffer was free.
    left_unpaired, right_unpaired : Out(16)
        Complete frames that found no partner, or a newer one took their place first.
    pictures_dropped, pictures_abandoned : Out(16)
        Complete pictures that gave way to the next one before a fetch; pictures that did not become complete.
    """
    def __init__(self, buffers, window_clocks, life_clocks=None):
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
            "reader": In(PairRead(buffers)),
            "display": In(Fetch(buffers)),
            "hold": In(1),
            "clear": In(1),
            **{name: Out(16) for name in self.COUNTERS},
        })

    COUNTERS = ("pairs", "left_skipped", "right_skipped", "left_unpaired", "right_unpaired", "pictures_dropped", "pictures_abandoned")

    def elaborate(self, platform):
        m = Module()
        m.submodules.left = left = CameraBuffers(self.buffers, self.life_clocks)
        m.submodules.right = right = CameraBuffers(self.buffers, self.life_clocks)
        m.submodules.slots = slots = PictureSlots(self.buffers, self.life_clocks)
        wiring.connect(m, wiring.flipped(self.left_camera), left.writer)
        wiring.connect(m, wiring.flipped(self.right_camera), right.writer)
        for name in ("disparity_plane", "left_plane", "display"):
            wiring.connect(m, wiring.flipped(getattr(self, name)), getattr(slots, name))

        # Both ages are of the same cycle, and neither has stopped while its frame is available: their difference is that of the begins.
        hold    = Signal()
        reading = Signal()
        start   = Signal()
        done    = Signal()
        near    = Signal()
        m.d.sync += hold.eq(self.hold)
        m.d.comb += [
            near.eq((left.age <= right.age + self.window_clocks) & (right.age <= left.age + self.window_clocks)),
            start.eq(left.available & right.available & near & slots.free & ~reading & ~hold),
            done.eq(reading & self.reader.done),
            slots.start.eq(start), slots.reading.eq(reading), slots.done.eq(done),
        ]
        m.d.sync += self.reader.start.eq(start)
        with m.If(done):
            m.d.sync += reading.eq(0)
        with m.If(start):
            m.d.sync += reading.eq(1)
        for camera, buffer in ((left, self.reader.left_buffer), (right, self.reader.right_buffer)):
            m.d.comb += [camera.take.eq(start), camera.locked.eq(reading & ~done), buffer.eq(camera.reading)]

        counted = (start, left.skipped, right.skipped, left.unpaired, right.unpaired, slots.dropped, slots.abandoned)
        for name, event in zip(self.COUNTERS, counted, strict=True):
            counter = getattr(self, name)
            with m.If(self.clear):
                m.d.sync += counter.eq(event)
            with m.Elif(event & ~counter.all()):
                m.d.sync += counter.eq(counter + 1)
        return m
