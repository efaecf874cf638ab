"""The weighted median of the labels around a pixel: those of like pixels count more, and of pixels that passed the check twice."""

import numpy as np


__all__ = ["SIZE", "THRESHOLDS", "votes", "weighted_median", "weighted_median_plain"]


SIZE = 7  # pixels, the side of the window

#: Grey levels up to which a pixel has 4, 2 and 1 votes.
THRESHOLDS = (16, 32, 64)


def votes(difference, passed):
    """Votes of a pixel by its difference to the centre: 4, 2, 1, 0 up to 16, 32, 64 grey levels and above; doubled where it passed.

    Parameters
    ----------
    difference : (...) integer ndarray
        Grey levels, ``0..255``.
    passed : (...) bool ndarray

    Returns
    -------
    (...) int16 ndarray
        ``0..8``.
    """
    near, middle, far = (np.asarray(difference) <= threshold for threshold in THRESHOLDS)
    return (far.astype(np.int16) + middle + 2 * near) << np.asarray(passed)


def weighted_median(labels, passed, left):
    """The least label of the 7x7 window around every pixel whose votes and those of the smaller ones are half of all, or more.

    Positions are clamped to the picture. The label is found bit by bit, the most significant first, as the gateware does: of the labels
    that agree with the bits so far those with a 0 have the half, or the bit is 1.

    Parameters
    ----------
    labels : (H, W) integer ndarray
        Not negative.
    passed : (H, W) bool ndarray
    left : (H, W) integer ndarray
        Grey levels.

    Returns
    -------
    (H, W) ndarray of the type of ``labels``
    """
    labels = np.asarray(labels)
    height, width = labels.shape
    reach = SIZE // 2
    pad = ((reach, reach), (reach, reach))
    near_label, near_passed, near_grey = (np.pad(part, pad, mode="edge") for part in (
        labels.astype(np.int16), np.asarray(passed), np.asarray(left, dtype=np.int16)))
    bits = max(1, int(labels.max()).bit_length())
    result = np.empty((height, width), dtype=labels.dtype)
    places = [(dy, dx) for dy in range(SIZE) for dx in range(SIZE)]
    window = np.empty((len(places), width), dtype=np.int16)
    weight = np.empty_like(window)
    centre = np.asarray(left, dtype=np.int16)
    for y in range(height):
        for n, (dy, dx) in enumerate(places):
            window[n] = near_label[y + dy, dx:dx + width]
            weight[n] = votes(np.abs(near_grey[y + dy, dx:dx + width] - centre[y]), near_passed[y + dy, dx:dx + width])
        total = weight.sum(axis=0, dtype=np.int16)
        below = np.zeros(width, dtype=np.int16)     # votes of labels below those that agree
        found = np.zeros(width, dtype=np.int16)
        for bit in reversed(range(bits)):
            # What agrees so far, with a 0 here.
            zeros = np.where((window >> bit) == (found >> bit), weight, 0).sum(axis=0, dtype=np.int16)
            one = 2 * (below + zeros) < total
            below += np.where(one, zeros, 0).astype(np.int16)
            found |= one.astype(np.int16) << np.int16(bit)
        result[y] = found
    return result


def weighted_median_plain(labels, passed, left):
    """:func:`weighted_median`, pixel by pixel: for reading, and to test the fast version against."""
    height, width = np.shape(labels)
    steps = range(-(SIZE // 2), SIZE // 2 + 1)
    result = np.zeros((height, width), dtype=np.asarray(labels).dtype)
    for y in range(height):
        for x in range(width):
            counted: dict[int, int] = {}
            for dy in steps:
                for dx in steps:
                    at = min(max(y + dy, 0), height - 1), min(max(x + dx, 0), width - 1)
                    difference = abs(int(left[at]) - int(left[y, x]))
                    vote = 4 if difference <= 16 else 2 if difference <= 32 else 1 if difference <= 64 else 0
                    counted[int(labels[at])] = counted.get(int(labels[at]), 0) + vote * (2 if passed[at] else 1)
            total, cumulated = sum(counted.values()), 0
            for label in sorted(counted):
                cumulated += counted[label]
                if 2 * cumulated >= total:
                    result[y, x] = label
                    break
    return result
