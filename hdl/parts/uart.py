"""UART: receiver and transmitter of bytes, eight data bits, no parity, one stop bit."""

from amaranth import *
from amaranth.lib import stream, wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out

from golden.host.protocol import BAUD


__all__ = ["TOLERANCE", "UartReceiver", "UartTransmitter"]


#: Mismatch of the two ends' baud rates that is tolerated.
TOLERANCE = 0.03

# Bits from the start edge of a byte to the middle of its stop bit, and to its end.
_BITS_TO_STOP = 9.5
_BITS = 10


class _BitTiming:
    """Cycles of a bit, and the tolerance that follows, as :class:`UartReceiver` derives it, less what rounding the cycles costs."""
    def __init__(self, clock_hz: int, baud: int):
        self.cycles = cycles = round(clock_hz / baud)
        self.filtered = cycles // 16
        self.apart = cycles // 8
        if cycles >= 16:
            late = (0.5 - (1 + 2 * self.filtered) / cycles) / _BITS_TO_STOP
            early = _BITS / (_BITS_TO_STOP + self.apart / cycles) - 1
            self.tolerance = min(late, early) - abs(cycles * baud / clock_hz - 1)
        if cycles < 16 or self.tolerance < TOLERANCE:
            raise ValueError(f"a clock of {clock_hz} Hz does not divide into {baud} baud: a bit must be 16 cycles or more, near a whole "
                             f"number, not {clock_hz / baud:.2f}; choose another baud")


class UartReceiver(wiring.Component):
    """Bytes from a serial line, least significant bit first, with a filter for noise on the line.

    Golden: the bytes that were sent.

    Noise: a pulse of up to a sixteenth of a bit has no effect, wherever it is: an up-down counter that follows the line must run from one
    end to the other before the level counts as changed. A start bit is confirmed in its middle. Each bit is the majority of three samples
    around its middle, an eighth of a bit apart: within a bit a pulse of an eighth has no effect either.

    Errors: a byte without a stop bit is dropped, and ``framing_error`` is raised; the line must then be high before the next byte. A byte
    that is complete while the one before it has not been accepted is dropped, and ``overrun`` is raised: a line has no back-pressure.

    Rate: the other end may be off by 3 % (:data:`TOLERANCE`) with pulses of a sixteenth anywhere. A bit is sampled in its middle, counted
    from the start edge of its byte. The stop bit is the worst case: its middle is 9.5 bits after that edge and must be less than half a
    bit off. The edge is seen up to a cycle late, and a pulse next to it shifts it by up to twice the pulse's length: 9.5 times the
    mismatch must fit in ``1/2 - 1/8`` bit less a cycle. And the last sample of the stop bit, at 9 5/8 bits, must not be after the bit's
    end, at 10 bits of a faster host, or the start edges of back-to-back bytes would be found later and later. Either gives 3.9 % at
    75 MHz and 115,200 baud.

    Timing: ``o`` is valid 11/16 of a bit and 4 cycles after the stop bit begins.

    Parameters
    ----------
    clock_hz : int
        Frequency of ``sync``; at least 16 cycles a bit.
    baud : int
        Bits a second.

    Members
    -------
    rx : In(1)
        The pin; asynchronous, synchronised here.
    o : Out(stream.Signature(8))
    framing_error, overrun : Out(1)
        High for one cycle.
    """
    def __init__(self, clock_hz: int, baud: int = BAUD):
        self._timing = _BitTiming(clock_hz, baud)
        super().__init__({
            "rx": In(1, init=1),
            "o": Out(stream.Signature(8)),
            "framing_error": Out(1),
            "overrun": Out(1),
        })

    @property
    def bit_cycles(self) -> int:
        """Cycles of a bit."""
        return self._timing.cycles

    @property
    def filtered_cycles(self) -> int:
        """Longest pulse that has no effect, wherever it is, in cycles."""
        return self._timing.filtered

    @property
    def tolerance(self) -> float:
        """Mismatch of baud rates that is tolerated with such pulses on the line; a fraction."""
        return self._timing.tolerance

    def elaborate(self, platform: object) -> Module:
        m = Module()
        line = Signal(init=1)
        m.submodules.synchronizer = FFSynchronizer(self.rx, line, init=1)

        # Filtered level. Both edges are delayed alike, so the delay does not matter.
        lean  = Signal(range(self.filtered_cycles + 1), init=self.filtered_cycles)
        level = Signal(init=1)
        with m.If(line):
            with m.If(lean == self.filtered_cycles):
                m.d.sync += level.eq(1)
            with m.Else():
                m.d.sync += lean.eq(lean + 1)
        with m.Else():
            with m.If(lean == 0):
                m.d.sync += level.eq(0)
            with m.Else():
                m.d.sync += lean.eq(lean - 1)

        # `phase` counts cycles since the bit began.
        phase    = Signal(range(self.bit_cycles))
        bit      = Signal(range(10))
        samples  = Signal(2, reset_less=True)
        majority = Signal()
        decide   = Signal()
        middle   = self.bit_cycles // 2
        apart    = self._timing.apart
        m.d.comb += [
            majority.eq((samples[0] & samples[1]) | (samples[0] & level) | (samples[1] & level)),
            decide.eq(phase == middle + apart),
        ]
        with m.If((phase == middle - apart) | (phase == middle)):
            m.d.sync += samples.eq(Cat(level, samples))

        shift = Signal(8, reset_less=True)
        done  = Signal()
        with m.FSM():
            with m.State("idle"):
                with m.If(~level):
                    m.d.sync += [phase.eq(1), bit.eq(0)]
                    m.next = "byte"

            with m.State("byte"):
                m.d.sync += phase.eq(phase + 1)
                with m.If(phase == self.bit_cycles - 1):
                    m.d.sync += [phase.eq(0), bit.eq(bit + 1)]
                with m.If(decide):
                    with m.If(bit == 9):
                        with m.If(majority):
                            m.d.comb += done.eq(1)
                            m.next = "idle"
                        with m.Else():
                            m.d.comb += self.framing_error.eq(1)
                            m.next = "wait for high"
                    with m.Elif(bit != 0):
                        m.d.sync += shift.eq(Cat(shift[1:], majority))
                    with m.Elif(majority):
                        m.next = "idle"

            with m.State("wait for high"):
                with m.If(level):
                    m.next = "idle"

        with m.If(self.o.ready):
            m.d.sync += self.o.valid.eq(0)
        with m.If(done):
            with m.If(self.o.valid & ~self.o.ready):
                m.d.comb += self.overrun.eq(1)
            with m.Else():
                m.d.sync += [self.o.valid.eq(1), self.o.payload.eq(shift)]
        return m


