"""Pictures out of the memory: for the matcher, and for the monitor."""

from typing import Any

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig
from golden.video.memory_map import MemoryMap, Plane

from ..matcher.stream import PixelPair, copy_flags
from .arbiter import ReadPort
from .buffers import PairRead
from .dma import LineScan, PixelUnpacker, PlanePair, WordFifo, line_number
from .words import ShownPixel


__all__ = ["PairReader", "PictureReader"]


class _PlanePairReader(wiring.Component):
    """Two planes read side by side, what :class:`PairReader` and :class:`PictureReader` share.

    Bursts of the two planes take turns, each into its own FIFO, when there is room for all words that are on their way. ``start`` and
    ``stop`` may come at any time. If they do not cut, the pictures under way are given to their end first. If they do, nothing more is
    asked for; once all words on their way have come, the FIFOs are emptied. A pixel that is offered then stays until it is taken.

    Members
    -------
    start, stop : In(1)
        Read the pictures; read nothing more.
    buffer : In(range(memory_map.buffers)).array(2)
        Taken with ``start``.
    o : Out(stream.Signature(PlanePair()))
    done : Out(1)
        For a cycle: every word of both has come.
    port, fill, clear_fill
        As of :class:`PairReader`.
    """
    def __init__(self, memory_map: MemoryMap, planes, *, cuts, burst, depth):
        self.memory_map = memory_map
        self.planes = planes
        self.cuts = cuts
        self.burst = burst
        self.depth = depth
        super().__init__({
            "start": In(1),
            "stop": In(1),
            "buffer": In(range(memory_map.buffers)).array(2),
            "o": Out(stream.Signature(PlanePair())),
            "port": Out(ReadPort(burst)),
            "done": Out(1),
            "fill": Out(range(depth + 1)),
            "clear_fill": In(1),
        })

    def elaborate(self, platform):
        m = Module()
        memory_map, port = self.memory_map, self.port
        m.submodules.scan = scan = LineScan(memory_map, burst=self.burst)
        m.submodules.unpacker = unpacker = PixelUnpacker(memory_map)
        wiring.connect(m, unpacker.o, wiring.flipped(self.o))

        # A new beginning waits until nothing is on its way.
        renew  = Signal()       # start or stop has come
        reads  = Signal()       # it was start
        clear  = Signal()
        asks   = Signal()
        gives  = Signal()       # pixels of these pictures are still to be given
        flying = Signal(range(2 * self.depth + 1))      # words granted that have not come
        cut    = renew if self.cuts else C(0)
        m.d.comb += [
            clear.eq(renew & ~asks & (flying == 0) & (~gives | cut)),
            scan.start.eq(clear & reads),
            unpacker.clear.eq(clear),
        ]
        with m.If(self.o.valid & self.o.ready & self.o.p.end):
            m.d.sync += gives.eq(0)
        with m.If(clear):
            m.d.sync += [renew.eq(0), gives.eq(reads)]
        with m.If(self.start | self.stop):
            m.d.sync += [renew.eq(1), reads.eq(self.start)]

        # Requests: a burst of one plane, then the same one of the other.
        reading = Signal()
        side    = Signal()
        granted = Signal()
        rooms   = Signal(data.ArrayLayout(range(self.depth + 1), 2))    # words of each FIFO that nothing was asked for yet
        m.d.comb += [
            port.request.valid.eq(asks),
            port.request.p.address.eq(scan.o.address),
            port.request.p.length.eq(scan.o.length),
            granted.eq(asks & port.request.ready),
            scan.advance.eq(granted & side),
        ]
        m.d.sync += flying.eq(flying + Mux(granted, scan.o.length, 0) - port.rdata_valid)
        with m.If(granted):
            m.d.sync += [asks.eq(0), side.eq(~side)]
        with m.Elif(reading & scan.active & ~cut & (rooms[side] >= scan.o.length)):
            m.d.sync += asks.eq(1)
        m.d.comb += self.done.eq(reading & ~scan.active & (flying == 0))
        with m.If(self.done):
            m.d.sync += reading.eq(0)
        with m.If(clear):
            m.d.sync += [reading.eq(reads), side.eq(0)]

        # Words come a burst of one plane, then a burst of the other.
        comes = Signal()
        with m.If(port.rdata_valid & port.rdata_last):
            m.d.sync += comes.eq(~comes)
        with m.If(clear):
            m.d.sync += comes.eq(0)

        fifos = [WordFifo(self.depth) for _ in range(2)]
        bases = []
        for number, (fifo, plane, buffer) in enumerate(zip(fifos, self.planes, self.buffer)):
            m.submodules[f"fifo_{number}"] = fifo
            wiring.connect(m, fifo.o, unpacker.i[number])
            m.d.comb += [
                fifo.i.payload.eq(port.rdata), fifo.i.valid.eq(port.rdata_valid & (comes == number)),
                fifo.clear.eq(clear), fifo.clear_fill.eq(self.clear_fill),
            ]
            m.d.sync += rooms[number].eq(rooms[number] - Mux(granted & (side == number), scan.o.length, 0) +
                                         (fifo.o.valid & fifo.o.ready))
            chosen = Signal.like(buffer, reset_less=True)
            base = Signal.like(scan.base, reset_less=True)
            with m.If(self.start):
                m.d.sync += chosen.eq(buffer)
            with m.If(clear):
                m.d.sync += [rooms[number].eq(self.depth), base.eq(line_number(memory_map, plane, chosen))]
            bases.append(base)
        m.d.comb += scan.base.eq(Mux(side, bases[1], bases[0]))
        m.d.comb += self.fill.eq(Mux(fifos[0].fill > fifos[1].fill, fifos[0].fill, fifos[1].fill))
        return m


