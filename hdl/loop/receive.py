"""Block writes: a line of a picture, with its CRC, from the host into a store."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.host.loop_registers import SENT_PLANES
from golden.host.protocol import CRC_BYTES, Status

from ..host.blocks import BlockWritePort, crc_step
from ..parts.delay import NO_COLLISION
from .store import row_start
from .words import SentPixel


__all__ = ["BlockWrite"]


class BlockWrite(wiring.Component):
    """Receives a line, and writes it once its CRC is known to be right: a bad block changes nothing.

    Golden: :meth:`golden.host.loop_device.LoopDevice.receive`.

    Timing: the first byte is accepted 4 cycles after ``port.start``, then one a cycle. ``port.done`` is high 2 cycles after the last byte
    was accepted if the CRC is wrong, and ``width + 3`` cycles after it if it is right and the store accepts a pixel a cycle: it has
    accepted all of them then. No byte is accepted in between.

    Memory: a line.

    Parameters
    ----------
    max_width, height : int
        Of a store, pixels.

    Members
    -------
    port : In(BlockWritePort())
    refuse : In(1)
        Blocks are refused, as busy.
    width : In(range(max_width + 1))
        Pixels of a line, at least 1; sampled at ``port.start``.
    o : Out(stream.Signature(SentPixel(max_width * height)))
        To the store.
    """
    def __init__(self, max_width: int, height: int):
        self.max_width, self.height = max_width, height
        super().__init__({
            "port": In(BlockWritePort()),
            "refuse": In(1),
            "width": In(range(max_width + 1)),
            "o": Out(stream.Signature(SentPixel(max_width * height))),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        port, byte, pixel = self.port, self.port.byte, self.o.p
        with m.If(port.plane >= len(SENT_PLANES)):
            m.d.sync += port.status.eq(Status.UNKNOWN_ADDRESS)
        with m.Elif(port.line >= self.height):
            m.d.sync += port.status.eq(Status.OUT_OF_RANGE)
        with m.Elif(self.refuse):
            m.d.sync += port.status.eq(Status.BUSY)
        with m.Else():
            m.d.sync += port.status.eq(Status.OK)

        m.submodules.line = memory = Memory(shape=8, depth=self.max_width, init=[], attrs=NO_COLLISION)
        reader, writer = memory.read_port(), memory.write_port()
        width = Signal.like(self.width, reset_less=True)
        count = Signal(range(self.max_width + CRC_BYTES + 1), reset_less=True)  # bytes accepted, then pixels read
        crc   = Signal(16, reset_less=True)
        taken = Signal(8)       # the next byte of the CRC
        step  = Signal()
        with m.If(step):
            m.d.sync += crc.eq(crc_step(crc, taken))

        accepted = Signal()
        m.d.comb += [
            accepted.eq(byte.valid & byte.ready),
            writer.addr.eq(count), writer.data.eq(byte.payload), writer.en.eq(accepted & (count < width)),
            reader.addr.eq(count), pixel.plane.eq(port.plane), pixel.level.eq(reader.data),
        ]
        address = Signal.like(pixel.address, reset_less=True)
        read    = Signal()      # the memory's output is a pixel
        moves   = Signal()      # it is accepted, or there is none
        m.d.comb += [self.o.valid.eq(read), pixel.address.eq(address), moves.eq(self.o.ready | ~read), reader.en.eq(moves)]
        with m.If(moves):
            m.d.sync += [read.eq(0), address.eq(address + read)]

        line = port.line[:max(1, (self.height - 1).bit_length())]
        with m.FSM():
            with m.State("idle"):
                m.d.sync += [crc.eq(0xFFFF), count.eq(0), width.eq(self.width), address.eq(row_start(line, self.max_width))]
                with m.If(port.start):
                    m.next = "plane"

            for state, value, after in (
                    ("plane", port.plane, "upper"), ("upper", port.line[8:], "lower"), ("lower", port.line[:8], "data")):
                with m.State(state):
                    m.d.comb += [step.eq(1), taken.eq(value)]
                    m.next = after

            with m.State("data"):
                m.d.comb += [byte.ready.eq(1), step.eq(accepted), taken.eq(byte.payload)]
                with m.If(port.cancel):
                    m.next = "idle"
                with m.Elif(accepted):
                    m.d.sync += count.eq(count + 1)
                    with m.If(count == width + (CRC_BYTES - 1)):
                        m.next = "check"

            with m.State("check"):
                # The CRC of data that end with their CRC is 0.
                m.d.sync += count.eq(0)
                with m.If(crc == 0):
                    m.next = "copy"
                with m.Else():
                    m.d.comb += port.done.eq(1)
                    m.next = "idle"

            with m.State("copy"):
                with m.If(moves & (count == width)):
                    m.next = "end"
                with m.Elif(moves):
                    m.d.sync += [read.eq(1), count.eq(count + 1)]

            with m.State("end"):
                m.d.comb += [port.done.eq(1), port.good.eq(1)]
                m.next = "idle"
        return m
