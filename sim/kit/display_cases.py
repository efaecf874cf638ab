"""Input of the display output for each frame, and the monitor's picture of it."""

from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from golden.video.display import monitor_picture, placement
from golden.video.formats import DISPLAYS, DisplayFormat

from .streams import Random


__all__ = ["FORMATS", "SMALL_DISPLAY", "Fetch", "mode_name", "seen", "shown_pictures", "shown_words"]


#: 18x10 pixels in 24x14.
SMALL_DISPLAY = DisplayFormat(18, range(20, 22), 24, 10, range(11, 13), 14, 65_000_000)
#: By name.
FORMATS = {"small": SMALL_DISPLAY, **DISPLAYS}


def mode_name(code: int) -> str:
    """Display mode of the setting's value ``code``."""
    return ("disparity", "left", "both", "both")[code]


def shown_pictures(width: int, height: int, labels: int, seed: int) -> tuple[NDArray[Any], NDArray[Any]]:
    """A disparity picture and a left picture of noise, with the least and the greatest values among them."""
    rng = np.random.default_rng(seed)
    disparity, left = rng.integers(0, labels, (height, width)), rng.integers(0, 256, (height, width))
    disparity.flat[:2], left.flat[:2] = (labels - 1, 0), (0, 255)
    return disparity, left


def shown_words(disparity: NDArray[Any], left: NDArray[Any], halves: bool = False) -> list[dict[str, int]]:
    """Payloads of :class:`hdl.video.words.ShownPixel`; with ``halves`` of the even lines only."""
    if halves:
        disparity, left = (picture[:picture.shape[0] // 2 * 2:2] for picture in (disparity, left))
    height, width = disparity.shape
    return [{"disparity": int(disparity[y, x]), "left": int(left[y, x]), "first": int(x == y == 0), "last": int(x == width - 1)}
            for y in range(height) for x in range(width)]


def seen(disparity: NDArray[Any], left: NDArray[Any], display: DisplayFormat, mode: str, colour: bool, labels: int,
         words: int | None = None) -> NDArray[Any]:
    """:func:`golden.video.display.monitor_picture` if only the first ``words`` words arrive in time: the rest is black."""
    height, width = disparity.shape
    columns, lines = placement(display, width, height, mode)
    arrived = np.arange(height * width).reshape(height, width) < (height * width if words is None else words)
    if mode == "both":
        arrived = arrived[:height // 2 * 2:2, :width // 2 * 2:2]
        arrived = np.hstack([arrived, np.repeat(arrived[:, -1:], width // 2, axis=1)])
    mask = np.zeros((display.height, display.width, 1), dtype=bool)
    mask[lines.start:lines.stop, columns.start:columns.stop, 0] = arrived
    return monitor_picture(disparity, left, display, mode, colour, labels) * mask


@dataclass
class Fetch:
    """Reply of the picture reader to one ``fetch``.

    Parameters
    ----------
    pair : pair of ndarray
        Disparities and left picture.
    in_time : int
        Number of their pixels that arrive in time; all by default, and then there is no underflow.
    words : list of dict
        Payloads; the pixels of ``pair`` by default.
    shown_valid : bool
        There is a picture to display.
    stale : sequence of dict
        Words of an earlier picture, valid from the cycle after ``fetch`` on.
    delay : int
        Cycles before the first word.
    pause : pair of int
        Index of the word before which the reader pauses, and the number of cycles.
    stall : float
        Probability of an idle cycle before each word.
    """
    pair: tuple[NDArray[Any], NDArray[Any]]
    in_time: int | None = None
    words: Sequence[dict[str, int]] | None = None
    shown_valid: bool = True
    stale: Sequence[dict[str, int]] = ()
    delay: int = 0
    pause: tuple[int, int] = (0, 0)
    stall: float = 0.0

    @property
    def underflow(self) -> bool:
        return self.shown_valid and self.in_time is not None

    def offers(self, rng: Random, halves: bool = False) -> Iterator[tuple[dict[str, int], int]]:
        """Words, and the number of idle cycles before each; in the first cycle after ``fetch`` only a stale word is valid.

        ``halves``: pixels of the even lines only.
        """
        for word in self.stale:
            yield word, 0
        for at, word in enumerate(shown_words(*self.pair, halves) if self.words is None else self.words):
            idle = self.pause[1] if at == self.pause[0] else 0
            if at == 0:
                idle += self.delay + (not self.stale)
            while rng.random() < self.stall:
                idle += 1
            yield word, idle

    def picture(self, display: DisplayFormat, mode: int, colour: bool, labels: int) -> NDArray[Any]:
        """The monitor's picture; ``mode`` is the setting's value."""
        return seen(*self.pair, display, mode_name(mode), bool(colour), labels, self.in_time if self.shown_valid else 0)
