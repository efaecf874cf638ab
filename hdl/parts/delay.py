"""Registers and memories that delay: fixed delays, a stream's register, an output's register."""

from amaranth import *
from amaranth.hdl import ShapeLike
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out


__all__ = ["NO_COLLISION", "Delay", "StreamRegister", "data_register"]


#: Attributes of a memory that is never read where it is written in the same cycle. A synthesiser that is not told adds a bypass, twice as
#: many registers as a word has bits, for devices whose memory blocks do not return the old word then.
NO_COLLISION = {"no_rw_check": 1}


class Delay(wiring.Component):
    """Delays every word by ``clocks`` cycles.

    Timing: one word a cycle, always. Short delays are flip-flops, and so are those with ``registers``. Longer ones are a memory, read one
    word ahead of where it is written, and a register behind it, because a memory block's read access is slow. Before the first word ``o``
    is undefined, or zero with ``clean``, which control bits need.

    Memory: ``clocks - 1`` words where the delay is longer than :attr:`LONGEST_IN_REGISTERS` cycles, unless ``registers``.

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

        depth = self.clocks - 1
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
        later = Signal(self.shape, reset_less=not self.clean)
        m.d.sync += later.eq(read_port.data)
        if self.clean:
            with m.If(~wrapped):
                m.d.sync += later.eq(0)
        m.d.comb += self.o.eq(later)
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
