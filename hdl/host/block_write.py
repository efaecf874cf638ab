"""Block writes: a line of a picture, with its CRC, from the host to whatever stores it."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out

from golden.host.blocks import SENT_PLANES
from golden.host.protocol import CRC_BYTES, Status

from ..parts.delay import NO_COLLISION
from .blocks import BlockWritePort, LineByte, crc_step


__all__ = ["BlockWrite"]


class BlockWrite(wiring.Component):
    """Receives a line, and passes it on once its CRC is known to be right: a bad block changes nothing.

    Golden: :meth:`golden.host.device.SerialDevice.receive`.

    Timing: the first byte is accepted 4 cycles after ``port.start``, then one a cycle. ``port.done`` is high 2 cycles after the last byte
    was accepted if the CRC is wrong, and ``length + 3`` cycles after it if it is right and the store accepts a byte a cycle: it has
    accepted all of them then. No byte is accepted in between.

    Memory: a line.

    Parameters
    ----------
    max_length, height : int
        Most bytes of a line, and lines of a picture.

    Members
    -------
    port : In(BlockWritePort())
    refuse : In(1)
        The block of ``port.plane`` and ``port.line`` is refused, as busy.
    length : In(range(max_length + 1))
        Bytes of a line, at least 1; sampled at ``port.start``.
    o : Out(stream.Signature(LineByte()))
        Of the line ``port.line``, to the store.
    """
    def __init__(self, max_length: int, height: int):
        self.max_length, self.height = max_length, height
        super().__init__({
            "port": In(BlockWritePort()),
            "refuse": In(1),
            "length": In(range(max_length + 1)),
            "o": Out(stream.Signature(LineByte())),
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

        m.submodules.line = memory = Memory(shape=8, depth=self.max_length, init=[], attrs=NO_COLLISION)
        reader, writer = memory.read_port(), memory.write_port()
        length = Signal.like(self.length, reset_less=True)
        count = Signal(range(self.max_length + CRC_BYTES + 1), reset_less=True)     # bytes accepted, then bytes read
        crc   = Signal(16, reset_less=True)
        taken = Signal(8)       # the next byte of the CRC
        step  = Signal()
        with m.If(step):
            m.d.sync += crc.eq(crc_step(crc, taken))

        accepted = Signal()
        m.d.comb += [
            accepted.eq(byte.valid & byte.ready),
            writer.addr.eq(count), writer.data.eq(byte.payload), writer.en.eq(accepted & (count < length)),
            reader.addr.eq(count), self.o.p.value.eq(reader.data), self.o.p.last.eq(count == length),
        ]
        read  = Signal()        # the memory's output is a byte of the line
        moves = Signal()        # it is accepted, or there is none
        m.d.comb += [self.o.valid.eq(read), moves.eq(self.o.ready | ~read), reader.en.eq(moves)]
        with m.If(moves):
            m.d.sync += read.eq(0)

        with m.FSM():
            with m.State("idle"):
                m.d.sync += [crc.eq(0xFFFF), count.eq(0), length.eq(self.length)]
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
                    with m.If(count == length + (CRC_BYTES - 1)):
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
                with m.If(moves & (count == length)):
                    m.next = "end"
                with m.Elif(moves):
                    m.d.sync += [read.eq(1), count.eq(count + 1)]

            with m.State("end"):
                m.d.comb += [port.done.eq(1), port.good.eq(1)]
                m.next = "idle"
        return m
