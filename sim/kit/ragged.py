"""Ragged frames, and what the line store must make of them."""

from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np
from numpy.typing import NDArray

from .cases import noise, pixel_words


__all__ = ["MAX_WIDTH", "RAGGED", "cut", "frame", "in_a_row", "repaired", "without"]


Word = dict[str, Any]

#: Longest line, pixels, of the line stores that get these frames.
MAX_WIDTH = 8


def repaired(words: Iterable[Word], max_width: int = MAX_WIDTH) -> tuple[list[NDArray[Any]], int]:
    """What the line store's docstring makes of a sequence of pixels: the frames it lets out, and how often it raises ``error``."""
    frames, errors = [], 0
    lines: list[Any] = []
    line: list[Any] = []
    inside, expected = False, True

    def close():
        nonlocal lines, line, inside
        if lines:
            frames.append(lines)
        lines, line, inside = [], [], False

    def pad():
        nonlocal line
        lines.append(line + [line[-1]] * (len(lines[0]) - len(line)))
        line = []

    for word in words:
        pixel = word["left"], word["right"]
        if inside and word["first"]:        # in mid-frame: the frame ends before it
            errors += 1
            if lines and line:
                pad()
            close()
        if not inside:
            if not word["first"]:
                errors += expected
                expected = False
                continue
            inside = True
        expected = False
        fault = word["end"] and not word["last"]    # one pulse a pixel, however much is wrong with it
        closes = word["last"] or word["end"]
        line.append(pixel)
        width = len(lines[0]) if lines else None
        if width is None and not closes and len(line) == max_width:
            fault = True
            close()
        elif (width is None and closes) or len(line) == width:
            lines.append(line)
            line = []
            if not closes:
                fault = True
                close()
            elif word["end"]:
                expected = True
                close()
        elif closes and width is not None:
            fault = True
            expected = bool(word["end"])
            pad()
            close()
        errors += bool(fault)
    assert not inside, "the words end within a frame: nothing can be said of its last lines"
    return [np.moveaxis(np.array(frame), -1, 0) for frame in frames], errors


def frame(width: int = 5, height: int = 4, seed: int = 0) -> list[Word]:
    return pixel_words(*noise(width, height, seed))


def without(words: Sequence[Word], place: int, **flags: int) -> list[Word]:
    """The words with the flags of one changed."""
    return [*words[:place], {**words[place], **flags}, *words[place + 1:]]


def cut(words: Sequence[Word], *places: int) -> list[Word]:
    return [word for place, word in enumerate(words) if place not in places]


# Ragged frames of width 5, four lines: words, size of what is let out of them (None: nothing), error pulses.
RAGGED = {
    "short first line": ([*cut(frame(), 2), ], (4, 2), 1),   # line 1 is then too long
    "short line": (cut(frame(), 7), (5, 2), 1),
    "short line of one pixel": (cut(frame(), 6, 7, 8, 5), (5, 2), 1),
    "short last line": (cut(frame(), 16), (5, 4), 1),
    "long line": ([*frame()[:7], {**frame()[7], "left": 1}, *frame()[7:]], (5, 2), 1),
    "long last line": ([*frame()[:17], frame()[17], *frame()[17:]], (5, 4), 1),
    "long first line": ([*frame()[:3], *frame()[3:4] * 2, *frame()[4:]], (6, 2), 1),  # line 1 is then too short
    "first line longer than max_width": ([*frame()[:3], *frame()[3:4] * 5, *frame()[4:]], None, 1),
    "first in first line": ([*frame()[:3], *frame(seed=9)], (5, 4), 1),
    "first at start of line 1": ([*frame()[:5], *frame(seed=9)], (5, 1), 1),
    "first in line 1": ([*frame()[:8], *frame(seed=9)], (5, 2), 1),
    "first at start of line 2": ([*frame()[:10], *frame(seed=9)], (5, 2), 1),
    "first in line 3": ([*frame()[:16], *frame(seed=9)], (5, 4), 1),
    "last missing": (without(frame(), 9, last=0), (5, 2), 1),
    "last missing in first line": (without(frame(width=3), 2, last=0), (6, 2), 1),
    "last missing in last line": (without(frame(), 19, last=0), (5, 4), 1),
    "end in mid-line": (without(frame(), 12, end=1), (5, 3), 2),  # what follows are pixels before first
    "end in first line": (without(frame(), 3, end=1), (4, 1), 2),
    "end after first line": (without(frame(), 4, end=1), (5, 1), 1),
    "pixels before first": ([*frame()[1:], *frame(seed=9)], (5, 4), 1),
    "end missing": ([*without(frame(), 19, end=0), *frame(seed=9)], (5, 4), 1),
    "one-line frame cut off": ([*frame()[:5], *frame(seed=9)], (5, 1), 1),
    "one pixel": ([frame()[0], *frame(seed=9)], (5, 4), 1),
}


def in_a_row(cases: Iterable[str] = RAGGED) -> list[Word]:
    """Words of these ragged frames, each between frames that are good, for one run: a matcher takes longer to elaborate than to run."""
    words = frame(5, 3, seed=20)
    for seed, case in enumerate(cases, start=21):
        words += [*RAGGED[case][0], *frame(5, 4, seed)]
    return words
