"""Readers of pictures out of the frame store: of pairs for the matcher, and of the picture for the monitor."""

from abc import ABC, abstractmethod
from typing import Any

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.config import MatcherConfig
from golden.video.memory_map import MemoryMap, Plane

from ..matcher.stream import PixelPair, copy_flags
from ..parts.arithmetic import maximum
from ..rig.control import ROWS
from .arbiter import ReadPort
from .buffers import PairRead
from .dma import LineScan, PixelUnpacker, PlanePair, WordFifo, line_number
from .words import ShownPixel


__all__ = ["PairReader", "PictureReader"]


class _PlanePairReader(wiring.Component):
    """Reads two planes in parallel.

    Bursts of the two planes alternate, each into a FIFO with space for all words in flight. ``start`` and ``stop`` may be high at any
    time. Without ``cuts``, the current pictures are sent to their end first. With ``cuts``, no more bursts are requested, and once no word
    is in flight the FIFOs are emptied; a pixel that is offered then stays until it is accepted. With ``moves`` the second plane is moved by
    ``row_offset``.

    Members
    -------
    start, stop : In(1)
        Read the pictures; read no more.
    buffer : In(range(buffers of the planes)).array(2)
        Sampled with ``start``.
    row_offset : In(signed(8))
        Likewise.
    o : Out(stream.Signature(PlanePair()))
    done : Out(1)
        One cycle: all words of both have been returned.
    port, fill, clear_fill
        As of :class:`PairReader`.
    """
    def __init__(self, memory_map: MemoryMap, planes: tuple[Plane, Plane], *, cuts: bool, burst: int, depth: int, moves: bool = False):
        self.memory_map = memory_map
        self.planes = planes
        self.cuts = cuts
        self.burst = burst
        self.depth = depth
        self.moves = moves
        super().__init__({
            "start": In(1),
            "stop": In(1),
            "buffer": In(range(max(map(memory_map.buffers_of, planes)))).array(2),
            **({"row_offset": In(ROWS)} if moves else {}),
            "o": Out(stream.Signature(PlanePair())),
            "port": Out(ReadPort(burst)),
            "done": Out(1),
            "fill": Out(range(depth + 1)),
            "clear_fill": In(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        memory_map, port = self.memory_map, self.port
        m.submodules.scan = scan = LineScan(memory_map, burst=self.burst, moves=self.moves)
        m.submodules.unpacker = unpacker = PixelUnpacker(memory_map)
        wiring.connect(m, unpacker.o, wiring.flipped(self.o))

        # A restart waits until no word is in flight.
        pending    = Signal()   # start or stop was high, the restart has not been carried out
        to_read    = Signal()   # it was start
        clear      = Signal()
        requesting = Signal()
        sending    = Signal()   # the last pixel of these pictures has not been accepted
        in_flight  = Signal(range(2 * self.depth + 1))  # words granted and not yet returned
        cut        = pending if self.cuts else C(0)
        m.d.comb += [
            clear.eq(pending & ~requesting & (in_flight == 0) & (~sending | cut)),
            scan.start.eq(clear & to_read),
            unpacker.clear.eq(clear),
        ]
        with m.If(self.o.valid & self.o.ready & self.o.p.end):
            m.d.sync += sending.eq(0)
        with m.If(clear):
            m.d.sync += [pending.eq(0), sending.eq(to_read)]
        with m.If(self.start | self.stop):
            m.d.sync += [pending.eq(1), to_read.eq(self.start)]

        # Requests: a burst of one plane, then the same one of the other.
        reading = Signal()
        side    = Signal()
        granted = Signal()
        space   = Signal(data.ArrayLayout(range(self.depth + 1), 2))    # words of each FIFO neither occupied nor requested
        m.d.comb += [
            port.request.valid.eq(requesting),
            port.request.p.address.eq(scan.o.address),
            port.request.p.length.eq(scan.o.length),
            granted.eq(requesting & port.request.ready),
            scan.advance.eq(granted & side),
        ]
        m.d.sync += in_flight.eq(in_flight + Mux(granted, scan.o.length, 0) - port.rdata_valid)
        with m.If(granted):
            m.d.sync += [requesting.eq(0), side.eq(~side)]
        with m.Elif(reading & scan.active & ~cut & (space[side] >= scan.o.length)):
            m.d.sync += requesting.eq(1)
        m.d.comb += self.done.eq(reading & ~scan.active & (in_flight == 0))
        with m.If(self.done):
            m.d.sync += reading.eq(0)
        with m.If(clear):
            m.d.sync += [reading.eq(to_read), side.eq(0)]

        # Words are returned in the order of the requests: a burst of one plane, then a burst of the other.
        returned_side = Signal()
        with m.If(port.rdata_valid & port.rdata_last):
            m.d.sync += returned_side.eq(~returned_side)
        with m.If(clear):
            m.d.sync += returned_side.eq(0)

        fifos = [WordFifo(self.depth) for _ in range(2)]
        bases = []
        for number, (fifo, plane, buffer) in enumerate(zip(fifos, self.planes, self.buffer)):
            m.submodules[f"fifo_{number}"] = fifo
            wiring.connect(m, fifo.o, unpacker.i[number])
            m.d.comb += [
                fifo.i.payload.eq(port.rdata), fifo.i.valid.eq(port.rdata_valid & (returned_side == number)),
                fifo.clear.eq(clear), fifo.clear_fill.eq(self.clear_fill),
            ]
            m.d.sync += space[number].eq(space[number] - Mux(granted & (side == number), scan.o.length, 0) +
                                         (fifo.o.valid & fifo.o.ready))
            chosen = Signal.like(buffer, reset_less=True)
            base = Signal.like(scan.base, reset_less=True)
            with m.If(self.start):
                m.d.sync += chosen.eq(buffer)
            with m.If(clear):
                m.d.sync += [space[number].eq(self.depth), base.eq(line_number(memory_map, plane, chosen))]
            bases.append(base)
        m.d.comb += scan.base.eq(Mux(side, bases[1], bases[0]))
        if self.moves:
            wanted, offset = Signal(ROWS), Signal(ROWS)
            with m.If(self.start):
                m.d.sync += wanted.eq(self.row_offset)
            with m.If(clear):
                m.d.sync += offset.eq(wanted)
            m.d.comb += scan.offset.eq(Mux(side, offset, 0))
        m.d.comb += self.fill.eq(maximum(fifos[0].fill, fifos[1].fill))
        return m


class _Reader(wiring.Component, ABC):
    """What :class:`PairReader` and :class:`PictureReader` share; see there.

    Parameters
    ----------
    planes : pair of :class:`golden.video.memory_map.Plane`
    cuts : bool
        Whether a restart cuts the current pictures.
    moves : bool
        Whether the second plane is moved.
    members : dict
        Those beyond ``port``, ``fill`` and ``clear_fill``; ``o`` among them.
    """
    def __init__(self, memory_map: MemoryMap, planes: tuple[Plane, Plane], members: dict[str, Any], *, cuts: bool, burst: int, depth: int,
                 moves: bool = False):
        LineScan.check(memory_map, burst)
        if depth < 2 * burst:
            raise ValueError(f"each FIFO of a reader must hold at least {2 * burst} words, two bursts, not {depth!r}")
        self.memory_map = memory_map
        self.planes = planes
        self.cuts = cuts
        self.burst = burst
        self.depth = depth
        self.moves = moves
        super().__init__({
            **members,
            "port": Out(ReadPort(burst)),
            "fill": Out(range(depth + 1)),
            "clear_fill": In(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.reader = reader = _PlanePairReader(
            self.memory_map, self.planes, cuts=self.cuts, burst=self.burst, depth=self.depth, moves=self.moves)
        wiring.connect(m, reader.port, wiring.flipped(self.port))
        m.d.comb += [
            self.fill.eq(reader.fill), reader.clear_fill.eq(self.clear_fill),
            self.o.valid.eq(reader.o.valid), reader.o.ready.eq(self.o.ready),
        ]
        self._connect(m, reader)
        return m

    @abstractmethod
    def _connect(self, m: Module, reader: _PlanePairReader) -> None:
        """Connect the control of ``reader``, and the fields of its pixels to those of ``o``."""


class PairReader(_Reader):
    """Reads the two pictures of a pair out of their buffers, for the matcher.

    Golden: :meth:`golden.video.memory_map.MemoryMap.picture` of both.

    Timing: ``done`` is high when every pixel of both has been read from memory, so that the buffers may be overwritten; the last pixels
    may still be in the FIFOs. A ``start`` before they have been sent waits for that. A pixel a cycle, as long as the memory keeps pace.

    FIFO: while a burst is in flight, :func:`golden.video.bandwidth.served_clocks` and the read latency, the matcher consumes a word of
    each plane in 16 cycles; :attr:`golden.video.bandwidth.Budget.matcher_depth`.

    Memory: ``2 * (depth - 1) * 128`` bits.

    Parameters
    ----------
    memory_map : :class:`golden.video.memory_map.MemoryMap`
    burst : int
        Most words of a burst, a power of two.
    depth : int
        Words that each of the two FIFOs holds.
    moves : bool
        The right picture is moved by a row offset.

    Members
    -------
    control : Out(PairRead(memory_map.frames))
        When a pair is read, and from where; the buffers are sampled with ``start``.
    row_offset : In(signed(8))
        With ``moves``; sampled with ``start``: line ``y`` of the right picture is the camera's ``y + row_offset``, as
        :func:`golden.rig.rectify.move_rows` says.
    o : Out(stream.Signature(PixelPair()))
    port : Out(ReadPort(burst))
    fill : Out(range(depth + 1))
        Highest level of either FIFO since ``clear_fill``.
    clear_fill : In(1)
    """
    def __init__(self, memory_map: MemoryMap, *, burst: int = 16, depth: int = 64, moves: bool = False):
        super().__init__(memory_map, (Plane.LEFT, Plane.RIGHT), {
            "control": Out(PairRead(memory_map.frames)),
            **({"row_offset": In(ROWS)} if moves else {}),
            "o": Out(stream.Signature(PixelPair())),
        }, cuts=False, burst=burst, depth=depth, moves=moves)

    def _connect(self, m: Module, reader: _PlanePairReader) -> None:
        control = self.control
        m.d.comb += [
            reader.start.eq(control.start), control.done.eq(reader.done), *([reader.row_offset.eq(self.row_offset)] if self.moves else []),
            reader.buffer[0].eq(control.left_buffer), reader.buffer[1].eq(control.right_buffer),
            self.o.p.left.eq(reader.o.p.pixels[0]), self.o.p.right.eq(reader.o.p.pixels[1]), *copy_flags(self.o.p, reader.o.p),
        ]


class PictureReader(_Reader):
    """Reads the picture that is shown, disparities and grey levels, out of its slot, for the monitor.

    Golden: :meth:`golden.video.memory_map.MemoryMap.picture` of both planes.

    ``fetch`` is high for a cycle as the monitor begins a picture; in the next cycle ``shown_valid`` and ``shown_buffer`` tell whether
    there is one, and where. A picture that is not finished by then is cut: words in the FIFOs and in flight are discarded, and the next
    pixel is the new picture's ``first``. Before it, until the words in flight have been returned, pixels of the old picture may still be
    sent. Without ``shown_valid`` nothing more is sent.

    Timing: a pixel a cycle, as long as the memory keeps pace.

    FIFO: it must hold what the monitor consumes during a stall of the memory, :attr:`golden.video.bandwidth.Budget.display_depth`.

    Memory: ``2 * (depth - 1) * 128`` bits.

    Parameters
    ----------
    memory_map : :class:`golden.video.memory_map.MemoryMap`
    config : :class:`golden.config.MatcherConfig`
    burst : int
        Most words of a burst, a power of two.
    depth : int
        Words that each of the two FIFOs holds.

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
