"""The matcher behind a serial line as a model of what it answers, byte by byte: for tests of the host, and of the gateware."""

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..config import MatcherConfig
from ..matcher.matcher import match
from .blocks import SENT_PLANES
from .device import SerialDevice
from .loop_registers import LOOP_PLANES, PICTURE_PLANES, loop_register_map, result_bits, result_bytes
from .protocol import Reply, Request, Status, encode_block, encode_reply


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


class LoopDevice(SerialDevice):
    """What the gateware :class:`hdl.loop.system.LoopSystem` sends in answer to bytes, and to pauses between them.

    Parameters
    ----------
    config : MatcherConfig
    height : int
        Most lines of a picture.

    Attributes
    ----------
    pictures : list of two (height, max_width) arrays
        The stored pair.
    """
    def __init__(self, config: MatcherConfig, height: int) -> None:
        super().__init__(loop_register_map(config, height), height)
        self.config = config
        self.pictures = [np.zeros((height, config.max_width), np.uint8) for _ in SENT_PLANES]
        self._words = np.zeros((height, config.max_width), np.int64)

    def _sent_bytes(self) -> int:
        return self._value("picture_width")

    def _refusal(self, plane: int, line: int) -> Status:
        return Status.BUSY if self._value("keep") else Status.OK

    def _store(self, plane: int, line: int, data: bytes) -> None:
        self.pictures[plane][line, :len(data)] = np.frombuffer(data, np.uint8)
        self.values["kept"] = 0

    def _read_block(self, frame: bytes, request: Request) -> bytes:
        status = self._status(request, len(LOOP_PLANES)) or (Status.OK if self._value("kept") else Status.NOT_KEPT)
        reply = Reply(status, request.address, request.value if status is Status.OK else 0)
        block = encode_block(request.address, request.value, self._line(request)) if status is Status.OK else b""
        return encode_reply(reply) + block

    def _act(self, name: str, value: int) -> None:
        if name == "start" and not self._value("keep"):
            self._match()

    def _match(self) -> None:
        width, height = self._value("picture_width"), self._value("picture_height")
        config = self.config.with_settings({name: self._value(name) for name in self.config.settings})
        left, right = (picture[:height, :width] for picture in self.pictures)
        fields = match(left, right, config)
        self._words[:height, :width] = packed_result(fields, config)
        self.values["kept"] = 1
        self._count("pairs")

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
