"""Memory of a process over a long run: resident bytes, and how they grow."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np


__all__ = ["GROWTH", "growth", "resident_bytes"]


#: Bytes by which a process may grow in 100 frames: a picture's bytes that are kept by mistake, of each camera or of the monitor, are more.
GROWTH = 100_000

_PAGE = 4096


def resident_bytes() -> int:
    """Of this process; 0 where the system does not tell."""
    try:
        return int(Path("/proc/self/statm").read_text().split()[1]) * _PAGE
    except OSError:
        return 0


def growth(samples: Sequence[tuple[int, int]]) -> float:
    """Bytes by which a run grows in 100 frames: the slope of the straight line of least squares through its second half, after caches and
    pools have filled.

    Parameters
    ----------
    samples : sequence of (int, int)
        Frames so far, and bytes.

    Examples
    --------
    >>> growth([(0, 0), (100, 9000), (200, 10_000), (300, 10_100), (400, 10_200)])
    100.0
    """
    frames, resident = np.array(samples[len(samples) // 2:], dtype=float).T
    return float(round(100 * np.polyfit(frames - frames.mean(), resident, 1)[0], 3))
