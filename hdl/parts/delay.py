"""Registers and memories that delay: fixed delays, a stream's register, an output's register."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.memory import Memory
from amaranth.lib.wiring import In, Out


__all__ = ["NO_COLLISION", "Delay", "StreamRegister", "data_register"]


#: Attributes of a memory that is never read where it is written in the same cycle. A synthesiser that does not know it builds a way around
#: the memory, twice as many registers as a word has bits, for devices whose blocks do not give the old word then.
NO_COLLISION = {"no_rw_check": 1}


class Delay(wiring.Component):
    """Gives every word back ``clocks`` cycles later.

    Timing: one word a cycle, always. Short delays are flip-flops; longer ones are a memory, read a place ahead of where it is written, and
    a register behind it: a memory block is slow to give its word. What comes out before the first word is undefined, or zero with
    ``clean``: control bits need that.

    Memory: ``clocks - 1`` words where the delay is longer than :attr:`LONGEST_IN_REGISTERS` cycles.

    Parameters
    ----------
    shape : shape-like
        Of a word.
    clocks : int
        Cycles, from 0.
    clean : bool
        Zeros until the first word after reset comes out.

    Members
    -------
    i : In(shape)
    o : Out(shape)
    """
    LONGEST_IN_REGISTERS = 4

    def __init__(self, shape, clocks, *, clean=False):
        if clocks < 0:
            raise ValueError(f"a delay must be at least 0 cycles, not {clocks!r}")
        self.shape = shape
        self.clocks = clocks
        self.clean = clean
        super().__init__({"i": In(shape), "o": Out(shape)})

    def elaborate(self, platform):
        m = Module()
        if self.clocks <= self.LONGEST_IN_REGISTERS:
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
        place   = Signal(range(depth))
        written = Signal(range(depth), init=depth - 1)  # the place before
        around  = Signal()  # what was read in the cycle before had been written
        m.d.sync += [place.eq(place + 1), written.eq(place)]
        with m.If(place == depth - 1):
            m.d.sync += [place.eq(0), around.eq(1)]
        m.d.comb += [
            read_port.addr.eq(place), read_port.en.eq(1),
            write_port.addr.eq(written), write_port.data.eq(self.i), write_port.en.eq(1),
        ]
        later = Signal(self.shape, reset_less=not self.clean)
        m.d.sync += later.eq(read_port.data)
        if self.clean:
            with m.If(~around):
                m.d.sync += later.eq(0)
        m.d.comb += self.o.eq(later)
        return m


class StreamRegister(wiring.Component):
    """A word of a stream in registers: behind a memory, which is slow to give its word.

    Timing: latency 1 cycle, a word a cycle; ``i.ready`` depends combinationally on ``o.ready``.

    Members
    -------
    i : In(stream.Signature(shape))
    o : Out(stream.Signature(shape))
    """
    LATENCY = 1

    def __init__(self, shape):
        super().__init__({"i": In(stream.Signature(shape)), "o": Out(stream.Signature(shape))})

    def elaborate(self, platform):
        m = Module()
        payload = data_register(m, self.o.payload)
        m.d.comb += self.i.ready.eq(self.o.ready | ~self.o.valid)
        with m.If(self.i.ready):
            m.d.sync += [self.o.valid.eq(self.i.valid), payload.eq(self.i.payload)]
        return m


def data_register(m, port, name=None):
    """A register without reset that drives an output; what it holds is data, and something beside it tells whether it is valid.

    The register that an output itself would be has a reset, as all members of an interface. Thousands of them make the reset the net of
    the most pins, for nothing.

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
        As wide, to be assigned in a clock domain.
    """
    register = Signal.like(port, name=name or f"{Value.cast(port).name}_data", reset_less=True)
    m.d.comb += port.eq(register)
    return register
