"""Maps of a rectifier: control points, displacements between them, and the words of the gateware's memory."""

from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


__all__ = ["CELL", "CELL_BITS", "DISPLACEMENT_BITS", "GAIN_BITS", "GAIN_ONE", "SIZES", "SUB_PIXEL", "SUM_BITS", "WORD_BITS",
           "RectifyMap", "displacement", "grid", "identity", "map_sum", "pack", "unpack", "word_count"]


CELL_BITS = 5
CELL = 1 << CELL_BITS       # pixels between control points, both ways
SUB_PIXEL = 32              # units of a displacement in a pixel
DISPLACEMENT_BITS = 14      # signed
GAIN_BITS = 8
GAIN_ONE = 128
WORD_BITS = 2 * DISPLACEMENT_BITS + GAIN_BITS
SUM_BITS = 16               # of the sum that tells whether a map was loaded

#: Widths and heights of a picture that can be rectified, pixels.
SIZES = range(2, 4097)

_DISPLACEMENTS = range(-(1 << (DISPLACEMENT_BITS - 1)), 1 << (DISPLACEMENT_BITS - 1))
_GAINS = range(1 << GAIN_BITS)

Whole = NDArray[np.int64]


def grid(width: int, height: int) -> tuple[int, int]:
    """Rows and columns of the control points of a picture, one of each beyond its last pixel.

    Examples
    --------
    >>> grid(720, 576)
    (19, 24)
    """
    return ((height - 1) >> CELL_BITS) + 2, ((width - 1) >> CELL_BITS) + 2


def word_count(width: int, height: int) -> int:
    """Words of a map: a row of control points and its row bound, for each row."""
    rows, columns = grid(width, height)
    return rows * (columns + 1)


@dataclass(frozen=True, eq=False)
class RectifyMap:
    """From where a rectifier takes each pixel of its picture, and the gain there; control points are 32 pixels apart.

    Parameters
    ----------
    width, height : int
        Pixels of a line, lines of a picture: ``2..4096``.
    dx, dy : (rows, columns) integer ndarray
        Distance from a pixel to its source at the control points, of the shape that :func:`grid` tells, 1/32 pixel: ``-8192..8191``.
    gain : (rows, columns) integer ndarray
        ``0..255``; 128 is 1.
    bounds : (rows,) integer ndarray
        Row bounds, lines: see :func:`golden.rig.lines.first_rows`; ``-8192..8191``.

    :class:`ValueError` for an array of another shape, and for a number beyond these limits, with its place.
    """
    width: int
    height: int
    dx: Whole
    dy: Whole
    gain: Whole
    bounds: Whole

    def __post_init__(self) -> None:
        for name in ("width", "height"):
            value = getattr(self, name)
            if not isinstance(value, int) or value not in SIZES:
                raise ValueError(f"{name} must be a whole number from {SIZES[0]} to {SIZES[-1]}, not {value!r}")
        shape = grid(self.width, self.height)
        for name, limits, what in (("dx", _DISPLACEMENTS, " in 1/32 pixel"), ("dy", _DISPLACEMENTS, " in 1/32 pixel"),
                                   ("gain", _GAINS, f" where {GAIN_ONE} is 1"), ("bounds", _DISPLACEMENTS, " in lines")):
            array = np.asarray(getattr(self, name))
            wanted = shape[:1] if name == "bounds" else shape
            if array.shape != wanted or array.dtype.kind not in "iu":
                raise ValueError(f"{name} of a map for {self.width}x{self.height} pixels must be whole numbers of shape {wanted}, "
                                 f"not {array.dtype} of shape {array.shape}")
            array = array.astype(np.int64)
            wrong = np.argwhere((array < limits[0]) | (array > limits[-1]))
            if wrong.size:
                place = tuple(map(int, wrong[0]))
                raise ValueError(f"{name} of the control point {place} is {array[place]}, but must be from {limits[0]} to {limits[-1]}"
                                 f"{what}; mount the cameras nearer to level and parallel")
            object.__setattr__(self, name, array)


def identity(width: int, height: int) -> RectifyMap:
    """The map whose result is an exact copy."""
    zero = np.zeros(grid(width, height), dtype=np.int64)
    return RectifyMap(width, height, zero, zero, zero + GAIN_ONE, zero[:, 0])


