"""What a chip that takes blocks answers to bytes, and to pauses between them: registers and block writes, without its pictures."""

from abc import ABC, abstractmethod

from .blocks import SENT_PLANES
from .protocol import (
    CRC_BYTES,
    FRAME_BYTES,
    REQUEST_SYNC,
    Operation,
    Reply,
    Request,
    Status,
    decode_block,
    decode_request,
    encode_reply,
)
from .registers import Kind, RegisterMap, answer


__all__ = ["SerialDevice"]


class SerialDevice(ABC):
    """What gateware with :class:`hdl.host.registers.RequestReader` sends in answer to bytes, and to pauses between them.

    After a byte that is no sync byte where a request must begin, a bad sum, an operation that there is not, a block write that is refused,
    or a block whose CRC is wrong, all bytes are ignored until a pause: so no pixel of a block is ever taken for a request.

    Parameters
    ----------
    registers : RegisterMap
    height : int
        Most lines of a picture.

    Attributes
    ----------
    values : dict of str to int
        Of the registers that differ from their reset value.
    """
    def __init__(self, registers: RegisterMap, height: int) -> None:
        self.registers, self.height = registers, height
        self.values: dict[str, int] = {}
        self._bytes = b""
        self._block: Request | None = None  # of which data are being received
        self._ignores = False

    @abstractmethod
    def _sent_bytes(self) -> int:
        """Bytes of a block write, without the CRC."""

    @abstractmethod
    def _refusal(self, plane: int, line: int) -> Status:
        """Of a block write whose plane and line there are: ``OK`` if its data may follow."""

    @abstractmethod
    def _store(self, plane: int, line: int, data: bytes) -> None:
        """A line has been received."""

    @abstractmethod
    def _read_block(self, frame: bytes, request: Request) -> bytes:
        """The answer to a block read."""

    @abstractmethod
    def _act(self, name: str, value: int) -> None:
        """A register has been written, whose value is recorded if it is a setting."""

    def _value(self, name: str) -> int:
        return self.values.get(name, self.registers[name].reset)

    def _count(self, name: str) -> None:
        self.values[name] = min(self._value(name) + 1, self.registers[name].maximum)

    def _error(self) -> None:
        self._count("uart_errors")

    def pause(self) -> bytes:
        """The line is silent for the time-out; bytes in answer."""
        cut, self._block, self._ignores = self._block, None, False
        if self._bytes or cut:
            self._error()
        self._bytes = b""
        return encode_reply(Reply(Status.BAD_SUM, cut.address)) if cut else b""

    def receive(self, data: bytes) -> bytes:
        """Bytes without a pause between them; those in answer."""
        sent = b""
        for number in data:
            if self._ignores:
                continue
            self._bytes += bytes([number])
            if self._block:
                sent += self._data(self._block)
            elif self._bytes[0] != REQUEST_SYNC:
                self._drop()
            elif len(self._bytes) == FRAME_BYTES:
                frame, self._bytes = self._bytes, b""
                sent += self._request(frame)
        return sent

    def _drop(self) -> None:
        """An error: everything is ignored until a pause."""
        self._error()
        self._bytes, self._block, self._ignores = b"", None, True

    def _data(self, request: Request) -> bytes:
        """A byte of a block has been received."""
        if len(self._bytes) < self._sent_bytes() + CRC_BYTES:
            return b""
        data = decode_block(request.address, request.value, self._bytes)
        if data is None:
            self._drop()
            return encode_reply(Reply(Status.BAD_SUM, request.address))
        self._bytes, self._block = b"", None
        self._store(request.address, request.value, data)
        return encode_reply(Reply(Status.OK, request.address, request.value))

    def _status(self, request: Request, planes: int) -> Status:
        """Of a block whose plane or line there is not; ``OK`` otherwise."""
        if request.address >= planes:
            return Status.UNKNOWN_ADDRESS
        return Status.OUT_OF_RANGE if request.value >= self.height else Status.OK

    def _request(self, frame: bytes) -> bytes:
        request = decode_request(frame)
        if request and request.operation == Operation.BLOCK_WRITE:
            status = self._status(request, len(SENT_PLANES)) or self._refusal(request.address, request.value)
            if status is Status.OK:
                self._block = request
                return b""
            self._ignores = True
            return encode_reply(Reply(status, request.address))
        if request and request.operation == Operation.BLOCK:
            return self._read_block(frame, request)
        reply, written = answer(self.registers, self.values, frame)
        if reply.status is Status.BAD_SUM:
            self._drop()
        self._ignores |= reply.status is Status.UNKNOWN_OPERATION
        for name, value in written.items():
            if self.registers[name].kind is Kind.SETTING:
                self.values[name] = value
            if name == "clear_counters":
                self.values.update({register.name: 0 for register in self.registers.of(Kind.COUNTER)})
            self._act(name, value)
        return encode_reply(reply)
