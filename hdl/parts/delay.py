"""Registers and memories that delay: fixed delays, registers of a stream, an output's register."""

from amaranth import *
from amaranth.hdl import ShapeLike
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out


__all__ = ["NO_COLLISION", "CountedDelay", "Delay", "SkidRegister", "StreamRegister", "data_register"]


#: Attributes of a memory that is never read where it is written in the same cycle. A synthesiser that is not told adds a bypass, twice as
#: many registers as a word has bits, for devices whose memory blocks do not return the old word then.
NO_COLLISION = {"no_rw_check": 1}


class Delay(wiring.Component):
    """Delays every word by ``clocks`` cycles.

    Timing: one word a cycle, always. Short delays are flip-flops, and so are those with ``registers``. Longer ones are a memory, read one
    word ahead of where it is written, and a register behind it, because a memory block's read access is slow. Before the first word ``o``
    is undefined, or zero with ``clean``, which control bits need.

    Memory: ``clocks - 1`` words, one less with ``clean``, where the delay is longer than :attr:`LONGEST_IN_REGISTERS` cycles, unless
    ``registers``.

    Parameters
    ----------
    shape : shape-like
        Of a word.
    clocks : int
        Cycles, from 0.
    clean : bool
        ``o`` is zero after reset until the first word.
    registers : bool
        Flip-flops, however long.

    Members
    -------
    i : In(shape)
    o : Out(shape)
    """
    LONGEST_IN_REGISTERS = 4

    def __init__(self, shape: ShapeLike, clocks: int, *, clean: bool = False, registers: bool = False):
        if clocks < 0:
            raise ValueError(f"a delay must be at least 0 cycles, not {clocks!r}")
        self.shape = shape
        self.clocks = clocks
        self.clean = clean
        self.in_registers = registers or clocks <= self.LONGEST_IN_REGISTERS
        super().__init__({"i": In(shape), "o": Out(shape)})

    def elaborate(self, platform: object) -> Module:
        m = Module()
        if self.in_registers:
            word = self.i
            for stage in range(self.clocks):
                later = Signal(self.shape, name=f"stage_{stage}", reset_less=not self.clean)
                m.d.sync += later.eq(word)
                word = later
            m.d.comb += self.o.eq(word)
            return m

        depth = self.clocks - 1 - self.clean
        m.submodules.memory = memory = Memory(shape=self.shape, depth=depth, init=[], attrs=NO_COLLISION)
        read_port = memory.read_port()
        write_port = memory.write_port()
        read_index  = Signal(range(depth))
        write_index = Signal(range(depth), init=depth - 1)  # one behind `read_index`
        wrapped     = Signal()  # the word read in the cycle before had been written since reset
        m.d.sync += [read_index.eq(read_index + 1), write_index.eq(read_index)]
        with m.If(read_index == depth - 1):
            m.d.sync += [read_index.eq(0), wrapped.eq(1)]
        m.d.comb += [
            read_port.addr.eq(read_index), read_port.en.eq(1),
            write_port.addr.eq(write_index), write_port.data.eq(self.i), write_port.en.eq(1),
        ]
        later = Signal(self.shape, reset_less=True)
        m.d.sync += later.eq(read_port.data)
        m.d.comb += self.o.eq(later)
        if self.clean:
            # Behind a register of its own: the one above can be that of the memory block.
            written = Signal()
            cleaned = Signal(self.shape)
            m.d.sync += [written.eq(wrapped), cleaned.eq(Mux(written, Value.cast(later), 0))]
            m.d.comb += self.o.eq(cleaned)
        return m


