"""I2C bus master."""

import enum

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.cdc import FFSynchronizer
from amaranth.lib.wiring import In, Out

from golden.video.setup_steps import Failure


__all__ = ["I2cCommand", "I2cMaster", "I2cResponse"]


class I2cCommand(data.StructLayout):
    """One byte on the bus.

    ``start``: a start condition before it, a repeated one if the bus is held. ``read``: the byte is read from the chip, and ``nack`` leaves
    it without acknowledge, as the last byte of a transfer must be; otherwise ``data`` is written to the chip. ``stop``: a stop condition
    after it.
    """
    def __init__(self) -> None:
        super().__init__({"data": 8, "start": 1, "read": 1, "nack": 1, "stop": 1})


class I2cResponse(data.StructLayout):
    """Result of a command: without a failure ``result`` is ``NONE``, and ``data`` the byte as it was on the bus."""
    def __init__(self) -> None:
        super().__init__({"data": 8, "result": Failure})


class _Kind(enum.Enum):
    """Purpose of a clock pulse."""
    START = 0
    BIT = 1
    STOP = 2
    RECOVERY = 3


class I2cMaster(wiring.Component):
    """I2C master for a bus without another master: standard mode, a byte a command, with clock stretching.

    Each command has one response, after the byte's acknowledge, or after the stop condition if there is one. Between the commands of a
    transfer SCL is held low.

    Failures: a byte without acknowledge is followed by a stop condition. SCL that stays low for ``stretch_seconds`` after it was released:
    ``CLOCK_HELD``, and both lines are released. SDA that is low where a one is sent, or at a repeated start: ``DATA_HELD``, and both lines
    are released. After any of these the bus is not held; a command without ``start`` is then not sent, and its result is
    ``NO_ACKNOWLEDGE``.

    Recovery: if SDA is low before the start of a transfer, a chip is out of step with its bits. Up to nine clock pulses are sent until it
    releases SDA, then a stop condition; then the transfer continues. If SDA is still low: ``DATA_HELD``.

    Timing, in cycles of ``clock_hz``, from the minima of standard mode (UM10204: low 4.7 us, high 4.0 us, start set-up 4.7 us and hold
    4.0 us, stop set-up 4.0 us, bus free 4.7 us, data set-up 250 ns): ``low`` and ``high`` are 54 % and 46 % of a period of
    ``bus_hz``, or the minimum; ``hold`` is 300 ns, the hold time of data after SCL's fall. SCL's high time counts from when it is seen
    high, without interruption, so a slow edge or clock stretching only lengthens a bit. Inputs are synchronised, 2 cycles late.

    Parameters
    ----------
    clock_hz : int
        Frequency of ``sync``; at least four times ``bus_hz``.
    bus_hz : int
        Greatest frequency of SCL, up to 100 kHz.
    stretch_seconds : float
        Longest time for which a chip may hold SCL low.

    Members
    -------
    i : In(stream.Signature(I2cCommand()))
    o : Out(stream.Signature(I2cResponse()))
    scl_low, sda_low : Out(1)
        Drive the line low (open drain).
    scl_i, sda_i : In(1)
        Levels of the lines, asynchronous.
    """
    def __init__(self, clock_hz: int, bus_hz: int = 100_000, *, stretch_seconds: float = 1e-3):
        if not 0 < bus_hz <= 100_000:
            raise ValueError(f"bus_hz must be from 1 to 100000, the limit of I2C's standard mode, not {bus_hz!r}")
        if clock_hz < 4 * bus_hz:
            raise ValueError(f"clock_hz must be at least four times bus_hz, {4 * bus_hz}, not {clock_hz!r}")
        if not stretch_seconds > 0:
            raise ValueError(f"stretch_seconds must be greater than 0, not {stretch_seconds!r}")

        def cycles(nanoseconds: int) -> int:
            return -(-nanoseconds * clock_hz // 10**9)

        period = -(-clock_hz // bus_hz)
        self.low = max(cycles(4_700), -(-54 * period // 100))
        self.high = max(cycles(4_000), period - self.low)
        self.hold = cycles(300)
        self.stretch = cycles(round(stretch_seconds * 1e9))
        super().__init__({
            "i": In(stream.Signature(I2cCommand())),
            "o": Out(stream.Signature(I2cResponse())),
            "scl_low": Out(1),
            "sda_low": Out(1),
            "scl_i": In(1, init=1),
            "sda_i": In(1, init=1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        scl = Signal(init=1)
        sda = Signal(init=1)
        m.submodules.scl_sync = FFSynchronizer(self.scl_i, scl, init=1)
        m.submodules.sda_sync = FFSynchronizer(self.sda_i, sda, init=1)

        command = Signal(I2cCommand(), reset_less=True)     # its data is the shift register
        result  = Signal(Failure, reset_less=True)
        kind    = Signal(_Kind)
        held    = Signal()                                  # between start and stop: SCL is low between commands
        bit     = Signal(range(9), reset_less=True)         # of the byte; 8 is the acknowledge
        pulses  = Signal(range(10), reset_less=True)        # clock pulses of a recovery
        timer   = Signal(range(max(self.low, self.high)))   # cycles left of this phase, less one
        stretch = Signal(range(self.stretch), reset_less=True)

        acknowledge = Signal()
        m.d.comb += acknowledge.eq(bit == 8)

        def begin(state: str, cycles: Value | int) -> None:
            m.d.sync += timer.eq(cycles - 1)
            m.next = state

        def fall(next_kind: Value | _Kind) -> None:
            """SCL falls; ``next_kind`` is the purpose of the next pulse."""
            m.d.sync += [self.scl_low.eq(1), kind.eq(next_kind)]
            begin("hold", self.hold)

        def rise() -> None:
            m.d.sync += [self.scl_low.eq(0), stretch.eq(self.stretch - 1)]
            m.next = "rise"

        def give_up(failure: Failure) -> None:
            m.d.sync += [self.scl_low.eq(0), self.sda_low.eq(0), held.eq(0), result.eq(failure)]
            m.next = "respond"

        m.d.comb += [self.o.p.data.eq(command.data), self.o.p.result.eq(result)]

        with m.If(timer != 0):
            m.d.sync += timer.eq(timer - 1)

        with m.FSM():
            with m.State("idle"):
                m.d.comb += self.i.ready.eq(1)
                m.d.sync += [command.eq(self.i.p), result.eq(Failure.NONE), bit.eq(0)]
                with m.If(self.i.valid):
                    with m.If(self.i.p.start & ~held):
                        m.d.sync += kind.eq(_Kind.START)
                        rise()
                    with m.Elif(held):
                        fall(Mux(self.i.p.start, _Kind.START, _Kind.BIT))
                    with m.Else():
                        give_up(Failure.NO_ACKNOWLEDGE)

            # SCL low: data hold, then change.
            with m.State("hold"):
                with m.If(timer == 0):
                    with m.Switch(kind):
                        with m.Case(_Kind.BIT):
                            with m.If(acknowledge):
                                m.d.sync += self.sda_low.eq(command.read & ~command.nack)
                            with m.Else():
                                m.d.sync += self.sda_low.eq(~command.read & ~command.data[7])
                        with m.Case(_Kind.STOP):
                            m.d.sync += self.sda_low.eq(1)
                        with m.Default():
                            m.d.sync += self.sda_low.eq(0)
                    begin("low", self.low - self.hold)
            with m.State("low"):
                with m.If(timer == 0):
                    rise()

            # SCL released: it may be stretched, or rise slowly.
            with m.State("rise"):
                with m.If(scl):
                    begin("high", Mux(kind == _Kind.START, self.low, self.high))
                with m.Elif(stretch == 0):
                    give_up(Failure.CLOCK_HELD)
                with m.Else():
                    m.d.sync += stretch.eq(stretch - 1)

            with m.State("high"):
                with m.If(~scl):
                    m.next = "rise"
                with m.Elif(timer == 0):
                    with m.Switch(kind):
                        with m.Case(_Kind.START):
                            with m.If(sda):
                                m.d.sync += self.sda_low.eq(1)
                                begin("start", self.high)
                            with m.Elif(held):
                                give_up(Failure.DATA_HELD)
                            with m.Else():
                                m.d.sync += pulses.eq(0)
                                fall(_Kind.RECOVERY)
                        with m.Case(_Kind.BIT):
                            with m.If(~acknowledge):
                                m.d.sync += [command.data.eq(Cat(sda, command.data[:-1])), bit.eq(bit + 1)]
                                with m.If(~command.read & ~self.sda_low & ~sda):
                                    give_up(Failure.DATA_HELD)
                                with m.Else():
                                    fall(_Kind.BIT)
                            with m.Else():
                                refused = ~command.read & sda
                                with m.If(refused):
                                    m.d.sync += result.eq(Failure.NO_ACKNOWLEDGE)
                                with m.If(refused | command.stop):
                                    fall(_Kind.STOP)
                                with m.Else():
                                    m.d.sync += self.scl_low.eq(1)
                                    m.next = "respond"
                        with m.Case(_Kind.STOP):
                            m.d.sync += self.sda_low.eq(0)
                            begin("free", self.low)
                        with m.Case(_Kind.RECOVERY):
                            m.d.sync += pulses.eq(pulses + 1)
                            fall(Mux(sda | (pulses == 8), _Kind.STOP, _Kind.RECOVERY))

            with m.State("start"):
                with m.If(timer == 0):
                    m.d.sync += held.eq(1)
                    fall(_Kind.BIT)

            # After a stop. At the end of a recovery there is none if the chip sends a zero in that bit.
            with m.State("free"):
                with m.If(timer == 0):
                    m.d.sync += held.eq(0)
                    with m.If(held):
                        m.next = "respond"
                    with m.Elif(sda):
                        m.d.sync += kind.eq(_Kind.START)
                        rise()
                    with m.Elif(pulses == 9):
                        give_up(Failure.DATA_HELD)
                    with m.Else():
                        fall(_Kind.RECOVERY)

            with m.State("respond"):
                m.d.comb += self.o.valid.eq(1)
                with m.If(self.o.ready):
                    m.next = "idle"
        return m