def _interpolated(points: Whole, width: int, height: int) -> Whole:
    """Values of control points at every pixel, times 1024: bilinear and exact."""
    y, x = np.arange(height), np.arange(width)
    j, fy = y >> CELL_BITS, (y & (CELL - 1))[:, None]
    i, fx = x >> CELL_BITS, x & (CELL - 1)
    edges = (points[j] << CELL_BITS) + (points[j + 1] - points[j]) * fy     # at every line, between the columns of control points
    left, right = edges[:, i], edges[:, i + 1]
    result: Whole = (left << CELL_BITS) + (right - left) * fx
    return result


def displacement(which: RectifyMap) -> tuple[Whole, Whole, Whole]:
    """Displacement and gain of every pixel.

    Returns
    -------
    dx, dy : (H, W) int64 ndarray
        1/32 pixel, rounded half up.
    gain : (H, W) int64 ndarray
        ``0..1020``; 512 is 1.
    """
    half = 1 << (2 * CELL_BITS - 1)
    dx, dy = ((_interpolated(points, which.width, which.height) + half) >> 2 * CELL_BITS for points in (which.dx, which.dy))
    return dx, dy, (_interpolated(which.gain, which.width, which.height) + 128) >> 8


def _field(value: Whole, bits: int) -> Whole:
    return value & ((1 << bits) - 1)


def pack(which: RectifyMap) -> list[int]:
    """The words of a map in the order of their addresses, 36 bits each: ``dx`` in bits 0 to 13, ``dy`` from 14, ``gain`` from 28.

    Word ``j * (columns + 1) + i`` is control point ``(j, i)``; for ``i = columns`` its ``dx`` is the row bound ``j``, and the rest 0.

    Examples
    --------
    >>> [f"{word:09x}" for word in pack(identity(2, 2))]
    ['800000000', '800000000', '000000000', '800000000', '800000000', '000000000']
    """
    points = (_field(which.dx, DISPLACEMENT_BITS) | _field(which.dy, DISPLACEMENT_BITS) << DISPLACEMENT_BITS
              | which.gain << 2 * DISPLACEMENT_BITS)
    bounds = _field(which.bounds, DISPLACEMENT_BITS)
    words: list[int] = np.concatenate([points, bounds[:, None]], axis=1).ravel().tolist()
    return words


def map_sum(words: Any) -> int:
    """The sum by which a host verifies the words that it has loaded, 16 bits.

    Each word's low, middle and high 16 bits are added in this order, the sum being rotated left by a bit before each.

    Examples
    --------
    >>> map_sum([0x1]), map_sum([0x10000]), map_sum([0x100000000]), map_sum([0x1, 0x1])
    (4, 2, 1, 36)
    """
    total = 0
    for word in words:
        for part in range(0, 3 * SUM_BITS, SUM_BITS):
            rotated = (total << 1 | total >> (SUM_BITS - 1)) & ((1 << SUM_BITS) - 1)
            total = (rotated + (word >> part & ((1 << SUM_BITS) - 1))) & ((1 << SUM_BITS) - 1)
    return total


def unpack(words: Any, width: int, height: int) -> RectifyMap:
    """The map of :func:`pack`'s words; :class:`ValueError` if they are not as many as the picture needs, or have more than 36 bits."""
    count = word_count(width, height)
    if len(words) != count:
        raise ValueError(f"a map for {width}x{height} pixels has {count} words, not {len(words)}; give the map of this size")
    wrong = next((number for number, word in enumerate(words) if not 0 <= word < 1 << WORD_BITS), None)
    if wrong is not None:
        raise ValueError(f"word {wrong} of a map is {words[wrong]:#x}, which has not {WORD_BITS} bits; make the map again")
    rows, columns = grid(width, height)
    table = np.array(words, dtype=np.int64).reshape(rows, columns + 1)

    def signed(field: Whole) -> Whole:
        value = _field(field, DISPLACEMENT_BITS)
        return value - ((value >> (DISPLACEMENT_BITS - 1)) << DISPLACEMENT_BITS)

    points = table[:, :columns]
    return RectifyMap(width, height, signed(points), signed(points >> DISPLACEMENT_BITS), points >> 2 * DISPLACEMENT_BITS,
                      signed(table[:, columns]))