class CountedDelay(wiring.Component):
    """A :class:`Delay` whose addresses derive from a counter, which several can share.

    Timing: one word a cycle, always; registers up to :attr:`Delay.LONGEST_IN_REGISTERS` cycles. Before the first word ``o`` is undefined,
    and so it is for ``clocks`` cycles after ``count`` did not advance by one.

    Memory: the power of two from ``clocks - 1`` words on.

    Parameters
    ----------
    shape : shape-like
        Of a word.
    clocks : int
        Cycles, from 0.
    count_bits : int
        Of ``count``, at least those of ``clocks - 2``.

    Members
    -------
    count : In(count_bits)
        One more each cycle, modulo its range.
    i : In(shape)
    o : Out(shape)
    """
    def __init__(self, shape: ShapeLike, clocks: int, count_bits: int):
        self.shape = shape
        self.clocks = clocks
        self.bits = max(clocks - 2, 0).bit_length()
        if self.bits > count_bits:
            raise ValueError(f"a delay of {clocks} cycles needs a counter of {self.bits} bits or more, not {count_bits!r}")
        super().__init__({"count": In(count_bits), "i": In(shape), "o": Out(shape)})

    def elaborate(self, platform: object) -> Module:
        m = Module()
        if self.clocks <= Delay.LONGEST_IN_REGISTERS:
            m.submodules.registers = registers = Delay(self.shape, self.clocks)
            m.d.comb += [registers.i.eq(self.i), self.o.eq(registers.o)]
            return m
        m.submodules.memory = memory = Memory(shape=self.shape, depth=1 << self.bits, init=[], attrs=NO_COLLISION)
        read_port = memory.read_port()
        write_port = memory.write_port()
        # A word is read `clocks - 2` cycles after it was written, and its address computed a cycle before.
        place = Signal(self.bits, reset_less=True)
        later = Signal(self.shape, reset_less=True)
        m.d.sync += [place.eq(self.count + (3 - self.clocks) % (1 << self.bits)), later.eq(read_port.data)]
        m.d.comb += [
            read_port.addr.eq(place), read_port.en.eq(1),
            write_port.addr.eq(self.count), write_port.data.eq(self.i), write_port.en.eq(1), self.o.eq(later),
        ]
        return m


class StreamRegister(wiring.Component):
    """Pipeline register of a stream; behind a memory it takes the read access out of the path that follows.

    Timing: latency 1 cycle, a word a cycle; ``i.ready`` depends combinationally on ``o.ready``.

    Members
    -------
    i : In(stream.Signature(shape))
    o : Out(stream.Signature(shape))
    """
    LATENCY = 1

    def __init__(self, shape: ShapeLike):
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape))})

    def elaborate(self, platform: object) -> Module:
        m = Module()
        payload = data_register(m, self.o.payload)
        m.d.comb += self.i.ready.eq(self.o.ready | ~self.o.valid)
        with m.If(self.i.ready):
            m.d.sync += [self.o.valid.eq(self.i.valid), payload.eq(self.i.payload)]
        return m


class SkidRegister(wiring.Component):
    """Pipeline register of a stream that ends the path of ``ready`` too: a second word waits where the first one stalls.

    Golden: the words that were accepted, in order.

    Timing: latency 1 cycle, a word a cycle; ``i.ready`` is a register.

    Members
    -------
    i : In(stream.Signature(shape))
    o : Out(stream.Signature(shape))
    """
    LATENCY = 1

    def __init__(self, shape: ShapeLike):
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape))})

    def elaborate(self, platform: object) -> Module:
        m = Module()
        payload = data_register(m, self.o.payload)
        waiting = Signal.like(self.i.payload, reset_less=True)
        ready   = Signal(init=1)  # no word waits
        m.d.comb += self.i.ready.eq(ready)
        with m.If(ready):
            m.d.sync += waiting.eq(self.i.payload)
        with m.If(self.o.ready | ~self.o.valid):
            m.d.sync += [self.o.valid.eq(self.i.valid | ~ready), payload.eq(Mux(ready, self.i.payload, waiting)), ready.eq(1)]
        with m.Elif(self.i.valid):
            m.d.sync += ready.eq(0)
        return m


def data_register(m: Module, port: Value, name: str | None = None) -> Signal:
    """A register without reset that drives an output. It holds data; another signal must tell when they are valid.

    An output that is assigned in a clock domain itself has a reset, as all members of an interface. Thousands of these would make the
    reset the net with the largest fan-out, for nothing.

    Parameters
    ----------
    m : Module
    port : Value
        Output of a component, or a field of one.
    name : str
        Of the register; that of the output by default, with ``_data`` behind it. A field has none.

    Returns
    -------
    Signal
        As wide as ``port``, to be assigned in a clock domain.
    """
    register = Signal.like(port, name=name or f"{Value.cast(port).name}_data", reset_less=True)
    m.d.comb += port.eq(register)
    return register
