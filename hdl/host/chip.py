"""The host's end of the line: a serial port, and the chip's registers with retries."""

import contextlib
import errno
import os
from collections.abc import Sequence
from typing import Protocol

from golden.config import METHODS, MatcherConfig
from golden.errors import UserError
from golden.host.blocks import PLANES
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
from golden.host.registers import Kind, RegisterMap, register_map
from golden.host.systems import SYSTEMS


__all__ = ["Chip", "SerialPort", "Transport"]


#: What is wrong where no byte was received.
NOTHING = "nothing"


class Transport(Protocol):
    """A line to the chip."""

    def write(self, data: bytes) -> None:
        """Send bytes."""

    def read(self, count: int, seconds: float) -> bytes:
        """Up to ``count`` bytes; fewer if the others are not received within ``seconds``."""


# Why a port cannot be opened, and what helps, by the number of the error; 0 is any other.
_REFUSALS = {
    errno.ENOENT: ("there is no such port", "{option} names the one that the line is plugged into, and python -m serial.tools.list_ports "
                   "lists them"),
    errno.EACCES: ("permission denied", "ask for the rights of its group, such as with usermod -aG dialout, and log in again"),
    errno.EAGAIN: ("another program has it open", "end that program"),
    errno.EBUSY: ("another program has it open", "end that program"),
    0: ("{error}", "name the one that the line is plugged into with {option}"),
}

# Longest time in which a port takes no byte.
_WRITE_SECONDS = 5.0


class SerialPort:
    """A serial port of this machine as a :class:`Transport`; closed when its context ends.

    Parameters
    ----------
    port : str
    baud : int
    option : str
        The option that names the port, for the remedy.
    """
    def __init__(self, port: str, baud: int, option: str = "--port") -> None:
        try:
            import serial
        except ImportError:
            raise UserError("the console needs pyserial, which is not installed; install it: pip install 'pyserial>=3.5,<4'") from None
        self.port = port
        try:
            self._line = serial.Serial(port, baud, exclusive=True, write_timeout=_WRITE_SECONDS)
        except (OSError, ValueError) as error:
            number = getattr(error, "errno", None) or 0
            reason, remedy = _REFUSALS.get(number, _REFUSALS[0])
            told = reason.format(error=os.strerror(number) if number else error)
            raise UserError(f"the serial port {port} cannot be opened: {told}; {remedy.format(option=option)}") from None
        # A USB adapter delivers a few bytes after 16 ms; Linux lets some deliver them after 1 ms, and other ports refuse.
        with contextlib.suppress(OSError, ValueError, AttributeError):
            self._line.set_low_latency_mode(True)

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
    option : str
        The option that names the port, for remedies.

    Attributes
    ----------
    system : golden.host.systems.System
        The one that answered.
    registers : RegisterMap
        Its register map.
    repeated : int
        Requests that were sent again. The chip may have carried out each attempt, which matters to an action.
    """
    ATTEMPTS = 4

    #: Bytes, noise among them, that are searched for a reply.
    NOISE_BYTES = 64

    #: Most bytes on their way, of blocks that were sent, or requested, ahead.
    AHEAD_BYTES = 8192

    def __init__(self, transport: Transport, answer_seconds: float = 0.2, option: str = "--port") -> None:
        self._transport = transport
        self._answer_seconds = answer_seconds
        self.repeated = 0
        self.registers: RegisterMap = register_map()    # the first two registers are the same in all systems
        identity, version = self.read("identity"), self.read("version")
        if identity not in SYSTEMS:
            raise UserError(f"the port's device is no stereo system: its identity is {identity}, not {' or '.join(map(str, SYSTEMS))}; "
                            f"choose another {option}")
        self.system = SYSTEMS[identity]
        if version != self.system.version:
            raise UserError(f"the chip has version {version} of the register map, this program version {self.system.version}; "
                            "use the program that came with the chip's build")
        disparities, lead, method, width, height, lines = (
            self.read(name) for name in ("disparities", "lead", "method", "width", "height", "rectify_lines"))
        methods = [MatcherConfig(disparities, width, minimum=-lead, method=kind()) for kind in METHODS.values()]
        if method >= len(methods):
            raise UserError(f"the chip has the method {method}, this program knows those from 0 to {len(methods) - 1}; "
                            "use the program that came with the chip's build")
        self.registers = self.system.registers(methods[method], height, lines)

    @property
    def size(self) -> tuple[int, int]:
        """Width and height of the pictures in the chip's memory, pixels."""
        registers = [self.registers[name] for name in self.system.size]
        width, height = (each.reset if each.kind is Kind.CONSTANT else self.read(each.name) for each in registers)
        return width, height

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
                            "use the program that came with the chip's build")
        return register.decode(reply.value)

    def block(self, plane: int, line: int, width: int) -> bytes:
        """A line of a kept picture of that width, its bytes as :func:`golden.host.blocks.stored_line` has them, or without padding.

        :class:`UserError` if the chip refuses, sends nothing, or sends it garbled each time.
        """
        request = Request(Operation.BLOCK, plane, line)
        reply, data = self._attempt(request, self.system.line_bytes(width))
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
        problems: list[str] = []
        for attempt in range(self.ATTEMPTS):
            self.drop(QUIET_SECONDS if attempt else 0)
            self.repeated += attempt > 0
            self.send(request)
            reply, problem = self.answer(request)
            if reply is None or reply.status is Status.BAD_SUM:
                problems.append(problem)
            elif not block_bytes or reply.status is not Status.OK:
                return reply, b""
            elif (data := self.data(request, block_bytes)) is not None:
                return reply, data
            else:
                problems.append("garbled block")
        raise self.failure(problems)

    def failure(self, problems: Sequence[str]) -> UserError:
        """What to say after as many attempts as there are problems."""
        if set(problems) == {NOTHING}:
            return UserError(f"no answer in {len(problems)} attempts of {self._answer_seconds:g} s; check the wires (TX to RX), the "
                             "board's power and --baud, or choose a longer --timeout")
        return UserError(f"no good answer in {len(problems)} attempts ({', '.join(problems)}); check the wires and --baud")

    def send(self, request: Request, data: bytes = b"") -> None:
        """Send a request, and the data of a block write."""
        self._transport.write(encode_request(request) + data)

    def answer(self, request: Request) -> tuple[Reply | None, str]:
        """The reply to the oldest request without one, which is ``request``; ``None`` if it is lost or is one to another request.

        And what is wrong, in a word, if it is ``None`` or tells of a bad sum.
        """
        reply, heard = self._listen()
        if reply is None:
            return None, "garbled" if heard else NOTHING
        if reply.status is Status.BAD_SUM:
            return reply, "bad sum"
        if reply.address != request.address or (
                reply.status is Status.OK and request.operation != Operation.READ and reply.value != request.value):
            return None, "garbled"
        return reply, ""

    def data(self, request: Request, count: int) -> bytes | None:
        """The ``count`` bytes of the block after a good reply to a block read; ``None`` if it is lost or garbled."""
        return decode_block(request.address, request.value, self._receive(count + CRC_BYTES))

    def _receive(self, count: int) -> bytes:
        """So many bytes, or fewer if the next one is not received in time."""
        data = b""
        while len(data) < count and (more := self._transport.read(min(count - len(data), self.NOISE_BYTES), self._answer_seconds)):
            data += more
        return data

    def drop(self, seconds: float) -> None:
        """Discard bytes until none is received for ``seconds``; gives up after a while, but not before blocks on their way have ended."""
        for _ in range(16 + self.AHEAD_BYTES // self.NOISE_BYTES):
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
