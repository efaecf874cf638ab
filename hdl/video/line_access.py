"""Reader and writer of single lines for the host: lines of a kept pair are read, those of the host's pair are written."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out

from golden.video.memory_map import WORD_BYTES, MemoryMap, Plane

from ..host.blocks import LineByte, LineRequest
from .arbiter import ReadPort, WritePort
from .dma import line_number
from .words import ADDRESS_BITS


__all__ = ["LineAccess"]


class LineAccess(wiring.Component):
    """Reads a line out of the frame store, or writes one, a byte at a time. Golden: :func:`golden.host.blocks.stored_line`.

    One line after the other, which share a register of a word. A word is requested once all bytes of the one before are accepted, or once
    it is complete, in bursts of one word: there is space for it whenever the memory returns it, so the arbiter never waits for this
    reader. The serial line takes a word each 160 bits; even at 3,000,000 baud these are 18,750 words a second, with their overheads 0.4 %
    of what the memory serves at 75 MHz, and a word that is read arrives while the last byte of the one before is sent, as long as the
    memory serves it within a byte's time. A later one only delays.

    Timing: a word is requested in the second cycle after its line was, and in the cycle after a word's last byte was accepted; its first
    byte is offered in the cycle after it was returned. A byte to be written is accepted each cycle, but after each sixteenth one the word
    is written first; the last byte of the line is accepted in the cycle in which the memory has accepted its word, so that all later reads
    see the line.

    Parameters
    ----------
    memory_map : :class:`golden.video.memory_map.MemoryMap`
        With a pair of the host.
    burst : int
        Of the arbiter.

    Members
    -------
    i : In(stream.Signature(LineRequest()))
        Planes above 2 must not be requested, nor lines beyond the picture's height.
    left, right, slot : In
        Buffers of the kept pair; sampled as a request is accepted.
    o : Out(stream.Signature(LineByte()))
        ``16 * memory_map.line_words`` bytes, in the order of pixels.
    put : In(stream.Signature(LineByte()))
        As many bytes of a line of the host's pair; none while a line is read.
    put_plane : In(1), put_line : In(16)
        0 left, 1 right, and the line; hold from the cycle before the first byte to the last one.
    read : Out(ReadPort(burst)), write : Out(WritePort(burst))
        One of them at a time.
    """
    def __init__(self, memory_map: MemoryMap, *, burst: int):
        if not memory_map.host:
            raise ValueError("the memory map has no pair of the host; choose one with host=True")
        self.memory_map = memory_map
        super().__init__({
            "i": In(stream.Signature(LineRequest())),
            **dict.fromkeys(("left", "right"), In(range(memory_map.frames))),
            "slot": In(range(memory_map.buffers)),
            "o": Out(stream.Signature(LineByte())),
            "put": In(stream.Signature(LineByte())),
            "put_plane": In(1),
            "put_line": In(16),
            "read": Out(ReadPort(burst)),
            "write": Out(WritePort(burst)),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        memory_map, read, write, pitch = self.memory_map, self.read, self.write, self.memory_map.pitch
        line  = Signal(range(memory_map.total_words // pitch), reset_less=True)     # in memory
        word  = Signal(range(max(2, memory_map.line_words)), reset_less=True)       # of the line
        bits  = Signal(8 * WORD_BYTES, reset_less=True)
        left  = Signal(range(WORD_BYTES), reset_less=True)      # bytes that follow the one offered, or accepted next
        final = Signal()                                        # the last word of the line
        last  = Signal()                                        # and the last byte of a word

        reads  = self.i.valid
        number = Signal(16)
        first  = Signal.like(line)
        m.d.comb += number.eq(Mux(reads, self.i.p.line, self.put_line))
        with m.Switch(Mux(reads, self.i.p.plane, self.put_plane)):
            for plane, buffer in ((Plane.LEFT, self.left), (Plane.RIGHT, self.right)):
                with m.Case(plane.value):
                    m.d.comb += first.eq(line_number(memory_map, plane, Mux(reads, buffer, memory_map.buffers)))
            with m.Default():
                m.d.comb += first.eq(line_number(memory_map, Plane.DISPARITY, self.slot))
        address = Cat(word[:(pitch - 1).bit_length()], line)
        for request in (read.request, write.request):
            m.d.comb += [request.p.address.eq(address[:ADDRESS_BITS]), request.p.length.eq(1)]
        m.d.comb += [
            last.eq(left == 0), final.eq(word == memory_map.line_words - 1),
            self.o.p.value.eq(bits[:8]), self.o.p.last.eq(final & last),
            write.word.p.data.eq(bits), write.word.p.be.eq(-1),
        ]
        with m.FSM():
            with m.State("idle"):
                m.d.comb += self.i.ready.eq(1)
                m.d.sync += [line.eq(first + number), word.eq(0), left.eq(WORD_BYTES - 1)]
                with m.If(reads):
                    m.next = "request"
                with m.Elif(self.put.valid):
                    m.next = "collect"

            with m.State("request"):
                m.d.comb += read.request.valid.eq(1)
                with m.If(read.request.ready):
                    m.next = "wait"

            with m.State("wait"):
                m.d.sync += [bits.eq(read.rdata), left.eq(WORD_BYTES - 1)]
                with m.If(read.rdata_valid):
                    m.next = "bytes"

            with m.State("bytes"):
                m.d.comb += self.o.valid.eq(1)
                with m.If(self.o.ready):
                    m.d.sync += [bits.eq(Cat(bits[8:], self.put.p.value)), left.eq(left - 1)]
                    with m.If(last):
                        m.d.sync += word.eq(word + 1)
                        m.next = "request"
                        with m.If(final):
                            m.next = "idle"

            with m.State("collect"):
                # The line's last byte is accepted later.
                m.d.comb += self.put.ready.eq(~(final & last))
                with m.If(self.put.valid):
                    m.d.sync += [bits.eq(Cat(bits[8:], self.put.p.value)), left.eq(left - 1)]
                    with m.If(last):
                        m.next = "put"

            with m.State("put"):
                m.d.comb += [write.request.valid.eq(1), write.word.valid.eq(1)]
                with m.If(write.request.ready):
                    m.next = "accepted"

            with m.State("accepted"):
                m.d.comb += [write.word.valid.eq(1), self.put.ready.eq(write.accepted & final)]
                with m.If(write.accepted):
                    m.d.sync += word.eq(word + 1)
                    m.next = "collect"
                    with m.If(final):
                        m.next = "idle"
        return m
