"""Blocks: the chip's reply to a request for a line of a kept picture, and the order in which it takes the lines of a pair."""

from collections.abc import Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..video.memory_map import WORD_BYTES
from .protocol import FRAME_BYTES, Operation, Reply, Status, decode_request, encode_block, encode_reply


__all__ = ["PLANES", "SENT_PLANES", "PairLines", "block_answer", "line_bytes", "stored_line"]


#: Planes that can be read, and those that the host writes, in the order of their numbers.
PLANES = ("left", "right", "disparity")
SENT_PLANES = PLANES[:2]


def line_bytes(width: int) -> int:
    """Bytes of a line of ``width`` pixels in memory, which is in whole words.

    >>> line_bytes(720), line_bytes(100)
    (720, 112)
    """
    return -(-width // WORD_BYTES) * WORD_BYTES


def stored_line(pixels: NDArray[Any]) -> bytes:
    """A line, shape (W,), as memory holds it: a byte a pixel, with zeros after the last one."""
    return np.asarray(pixels, np.uint8).tobytes().ljust(line_bytes(len(pixels)), b"\0")


def block_answer(planes: Sequence[NDArray[Any]] | None, height: int, frame: bytes) -> bytes:
    """The chip's bytes in reply to a block read.

    Parameters
    ----------
    planes : sequence of three arrays, shape (H, W), or None
        The kept pictures, in the order of :data:`PLANES`; ``None`` if no pair is kept.
    height : int
        Lines of a picture.
    frame : bytes
        A request, valid, with the operation ``BLOCK``.

    Examples
    --------
    >>> block_answer(None, 576, bytes.fromhex("a5 61 03 00 00 f7")).hex(" ")
    '5a 02 03 00 00 a1'
    """
    request = decode_request(frame)
    if request is None or request.operation != Operation.BLOCK:
        raise ValueError(f"a block read has {FRAME_BYTES} bytes and the operation {Operation.BLOCK:#x}, not {frame.hex(' ')}")
    plane, line = request.address, request.value
    if plane >= len(PLANES):
        status = Status.UNKNOWN_ADDRESS
    elif line >= height:
        status = Status.OUT_OF_RANGE
    elif planes is None:
        status = Status.NOT_KEPT
    else:
        return encode_reply(Reply(Status.OK, plane, line)) + encode_block(plane, line, stored_line(planes[plane][line]))
    return encode_reply(Reply(status, plane))


class PairLines:
    """Which lines of the host's pair are stored: all before one. So no part of another pair is ever taken for this one's.

    A line is accepted if all before it, of the left picture and then of the right one, are stored; what was stored after it is then not
    of this pair any more.

    Parameters
    ----------
    height : int
        Lines of a picture.

    Examples
    --------
    >>> lines = PairLines(1)
    >>> lines.accepts(1, 0), lines.accepts(0, 0)
    (False, True)
    >>> lines.store(0, 0)
    >>> lines.store(1, 0)
    >>> lines.whole
    True
    >>> lines.store(0, 0)
    >>> lines.whole
    False
    """
    def __init__(self, height: int) -> None:
        self._height = height
        self._stored = 0

    def accepts(self, plane: int, line: int) -> bool:
        """Whether this line may be stored."""
        return plane * self._height + line <= self._stored

    def store(self, plane: int, line: int) -> None:
        """The line is stored; it must be accepted."""
        self._stored = plane * self._height + line + 1

    @property
    def whole(self) -> bool:
        """Both pictures are stored."""
        return self._stored == len(SENT_PLANES) * self._height
