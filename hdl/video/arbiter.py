"""Arbiter: several masters on the memory controller's local interface."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out, Signature

from ..parts.queue import Queue
from .words import ADDRESS_BITS, WORD_BYTES, LocalBus


__all__ = ["Arbiter", "Burst", "ReadPort", "WritePort", "WriteWord"]


class Burst(data.StructLayout):
    """A request for ``length`` words, 1 .. ``burst``, at consecutive addresses from ``address`` on."""
    def __init__(self, burst: int):
        super().__init__({"address": ADDRESS_BITS, "length": range(burst + 1)})


class WriteWord(data.StructLayout):
    """A word to write; bit ``n`` of ``be`` enables byte ``n``."""
    def __init__(self) -> None:
        super().__init__({"data": 8 * WORD_BYTES, "be": WORD_BYTES})


class WritePort(Signature):
    """Port to the arbiter, seen from a writer.

    A writer requests a burst when all its words are available at ``word``, from which the arbiter then accepts one after another. Outside
    of a burst that was granted, what is offered there may change. ``accepted`` is high in the cycle in which the memory accepts the last of
    them: later reads see the burst.
    """
    def __init__(self, burst: int):
        super().__init__({
            "request": Out(stream.Signature(Burst(burst))),
            "word": Out(stream.Signature(WriteWord())),
            "accepted": In(1),
        })


class ReadPort(Signature):
    """Port to the arbiter, seen from a reader.

    A reader requests a burst when it has space for all words in flight and of the burst. They are returned in the order of the requests,
    marked by ``rdata_valid``, the last one of each burst by ``rdata_last`` too, without back-pressure.
    """
    def __init__(self, burst: int):
        super().__init__({
            "request": Out(stream.Signature(Burst(burst))),
            "rdata": In(8 * WORD_BYTES),
            "rdata_valid": In(1),
            "rdata_last": In(1),
        })


def _lowest(bits: Value) -> Value:
    """One-hot: the lowest bit that is set."""
    return (bits & (~bits + 1))[:len(bits)]


class Arbiter(wiring.Component):
    """Grants the memory to its masters, a burst at a time, round robin: writers first, then readers, in the order of their numbers.

    A burst is issued on the local interface as local bursts of at most ``size`` words. Nothing is issued before ``init_done``. Words read
    are routed to their masters by a queue with an entry for each burst in flight; while it is full, reads are not granted, but writes are.

    Latency: a request is granted within :func:`golden.video.bandwidth.grant_clocks` cycles, and the memory accepts its last word within
    :func:`golden.video.bandwidth.served_clocks` cycles, as long as the queue of bursts in flight is not full. With ``N`` masters, a memory
    that accepts a word each ``pace`` cycles at the slowest, and a stall of ``T`` cycles, these are ``N * burst * pace + T + 2`` and
    ``(N + 1) * burst * pace + T + 3``: the master's previous burst, a burst of each other master, then the one requested.

    Timing: a word a cycle, across bursts too. The signals of a request are registered; ``ready`` of the masters depends combinationally
    on ``bus.ready``. Words read are passed on combinationally.

    Memory: ``outstanding * (bits of a reader's number + bits of a length)`` bits.

    Parameters
    ----------
    writers, readers : int
        Number of masters of either kind.
    burst : int
        Most words of a burst.
    size : int
        Most words of a local burst.
    outstanding : int
        Most read bursts in flight.

    Members
    -------
    write : In(WritePort(burst)).array(writers)
    read : In(ReadPort(burst)).array(readers)
    bus : Out(LocalBus())
    """
    def __init__(self, writers: int, readers: int, *, burst: int = 16, size: int = 1, outstanding: int = 16):
        for name, value, least in (("writers", writers, 1), ("readers", readers, 1), ("burst", burst, 1), ("size", size, 1),
                                   ("outstanding", outstanding, 4)):
            if value < least:
                raise ValueError(f"{name} of the arbiter must be at least {least}, not {value!r}")
        self.burst = burst
        self.size = size
        self.outstanding = outstanding
        super().__init__({
            "write": In(WritePort(burst)).array(writers),
            "read": In(ReadPort(burst)).array(readers),
            "bus": Out(LocalBus(size_bits=size.bit_length())),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        bus = self.bus
        masters = [*self.write, *self.read]
        writers = len(self.write)
        lengths = range(self.burst + 1)

        entry = data.StructLayout({"reader": range(len(self.read)), "length": lengths})
        m.submodules.in_flight = in_flight = Queue(entry, self.outstanding)

        # The granted burst, as far as it has not been issued.
        busy      = Signal()
        master    = Signal(range(len(masters)), reset_less=True)
        reading   = Signal(reset_less=True)
        address   = Signal(ADDRESS_BITS, reset_less=True)
        remaining = Signal(lengths, reset_less=True)
        local     = Signal(range(self.size))    # words of the current local burst that follow
        local_length = Signal(lengths)          # of a local burst that begins in this cycle
        step      = Signal(lengths)             # words that one request stands for
        issue     = Signal()                    # a request is issued to the bus
        last      = Signal()                    # it is the last one of the burst
        m.d.comb += [
            local_length.eq(Mux(remaining > self.size, self.size, remaining)),
            step.eq(Mux(reading, local_length, 1)),
            last.eq(remaining == step),
        ]

        # Round robin: masters with a higher number than the one granted last have priority.
        requests = Signal(len(masters))
        higher   = Signal(len(masters))
        grant    = Signal(len(masters))
        for number, port in enumerate(masters):
            m.d.comb += requests[number].eq(port.request.valid if number < writers else port.request.valid & in_flight.i.ready)
        with m.If(bus.init_done & (~busy | (issue & last))):
            m.d.comb += grant.eq(Mux((requests & higher).any(), _lowest(requests & higher), _lowest(requests)))
        with m.If(issue & last):
            m.d.sync += busy.eq(0)
        with m.If(grant.any()):
            m.d.sync += [busy.eq(1), higher.eq(~(grant | (grant - 1)))]
        with m.If(issue):
            m.d.sync += [address.eq(address + step), remaining.eq(remaining - step)]
        for number, port in enumerate(masters):
            m.d.comb += port.request.ready.eq(grant[number])
            with m.If(grant[number]):
                m.d.sync += [master.eq(number), reading.eq(number >= writers)]
                m.d.sync += [address.eq(port.request.p.address), remaining.eq(port.request.p.length)]
                if number >= writers:
                    m.d.comb += [
                        in_flight.i.valid.eq(1), in_flight.i.p.reader.eq(number - writers), in_flight.i.p.length.eq(port.request.p.length),
                    ]

        # Requests to the memory. They hold until ready; burstbegin does not.
        free = Signal()
        word = Signal(WriteWord())
        word_valid = Signal()
        with m.Switch(master):
            for number, port in enumerate(self.write):
                with m.Case(number):
                    m.d.comb += [word.eq(port.word.p), word_valid.eq(port.word.valid), port.word.ready.eq(issue & ~reading)]
        m.d.comb += [
            free.eq(bus.ready | ~(bus.read_req | bus.write_req)),
            issue.eq(free & busy & (reading | word_valid)),
        ]
        closes = Signal(writers)    # one-hot: the word on the bus is the last of this writer's burst
        m.d.sync += bus.burstbegin.eq(0)
        with m.If(free):
            m.d.sync += [bus.read_req.eq(0), bus.write_req.eq(0)]
        with m.If(issue):
            m.d.sync += [bus.read_req.eq(reading), bus.write_req.eq(~reading), bus.wdata.eq(word.data), bus.be.eq(word.be)]
            m.d.sync += closes.eq(Mux(last, 1 << master, 0))
            with m.If(local == 0):
                m.d.sync += [bus.burstbegin.eq(1), bus.address.eq(address), bus.size.eq(local_length)]
                m.d.sync += local.eq(Mux(reading, 0, local_length - 1))
            with m.Else():
                m.d.sync += local.eq(local - 1)
        for number, port in enumerate(self.write):
            m.d.comb += port.accepted.eq(bus.write_req & bus.ready & closes[number])

        # Words returned.
        burst    = in_flight.o.p
        returned = Signal(lengths)  # words of this burst
        rdata_last = Signal()
        m.d.comb += [rdata_last.eq(returned + 1 == burst.length), in_flight.o.ready.eq(bus.rdata_valid & rdata_last)]
        with m.If(bus.rdata_valid):
            m.d.sync += returned.eq(Mux(rdata_last, 0, returned + 1))
        for number, port in enumerate(self.read):
            m.d.comb += [
                port.rdata.eq(bus.rdata),
                port.rdata_valid.eq(bus.rdata_valid & (burst.reader == number)),
                port.rdata_last.eq(rdata_last),
            ]
        return m
