"""Streams with frames that contradict a size: each kind of contradiction, and all of them at random."""

import numpy as np

from golden.video.frame_rule import Closes, Fault, ReceivedWord


__all__ = ["FAULTY", "frame", "random_words", "sizes"]


def frame(width, height, closes, seed):
    """Words of a frame of noise without a fault."""
    grey = np.random.default_rng(seed).integers(0, 256, (height, width, 2)).tolist()
    return [ReceivedWord(*grey[y][x], first=x == y == 0, closes=x == width - 1 and (closes is Closes.LINE or y == height - 1))
            for y in range(height) for x in range(width)]


#: Each kind of contradiction: what is done to the words of a frame of 5x4 pixels, and the faults that it has, by what closes.
FAULTY = {
    "short line": (lambda words: words[:7] + words[8:], {closes: [Fault.EARLY_END] for closes in Closes}),
    "short first line": (lambda words: words[:2] + words[3:], {closes: [Fault.EARLY_END] for closes in Closes}),
    "long line": (lambda words: words[:7] + words[6:], {closes: [Fault.LATE_END] for closes in Closes}),
    "long first line": (lambda words: words[:3] + words[2:], {closes: [Fault.LATE_END] for closes in Closes}),
    "line too few": (lambda words: words[:5] + words[10:], {Closes.LINE: [Fault.EARLY_START], Closes.FRAME: [Fault.EARLY_END]}),
    "line too many": (lambda words: words[:15] + words[10:], {Closes.LINE: [Fault.LATE_START], Closes.FRAME: [Fault.LATE_END]}),
    "start within": (lambda words: words[:13], {closes: [Fault.EARLY_START] for closes in Closes}),
    "start in the first line": (lambda words: words[:3], {closes: [Fault.EARLY_START] for closes in Closes}),
    "no start": (lambda words: [words[0]._replace(first=False), *words[1:]], {closes: [Fault.LATE_START] for closes in Closes}),
}


def sizes(pairs):
    """Widths and heights of pictures."""
    return [left.shape[::-1] for left, _ in pairs]


def random_words(rng, width, height, closes, frames):
    """Frames of which most are whole; the others lack words, have some twice, or have marks where there should be none."""
    words = frame(width, height, closes, 0)[int(rng.integers(width * height)):]     # one in progress
    for number in range(frames):
        whole = frame(width, height, closes, number + 1)
        for _ in range(int(rng.choice([0, 0, 1, 2]))):
            at = int(rng.choice([rng.integers(len(whole) or 1), max(len(whole) - 1, 0)]))
            word = (whole or frame(width, height, closes, number))[at]
            whole[at:at + 1] = [[], [word, word], [word._replace(closes=not word.closes)],
                                [word._replace(first=not word.first)]][int(rng.integers(4))]
        words += whole
    return words + frame(width, height, closes, frames + 1)
