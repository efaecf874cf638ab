# amaranth: UnusedElaboratable=no
"""What the control promises, proved for all inputs in all orders, against models of what its neighbours do."""

from operator import attrgetter

import pytest
from amaranth import *
from amaranth.hdl import Assert, Elaboratable

from golden.video.pairing import CAMERAS, PLANES
from hdl.video.pairing import BufferControl
from sim.kit.formal import prove


class Promises(Elaboratable):
    """The control and its neighbours: writers that write from the cycle after ``begin``, if they may, until they tell the end; a reader
    that reads from ``start`` to ``done``. None of their events has to make sense.

    Parameters
    ----------
    buffers, window, life : int
        As of :class:`BufferControl`.
    promise : str
        Name of the method that asserts.
    """
    def __init__(self, buffers, window, life, promise):
        self.buffers, self.window, self.promise = buffers, window, promise
        self.dut = BufferControl(buffers, window, life)
        self.life = self.dut.life_clocks
        self.events = {name: Signal(name=name) for name in (
            "reader.done", "display.fetch", "hold", "keep", "host", "put", *(f"{writer}.{event}" for writer in (*CAMERAS, *PLANES)
                                                      for event in ("begin", "complete", "abandoned")))}

    def writer(self, m, name):
        """Whether the writer may write in this cycle, where to, and whether its frame is complete with it."""
        port = getattr(self.dut, name)
        sample  = Signal(name=f"{name}_sample")
        began   = Signal(name=f"{name}_began")
        held    = Signal(range(self.buffers), name=f"{name}_held")
        writes  = Signal(name=f"{name}_writes")
        buffer  = Signal(range(self.buffers), name=f"{name}_buffer")
        m.d.comb += [writes.eq(Mux(sample, port.accept, began)), buffer.eq(Mux(sample, port.buffer, held))]
        m.d.sync += [sample.eq(port.begin), held.eq(buffer), began.eq(writes & ~(port.complete | port.abandoned | port.begin))]
        return writes, buffer, writes & port.complete & ~port.abandoned

    def elaborate(self, platform):
        m = Module()
        m.submodules.dut = dut = self.dut
        m.d.comb += [attrgetter(name)(dut).eq(event) for name, event in self.events.items()]
        self.cameras = [self.writer(m, name) for name in CAMERAS]
        self.planes = [self.writer(m, name) for name in PLANES]

        reads = Signal()
        self.reads = Signal()
        m.d.comb += self.reads.eq(reads | dut.reader.start)
        m.d.sync += reads.eq(self.reads & ~dut.reader.done)
        self.buffers_read = dut.reader.left_buffer, dut.reader.right_buffer
        self.of_cameras = dut.reader.left_buffer != self.buffers
        self.earlier = reads
        getattr(self, self.promise)(m)
        return m

    def no_torn_frame(self, m):
        """No buffer is written while it is read."""
        for (writes, buffer, _), read in zip(self.cameras, self.buffers_read):
            m.d.comb += Assert(~(writes & self.reads & (buffer == read)))

    def no_torn_pair_of_the_host(self, m):
        """Its buffers are read together, and only while it is told that they must not be written."""
        left, right = (buffer == self.buffers for buffer in self.buffers_read)
        m.d.comb += [Assert(~self.reads | (left == right)), Assert(~(self.reads & left) | self.dut.putting)]

    def no_torn_picture(self, m):
        """No slot is written while it is shown."""
        display = self.dut.display
        for writes, buffer, _ in self.planes:
            m.d.comb += Assert(~(writes & display.shown_valid & (buffer == display.shown_buffer)))

    def no_torn_pair(self, m):
        """What is kept was not written since its pair started, and is not written; a kept pair holds."""
        dut = self.dut
        kept = Cat(dut.kept_left, dut.kept_right, dut.kept_slot)
        was_kept, before = Signal(), Signal.like(kept)
        m.d.sync += [was_kept.eq(dut.kept), before.eq(kept)]
        m.d.comb += Assert(~(was_kept & dut.kept) | (kept == before))
        for number, ((writes, buffer, _), read, held) in enumerate(zip(self.cameras, self.buffers_read, (dut.kept_left, dut.kept_right))):
            written = Array(Signal(name=f"written_{number}_{n}") for n in range(self.buffers))
            with m.If(writes):
                m.d.sync += written[buffer].eq(1)
            # Between a kept pair's start and ``kept`` no other pair starts.
            with m.If(dut.reader.start & ~dut.kept & self.of_cameras):
                m.d.sync += written[read].eq(0)
            m.d.comb += Assert(~(dut.kept & (held != self.buffers) & (written[held] | (writes & (buffer == held)))))
        for writes, buffer, _ in self.planes:
            m.d.comb += Assert(~(dut.kept & writes & (buffer == dut.kept_slot)))

    def keeps_nothing(self, m):
        m.d.comb += Assert(~self.dut.kept)

    def what_holds(self, m):
        """No pair starts while one is read, whose buffers hold; the shown picture holds from fetch to fetch."""
        display = self.dut.display
        m.d.comb += Assert(~(self.dut.reader.start & self.earlier))
        fetched = Signal()
        m.d.sync += fetched.eq(display.fetch)
        for held, may_change in ((Cat(self.buffers_read), ~self.earlier), (Cat(display.shown_buffer, display.shown_valid), fetched)):
            before = Signal.like(held, name="before")
            m.d.sync += before.eq(held)
            m.d.comb += Assert((held == before) | may_change)

    def near_and_fresh(self, m, nearer=0, younger=0):
        """The frames of a pair began within the window, are complete, used once, not older than the life: by a clock for each buffer."""
        ages = []
        for (writes, buffer, complete), read, name in zip(self.cameras, self.buffers_read, CAMERAS):
            since = Array(Signal(range(self.life + 3), name=f"{name}_since_{n}") for n in range(self.buffers))
            unused = Array(Signal(name=f"{name}_unused_{n}") for n in range(self.buffers))
            for age in since:
                m.d.sync += age.eq(Mux(age == self.life + 2, age, age + 1))
            with m.If(self.dut.reader.start & self.of_cameras):
                m.d.comb += Assert(unused[read] & (since[read] <= self.life - younger))
                m.d.sync += unused[read].eq(0)
            sample = Signal(name=f"{name}_sampled")
            m.d.sync += sample.eq(getattr(self.dut, name).begin)
            with m.If(sample & writes):
                m.d.sync += [since[buffer].eq(2), unused[buffer].eq(0)]
            with m.If(complete):
                m.d.sync += unused[buffer].eq(1)
            ages.append(since[read])
        with m.If(self.dut.reader.start & self.of_cameras):
            m.d.comb += [Assert(age <= other + self.window - nearer) for age, other in (ages, ages[::-1])]

    def nearer(self, m):
        self.near_and_fresh(m, nearer=1)

    def younger(self, m):
        self.near_and_fresh(m, younger=1)

    def shows_nothing(self, m):
        m.d.comb += Assert(~self.dut.display.shown_valid)


def proved(folder, *arguments):
    promises = Promises(*arguments)
    return prove(promises, promises.events.values(), folder)


@pytest.mark.parametrize("buffers, window, life, promise", [
    *((buffers, 2, 5, promise) for buffers in (2, 3) for promise in (
        "no_torn_frame", "no_torn_picture", "no_torn_pair_of_the_host", "what_holds", "near_and_fresh")),
    (2, 2, 5, "no_torn_pair"), (3, 2, 5, "no_torn_pair"),
    # The widths of the system as built; the proof does not depend on the length of its times.
    (2, 1_875_000, None, "no_torn_frame"), (3, 1_875_000, None, "no_torn_picture"),
])
def test_promise(tmp_path, buffers, window, life, promise):
    assert proved(tmp_path, buffers, window, life, promise)


@pytest.mark.parametrize("promise", ["shows_nothing", "keeps_nothing", "nearer", "younger"])
def test_what_is_not_promised(tmp_path, promise):
    """Refuted: the system does something, and the bounds of ``near_and_fresh`` are met."""
    assert not proved(tmp_path, 2, 2, 5, promise)
