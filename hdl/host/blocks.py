"""Block reads: a line of a kept picture, with its CRC, as bytes for the host. And the port of block writes, which bring one."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out, Signature

from golden.host.blocks import PLANES
from golden.host.protocol import Status


__all__ = ["BlockPort", "BlockRead", "BlockWritePort", "LineByte", "LineRequest", "crc_step"]


class LineRequest(data.StructLayout):
    """A line of a kept picture: the plane's number in :data:`golden.host.blocks.PLANES`, and the line, from 0."""
    def __init__(self) -> None:
        super().__init__({"plane": range(len(PLANES)), "line": 16})


class LineByte(data.StructLayout):
    """A byte of a line or of a block; ``last``: its last one."""
    def __init__(self) -> None:
        super().__init__({"value": 8, "last": 1})


class BlockPort(Signature):
    """Port to the block read, seen from the register file.

    ``plane`` and ``line`` hold for two cycles: in the second one ``status`` tells whether the block can be sent, and ``start`` may be high
    if it is ``OK``. Then the bytes of one block are sent.
    """
    def __init__(self) -> None:
        super().__init__({
            "plane": Out(8),
            "line": Out(16),
            "status": In(Status, init=Status.NOT_KEPT),
            "start": Out(1),
            "byte": In(stream.Signature(LineByte())),
        })


class BlockWritePort(Signature):
    """Port to the block write, seen from the register file.

    ``plane`` and ``line`` hold from two cycles before ``start`` until the block has ended: in the second one ``status`` tells whether the
    block can be accepted, and ``start`` may be high if it is ``OK``. The bytes that follow are data and CRC. The block ends with ``done``,
    high for one cycle, and ``good``: it was stored; or with ``cancel``, high for one cycle in which no byte is valid. A byte
    that is offered as the block ends is none of it, and is withdrawn.
    """
    def __init__(self) -> None:
        super().__init__({
            "plane": Out(8),
            "line": Out(16),
            "status": In(Status, init=Status.UNKNOWN_OPERATION),
            "start": Out(1),
            "byte": Out(stream.Signature(8)),
            "cancel": Out(1),
            "done": In(1),
            "good": In(1),
        })


def crc_step(crc: Value, byte: Value) -> Value:
    """The CRC of the bytes before, and of ``byte`` too. Golden: :func:`golden.host.protocol.crc`."""
    # A bit at a time, written out: each bit of the result is an exclusive or of some bits of both.
    bits = [*crc]
    for bit in reversed([*byte]):
        feedback = bits[15] ^ bit
        bits = [feedback, *bits[:15]]
        bits[5] ^= feedback
        bits[12] ^= feedback
    return Cat(bits)


class BlockRead(wiring.Component):
    """Sends a line of a kept picture, and its CRC. Golden: :func:`golden.host.blocks.block_answer`, the bytes after the reply.

    If ``kept`` falls before the last byte of the line is accepted, the CRC is inverted: the bytes may be of another picture, and the host
    repeats its request, or finds that no pair is kept. A block that has begun is always sent to its end.

    Timing: the line is requested in the cycle after ``start``; its bytes are passed on combinationally, from the fourth cycle on, and the
    two of the CRC follow in the cycles after the last one was accepted.

    Parameters
    ----------
    height : int
        Lines of a picture.
    planes : int
        Planes that can be read.

    Members
    -------
    port : In(BlockPort())
    kept : In(1)
        A pair is kept.
    request : Out(stream.Signature(LineRequest()))
    i : In(stream.Signature(LineByte()))
        Bytes of the line that was requested last.
    """
    def __init__(self, height: int, planes: int = len(PLANES)):
        self.height = height
        self.planes = planes
        super().__init__({
            "port": In(BlockPort()),
            "kept": In(1),
            "request": Out(stream.Signature(LineRequest())),
            "i": In(stream.Signature(LineByte())),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        port, wanted = self.port, self.request.p
        byte = port.byte

        with m.If(port.plane >= self.planes):
            m.d.sync += port.status.eq(Status.UNKNOWN_ADDRESS)
        with m.Elif(port.line >= self.height):
            m.d.sync += port.status.eq(Status.OUT_OF_RANGE)
        with m.Elif(~self.kept):
            m.d.sync += port.status.eq(Status.NOT_KEPT)
        with m.Else():
            m.d.sync += port.status.eq(Status.OK)

        crc   = Signal(16, reset_less=True)
        taken = Signal(8)       # the next byte of the CRC
        step  = Signal()
        lost  = Signal()        # the pair was let go
        low   = Signal()        # the CRC's second byte is next
        with m.If(step):
            m.d.sync += crc.eq(crc_step(crc, taken))
        with m.If(self.request.ready):
            m.d.sync += self.request.valid.eq(0)
        with m.FSM():
            with m.State("idle"):
                m.d.sync += lost.eq(~self.kept)
                with m.If(port.start):
                    m.d.sync += [wanted.plane.eq(port.plane), wanted.line.eq(port.line), self.request.valid.eq(1), crc.eq(0xFFFF)]
                    m.next = "plane"

            for state, value, after in (
                    ("plane", wanted.plane, "upper"), ("upper", wanted.line[8:], "lower"), ("lower", wanted.line[:8], "line")):
                with m.State(state):
                    m.d.comb += [step.eq(1), taken.eq(value)]
                    m.d.sync += lost.eq(lost | ~self.kept)
                    m.next = after

            with m.State("line"):
                m.d.comb += [
                    byte.valid.eq(self.i.valid), byte.p.value.eq(self.i.p.value), self.i.ready.eq(byte.ready),
                    taken.eq(self.i.p.value), step.eq(self.i.valid & byte.ready),
                ]
                m.d.sync += lost.eq(lost | ~self.kept)
                with m.If(step & self.i.p.last):
                    m.d.sync += low.eq(0)
                    m.next = "crc"

            with m.State("crc"):
                m.d.comb += [byte.valid.eq(1), byte.p.value.eq(Mux(low, crc[:8], crc[8:]) ^ lost.replicate(8)), byte.p.last.eq(low)]
                with m.If(byte.ready):
                    m.d.sync += low.eq(1)
                    with m.If(low):
                        m.next = "idle"

        return m