class UartTransmitter(wiring.Component):
    """Bytes onto a serial line, least significant bit first.

    Golden: for each byte a start bit, low, its eight bits, and a stop bit, high; the line is high between bytes.

    Timing: the start bit begins in the cycle after the byte is accepted. A byte takes 10 bits; one that waits follows without a gap.
    ``i.ready`` does not depend on ``i.valid``.

    Parameters
    ----------
    clock_hz, baud : int
        As of :class:`UartReceiver`.

    Members
    -------
    i : In(stream.Signature(8))
    tx : Out(1)
        The pin, from a flip-flop.
    """
    def __init__(self, clock_hz: int, baud: int = BAUD):
        self._timing = _BitTiming(clock_hz, baud)
        super().__init__({"i": In(stream.Signature(8)), "tx": Out(1, init=1)})

    @property
    def bit_cycles(self) -> int:
        """Cycles of a bit."""
        return self._timing.cycles

    def elaborate(self, platform: object) -> Module:
        m = Module()
        phase = Signal(range(self.bit_cycles))  # 0 between bytes
        bits  = Signal(range(11))           # left to send, with the one on the line
        rest  = Signal(9, reset_less=True)  # those after it
        last  = Signal()                    # last cycle of a bit
        m.d.comb += [
            last.eq(phase == self.bit_cycles - 1),
            self.i.ready.eq((bits == 0) | ((bits == 1) & last)),
        ]
        with m.If(bits != 0):
            m.d.sync += phase.eq(phase + 1)
            with m.If(last):
                m.d.sync += [phase.eq(0), bits.eq(bits - 1), Cat(self.tx, rest).eq(Cat(rest, 1))]
        with m.If(self.i.valid & self.i.ready):
            m.d.sync += [bits.eq(10), self.tx.eq(0), rest.eq(Cat(self.i.payload, 1))]
        return m