class _Reader(wiring.Component):
    """What :class:`PairReader` and :class:`PictureReader` share; see there.

    Parameters
    ----------
    planes : pair of :class:`golden.video.memory_map.Plane`
    cuts : bool
        Whether a new beginning cuts the pictures under way.
    members : dict
        Those beyond ``port``, ``fill`` and ``clear_fill``; ``o`` among them.
    """
    def __init__(self, memory_map: MemoryMap, planes: tuple[Plane, Plane], members: dict[str, Any], *, cuts: bool, burst: int, depth: int):
        LineScan.check(memory_map, burst)
        if depth < 2 * burst:
            raise ValueError(f"each FIFO of a reader must hold at least {2 * burst} words, two bursts, not {depth!r}")
        self.memory_map = memory_map
        self.planes = planes
        self.cuts = cuts
        self.burst = burst
        self.depth = depth
        super().__init__({
            **members,
            "port": Out(ReadPort(burst)),
            "fill": Out(range(depth + 1)),
            "clear_fill": In(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.reader = reader = _PlanePairReader(self.memory_map, self.planes, cuts=self.cuts, burst=self.burst, depth=self.depth)
        wiring.connect(m, reader.port, wiring.flipped(self.port))
        m.d.comb += [
            self.fill.eq(reader.fill), reader.clear_fill.eq(self.clear_fill),
            self.o.valid.eq(reader.o.valid), reader.o.ready.eq(self.o.ready),
        ]
        self._connect(m, reader)
        return m

    def _connect(self, m: Module, reader: _PlanePairReader) -> None:
        """Connect what tells ``reader`` to begin, and the fields of its pixels to those of ``o``."""
        raise NotImplementedError


class PairReader(_Reader):
    """The two pictures of a pair, out of their buffers into the matcher.

    Golden: :meth:`golden.video.memory_map.MemoryMap.picture` of both.

    Timing: ``start`` for a cycle; ``done`` for a cycle when every pixel of both has been read from memory, so that the buffers may be
    written again; the last ones may still be in the FIFOs then. A ``start`` that comes before they are given waits for that. A pixel a
    cycle, as long as the memory keeps pace.

    FIFO: while a burst is on its way, :func:`golden.video.bandwidth.served_clocks` and the read latency, the matcher takes a word of each
    plane in 16 cycles; :attr:`golden.video.bandwidth.Budget.matcher_depth`.

    Memory: ``2 * (depth - 1) * 128`` bits.

    Parameters
    ----------
    memory_map : :class:`golden.video.memory_map.MemoryMap`
    burst : int
        Most words of a burst, a power of two.
    depth : int
        Words in each of the two FIFOs.

    Members
    -------
    control : Out(PairRead(memory_map.buffers))
        When a pair is read, and from where; the buffers are sampled with ``start``.
    o : Out(stream.Signature(PixelPair()))
    port : Out(ReadPort(burst))
    fill : Out(range(depth + 1))
        Most words ever in one of the FIFOs since ``clear_fill``.
    clear_fill : In(1)
    """
    def __init__(self, memory_map: MemoryMap, *, burst: int = 16, depth: int = 64):
        super().__init__(memory_map, (Plane.LEFT, Plane.RIGHT), {
            "control": Out(PairRead(memory_map.buffers)),
            "o": Out(stream.Signature(PixelPair())),
        }, cuts=False, burst=burst, depth=depth)

    def _connect(self, m: Module, reader: _PlanePairReader) -> None:
        control = self.control
        m.d.comb += [
            reader.start.eq(control.start), control.done.eq(reader.done),
            reader.buffer[0].eq(control.left_buffer), reader.buffer[1].eq(control.right_buffer),
            self.o.p.left.eq(reader.o.p.pixels[0]), self.o.p.right.eq(reader.o.p.pixels[1]), *copy_flags(self.o.p, reader.o.p),
        ]


class PictureReader(_Reader):
    """The picture that is shown, disparities and grey levels, out of its slot to the monitor.

    Golden: :meth:`golden.video.memory_map.MemoryMap.picture` of both planes.

    ``fetch`` comes for a cycle as the monitor begins a picture; in the cycle after, ``shown_valid`` and ``shown_buffer`` say whether there
    is one, and where. A picture that is not over by then is cut: what is in the FIFOs and on its way is thrown away, and the next pixel is
    the new one's ``first``, but for those that leave in the meantime: at most the words that are on their way, and the pixel offered.
    Without ``shown_valid`` nothing more comes.

    Timing: a pixel a cycle, as long as the memory keeps pace.

    FIFO: to bridge a stall, it must hold what the monitor takes in it: :attr:`golden.video.bandwidth.Budget.display_depth`.

    Memory: ``2 * (depth - 1) * 128`` bits.

    Parameters
    ----------
    memory_map : :class:`golden.video.memory_map.MemoryMap`
    config : :class:`golden.config.MatcherConfig`
    burst : int
        Most words of a burst, a power of two.
    depth : int
        Words in each of the two FIFOs.

    Members
    -------
    fetch : In(1)
    shown_buffer : In(range(memory_map.buffers))
    shown_valid : In(1)
    o : Out(stream.Signature(ShownPixel(config)))
    port, fill, clear_fill
        As of :class:`PairReader`.
    """
    def __init__(self, memory_map: MemoryMap, config: MatcherConfig, *, burst: int = 16, depth: int = 512):
        super().__init__(memory_map, (Plane.DISPARITY, Plane.SHOWN_LEFT), {
            "fetch": In(1),
            "shown_buffer": In(range(memory_map.buffers)),
            "shown_valid": In(1),
            "o": Out(stream.Signature(ShownPixel(config))),
        }, cuts=True, burst=burst, depth=depth)

    def _connect(self, m: Module, reader: _PlanePairReader) -> None:
        fetched = Signal()
        m.d.sync += fetched.eq(self.fetch)
        m.d.comb += [
            reader.start.eq(fetched & self.shown_valid), reader.stop.eq(fetched & ~self.shown_valid),
            *(buffer.eq(self.shown_buffer) for buffer in reader.buffer),
            self.o.p.disparity.eq(reader.o.p.pixels[0]), self.o.p.left.eq(reader.o.p.pixels[1]),
            self.o.p.first.eq(reader.o.p.first), self.o.p.last.eq(reader.o.p.last),
        ]
