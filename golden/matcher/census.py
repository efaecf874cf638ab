"""Census of a picture, and the Hamming distance of two."""

import numpy as np

from ..config import FUSED_1, FusedCost


__all__ = ["census", "census_plain", "hamming"]


def _offsets(cost: FusedCost) -> list[tuple[int, int]]:
    """``(dy, dx)`` of the neighbours in reading order: bit 0 is the upper left one; the centre has no bit."""
    dy, dx = cost.census_rows // 2, cost.census_columns // 2
    return [(y, x) for y in range(-dy, dy + 1) for x in range(-dx, dx + 1) if (y, x) != (0, 0)]


def census(picture, cost: FusedCost = FUSED_1.cost):
    """Census of every pixel: a bit for each neighbour in the window, set where the neighbour is darker than the centre, by more than
    ``cost.darker_by``.

    The edges of the picture are replicated.

    Parameters
    ----------
    picture : (H, W) integer ndarray
        Grey levels ``0..255``.

    Returns
    -------
    (H, W) uint64 ndarray
        ``cost.neighbours`` bits; neighbours in reading order, the upper left one is bit 0.

    Examples
    --------
    >>> [f"{bits:b}" for bits in census(np.array([[5, 7, 6]]), FusedCost(census_rows=1, census_columns=3)).ravel().tolist()]
    ['0', '11', '0']
    """
    picture = np.asarray(picture, dtype=np.int16)
    limit = picture - cost.darker_by
    height, width = picture.shape
    dy, dx = cost.census_rows // 2, cost.census_columns // 2
    padded = np.pad(picture, ((dy, dy), (dx, dx)), mode="edge")
    result = np.zeros((height, width), dtype=np.uint64)
    for bit, (y, x) in enumerate(_offsets(cost)):
        darker = padded[dy + y:dy + y + height, dx + x:dx + x + width] < limit
        result |= darker.astype(np.uint64) << np.uint64(bit)
    return result


def hamming(left, right):
    """Hamming distance ``H`` of two censuses: the number of bits in which they differ.

    Parameters
    ----------
    left, right : uint64 ndarray
        Of :func:`census`; shapes must broadcast.

    Returns
    -------
    uint8 ndarray

    Examples
    --------
    >>> hamming(np.uint64(0b1100), np.array([0b1100, 0b1010, 0b0011], dtype=np.uint64)).tolist()
    [0, 2, 4]
    """
    return np.bitwise_count(left ^ right)


def census_plain(picture, cost: FusedCost = FUSED_1.cost):
    """:func:`census`, pixel by pixel: for reading, and to test the fast version against."""
    height, width = np.shape(picture)
    lines = np.asarray(picture).tolist()

    def pixel(y: int, x: int) -> int:
        return lines[min(max(y, 0), height - 1)][min(max(x, 0), width - 1)]

    return np.array([[
        sum((pixel(y + dy, x + dx) < pixel(y, x) - cost.darker_by) << bit for bit, (dy, dx) in enumerate(_offsets(cost)))
        for x in range(width)] for y in range(height)], dtype=np.uint64)
