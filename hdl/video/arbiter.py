"""Several masters on the memory controller's local interface."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out, Signature

from ..parts.queue import Queue
from .words import ADDRESS_BITS, WORD_BYTES, LocalBus


__all__ = ["Arbiter", "Burst", "ReadPort", "WritePort", "WriteWord"]


class Burst(data.StructLayout):
    """A request for ``length`` words, 1 .. ``burst``, at consecutive addresses from ``address`` on."""
    def __init__(self, burst):
        super().__init__({"address": ADDRESS_BITS, "length": range(burst + 1)})


class WriteWord(data.StructLayout):
    """A word to write; bit ``n`` of ``be`` enables byte ``n``."""
    def __init__(self):
        super().__init__({"data": 8 * WORD_BYTES, "be": WORD_BYTES})


class WritePort(Signature):
    """A writer, as it sees the arbiter.

    It asks when all words of the burst wait in ``word``, which the arbiter then takes one after another. ``accepted`` is high in the
    cycle in which the memory takes the last of them: whatever is read from then on sees the burst.
    """
    def __init__(self, burst):
        super().__init__({
            "request": Out(stream.Signature(Burst(burst))),
            "word": Out(stream.Signature(WriteWord())),
            "accepted": In(1),
        })


class ReadPort(Signature):
    """A reader, as it sees the arbiter.

    It asks when it has room for every word that it has asked for. They come in the order of the requests, marked by ``rdata_valid``,
    the last one of each burst by ``rdata_last`` too, and cannot be held up.
    """
    def __init__(self, burst):
        super().__init__({
            "request": Out(stream.Signature(Burst(burst))),
            "rdata": In(8 * WORD_BYTES),
            "rdata_valid": In(1),
            "rdata_last": In(1),
        })


def _lowest(bits):
    """The lowest bit that is set, alone."""
    return (bits & (~bits + 1))[:len(bits)]


class Arbiter(wiring.Component):
    """Grants the memory to its masters, a burst at a time, round robin: writers first, then readers, in the order of their numbers.

    A burst goes to the local interface as local bursts of at most ``size`` words. Nothing is asked of the memory before ``init_done``.
    Words read go to their masters by a queue of owners, one entry a burst; while it is full no read is granted, writes are.

    Latency: a request is granted within :func:`golden.video.bandwidth.grant_clocks` cycles, and its last word is taken by the memory within
    :func:`golden.video.bandwidth.served_clocks` cycles, as long as the queue of owners is not full. With ``N`` masters, a memory that
    takes a
    word each ``pace`` cycles at the slowest, and a stall of ``T`` cycles, that is ``N * burst * pace + T + 2`` and
    ``(N + 1) * burst * pace + T + 3``: a master's own burst of before, then one of each other master, then its own.

    Timing: a word a cycle, across bursts too. Requests to the memory leave registers; ``ready`` of masters depends combinationally on
    ``bus.ready``. Words that were read pass combinationally.

    Memory: ``outstanding * (bits of a reader's number + bits of a length)`` bits.

    Parameters
    ----------
    writers, readers : int
        Masters of either kind.
    burst : int
        Most words of a burst.
    size : int
        Most words of a local burst.
    outstanding : int
        Bursts whose words may be on their way.

    Members
    -------
    write : In(WritePort(burst)).array(writers)
    read : In(ReadPort(burst)).array(readers)
    bus : Out(LocalBus())
    """
    def __init__(self, writers, readers, *, burst=16, size=1, outstanding=16):
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

    def elaborate(self, platform):
        m = Module()
        bus = self.bus
        masters = [*self.write, *self.read]
        writers = len(self.write)
        lengths = range(self.burst + 1)

        entry = data.StructLayout({"reader": range(len(self.read)), "length": lengths})
        m.submodules.owners = owners = Queue(entry, self.outstanding)

        # The burst under way: what of it is not on the bus yet.
        busy      = Signal()
        master    = Signal(range(len(masters)), reset_less=True)
        reading   = Signal(reset_less=True)
        address   = Signal(ADDRESS_BITS, reset_less=True)
        left      = Signal(lengths, reset_less=True)
        local     = Signal(range(self.size))                     # words of the local burst under way that follow
        part      = Signal(lengths)     # length of a local burst that begins now
        step      = Signal(lengths)     # words that one request stands for
        moves     = Signal()            # a request goes to the bus
        last      = Signal()            # with it nothing is left
        m.d.comb += [
            part.eq(Mux(left > self.size, self.size, left)),
            step.eq(Mux(reading, part, 1)),
            last.eq(left == step),
        ]

        # Round robin: masters beyond the one served last go first.
        asks   = Signal(len(masters))
        beyond = Signal(len(masters))
        grant  = Signal(len(masters))
        for number, port in enumerate(masters):
            m.d.comb += asks[number].eq(port.request.valid if number < writers else port.request.valid & owners.i.ready)
        with m.If(bus.init_done & (~busy | (moves & last))):
            m.d.comb += grant.eq(Mux((asks & beyond).any(), _lowest(asks & beyond), _lowest(asks)))
        with m.If(moves & last):
            m.d.sync += busy.eq(0)
        with m.If(grant.any()):
            m.d.sync += [busy.eq(1), beyond.eq(~(grant | (grant - 1)))]
        with m.If(moves):
            m.d.sync += [address.eq(address + step), left.eq(left - step)]
        for number, port in enumerate(masters):
            m.d.comb += port.request.ready.eq(grant[number])
            with m.If(grant[number]):
                m.d.sync += [master.eq(number), reading.eq(number >= writers)]
                m.d.sync += [address.eq(port.request.p.address), left.eq(port.request.p.length)]
                if number >= writers:
                    m.d.comb += [owners.i.p.reader.eq(number - writers), owners.i.p.length.eq(port.request.p.length), owners.i.valid.eq(1)]

        # Requests to the memory. They hold until ready; burstbegin does not.
        free = Signal()
        word = Signal(WriteWord())
        word_valid = Signal()
        with m.Switch(master):
            for number, port in enumerate(self.write):
                with m.Case(number):
                    m.d.comb += [word.eq(port.word.p), word_valid.eq(port.word.valid), port.word.ready.eq(moves & ~reading)]
        m.d.comb += [
            free.eq(bus.ready | ~(bus.read_req | bus.write_req)),
            moves.eq(free & busy & (reading | word_valid)),
        ]
        closes = Signal(writers)    # the word on the bus is the last of a writer's burst
        m.d.sync += bus.burstbegin.eq(0)
        with m.If(free):
            m.d.sync += [bus.read_req.eq(0), bus.write_req.eq(0)]
        with m.If(moves):
            m.d.sync += [bus.read_req.eq(reading), bus.write_req.eq(~reading), bus.wdata.eq(word.data), bus.be.eq(word.be)]
            m.d.sync += closes.eq(Mux(last, 1 << master, 0))
            with m.If(local == 0):
                m.d.sync += [bus.burstbegin.eq(1), bus.address.eq(address), bus.size.eq(part)]
                m.d.sync += local.eq(Mux(reading, 0, part - 1))
            with m.Else():
                m.d.sync += local.eq(local - 1)
        for number, port in enumerate(self.write):
            m.d.comb += port.accepted.eq(bus.write_req & bus.ready & closes[number])

        # Words that come back.
        owner = owners.o.p
        count = Signal(lengths)     # words of this burst that have come
        closing = Signal()
        m.d.comb += [closing.eq(count + 1 == owner.length), owners.o.ready.eq(bus.rdata_valid & closing)]
        with m.If(bus.rdata_valid):
            m.d.sync += count.eq(Mux(closing, 0, count + 1))
        for number, port in enumerate(self.read):
            m.d.comb += [
                port.rdata.eq(bus.rdata),
                port.rdata_valid.eq(bus.rdata_valid & (owner.reader == number)),
                port.rdata_last.eq(closing),
            ]
        return m
