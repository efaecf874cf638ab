"""Writers of pictures into the frame store: of camera frames, and of the pictures for the monitor."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.video.memory_map import MemoryMap, Plane

from ..parts.counters import count_events
from .arbiter import WritePort
from .buffers import Writing
from .dma import LineScan, PixelPacker, WordFifo, line_number
from .words import WORD_BYTES, CameraWord, PlanePixel


__all__ = ["FrameWriter", "PictureWriter"]


class _PlaneWriter(wiring.Component):
    """What :class:`FrameWriter` and :class:`PictureWriter` share; see there."""
    def __init__(self, memory_map: MemoryMap, plane: Plane, payload: data.StructLayout, *, value: str, interlaced: bool, burst: int,
                 depth: int):
        if depth < burst + 2:
            raise ValueError(f"the FIFO of a writer must hold at least {burst + 2} words, two more than a burst, not {depth!r}")
        LineScan.check(memory_map, burst, interlaced)
        self.memory_map = memory_map
        self.plane = plane
        self.value = value
        self.interlaced = interlaced
        self.burst = burst
        self.depth = depth
        super().__init__({
            "i": In(stream.Signature(payload)),
            "port": Out(WritePort(burst)),
            "control": Out(Writing(memory_map.buffers)),
            "ragged": Out(1),
            "overflow": Out(1),
            "skipped": Out(16),
            "fill": Out(range(depth + 1)),
            "clear_fill": In(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        memory_map, word, control = self.memory_map, self.i.p, self.control
        m.submodules.packer = packer = PixelPacker()
        m.submodules.fifo = fifo = WordFifo(self.depth)
        m.submodules.scan = scan = LineScan(memory_map, burst=self.burst, interlaced=self.interlaced)
        wiring.connect(m, packer.o, fifo.i)
        m.d.comb += [self.fill.eq(fifo.fill), fifo.clear_fill.eq(self.clear_fill)]

        # Check of a pixel's flags against its position.
        x      = Signal(range(memory_map.width))
        y      = Signal(range(memory_map.height))
        drop   = word.drop if "drop" in word.shape().members else C(0)
        origin = Signal()
        wrong  = Signal()
        line_end, frame_end = Signal(), Signal()
        m.d.comb += [
            origin.eq((x == 0) & (y == 0)),
            line_end.eq(x == memory_map.width - 1),
            frame_end.eq(line_end & (y == memory_map.height - 1)),
            wrong.eq((word.first != origin) | (word.last != line_end) | (word.end != frame_end)),
            packer.i.p.value.eq(word[self.value]),
            packer.i.p.last.eq(line_end),
        ]

        # A burst is requested when all its words are in the FIFO, and done when the memory has accepted the last one.
        writing    = Signal()   # a frame is being written
        requesting = Signal()
        granted    = Signal()   # and not yet accepted
        remaining  = Signal.like(scan.o.length, reset_less=True)
        line_last  = Signal()   # the line's last word, which may be padded
        padding    = -memory_map.width % WORD_BYTES
        m.d.comb += [
            self.port.request.valid.eq(requesting),
            self.port.request.p.address.eq(scan.o.address),
            self.port.request.p.length.eq(scan.o.length),
            line_last.eq(scan.o.last & (remaining == 1)),
            self.port.word.p.data.eq(fifo.o.payload),
            self.port.word.p.be.eq((2**WORD_BYTES - 1) >> Mux(line_last, padding, 0)),
            self.port.word.valid.eq(fifo.o.valid),
            fifo.o.ready.eq(self.port.word.ready),
            scan.advance.eq(self.port.accepted),
        ]
        with m.If(writing & scan.active & ~requesting & ~granted & (fifo.level >= scan.o.length)):
            m.d.sync += requesting.eq(1)
        with m.If(requesting & self.port.request.ready):
            m.d.sync += [requesting.eq(0), granted.eq(1), remaining.eq(scan.o.length)]
        with m.If(self.port.word.valid & self.port.word.ready):
            m.d.sync += remaining.eq(remaining - 1)
        with m.If(self.port.accepted):
            m.d.sync += granted.eq(0)

        base = Signal.like(scan.base, reset_less=True)
        m.d.comb += scan.base.eq(base)
        with m.FSM():
            with m.State("idle"):
                # Words that do not begin a frame are the rest of one that was abandoned.
                m.d.comb += control.begin.eq(self.i.valid & word.first & ~drop)
                m.d.comb += self.i.ready.eq(~word.first | drop)
                m.d.sync += [x.eq(0), y.eq(0)]
                with m.If(control.begin):
                    m.next = "decide"
            with m.State("decide"):
                m.d.sync += base.eq(line_number(memory_map, self.plane, control.buffer))
                with m.If(control.accept):
                    m.d.comb += scan.start.eq(1)
                    m.next = "fill"
                with m.Else():
                    m.d.comb += self.i.ready.eq(1)
                    count_events(m, self.skipped)
                    m.next = "idle"
            with m.State("fill"):
                m.d.comb += [writing.eq(1), self.overflow.eq(self.i.valid & ~packer.i.ready)]
                with m.If(self.i.valid & (drop | wrong)):
                    # The word is examined again in state idle, unless it is this frame's first pixel.
                    m.d.comb += [self.i.ready.eq(origin), self.ragged.eq(~drop)]
                    m.next = "abandon"
                with m.Else():
                    m.d.comb += [packer.i.valid.eq(self.i.valid), self.i.ready.eq(packer.i.ready)]
                    with m.If(self.i.valid & self.i.ready):
                        m.d.sync += x.eq(Mux(line_end, 0, x + 1))
                        with m.If(line_end):
                            m.d.sync += y.eq(y + 1)
                        with m.If(frame_end):
                            m.next = "finish"
            with m.State("finish"):
                m.d.comb += writing.eq(1)
                with m.If(~scan.active):
                    m.d.comb += control.complete.eq(1)
                    m.next = "idle"
            with m.State("abandon"):
                # A burst that was requested is written, because the arbiter counts on its words.
                with m.If(~requesting & ~granted):
                    m.d.comb += [control.abandoned.eq(1), packer.clear.eq(1), fifo.clear.eq(1)]
                    m.next = "idle"
        return m


class FrameWriter(_PlaneWriter):
    """Writes camera frames into the buffers of a plane, the top field's lines into even rows, the bottom field's into odd ones.

    Golden: :meth:`golden.video.memory_map.MemoryMap.words`.

    Control: ``begin`` is high while a frame's first pixel waits. ``complete`` follows when the memory has accepted the frame's last word,
    so that later reads see all of it; or ``abandoned``, after which nothing more of it is written. Frames that are not accepted are
    counted in ``skipped``. A ``drop`` word abandons the frame. So does a pixel whose flags do not fit its place, and ``ragged`` is then
    high for a cycle: nothing is ever written outside the buffer. Such a frame is ignored up to the next ``first``.

    Timing: a pixel a cycle; ``overflow`` is high while a pixel waits because the FIFO is full: the camera's input must then drop a frame.
    After the last pixel, and after a frame that is abandoned, the next pixel waits until all bursts are written. ``i.ready`` depends
    combinationally on ``i``.

    FIFO: a burst is requested when all its words are there. Until the memory has accepted its last word, after
    :func:`golden.video.bandwidth.served_clocks`, words arrive at the camera's rate: ``depth >= burst + words in that time + 1``. For PAL,
    seven masters and a stall of 100 us that is 96, :attr:`golden.video.bandwidth.Budget.camera_depth`.

    Memory: ``(depth - 1) * 128`` bits.

    Parameters
    ----------
    memory_map : :class:`golden.video.memory_map.MemoryMap`
    plane : :class:`golden.video.memory_map.Plane`
    burst : int
        Most words of a burst, a power of two.
    depth : int
        Words that the FIFO holds.

    Members
    -------
    i : In(stream.Signature(CameraWord()))
    port : Out(WritePort(burst))
    control : Out(Writing(memory_map.buffers))
        Whether a frame is written, and where.
    ragged, overflow : Out(1)
    skipped : Out(16)
        Holds its greatest value.
    fill : Out(range(depth + 1))
        Highest level of the FIFO since ``clear_fill``.
    clear_fill : In(1)
    """
    def __init__(self, memory_map: MemoryMap, plane: Plane, *, burst: int = 16, depth: int = 128):
        super().__init__(memory_map, plane, CameraWord(), value="luma", interlaced=True, burst=burst, depth=depth)


class PictureWriter(_PlaneWriter):
    """Writes pictures into the buffers of a plane as :class:`FrameWriter` does, but in raster order, and without ``drop``.

    FIFO: its source can stall, so it bridges the bursts of the other masters only, :attr:`golden.video.bandwidth.Budget.matcher_depth`.

    Parameters
    ----------
    memory_map, plane, burst, depth
        As of :class:`FrameWriter`.

    Members
    -------
    i : In(stream.Signature(PlanePixel()))
    ...
        All others as of :class:`FrameWriter`.
    """
    def __init__(self, memory_map: MemoryMap, plane: Plane, *, burst: int = 16, depth: int = 64):
        super().__init__(memory_map, plane, PlanePixel(), value="value", interlaced=False, burst=burst, depth=depth)
