"""Photometric balance: the right picture's brightness and contrast are made those of the left one, from pair to pair."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..config import PIXEL_MAX


__all__ = ["BALANCE_OFF", "Auto", "Fixed", "GAINS", "GAIN_ONE", "LEAST_DEVIATION", "OFFSETS", "Statistics", "apply", "apply_plain",
           "balance", "measure", "measure_plain", "target", "windows"]


GAIN_BITS = 8
GAIN_ONE = 1 << GAIN_BITS
GAINS = range(128, 513)             # a, 256 is 1
OFFSETS = range(-16384, 16385)      # b, 1/256 grey level
LEAST_DEVIATION = 32                # of the right picture, 1/16 grey level: below it there is nothing to measure
_SMOOTH_BITS = 4                    # more, of the smoothed a and b
_SMOOTH = 3                         # an eighth of the difference a pair

Window = tuple[slice, slice]


@dataclass(frozen=True)
class Statistics:
    """Mean and mean absolute deviation of both windows, 1/16 grey level."""
    left_mean: int
    right_mean: int
    left_deviation: int
    right_deviation: int


def windows(width: int, height: int, minimum: int, labels: int) -> tuple[Window, Window]:
    """Windows of the left and the right picture that are measured, as slices of lines and columns.

    They are central and the largest whose sides are powers of two. So that both see the same scene they are moved apart by the middle
    disparity, ``minimum + labels // 2``: the left one to the right by half of it, rounded up, the right one to the left by the rest, each
    as far as the picture reaches.

    Examples
    --------
    >>> windows(720, 576, 0, 80)
    ((slice(32, 544, None), slice(124, 636, None)), (slice(32, 544, None), slice(84, 596, None)))
    """
    lines, columns = (1 << size.bit_length() - 1 for size in (height, width))
    top, start = (height - lines) // 2, (width - columns) // 2
    last = width - columns
    apart = minimum + labels // 2
    left = min(max(start + (apart + 1) // 2, 0), last)
    right = min(max(start - (apart - (left - start)), 0), last)
    rows = slice(top, top + lines)
    return (rows, slice(left, left + columns)), (rows, slice(right, right + columns))


def _means(left: NDArray[Any], right: NDArray[Any], places: tuple[Window, Window]) -> tuple[int, int]:
    first, second = ((int(side[place].sum(dtype=np.int64)) << 4) // side[place].size for side, place in zip((left, right), places))
    return first, second


def measure(left, right, minimum: int, labels: int, before: Statistics | None = None) -> Statistics:  # type: ignore[no-untyped-def]
    """What is measured of a pair.

    Parameters
    ----------
    left, right : (H, W) integer ndarray
        Grey levels ``0..255``.
    minimum, labels : int
        Least disparity, pixels, and number of disparities.
    before : Statistics or None
        Those of the pair before, from whose means this pair's deviations are taken: a stream is read once. ``None``: from its own.
    """
    places = windows(left.shape[1], left.shape[0], minimum, labels)
    means = _means(left, right, places)
    around = (before.left_mean, before.right_mean) if before else means
    deviations = [int(np.abs(16 * side[place].astype(np.int64) - mean).sum()) // side[place].size
                  for side, place, mean in zip((left, right), places, around)]
    return Statistics(*means, *deviations)


def measure_plain(left, right, minimum: int, labels: int, before: Statistics | None = None) -> Statistics:  # type: ignore[no-untyped-def]
    """:func:`measure` by the formulas of one pixel."""
    height, width = left.shape
    b, a = width.bit_length() - 1, height.bit_length() - 1
    n = a + b
    x0, y0, s = (width - 2**b) // 2, (height - 2**a) // 2, minimum + labels // 2
    room = width - 2**b - x0
    right_by = max(min((s + 1) // 2, room), -x0)
    left_by = max(min(s - right_by, x0), -room)
    means, deviations = [], []
    around_of = (before.left_mean, before.right_mean) if before else (None, None)
    for side, x1, mean in ((left, x0 + right_by, around_of[0]), (right, x0 - left_by, around_of[1])):
        pixels = [int(side[y, x]) for y in range(y0, y0 + 2**a) for x in range(x1, x1 + 2**b)]
        means.append((sum(pixels) << 4) >> n)
        around = means[-1] if mean is None else mean
        deviations.append(sum(abs(16 * p - around) for p in pixels) >> n)
    return Statistics(*means, *deviations)


def target(found: Statistics) -> tuple[int, int] | None:
    """Gain ``a`` (256 is 1) and offset ``b`` (1/256 grey level) that give the right picture the left one's mean and deviation; ``None`` if
    the right picture has too little contrast to tell.

    Examples
    --------
    >>> target(Statistics(1600, 1120, 400, 280))
    (366, -20)
    """
    if found.right_deviation < LEAST_DEVIATION:
        return None
    gain = ((found.left_deviation << GAIN_BITS) + (found.right_deviation >> 1)) // found.right_deviation
    gain = min(max(gain, GAINS[0]), GAINS[-1])
    offset = (found.left_mean << 4) - ((gain * found.right_mean) >> 4)
    return gain, min(max(offset, OFFSETS[0]), OFFSETS[-1])


def apply(right, gain: int, offset: int) -> NDArray[np.uint8]:  # type: ignore[no-untyped-def]
    """The right picture after the balance's table: ``clip((a p + b + 128) >> 8, 0, 255)``."""
    levels = np.arange(PIXEL_MAX + 1)
    table = np.clip((gain * levels + offset + 128) >> GAIN_BITS, 0, PIXEL_MAX).astype(np.uint8)
    return table[right]


