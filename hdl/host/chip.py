"""The host's end of the line: a serial port, and the chip's registers with retries."""

import os
from typing import Protocol

from golden.config import METHODS, MatcherConfig
from golden.errors import UserError
from golden.host.blocks import PLANES, line_bytes
from golden.host.protocol import (
    CRC_BYTES,
    FRAME_BYTES,
    QUIET_SECONDS,
    Operation,
    Reply,
    Request,
    Status,
    decode_block,
    encode_request,
    first_reply,
)
from golden.host.registers import IDENTITY, VERSION, RegisterMap, register_map
from golden.rig.config import RigConfig


__all__ = ["Chip", "SerialPort", "Transport"]


class Transport(Protocol):
    """A line to the chip."""

    def write(self, data: bytes) -> None:
        """Send bytes."""

    def read(self, count: int, seconds: float) -> bytes:
        """Up to ``count`` bytes; fewer if the others are not received within ``seconds``."""


class SerialPort:
    """A serial port of this machine as a :class:`Transport`; closed when its context ends."""

    def __init__(self, port: str, baud: int) -> None:
        try:
            import serial
        except ImportError:
            raise UserError("the console needs pyserial, which is not installed; install it: pip install 'pyserial>=3.5,<4'") from None
        self.port = port
        try:
            self._line = serial.Serial(port, baud, exclusive=True)
        except (OSError, ValueError) as error:
            number = getattr(error, "errno", None)
            raise UserError(f"the serial port {port} cannot be opened: {os.strerror(number) if number else error}; "
                            "name the one that the line is plugged into with --port") from None

    def __enter__(self) -> "SerialPort":
        return self

    def __exit__(self, *_: object) -> None:
        self._line.close()

    def _lost(self, error: OSError) -> UserError:
        return UserError(f"the serial port {self.port} is lost: {error}; plug it in again")

    def write(self, data: bytes) -> None:
        try:
            self._line.write(data)
        except OSError as error:
            raise self._lost(error) from None

    def read(self, count: int, seconds: float) -> bytes:
        try:
            self._line.timeout = seconds
            return self._line.read(count)
        except OSError as error:
            raise self._lost(error) from None


class Chip:
    """The registers at the other end of a line; a request whose reply is lost or garbled is repeated.

    Parameters
    ----------
    transport : Transport
    answer_seconds : float
        Longest time until a reply.

    Attributes
    ----------
    registers : RegisterMap
        Register map of the system that answered.
    repeated : int
        Requests that were sent again. The chip may have carried out each attempt, which matters to an action.
    """
    ATTEMPTS = 4

    #: Bytes, noise among them, that are searched for a reply.
    NOISE_BYTES = 64

    def __init__(self, transport: Transport, answer_seconds: float = 0.2) -> None:
        self._transport = transport
        self._answer_seconds = answer_seconds
        self.repeated = 0
        self.registers: RegisterMap = register_map()
        identity, version = self.read("identity"), self.read("version")
        if identity != IDENTITY:
            raise UserError(f"the port's device is no stereo system: its identity is {identity}, not {IDENTITY}; choose another --port")
        if version != VERSION:
            raise UserError(f"the chip has version {version} of the register map, this console version {VERSION}; "
                            "use the console that came with the chip's build")
        disparities, lead, method, width, height, lines = (
            self.read(name) for name in ("disparities", "lead", "method", "width", "height", "rectify_lines"))
        methods = [MatcherConfig(disparities, width, minimum=-lead, method=kind()) for kind in METHODS.values()]
        if method >= len(methods):
            raise UserError(f"the chip has the method {method}, this console knows those from 0 to {len(methods) - 1}; "
                            "use the console that came with the chip's build")
        self.registers = register_map(methods[method], height, RigConfig(lines) if lines else None)

    def read(self, name: str) -> int:
        """The value of a register."""
        return self._value(name, Operation.READ, 0)

    def write(self, name: str, value: int) -> None:
        """Write a register."""
        self._value(name, Operation.WRITE, value)

    def _value(self, name: str, operation: Operation, value: int) -> int:
        register = self.registers[name]
        reply = self.transact(Request(operation, register.address, register.encode(value)))
        if reply.status is not Status.OK:
            raise UserError(f"the chip refuses to {operation.name.lower()} {name}: {reply.status.name.lower().replace('_', ' ')}; "
                            "use the console that came with the chip's build")
        return register.decode(reply.value)

    def block(self, plane: int, line: int) -> bytes:
        """A line of a kept picture, its bytes as :func:`golden.host.blocks.stored_line` has them.

        :class:`UserError` if the chip refuses, sends nothing, or sends it garbled each time.
        """
        request = Request(Operation.BLOCK, plane, line)
        reply, data = self._attempt(request, line_bytes(self.registers["width"].reset))
        if reply.status is not Status.OK:
            refused = reply.status.name.lower().replace("_", " ")
            raise UserError(f"the chip refuses to send line {line} of the {PLANES[plane]} picture: {refused}; set keep=1, and try again "
                            "once kept is yes")
        return data

    def transact(self, request: Request) -> Reply:
        """The chip's reply; :class:`UserError` if there is none, or only garbled ones."""
        return self._attempt(request)[0]

    def _attempt(self, request: Request, block_bytes: int = 0) -> tuple[Reply, bytes]:
        """The chip's reply, and the data of the block of so many bytes that follows it if it is ``OK``."""
        problems = []
        for attempt in range(self.ATTEMPTS):
            self._drop(QUIET_SECONDS if attempt else 0)
            self.repeated += attempt > 0
            self._transport.write(encode_request(request))
            reply, heard = self._listen()
            if reply is None:
                problems.append("garbled" if heard else "nothing")
            elif reply.status is Status.BAD_SUM:
                problems.append("bad sum")
            elif reply.address != request.address or (
                    reply.status is Status.OK and request.operation != Operation.READ and reply.value != request.value):
                problems.append("garbled")
            elif not block_bytes or reply.status is not Status.OK:
                return reply, b""
            elif (data := decode_block(request.address, request.value, self._receive(block_bytes + CRC_BYTES))) is not None:
                return reply, data
            else:
                problems.append("garbled block")
        if set(problems) == {"nothing"}:
            raise UserError(f"no answer in {self.ATTEMPTS} attempts of {self._answer_seconds:g} s; check the wires (TX to RX), the board's "
                            "power and --baud, or choose a longer --timeout")
        raise UserError(f"no good answer in {self.ATTEMPTS} attempts ({', '.join(problems)}); check the wires and --baud")

    def _receive(self, count: int) -> bytes:
        """So many bytes, or fewer if the next one is not received in time."""
        data = b""
        while len(data) < count and (more := self._transport.read(min(count - len(data), self.NOISE_BYTES), self._answer_seconds)):
            data += more
        return data

    def _drop(self, seconds: float) -> None:
        """Discard bytes until none is received for ``seconds``; gives up after a while, but not before a block has ended."""
        for _ in range(16 + line_bytes(self.registers["width"].reset) // self.NOISE_BYTES):
            if not self._transport.read(self.NOISE_BYTES, seconds):
                return

    def _listen(self) -> tuple[Reply | None, bool]:
        """A reply, if there is one, and whether any byte was received."""
        data = b""
        reply = None
        while reply is None and len(data) < self.NOISE_BYTES:
            more = self._transport.read(max(1, FRAME_BYTES - len(data)), self._answer_seconds)
            if not more:
                break
            data += more
            reply = first_reply(data)
        return reply, bool(data)
