"""The matcher behind a serial line as a model of what it answers, byte by byte: for tests of the host, and of the gateware."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..config import MatcherConfig
from ..matcher.matcher import match
from .loop_registers import LOOP_PLANES, PICTURE_PLANES, SENT_PLANES, loop_register_map, result_bits, result_bytes
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
    encode_block,
    encode_reply,
)
from .registers import Kind, answer


__all__ = ["LoopDevice", "packed_result", "plane_bytes", "unpacked_result"]


def plane_bytes(plane: int, width: int, config: MatcherConfig) -> int:
    """Bytes of a line of ``width`` pixels in a block of the plane with this number."""
    return width * (1 if plane < len(PICTURE_PLANES) else result_bytes(config))


def packed_result(fields: Mapping[str, NDArray[Any]], config: MatcherConfig) -> NDArray[np.int64]:
    """Stored words, (H, W), of a result of :func:`golden.matcher.matcher.match`."""
    scale, low = config.method.disparity_scale, 0
    words = np.zeros(np.shape(fields["disparity"]), np.int64)
    for name, bits in result_bits(config).items():
        values = np.asarray(fields[name], np.int64) - (config.minimum * scale if name == "disparity" else 0)
        words |= values << low
        low += bits
    return words


def unpacked_result(words: NDArray[Any], config: MatcherConfig) -> dict[str, NDArray[np.int32]]:
    """The reverse of :func:`packed_result`."""
    fields, low = {}, 0
    for name, bits in result_bits(config).items():
        fields[name] = (np.asarray(words) >> low & (1 << bits) - 1).astype(np.int32)
        low += bits
    fields["disparity"] += config.minimum * config.method.disparity_scale
    return fields


class LoopDevice:
    """What the gateware :class:`hdl.loop.system.LoopSystem` sends in answer to bytes, and to pauses between them.

    After a byte that is no sync byte where a request must begin, a bad sum, an operation that there is not, a block write that is refused,
    or a block whose CRC is wrong, all bytes are ignored until a pause: so no pixel of a block is ever taken for a request.

    Parameters
    ----------
    config : MatcherConfig
    height : int
        Most lines of a picture.

    Attributes
    ----------
    values : dict of str to int
        Of the registers that differ from their reset value.
    pictures : list of two (height, max_width) arrays
        The stored pair.
    """
    def __init__(self, config: MatcherConfig, height: int) -> None:
        self.config, self.height = config, height
        self.registers = loop_register_map(config, height)
        self.values: dict[str, int] = {}
        self.pictures = [np.zeros((height, config.max_width), np.uint8) for _ in SENT_PLANES]
        self._words = np.zeros((height, config.max_width), np.int64)
        self._minimum = 0
        self._bytes = b""
        self._block: Request | None = None  # of which data are being received
        self._ignores = False

    def _value(self, name: str) -> int:
        return self.values.get(name, self.registers[name].reset)

    def _error(self) -> None:
        self.values["uart_errors"] = min(self._value("uart_errors") + 1, self.registers["uart_errors"].maximum)

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
        width = self._value("picture_width")
        if len(self._bytes) < width + CRC_BYTES:
            return b""
        data = decode_block(request.address, request.value, self._bytes)
        if data is None:
            self._drop()
            return encode_reply(Reply(Status.BAD_SUM, request.address))
        self._bytes, self._block = b"", None
        self.pictures[request.address][request.value, :width] = np.frombuffer(data, np.uint8)
        self.values["kept"] = 0
        return encode_reply(Reply(Status.OK, request.address, request.value))

    def _request(self, frame: bytes) -> bytes:
        request = decode_request(frame)
        if request and request.operation == Operation.BLOCK_WRITE:
            status = self._status(request, len(SENT_PLANES), Status.BUSY if self._value("keep") else Status.OK)
            if status is Status.OK:
                self._block = request
                return b""
            self._ignores = True
            return encode_reply(Reply(status, request.address))
        if request and request.operation == Operation.BLOCK:
            status = self._status(request, len(LOOP_PLANES), Status.OK if self._value("kept") else Status.NOT_KEPT)
            reply = Reply(status, request.address, request.value if status is Status.OK else 0)
            block = encode_block(request.address, request.value, self._line(request)) if status is Status.OK else b""
            return encode_reply(reply) + block
        reply, written = answer(self.registers, self.values, frame)
        if reply.status is Status.BAD_SUM:
            self._drop()
        self._ignores |= reply.status is Status.UNKNOWN_OPERATION
        for name, value in written.items():
            if self.registers[name].kind is Kind.SETTING:
                self.values[name] = value
        if "clear_counters" in written:
            self.values.update({register.name: 0 for register in self.registers.of(Kind.COUNTER)})
        if "start" in written and not self._value("keep"):
            self._match()
        return encode_reply(reply)

    def _status(self, request: Request, planes: int, ready: Status) -> Status:
        if request.address >= planes:
            return Status.UNKNOWN_ADDRESS
        return Status.OUT_OF_RANGE if request.value >= self.height else ready

    def _match(self) -> None:
        width, height = self._value("picture_width"), self._value("picture_height")
        config = self.config.with_settings({name: self._value(name) for name in self.config.settings})
        left, right = (picture[:height, :width] for picture in self.pictures)
        fields = match(left, right, config)
        self._words[:height, :width] = packed_result(fields, config)
        self.values |= {"kept": 1, "pairs": min(self._value("pairs") + 1, self.registers["pairs"].maximum)}

    def _line(self, request: Request) -> bytes:
        width = self._value("picture_width")
        if request.address < len(SENT_PLANES):
            return self.pictures[request.address][request.value, :width].tobytes()
        words = self._words[request.value, :width]
        if request.address < len(PICTURE_PLANES):
            labels = words & (1 << result_bits(self.config)["disparity"]) - 1
            return (labels // self.config.method.disparity_scale).astype(np.uint8).tobytes()
        count = result_bytes(self.config)
        return words.astype("<i8").view(np.uint8).reshape(width, 8)[:, :count].tobytes()
