"""What the display is given for each frame, and what the monitor must show of it."""

from dataclasses import dataclass

import numpy as np

from golden.video.display import monitor_picture, placement
from golden.video.formats import DISPLAYS, DisplayFormat


__all__ = ["FORMATS", "SMALL_DISPLAY", "Fetch", "mode_name", "seen", "shown_pictures", "shown_words"]


#: 18x10 pixels in 24x14.
SMALL_DISPLAY = DisplayFormat(18, range(20, 22), 24, 10, range(11, 13), 14, 65_000_000)
#: By name.
FORMATS = {"small": SMALL_DISPLAY, **DISPLAYS}


def mode_name(code):
    """What the gateware makes of the number ``code``."""
    return ("disparity", "left", "both", "both")[code]


def shown_pictures(width, height, labels, seed):
    """A disparity picture and a left picture, without structure; the least and the greatest values are among them."""
    rng = np.random.default_rng(seed)
    disparity, left = rng.integers(0, labels, (height, width)), rng.integers(0, 256, (height, width))
    disparity.flat[:2], left.flat[:2] = (labels - 1, 0), (0, 255)
    return disparity, left


def shown_words(disparity, left, halves=False):
    """Payloads of :class:`hdl.video.words.ShownPixel`; ``halves``: of every second line."""
    if halves:
        disparity, left = (picture[:picture.shape[0] // 2 * 2:2] for picture in (disparity, left))
    height, width = disparity.shape
    return [{"disparity": int(disparity[y, x]), "left": int(left[y, x]), "first": int(x == y == 0), "last": int(x == width - 1)}
            for y in range(height) for x in range(width)]


def seen(disparity, left, display, mode, colour, labels, words=None):
    """:func:`golden.video.display.monitor_picture` if only the first ``words`` words came in time: black from the next one's place on."""
    height, width = disparity.shape
    columns, lines = placement(display, width, height, mode)
    came = np.arange(height * width).reshape(height, width) < (height * width if words is None else words)
    if mode == "both":
        came = came[:height // 2 * 2:2, :width // 2 * 2:2]
        came = np.hstack([came, np.repeat(came[:, -1:], width // 2, axis=1)])
    mask = np.zeros((display.height, display.width, 1), dtype=bool)
    mask[lines.start:lines.stop, columns.start:columns.stop, 0] = came
    return monitor_picture(disparity, left, display, mode, colour, labels) * mask


@dataclass
class Fetch:
    """What the picture reader does about one ``fetch``.

    Parameters
    ----------
    pair : pair of ndarray
        Disparities and left picture.
    came : int
        So many of their pixels come in time; all by default, and then there is no underflow.
    words : list of dict
        What is sent; the pixels of ``pair`` by default.
    shown_valid : bool
        There is a picture to show.
    stale : sequence of dict
        Words that are offered before, from the cycle after ``fetch`` on.
    delay : int
        Cycles before the first word.
    pause : pair of int
        Before which word the reader pauses, and for how many cycles.
    stall : float
        Probability of an idle cycle before each word.
    """
    pair: tuple
    came: int | None = None
    words: list | None = None
    shown_valid: bool = True
    stale: tuple = ()
    delay: int = 0
    pause: tuple = (0, 0)
    stall: float = 0.0

    @property
    def underflow(self):
        return self.shown_valid and self.came is not None

    def offers(self, rng, halves=False):
        """Words and, before each, a number of idle cycles; in the first cycle after ``fetch``, old words at most.

        ``halves``: the pixels of every second line.
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

    def picture(self, display, mode, colour, labels):
        """What the monitor shows; ``mode`` is a number."""
        return seen(*self.pair, display, mode_name(mode), bool(colour), labels, self.came if self.shown_valid else 0)
