"""Buffer management of the frame store: which buffer a camera fills, which slot a picture is written to, which one is shown."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out, Signature

from golden.video.buffers import PlaneState


__all__ = ["CameraBuffers", "Fetch", "PairRead", "PictureSlots", "Writing"]


class Writing(Signature):
    """Port to the buffer management, seen from the writer of a frame or of one plane of a shown picture.

    ``begin``: one cycle, the first pixel of a frame has arrived. In the next cycle the writer samples ``buffer``, and ``accept``: if that
    is low, the whole frame is to be skipped. ``complete``: one cycle, the memory has accepted the frame's last word. ``abandoned``: one
    cycle, the frame will not be completed. Either is high no later than the ``begin`` of the next frame; ``begin`` without either abandons
    the frame before. Both are ignored for a frame that was not accepted.
    """
    def __init__(self, buffers: int):
        super().__init__({
            "begin": Out(1),
            "complete": Out(1),
            "abandoned": Out(1),
            "buffer": In(range(buffers)),
            "accept": In(1),
        })


class PairRead(Signature):
    """Port to the control of the frame store, seen from the reader of a pair's frames.

    ``start``: one cycle; ``left_buffer`` and ``right_buffer`` hold from then on to ``done``: one cycle, the last pixel of both has been
    read from memory, in the cycle of ``start`` at the earliest.
    """
    def __init__(self, buffers: int):
        super().__init__({
            "start": In(1),
            "left_buffer": In(range(buffers)),
            "right_buffer": In(range(buffers)),
            "done": Out(1),
        })


class Fetch(Signature):
    """Port to the control of the frame store, seen from the reader of shown pictures.

    ``fetch``: one cycle, a frame of the display begins. In the next cycle the reader samples ``shown_buffer``, and ``shown_valid``: low
    until there is a picture. Both hold to the next ``fetch``.
    """
    def __init__(self, buffers: int):
        super().__init__({
            "fetch": Out(1),
            "shown_buffer": In(range(buffers)),
            "shown_valid": In(1),
        })


def lowest_free(m: Module, occupied: list[Value], name: str) -> tuple[Value, Signal]:
    """Whether a buffer is free, and the lowest one that is; ``occupied`` has a bit for each buffer."""
    index = Signal(range(len(occupied)), name=name)
    for number in reversed(range(len(occupied))):
        with m.If(~occupied[number]):
            m.d.comb += index.eq(number)
    return ~Cat(*occupied).all(), index


def older(age: Value, limit: int) -> Value:
    """``age`` a cycle later; it saturates at ``limit``."""
    return Mux(age == limit, limit, age + 1)


class CameraBuffers(wiring.Component):
    """The buffers of one camera: which one is filled, which one holds the latest frame. Golden: :class:`golden.video.buffers.Camera`.

    Ages: cycles since a frame began, saturating at ``life_clocks``. The latest frame expires at that age, so a frame that is too old is
    never mistaken for a new one.

    Timing: ``available``, ``latest``, ``reading``, ``kept`` and ``age`` depend on registers alone.

    Parameters
    ----------
    buffers, life_clocks : int
        As of :class:`hdl.video.pairing.BufferControl`.

    Members
    -------
    writer : In(Writing(buffers))
    take : In(1)
        The latest frame becomes the one that is read; only while ``available``.
    locked : In(1)
        The frame taken last is still being read.
    keep : In(1)
        The frame that is taken in this cycle is kept; only while ``take``, and not while ``held``.
    held : In(1)
        Buffer ``kept`` is not filled.
    available : Out(1)
        There is a latest frame that has not expired.
    latest, reading, kept : Out(range(buffers))
        Buffers of the latest frame, of the one taken last, and of the one kept last.
    age : Out(range(life_clocks + 1))
        Of the latest frame.
    skipped, unpaired : Out(1)
        One cycle: no buffer was free for a frame; a complete frame is given up without a partner.
    """
    def __init__(self, buffers: int, life_clocks: int):
        self.buffers = buffers
        self.life_clocks = life_clocks
        super().__init__({
            "writer": In(Writing(buffers)),
            "take": In(1),
            "locked": In(1),
            "keep": In(1),
            "held": In(1),
            "available": Out(1),
            "latest": Out(range(buffers)),
            "reading": Out(range(buffers)),
            "kept": Out(range(buffers)),
            "age": Out(range(life_clocks + 1)),
            "skipped": Out(1),
            "unpaired": Out(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        filling     = self.writer.buffer
        filling_age = Signal.like(self.age, reset_less=True)
        waits       = Signal()              # there is a latest frame

        # A frame ends; the latest one is taken, expires, or is replaced. Where the new one is too late, the latest one expired before.
        complete  = Signal()
        too_late  = Signal()
        completed = Signal()
        retired   = Signal()                # the latest frame expires or is replaced
        m.d.comb += [
            complete.eq(self.writer.accept & self.writer.complete & ~self.writer.abandoned),
            too_late.eq(filling_age == self.life_clocks),
            completed.eq(complete & ~too_late),
            self.available.eq(waits & (self.age != self.life_clocks)),
            retired.eq(~self.available | completed),
            self.unpaired.eq((waits & retired & ~self.take) | (complete & too_late)),
        ]
        m.d.sync += [filling_age.eq(older(filling_age, self.life_clocks)), self.age.eq(older(self.age, self.life_clocks))]
        with m.If(retired | self.take):
            m.d.sync += waits.eq(completed)
        with m.If(self.take):
            m.d.sync += self.reading.eq(self.latest)
        with m.If(self.keep):
            m.d.sync += self.kept.eq(self.latest)
        with m.If(completed):
            m.d.sync += [self.latest.eq(filling), self.age.eq(filling_age + 1)]

        # A frame begins. One that is taken in this cycle is read from the next one on.
        free, lowest = lowest_free(m, [
            (self.locked & (self.reading == buffer)) | ((self.take | ~retired) & (self.latest == buffer)) |
            (completed & (filling == buffer)) | (self.held & (self.kept == buffer)) for buffer in range(self.buffers)], "lowest")
        m.d.comb += self.skipped.eq(self.writer.begin & ~free)
        with m.If(self.writer.begin):
            m.d.sync += [self.writer.accept.eq(free), filling_age.eq(1)]
            with m.If(free):
                m.d.sync += filling.eq(lowest)
        with m.Elif(self.writer.complete | self.writer.abandoned):
            m.d.sync += self.writer.accept.eq(0)
        return m


class PictureSlots(wiring.Component):
    """The slots of the shown pictures: which one is written, which is shown. Golden: :class:`golden.video.buffers.Pictures`.

    Timing: ``free`` and ``slot`` depend on registers alone.

    Parameters
    ----------
    buffers, life_clocks : int
        As of :class:`hdl.video.pairing.BufferControl`.

    Members
    -------
    disparity_plane, left_plane : In(Writing(buffers))
    display : In(Fetch(buffers))
    start : In(1)
        A pair starts, whose picture is written to ``slot``; only while ``free``.
    reading, done : In(1)
        A pair is being read; it has been read.
    keep : In(1)
        The picture of the pair that starts in this cycle is kept; only while ``start``, and not while ``held``.
    held : In(1)
        Slot ``kept`` is not written once its picture is complete.
    free : Out(1)
        No picture is being written, and a slot is free.
    slot, kept : Out(range(buffers))
        The slot for the next picture, and that of the picture kept last.
    dropped, abandoned : Out(1)
        One cycle: a complete picture is replaced by the next one before it was shown; a picture will not be completed.
    complete : Out(1)
        One cycle: a picture is complete.
    """
    def __init__(self, buffers: int, life_clocks: int):
        self.buffers = buffers
        self.life_clocks = life_clocks
        super().__init__({
            "disparity_plane": In(Writing(buffers)),
            "left_plane": In(Writing(buffers)),
            "display": In(Fetch(buffers)),
            "start": In(1),
            "reading": In(1),
            "done": In(1),
            "keep": In(1),
            "held": In(1),
            "free": Out(1),
            "slot": Out(range(buffers)),
            "kept": Out(range(buffers)),
            "dropped": Out(1),
            "abandoned": Out(1),
            "complete": Out(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        writing = Signal()
        written = Signal(range(self.buffers), reset_less=True)
        waits   = Signal()                  # there is a complete picture that has not been shown
        latest  = Signal(range(self.buffers), reset_less=True)
        shown   = self.display.shown_buffer
        wait    = Signal(range(self.life_clocks + 1), reset_less=True)  # cycles since the pair was read

        free, lowest = lowest_free(m, [
            (waits & (latest == slot)) | (self.display.shown_valid & (shown == slot)) | (self.held & (self.kept == slot))
            for slot in range(self.buffers)], "lowest")
        m.d.comb += [self.free.eq(~writing & free), self.slot.eq(lowest)]

        # State of each plane at the end of this cycle.
        after = []
        for name in ("disparity_plane", "left_plane"):
            writer = getattr(self, name)
            plane = Signal(PlaneState, name=name)
            ended = Signal(PlaneState, name=f"{name}_ended")
            then  = Signal(PlaneState, name=f"{name}_then")
            m.d.comb += [
                ended.eq(plane), then.eq(ended),
                writer.buffer.eq(written), writer.accept.eq(writing & (plane == PlaneState.FILLING)),
            ]
            with m.If(plane == PlaneState.FILLING):
                with m.If(writer.abandoned | (writer.begin & ~writer.complete)):
                    m.d.comb += ended.eq(PlaneState.ABANDONED)
                with m.Elif(writer.complete):
                    m.d.comb += ended.eq(PlaneState.COMPLETE)
            with m.If(writer.begin & (ended == PlaneState.AWAITED)):
                m.d.comb += then.eq(PlaneState.FILLING)
            m.d.sync += plane.eq(Mux(writing, then, PlaneState.AWAITED))
            after.append(then)

        # The picture is finished when both planes are.
        give_up  = Signal()
        finished = Signal()
        complete = self.complete
        m.d.comb += [
            give_up.eq(writing & ~self.reading & (wait == self.life_clocks)),
            finished.eq(writing & Cat((then == PlaneState.COMPLETE) | (then == PlaneState.ABANDONED) for then in after).all()),
            complete.eq(finished & ~give_up & Cat(then == PlaneState.COMPLETE for then in after).all()),
            self.abandoned.eq((give_up | finished) & ~complete),
            self.dropped.eq(complete & waits),
        ]
        m.d.sync += wait.eq(Mux(self.done, 1, older(wait, self.life_clocks)))
        with m.If(self.start):
            m.d.sync += [writing.eq(1), written.eq(self.slot)]
            with m.If(self.keep):
                m.d.sync += self.kept.eq(self.slot)
        with m.Elif(give_up | finished):
            m.d.sync += writing.eq(0)

        # The display switches to the latest picture, even to one that is completed in this cycle.
        with m.If(self.display.fetch):
            m.d.sync += waits.eq(0)
            with m.If(waits | complete):
                m.d.sync += [self.display.shown_valid.eq(1), shown.eq(Mux(complete, written, latest))]
        with m.Elif(complete):
            m.d.sync += [waits.eq(1), latest.eq(written)]
        return m
