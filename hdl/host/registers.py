"""Registers behind the serial line: the parameters that the host sets, the status and the counters that it reads."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.host.protocol import BAUD, FRAME_BYTES, FRAME_SECONDS, REPLY_SYNC, REQUEST_SYNC, Operation, Status
from golden.host.registers import COUNT_MAX, Kind, RegisterMap

from ..parts.uart import UartReceiver, UartTransmitter


__all__ = ["ActionLayout", "ParameterLayout", "RegisterFile", "SerialRegisters", "StatusLayout"]


# What the register file counts itself, and what clears it.
_ERRORS = "uart_errors"
_CLEAR = "clear_counters"


class ParameterLayout(data.StructLayout):
    """Each parameter under its name."""
    def __init__(self, registers: RegisterMap):
        super().__init__({register.name: register.width for register in registers.of(Kind.SETTING)})


class ActionLayout(data.StructLayout):
    """Each action under its name."""
    def __init__(self, registers: RegisterMap):
        super().__init__({register.name: 1 for register in registers.of(Kind.ACTION)})


class StatusLayout(data.StructLayout):
    """Each status and each counter that other blocks give, under its name."""
    def __init__(self, registers: RegisterMap):
        given = [register for register in registers.of(Kind.STATUS, Kind.COUNTER) if register.name != _ERRORS]
        super().__init__({register.name: register.width for register in given})


class RegisterFile(wiring.Component):
    """Answers requests; holds the parameters. Protocol and map: docs/registers.md.

    Golden: :func:`golden.host.registers.answer`.

    A request of six bytes begins with a sync byte; others before it are passed over. Its value is read, or written, in one cycle:
    16 bits are never torn. A request is dropped if its next byte does not come within ``timeout`` cycles, or if ``line_error`` says that a
    byte was lost; whatever the line has brought, what comes after such a silence is read from its beginning.

    ``uart_errors`` counts bytes passed over, bad sums, time-outs and line errors, one a cycle at most, stays at its greatest value, and is
    set to 0 by ``clear_counters``.

    Timing: a reply begins 3 cycles after the request's last byte is taken, with the value of the first of them, and leaves a byte a cycle;
    no byte is taken until all of it is. An action is high in the cycle before the reply begins; a parameter has its new value from the
    cycle after on. No combinational path from ``i`` to ``o`` or back.

    Parameters
    ----------
    registers : RegisterMap
        With ``uart_errors`` and ``clear_counters`` among them.
    timeout : int
        Cycles; what :data:`golden.host.protocol.FRAME_SECONDS` makes of the clock.

    Members
    -------
    i, o : stream.Signature(8)
        Bytes from and to the line.
    line_error : In(1)
        High for a cycle: a byte of the line was lost.
    params : Out(ParameterLayout(registers))
        May change in any cycle; to be sampled at a frame's start.
    actions : Out(ActionLayout(registers))
        High for one cycle each.
    status : In(StatusLayout(registers))
        May change in any cycle.
    errors : Out(range(COUNT_MAX + 1))
        What ``uart_errors`` reads as.
    """
    def __init__(self, registers: RegisterMap, timeout):
        if timeout < 2:
            raise ValueError(f"the time-out of the register file must be at least 2 cycles, not {timeout!r}")
        for name in (_ERRORS, _CLEAR):
            if name not in registers:
                raise ValueError(f"the register map has no {name}, which the register file is to serve; add it")
        self.registers = registers
        self.timeout = timeout
        super().__init__({
            "i": In(stream.Signature(8)),
            "o": Out(stream.Signature(8)),
            "line_error": In(1),
            "params": Out(ParameterLayout(registers), init={register.name: register.reset for register in registers.of(Kind.SETTING)}),
            "actions": Out(ActionLayout(registers)),
            "status": In(StatusLayout(registers)),
            "errors": Out(range(COUNT_MAX + 1)),
        })

    def _value(self, register):
        """What a read of ``register`` finds."""
        match register.kind:
            case Kind.CONSTANT:
                return register.reset
            case Kind.SETTING:
                return self.params[register.name]
            case Kind.ACTION:
                return 0
        return self.errors if register.name == _ERRORS else self.status[register.name]

    def elaborate(self, platform):
        m = Module()

        # The four bytes between sync and sum, of the request and then of the reply; `second` is the operation, then the status.
        frame    = Signal(data.StructLayout({"low": 8, "high": 8, "address": 8, "second": 8}), reset_less=True)
        bits     = Value.cast(frame)
        position = Signal(range(FRAME_BYTES))   # of the next byte, in or out
        total    = Signal(8)                    # of the bytes before it
        final    = Signal()
        added    = Signal(8)
        m.d.comb += final.eq(position == FRAME_BYTES - 1)

        # Counted: at most one a cycle.
        error  = Signal()
        with m.If(self.actions[_CLEAR]):
            m.d.sync += self.errors.eq(0)
        with m.Elif((error | self.line_error) & ~self.errors.all()):
            m.d.sync += self.errors.eq(self.errors + 1)

        # The register that the request names, a cycle later: address and value hold while the request is carried out.
        value    = Cat(frame.low, frame.high)
        found    = Signal(16, reset_less=True)
        known    = Signal(reset_less=True)
        writable = Signal(reset_less=True)
        in_range = Signal(reset_less=True)
        write    = Signal()
        m.d.sync += [known.eq(0), writable.eq(0)]
        with m.Switch(frame.address):
            for register in self.registers:
                with m.Case(register.address):
                    m.d.sync += [known.eq(1), found.eq(self._value(register))]
                    if register.writable:
                        above = value >= register.minimum if register.minimum else 1
                        m.d.sync += [writable.eq(1), in_range.eq(above & (value <= register.maximum))]
                    if register.kind is Kind.SETTING:
                        with m.If(write):
                            m.d.sync += self.params[register.name].eq(value)
                    elif register.kind is Kind.ACTION:
                        m.d.comb += self.actions[register.name].eq(write)

        silence = Signal(range(self.timeout))
        with m.FSM():
            with m.State("request"):
                m.d.comb += [self.i.ready.eq(1), added.eq(total + self.i.payload)]
                with m.If(self.i.valid):
                    m.d.sync += silence.eq(0)
                    with m.If((position == 0) & (self.i.payload != REQUEST_SYNC)):
                        m.d.comb += error.eq(1)
                    with m.Elif(final):
                        m.d.sync += [position.eq(0), total.eq(0)]
                        with m.If(added == 0):
                            m.next = "look up"
                        with m.Else():
                            m.d.comb += error.eq(1)
                            m.d.sync += [frame.second.eq(Status.BAD_SUM), frame.low.eq(0), frame.high.eq(0)]
                            m.next = "reply"
                    with m.Else():
                        m.d.sync += [position.eq(position + 1), total.eq(added), bits.eq(Cat(self.i.payload, bits[:-8]))]
                with m.Elif(self.line_error):
                    m.d.sync += [position.eq(0), total.eq(0)]
                with m.Elif(position != 0):
                    m.d.sync += silence.eq(silence + 1)
                    with m.If(silence == self.timeout - 1):
                        m.d.comb += error.eq(1)
                        m.d.sync += [position.eq(0), total.eq(0)]

            with m.State("look up"):
                m.next = "carry out"

            with m.State("carry out"):
                status = Signal(Status, init=Status.OK)
                reading = frame.second == Operation.READ
                with m.If(~reading & (frame.second != Operation.WRITE)):
                    m.d.comb += status.eq(Status.UNKNOWN_OPERATION)
                with m.Elif(~known):
                    m.d.comb += status.eq(Status.UNKNOWN_ADDRESS)
                with m.Elif(reading):
                    m.d.sync += [frame.low.eq(found[:8]), frame.high.eq(found[8:])]
                with m.Elif(~writable):
                    m.d.comb += status.eq(Status.READ_ONLY)
                with m.Elif(~in_range):
                    m.d.comb += status.eq(Status.OUT_OF_RANGE)
                with m.Else():
                    m.d.comb += write.eq(1)
                m.d.sync += frame.second.eq(status)
                with m.If(status != Status.OK):
                    m.d.sync += [frame.low.eq(0), frame.high.eq(0)]
                m.next = "reply"

            with m.State("reply"):
                m.d.comb += [self.o.valid.eq(1), added.eq(total + self.o.payload)]
                with m.If(position == 0):
                    m.d.comb += self.o.payload.eq(REPLY_SYNC)
                with m.Elif(final):
                    m.d.comb += self.o.payload.eq(-total)
                with m.Else():
                    m.d.comb += self.o.payload.eq(frame.second)
                with m.If(self.o.ready):
                    m.d.sync += [position.eq(position + 1), total.eq(added)]
                    with m.If(position != 0):
                        m.d.sync += bits.eq(bits << 8)
                    with m.If(final):   # `added` is 0: that is what the sum is for
                        m.d.sync += position.eq(0)
                        m.next = "request"
        return m


class SerialRegisters(wiring.Component):
    """The register file on its serial line: receiver, :class:`RegisterFile`, transmitter.

    Golden: :func:`golden.host.registers.answer`, in the bytes of :mod:`golden.host.protocol`.

    Timing: a request and its reply take 120 bits, 1.04 ms at 115,200 baud. A byte that comes while a reply is sent waits in the receiver; a
    second one is lost and counted.

    Parameters
    ----------
    registers : RegisterMap
    clock_hz, baud : int
        As of :class:`hdl.parts.uart.UartReceiver`.
    frame_seconds : float
        Longest silence within a request.

    Members
    -------
    rx : In(1), tx : Out(1)
        The pins.
    params, actions, status
        As of :class:`RegisterFile`.
    """
    def __init__(self, registers: RegisterMap, clock_hz, baud=BAUD, *, frame_seconds=FRAME_SECONDS):
        self.receiver = UartReceiver(clock_hz, baud)
        self.register_file = RegisterFile(registers, round(clock_hz * frame_seconds))
        self.transmitter = UartTransmitter(clock_hz, baud)
        members = self.register_file.signature.members
        super().__init__({
            "rx": In(1, init=1),
            "tx": Out(1, init=1),
            **{name: members[name] for name in ("params", "actions", "status")},
        })

    def elaborate(self, platform):
        m = Module()
        m.submodules.receiver = receiver = self.receiver
        m.submodules.register_file = register_file = self.register_file
        m.submodules.transmitter = transmitter = self.transmitter
        wiring.connect(m, receiver.o, register_file.i)
        wiring.connect(m, register_file.o, transmitter.i)
        m.d.comb += [
            receiver.rx.eq(self.rx), self.tx.eq(transmitter.tx),
            register_file.line_error.eq(receiver.framing_error | receiver.overrun),
            self.params.eq(register_file.params), self.actions.eq(register_file.actions), register_file.status.eq(self.status),
        ]
        return m
