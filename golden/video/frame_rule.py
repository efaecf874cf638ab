"""Frames on a stream that marks where they start, and where either lines or frames end, against the size that registers state."""

import enum
from collections.abc import Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray


__all__ = ["Closes", "Fault", "Received", "ReceivedWord", "received"]


class Closes(enum.StrEnum):
    """What a stream marks besides the start of a frame: AXI4-Stream the last pixel of a line, Avalon-ST that of a frame."""
    LINE = "line"
    FRAME = "frame"


class Fault(enum.IntEnum):
    """How a frame contradicts the size that was set."""
    NONE = 0
    EARLY_END = 1
    LATE_END = 2
    EARLY_START = 3
    LATE_START = 4

    @property
    def text(self) -> str:
        """For a reader."""
        return {Fault.NONE: "none", Fault.EARLY_END: "end marked too early", Fault.LATE_END: "end not marked where it is",
                Fault.EARLY_START: "start of a frame within one", Fault.LATE_START: "pixels after the last of a frame"}[self]


class ReceivedWord(NamedTuple):
    """A pixel of both pictures, grey levels; ``first`` of its frame, and whether the end of line or frame is marked at it."""
    left: int
    right: int
    first: bool
    closes: bool


class Received(NamedTuple):
    """Pictures that the matcher receives, left and right, and the faults in the order of their words."""
    pairs: list[tuple[NDArray[np.uint8], NDArray[np.uint8]]]
    faults: list[Fault]


def received(words: Iterable[ReceivedWord], width: int, height: int, closes: Closes) -> Received:
    """The pictures that are matched of a stream of pixels.

    A frame that contradicts the size is cut after the faulty line, which is padded with its last pixel if it is short; if that is the
    frame's first line, and it is short, nothing of the frame is left. The rest of it is dropped, to the next start of a frame. Words
    before the first start of a frame are dropped, and are no fault.

    Parameters
    ----------
    words : sequence of ReceivedWord
    width, height : int
        Of a frame, as it was set.
    closes : Closes
        What ``closes`` of a word marks.

    Returns
    -------
    Received
        Without a frame that is not complete where the words end. At a word with two faults it is the start that is told.
    """
    pairs: list[tuple[NDArray[np.uint8], NDArray[np.uint8]]] = []
    faults: list[Fault] = []
    lines: list[list[tuple[int, int]]] = []
    inside, dropping = False, True

    def cut(lines: Sequence[Sequence[tuple[int, int]]]) -> None:
        if lines and len(lines[0]) == width:
            whole: Any = np.array([[*line, *[line[-1]] * (width - len(line))] for line in lines if line], dtype=np.uint8)
            pairs.append((whole[..., 0], whole[..., 1]))

    for word in words:
        if word.first and inside:
            faults.append(Fault.EARLY_START)
            cut(lines)
        elif not word.first and not inside:
            if not dropping:
                faults.append(Fault.LATE_START)
            dropping = True
            continue
        if word.first:
            lines = [[]]
        lines[-1].append((word.left, word.right))
        line_ends = len(lines[-1]) == width
        frame_ends = line_ends and len(lines) == height
        right = word.closes == (line_ends if closes is Closes.LINE else frame_ends)
        if not right and not (word.first and inside):
            faults.append(Fault.EARLY_END if word.closes else Fault.LATE_END)
        inside, dropping = right and not frame_ends, not right
        if not inside:
            cut(lines)
        elif line_ends:
            lines.append([])
    return Received(pairs, faults)
