"""The system with cameras as a model of what it answers, byte by byte: for tests of the host, and of the gateware."""

from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..config import MatcherConfig
from ..matcher.matcher import disparities
from ..rig.balance import Auto, apply
from ..rig.config import RigConfig
from .blocks import SENT_PLANES, PairLines, block_answer, line_bytes
from .device import SerialDevice
from .protocol import Request, Status
from .registers import register_map


__all__ = ["CameraDevice"]


class CameraDevice(SerialDevice):
    """What the gateware :class:`hdl.video.system.StereoSystem` sends in answer to bytes, and to pauses between them.

    It knows no time: a pair starts and is matched at once, wherever it may, and the cameras' next pair is there whenever it is wanted.

    Parameters
    ----------
    config : MatcherConfig
    height : int
        Lines of a picture.
    rig : RigConfig or None
        Of rectification and balance; without them if ``None``.

    Attributes
    ----------
    cameras : sequence of two (height, max_width) arrays, or None
        What the cameras see; nothing if ``None``.
    pictures : list of two (height, max_width) arrays
        The host's pair.
    kept : list of three (height, max_width) arrays, or None
        The kept pair and its labels.
    """
    def __init__(self, config: MatcherConfig, height: int, rig: RigConfig | None = None) -> None:
        super().__init__(register_map(config, height, rig), height)
        self.config, self.rig = config, rig
        self.cameras: list[NDArray[np.uint8]] | None = None
        self.pictures = [np.zeros((height, config.max_width), np.uint8) for _ in SENT_PLANES]
        self.kept: list[NDArray[Any]] | None = None
        self._lines = PairLines(height)
        self._auto = Auto(config.minimum, config.labels)

    def _sent_bytes(self) -> int:
        return line_bytes(self.config.max_width)

    def _refusal(self, plane: int, line: int) -> Status:
        busy = self._value("keep") or not self._value("source") or not self._lines.accepts(plane, line)
        return Status.BUSY if busy else Status.OK

    def _store(self, plane: int, line: int, data: bytes) -> None:
        self.pictures[plane][line] = np.frombuffer(data, np.uint8)[:self.config.max_width]
        self._lines.store(plane, line)
        self.values["pair_whole"] = int(self._lines.whole)

    def _read_block(self, frame: bytes, request: Request) -> bytes:
        return block_answer(self.kept, self.height, frame)

    def _act(self, name: str, value: int) -> None:
        if name == "keep" and not value:
            self.kept = None
        if name == "start_pair" and self._value("source") and self._lines.whole:
            self._match(self.pictures)
        elif name == "keep" and value and not self._value("source") and self.cameras:
            self._match(self.cameras)
        self.values["kept"] = int(self.kept is not None)

    def _match(self, pair: list[NDArray[np.uint8]]) -> None:
        """A pair is matched, and kept if that is wanted and none is."""
        if self._value("hold"):
            return
        config = self.config.with_settings({name: self._value(name) for name in self.config.settings})
        left, right = pair
        if self.rig and self.rig.rig and self._value("rectify"):
            left, right = self.rig.rig.rectified(left, right)
        balance = self._value("balance") if self.rig else 0
        if balance == 1:
            self._auto.minimum = config.minimum
            right = self._auto.pair(left, right)
        elif balance == 2:
            right = apply(right, self._value("fixed_gain"), self._value("fixed_offset"))
        labels = np.floor(disparities(left, right, config)).astype(int) - config.minimum
        self._count("pairs")
        if self._value("keep") and self.kept is None:
            self.kept = [*(picture.copy() for picture in pair), labels]
