"""The host's registers and their serial line: settings that the host writes, status and counters that it reads."""

from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out

from golden.host.blocks import line_bytes
from golden.host.protocol import BAUD, FRAME_BYTES, FRAME_SECONDS, REPLY_SYNC, REQUEST_SYNC, Operation, Status
from golden.host.registers import COUNT_MAX, RegisterMap

from ..parts.uart import UartReceiver, UartTransmitter
from .block_write import BlockWrite
from .blocks import BlockPort, BlockRead, BlockWritePort, LineByte, LineRequest
from .pair_lines import PairLines
from .register_file import AccessPort, RegisterFile, StatusLayout


__all__ = ["ByteRegisters", "RequestReader", "SerialRegisters"]


# The counter that the protocol contains, and the action that clears it.
_ERRORS = "uart_errors"
_CLEAR = "clear_counters"

# The status that the line knows itself.
_WHOLE = "pair_whole"


class RequestReader(wiring.Component):
    """The protocol of docs/registers.md: requests in, accesses to a register file, replies out.

    Golden: :func:`golden.host.registers.answer`; of a block read :func:`golden.host.blocks.block_answer`, with ``block``. With ``writes``
    :class:`golden.host.device.SerialDevice`.

    A request of six bytes begins with a sync byte; bytes before it are skipped. Its value is read, or written, in one cycle: all 16 bits
    are of the same moment. A request is dropped if its next byte is not received within ``timeout`` cycles, or if ``line_error`` tells that
    a byte was lost; after such a pause the next byte is the first one of a request.

    ``errors`` counts skipped bytes, bad sums, time-outs and line errors, at most one a cycle, holds its greatest value, and is set to 0 by
    ``clear``.

    With ``writes``, blocks are received, too, and a host may send one after the other without waiting for replies. Pixels must then not be
    taken for requests: after each of these errors, an unknown operation, a refused block write and a bad block, bytes are ignored until
    none is received for ``timeout`` cycles. The reply to a block that is cut short, or whose CRC is wrong, is a bad sum.

    Timing: a reply begins 3 cycles after the request's last byte was accepted, with the value of the first of these cycles, and is sent a
    byte a cycle; no byte is accepted until all of it is sent, with its block. An action is high in the cycle before the reply begins; a
    setting changes in the cycle after. There is no combinational path from ``i`` to ``o`` or back.

    Parameters
    ----------
    timeout : int
        Cycles; :data:`golden.host.protocol.FRAME_SECONDS` at the clock's frequency.
    writes : bool
        With block writes.

    Members
    -------
    i, o : stream.Signature(8)
        Bytes from and to the line.
    line_error : In(1)
        One cycle: a byte of the line was lost.
    access : Out(AccessPort(16))
        To the :class:`hdl.host.register_file.RegisterFile`.
    clear : In(1)
    errors : Out(range(COUNT_MAX + 1))
    block : Out(BlockPort())
        To the component that carries out block reads.
    put : Out(BlockWritePort())
        To the component that carries out block writes; with ``writes`` only.
    """
    def __init__(self, timeout: int, *, writes: bool = False):
        if timeout < 2:
            raise ValueError(f"the time-out of a request must be at least 2 cycles, not {timeout!r}")
        self.timeout = timeout
        self.writes = writes
        super().__init__({
            "i": In(stream.Signature(8)),
            "o": Out(stream.Signature(8)),
            "line_error": In(1),
            "access": Out(AccessPort(16)),
            "clear": In(1),
            "errors": Out(range(COUNT_MAX + 1)),
            "block": Out(BlockPort()),
            **({"put": Out(BlockWritePort())} if writes else {}),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        writes = self.writes
        silence = Signal(range(self.timeout))
        ignores = Signal()      # after the reply, with `writes`

        def resynchronise() -> None:
            """In a state of the reader: bytes are ignored until a pause."""
            if writes:
                m.d.sync += silence.eq(0)
                m.next = "ignore"

        # The four bytes between sync and sum, of the request and then of the reply; `second` is the operation, then the status.
        frame    = Signal(data.StructLayout({"low": 8, "high": 8, "address": 8, "second": 8}), reset_less=True)
        bits     = Value.cast(frame)
        position = Signal(range(FRAME_BYTES))   # of the next byte, in or out
        total    = Signal(8)                    # of the bytes before it
        final    = Signal()
        added    = Signal(8)
        m.d.comb += final.eq(position == FRAME_BYTES - 1)

        # Errors: at most one a cycle is counted.
        error  = Signal()
        with m.If(self.clear):
            m.d.sync += self.errors.eq(0)
        with m.Elif((error | self.line_error) & ~self.errors.all()):
            m.d.sync += self.errors.eq(self.errors + 1)

        # Address and value hold while the request is carried out.
        value  = Cat(frame.low, frame.high)
        access = self.access
        m.d.comb += [access.address.eq(frame.address), access.value.eq(value), access.write.eq(frame.second == Operation.WRITE)]

        block   = self.block
        follows = Signal()      # a block follows the reply
        m.d.comb += [block.plane.eq(frame.address), block.line.eq(value)]

        with m.FSM():
            with m.State("request"):
                m.d.comb += [self.i.ready.eq(1), added.eq(total + self.i.payload)]
                with m.If(self.i.valid):
                    m.d.sync += silence.eq(0)
                    with m.If((position == 0) & (self.i.payload != REQUEST_SYNC)):
                        m.d.comb += error.eq(1)
                        resynchronise()
                    with m.Elif(final):
                        m.d.sync += [position.eq(0), total.eq(0)]
                        with m.If(added == 0):
                            m.next = "look up"
                        with m.Else():
                            m.d.comb += error.eq(1)
                            m.d.sync += [frame.second.eq(Status.BAD_SUM), frame.low.eq(0), frame.high.eq(0)]
                            if writes:
                                m.d.sync += ignores.eq(1)
                            m.next = "reply"
                    with m.Else():
                        m.d.sync += [position.eq(position + 1), total.eq(added), bits.eq(Cat(self.i.payload, bits[:-8]))]
                with m.Elif(self.line_error):
                    m.d.sync += [position.eq(0), total.eq(0)]
                    resynchronise()
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
                with m.If(frame.second == Operation.BLOCK):
                    m.d.comb += [status.eq(block.status), block.start.eq(block.status == Status.OK)]
                    m.d.sync += follows.eq(block.start)
                if writes:
                    with m.Elif(frame.second == Operation.BLOCK_WRITE):
                        m.d.comb += [status.eq(self.put.status), self.put.start.eq(self.put.status == Status.OK)]
                        m.d.sync += ignores.eq(~self.put.start)
                with m.Elif(~reading & (frame.second != Operation.WRITE)):
                    m.d.comb += status.eq(Status.UNKNOWN_OPERATION)
                    if writes:
                        m.d.sync += ignores.eq(1)
                with m.Else():
                    m.d.comb += [status.eq(access.status), access.commit.eq(1)]
                    with m.If(reading):
                        m.d.sync += Cat(frame.low, frame.high).eq(access.found)
                m.d.sync += frame.second.eq(status)
                with m.If(status != Status.OK):
                    m.d.sync += [frame.low.eq(0), frame.high.eq(0)]
                m.next = "reply"
                if writes:
                    with m.If(self.put.start):
                        m.next = "data"

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
                    with m.If(final):   # `added` is 0 modulo 256, as the sum byte makes it
                        m.d.sync += position.eq(0)
                        m.next = "request"
                        with m.If(follows):
                            m.next = "block"
                        if writes:
                            with m.Elif(ignores):
                                m.next = "ignore"

            with m.State("block"):
                m.d.sync += follows.eq(0)
                m.d.comb += [self.o.valid.eq(block.byte.valid), self.o.payload.eq(block.byte.p.value), block.byte.ready.eq(self.o.ready)]
                with m.If(block.byte.valid & block.byte.p.last & self.o.ready):
                    m.next = "request"

            if writes:
                self._write_states(m, frame, value, silence, ignores, error)
        return m

    def _write_states(self, m: Module, frame: data.View, value: Value, silence: Signal, ignores: Signal, error: Signal) -> None:
        """The states in which the data of a block are received, and in which bytes are ignored."""
        put = self.put
        quiet = silence == self.timeout - 1
        m.d.comb += [put.plane.eq(frame.address), put.line.eq(value), put.byte.payload.eq(self.i.payload)]
        with m.State("data"):
            m.d.comb += [put.byte.valid.eq(self.i.valid), self.i.ready.eq(put.byte.ready)]
            with m.If(self.i.valid):
                m.d.sync += silence.eq(0)
            with m.Elif(put.byte.ready):    # not while a line is stored
                m.d.sync += silence.eq(silence + 1)
                m.d.comb += put.cancel.eq(self.line_error | quiet)
            with m.If(put.done | put.cancel):
                m.d.sync += silence.eq(0)
                m.next = "reply"
            with m.If(put.cancel | (put.done & ~put.good)):
                m.d.comb += error.eq(1)
                # After the time-out the pause has been already.
                m.d.sync += [frame.second.eq(Status.BAD_SUM), frame.low.eq(0), frame.high.eq(0), ignores.eq(~(put.cancel & quiet))]

        with m.State("ignore"):
            m.d.comb += self.i.ready.eq(1)
            m.d.sync += [ignores.eq(0), silence.eq(silence + 1)]
            with m.If(self.i.valid | self.line_error):
                m.d.sync += silence.eq(0)
            with m.Elif(quiet):
                m.next = "request"


class ByteRegisters(wiring.Component):
    """A register file with its protocol: :class:`RequestReader` in front of :class:`hdl.host.register_file.RegisterFile`.

    Golden: :func:`golden.host.registers.answer`; of a block read :func:`golden.host.blocks.block_answer`, with ``block``.

    Parameters
    ----------
    registers : RegisterMap
        Must contain ``uart_errors`` and ``clear_counters``.
    timeout : int
        As of :class:`RequestReader`.
    writes : bool
        As of :class:`RequestReader`.

    Members
    -------
    i, o, line_error, errors, block, put
        As of :class:`RequestReader`; ``errors`` is the register ``uart_errors``, which ``clear_counters`` sets to 0.
    settings, actions
        As of :class:`RegisterFile`.
    status : In(StatusLayout(registers, ["uart_errors"]))
        As of :class:`RegisterFile`.
    """
    def __init__(self, registers: RegisterMap, timeout: int, *, writes: bool = False):
        for name in (_ERRORS, _CLEAR):
            if name not in registers:
                raise ValueError(f"the register map has no {name}, which the protocol needs; add it")
        self.timeout = timeout
        self.writes = writes
        self.reader = RequestReader(timeout, writes=writes)
        self.register_file = RegisterFile(registers)
        of_reader, of_file = self.reader.signature.members, self.register_file.signature.members
        super().__init__({
            **{name: of_reader[name] for name in ("i", "o", "line_error", "errors", "block", *(["put"] if writes else []))},
            **{name: of_file[name] for name in ("settings", "actions")},
            "status": In(StatusLayout(registers, [_ERRORS])),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.reader = reader = self.reader
        m.submodules.register_file = register_file = self.register_file
        wiring.connect(m, wiring.flipped(self.i), reader.i)
        wiring.connect(m, reader.o, wiring.flipped(self.o))
        wiring.connect(m, reader.block, wiring.flipped(self.block))
        if self.writes:
            wiring.connect(m, reader.put, wiring.flipped(self.put))
        wiring.connect(m, reader.access, register_file.access)
        m.d.comb += [
            reader.line_error.eq(self.line_error), reader.clear.eq(register_file.actions[_CLEAR]), self.errors.eq(reader.errors),
            self.settings.eq(register_file.settings), self.actions.eq(register_file.actions),
            *(register_file.status[name].eq(self.status[name]) for name in self.status.shape().members),
            register_file.status[_ERRORS].eq(reader.errors),
        ]
        return m


class SerialRegisters(wiring.Component):
    """The register file with its serial line: receiver, :class:`ByteRegisters`, blocks in either direction, transmitter.

    Golden: :class:`golden.host.camera_device.CameraDevice`.

    Lines of the host's pair are accepted in their order (:class:`hdl.host.pair_lines.PairLines`) while ``source`` is the host and ``keep``
    is not set; ``start_pair`` has effect once all of them are stored.

    Timing: a request and its reply take 120 bits, 1.04 ms at 115,200 baud, a block, read or written,
    :func:`golden.host.protocol.block_bits`. A byte received while a reply is sent, or a line is stored, waits in the receiver; a
    second one is lost and counted.

    Memory: a line.

    Parameters
    ----------
    registers : RegisterMap
        ``width`` and ``height`` determine the lines of blocks; the status ``kept`` tells that they can be read.
    clock_hz, baud : int
        As of :class:`hdl.parts.uart.UartReceiver`.
    frame_seconds : float
        Longest pause within a request.

    Members
    -------
    rx : In(1), tx : Out(1)
        The pins.
    settings, actions
        As of :class:`ByteRegisters`.
    status
        As of :class:`ByteRegisters`, without ``pair_whole``.
    line : Out(stream.Signature(LineRequest()))
        A line of the kept pictures is wanted.
    byte : In(stream.Signature(LineByte()))
        Its bytes.
    put : Out(stream.Signature(LineByte()))
        Bytes of a line of the host's pair.
    put_plane : Out(1), put_line : Out(16)
        Which line that is; hold from the cycle before its first byte to the last one.
    putting : In(1)
        The host's pair is being read, or will be: no line of it is accepted.
    start_pair : Out(1)
        One cycle: the host's pair, which is whole, is to be matched.
    """
    def __init__(self, registers: RegisterMap, clock_hz: int, baud: int = BAUD, *, frame_seconds: float = FRAME_SECONDS):
        height = registers["height"].reset
        self.length = line_bytes(registers["width"].reset)
        self.receiver = UartReceiver(clock_hz, baud)
        self.register_file = ByteRegisters(registers, round(clock_hz * frame_seconds), writes=True)
        self.block_read = BlockRead(height)
        self.block_write = BlockWrite(self.length, height)
        self.pair_lines = PairLines(height)
        self.transmitter = UartTransmitter(clock_hz, baud)
        members = self.register_file.signature.members
        super().__init__({
            "rx": In(1, init=1),
            "tx": Out(1, init=1),
            **{name: members[name] for name in ("settings", "actions")},
            "status": In(StatusLayout(registers, [_ERRORS, _WHOLE])),
            "line": Out(stream.Signature(LineRequest())),
            "byte": In(stream.Signature(LineByte())),
            "put": Out(stream.Signature(LineByte())),
            "put_plane": Out(1),
            "put_line": Out(16),
            "putting": In(1),
            "start_pair": Out(1),
        })

    def elaborate(self, platform: object) -> Module:
        m = Module()
        m.submodules.receiver = receiver = self.receiver
        m.submodules.register_file = register_file = self.register_file
        m.submodules.transmitter = transmitter = self.transmitter
        m.submodules.block_read = block_read = self.block_read
        m.submodules.block_write = block_write = self.block_write
        m.submodules.pair_lines = pair_lines = self.pair_lines
        wiring.connect(m, receiver.o, register_file.i)
        wiring.connect(m, register_file.put, block_write.port)
        wiring.connect(m, block_write.o, wiring.flipped(self.put))
        wiring.connect(m, register_file.block, block_read.port)
        wiring.connect(m, block_read.request, wiring.flipped(self.line))
        wiring.connect(m, wiring.flipped(self.byte), block_read.i)
        wiring.connect(m, register_file.o, transmitter.i)
        m.d.comb += [
            receiver.rx.eq(self.rx), self.tx.eq(transmitter.tx),
            register_file.line_error.eq(receiver.framing_error | receiver.overrun),
            self.settings.eq(register_file.settings), self.actions.eq(register_file.actions),
            *(register_file.status[name].eq(self.status[name]) for name in self.status.shape().members),
            register_file.status[_WHOLE].eq(pair_lines.whole), block_read.kept.eq(self.status.kept),
        ]
        port, settings = register_file.put, register_file.settings
        m.d.comb += [
            block_write.length.eq(self.length), self.put_plane.eq(port.plane), self.put_line.eq(port.line),
            pair_lines.plane.eq(port.plane), pair_lines.line.eq(port.line), pair_lines.stored.eq(port.done & port.good),
            block_write.refuse.eq(settings.keep | ~settings.source | self.putting | ~pair_lines.accepts),
            self.start_pair.eq(register_file.actions.start_pair & pair_lines.whole),
        ]
        return m