def apply_plain(right, gain: int, offset: int) -> NDArray[np.uint8]:  # type: ignore[no-untyped-def]
    """:func:`apply` by the formula of one pixel."""
    result = np.empty(right.shape, dtype=np.uint8)
    for place, level in np.ndenumerate(right):
        result[place] = min(max((gain * int(level) + offset + 128) >> 8, 0), 255)
    return result


class Fixed:
    """A balance with a gain and an offset that stay: the settings *fixed* and, with 256 and 0, *off*, an exact copy.

    Parameters
    ----------
    gain : int
        ``128..512``; 256 is 1.
    offset : int
        ``-16384..16384``, 1/256 grey level.
    """
    def __init__(self, gain: int, offset: int):
        for name, value, limits, unit in (("gain", gain, GAINS, "where 256 is 1"), ("offset", offset, OFFSETS, "in 1/256 grey level")):
            if value not in limits:
                raise ValueError(f"{name} must be a whole number from {limits[0]} to {limits[-1]}, {unit}, not {value!r}; "
                                 "choose one in that range")
        self.gain, self.offset = gain, offset

    def pair(self, left, right) -> NDArray[np.uint8]:  # type: ignore[no-untyped-def]
        """The right picture of the next pair, balanced."""
        return apply(right, self.gain, self.offset)


BALANCE_OFF = Fixed(GAIN_ONE, 0)


class Auto:
    """The setting *auto*, pair by pair: a pair is balanced by what was measured of those before it.

    The first pair is copied and its means are kept. From the second on deviations are known: the first ones that can be used are taken at
    once, later ones move gain and offset by an eighth of the difference, with four more bits, and rounded to 1/256 where they are applied.

    Parameters
    ----------
    minimum, labels : int
        Least disparity, pixels, and number of disparities.
    """
    def __init__(self, minimum: int, labels: int):
        self.minimum, self.labels = minimum, labels
        self.statistics: Statistics | None = None
        self._smooth: tuple[int, int] | None = None

    @property
    def gain(self) -> int:
        """``a``, 256 is 1."""
        return self._rounded(0, GAIN_ONE)

    @property
    def offset(self) -> int:
        """``b``, 1/256 grey level."""
        return self._rounded(1, 0)

    def _rounded(self, which: int, default: int) -> int:
        if self._smooth is None:
            return default
        # Half up: with the floor it would stay one below a target that it approaches from below.
        return (self._smooth[which] + (1 << (_SMOOTH_BITS - 1))) >> _SMOOTH_BITS

    def pair(self, left, right) -> NDArray[np.uint8]:  # type: ignore[no-untyped-def]
        """The right picture of the next pair, balanced; then the pair is measured."""
        result = apply(right, self.gain, self.offset)
        found = measure(left, right, self.minimum, self.labels, self.statistics)
        wanted = target(found) if self.statistics else None
        self.statistics = found
        if wanted is not None:
            goal = tuple(value << _SMOOTH_BITS for value in wanted)
            old = self._smooth or goal
            self._smooth = (old[0] + ((goal[0] - old[0]) >> _SMOOTH), old[1] + ((goal[1] - old[1]) >> _SMOOTH))
        return result


def balance(left, right, minimum: int, labels: int) -> NDArray[np.uint8]:  # type: ignore[no-untyped-def]
    """The right picture of a single pair, balanced by what is measured of this pair itself: what *auto* gives of a scene that stands still.

    Parameters
    ----------
    left, right : (H, W) integer ndarray
        Grey levels ``0..255``.
    minimum, labels : int
        Least disparity, pixels, and number of disparities.

    Returns
    -------
    (H, W) uint8 ndarray
        A copy if the right picture has too little contrast to be measured.
    """
    found = target(measure(left, right, minimum, labels))
    return apply(right, *(found or (GAIN_ONE, 0)))
