"""Reader of single lines of a kept pair, for the host."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.video.memory_map import WORD_BYTES, MemoryMap, Plane

from ..host.blocks import LineByte, LineRequest
from .arbiter import ReadPort
from .dma import line_number
from .words import ADDRESS_BITS


__all__ = ["LineReader"]


class LineReader(wiring.Component):
    """Reads a line out of the frame store, a byte at a time. Golden: :func:`golden.host.blocks.stored_line`.

    A word is requested once all bytes of the one before are accepted, in bursts of one word: there is space for it whenever the memory
    returns it, so the arbiter never waits for this reader. The serial line takes a word each 160 bits; even at 3,000,000 baud these are
    18,750 words a second, with their overheads 0.4 % of what the memory serves at 75 MHz, and the word arrives while the last byte of the
    one before is sent, as long as the memory serves it within a byte's time. A later one only delays.

    Timing: a word is requested in the second cycle after the line was, and in the cycle after a word's last byte was accepted; its first
    byte is offered in the cycle after it was returned.

    Parameters
    ----------
    memory_map : :class:`golden.video.memory_map.MemoryMap`
    burst : int
        Of the arbiter.

    Members
    -------
    i : In(stream.Signature(LineRequest()))
        Planes above 2 must not be requested, nor lines beyond the picture's height.
    buffer : In(range(memory_map.buffers)).array(3)
        Left, right, slot; sampled as a request is accepted.
    o : Out(stream.Signature(LineByte()))
        ``16 * memory_map.line_words`` bytes, in the order of pixels.
    port : Out(ReadPort(burst))
    """
    def __init__(self, memory_map: MemoryMap, *, burst: int):
        self.memory_map = memory_map
        super().__init__({
            "i": In(stream.Signature(LineRequest())),
            "buffer": In(range(memory_map.buffers)).array(3),
            "o": Out(stream.Signature(LineByte())),
            "port": Out(ReadPort(burst)),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        memory_map, port, pitch = self.memory_map, self.port, self.memory_map.pitch
        line  = Signal(range(memory_map.total_words // pitch), reset_less=True)     # in memory
        word  = Signal(range(max(2, memory_map.line_words)), reset_less=True)       # of the line
        bits  = Signal(8 * WORD_BYTES, reset_less=True)
        left  = Signal(range(WORD_BYTES), reset_less=True)      # bytes that follow the one offered
        final = Signal()                                        # the last word of the line

        first = C(0, line.shape())
        for plane, buffer in zip((Plane.LEFT, Plane.RIGHT, Plane.DISPARITY), self.buffer):
            first = Mux(self.i.p.plane == plane, line_number(memory_map, plane, buffer), first)
        address = Cat(word[:(pitch - 1).bit_length()], line)
        m.d.comb += [
            final.eq(word == memory_map.line_words - 1),
            port.request.p.address.eq(address[:ADDRESS_BITS]), port.request.p.length.eq(1),
            self.o.p.value.eq(bits[:8]), self.o.p.last.eq(final & (left == 0)),
        ]
        with m.FSM():
            with m.State("idle"):
                m.d.comb += self.i.ready.eq(1)
                m.d.sync += [line.eq(first + self.i.p.line), word.eq(0)]
                with m.If(self.i.valid):
                    m.next = "request"

            with m.State("request"):
                m.d.comb += port.request.valid.eq(1)
                with m.If(port.request.ready):
                    m.next = "wait"

            with m.State("wait"):
                m.d.sync += [bits.eq(port.rdata), left.eq(WORD_BYTES - 1)]
                with m.If(port.rdata_valid):
                    m.next = "bytes"

            with m.State("bytes"):
                m.d.comb += self.o.valid.eq(1)
                with m.If(self.o.ready):
                    m.d.sync += [bits.eq(bits >> 8), left.eq(left - 1)]
                    with m.If(left == 0):
                        m.d.sync += word.eq(word + 1)
                        m.next = "request"
                        with m.If(final):
                            m.next = "idle"
        return m
