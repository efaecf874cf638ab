"""Block writes: a line of a picture, with its CRC, from the host into a store."""

from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.host.loop_registers import SENT_PLANES
from golden.host.protocol import CRC_BYTES, Status

from ..host.blocks import BlockWritePort, crc_step
from ..parts.delay import NO_COLLISION
from .store import row_start


__all__ = ["BlockWrite"]


class BlockWrite(wiring.Component):
    """Receives a line, and writes it once its CRC is known to be right: a bad block changes nothing.

    Golden: :meth:`golden.host.loop_device.LoopDevice.receive`.

    Timing: the first byte is accepted 4 cycles after ``port.start``, then one a cycle. ``port.done`` is high 2 cycles after the last byte
    was accepted if the CRC is wrong, and ``width + 3`` cycles after it if it is right; the line is in its store
    :attr:`hdl.loop.store.FrameStore.LATENCY` cycles later. No byte is accepted in between.

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
    write : Out(1), plane : Out(range(2)), address : Out(range(max_width * height)), data : Out(8)
        To the stores.
    """
    def __init__(self, max_width: int, height: int):
        self.max_width, self.height = max_width, height
        super().__init__({
            "port": In(BlockWritePort()),
            "refuse": In(1),
            "width": In(range(max_width + 1)),
            "write": Out(1),
            "plane": Out(range(len(SENT_PLANES))),
            "address": Out(range(max_width * height)),
            "data": Out(8),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        port, byte = self.port, self.port.byte
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
            reader.addr.eq(count), reader.en.eq(1),
            self.plane.eq(port.plane), self.data.eq(reader.data),
        ]
        address = Signal.like(self.address, reset_less=True)
        read    = Signal()      # the memory's output is a pixel
        m.d.sync += read.eq(0)
        m.d.comb += [self.write.eq(read), self.address.eq(address)]
        with m.If(read):
            m.d.sync += address.eq(address + 1)

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
                with m.If(count == width):
                    m.next = "end"
                with m.Else():
                    m.d.sync += [read.eq(1), count.eq(count + 1)]

            with m.State("end"):
                m.d.comb += [port.done.eq(1), port.good.eq(1)]
                m.next = "idle"
        return m
