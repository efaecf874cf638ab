"""Layout of the pictures in memory: words, lines, buffers, planes."""

import enum
from dataclasses import dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray


__all__ = ["ADDRESS_BITS", "WORD_BYTES", "MemoryMap", "Plane"]


#: The memory controller's local interface: words of 128 bits, at half rate of a 32-bit DDR2 memory of 128 MB.
WORD_BYTES = 16
ADDRESS_BITS = 23


class Plane(enum.IntEnum):
    """Kinds of pictures in memory: those of the two cameras, and the two planes of a slot that the monitor shows."""
    LEFT = 0
    RIGHT = 1
    DISPARITY = 2
    SHOWN_LEFT = 3


@dataclass(frozen=True)
class MemoryMap:
    """Pictures of one byte a pixel, 16 pixels a word, the first one in the lowest byte.

    A line begins at a multiple of :attr:`pitch` words, a power of two, so that an address is a concatenation and a burst never crosses a
    row of the memory. Lines are stored without gaps, likewise the buffers of a plane, and the planes in the order of :class:`Plane`.

    Parameters
    ----------
    width, height : int
        Pixels of a line, lines of a picture.
    buffers : int
        Pictures of each plane: 2, or 3 for a slow matcher, see :func:`golden.video.pairing.buffers_needed`; and one more to keep a pair.
    host : bool
        Behind all planes there is a pair more, which the host writes: one more buffer of the cameras' planes, with the highest number.
    """
    width: int = 720
    height: int = 576
    buffers: int = 2
    host: bool = False

    def __post_init__(self) -> None:
        for name, limits in (("width", range(1, 4097)), ("height", range(1, 4097)), ("buffers", range(2, 5))):
            value = getattr(self, name)
            if not isinstance(value, int) or value not in limits:
                raise ValueError(f"{name} must be a whole number from {limits[0]} to {limits[-1]}, not {value!r}")
        if self.total_words > 2**ADDRESS_BITS:
            raise ValueError(f"{self.pictures} pictures of {self.width}x{self.height} take {self.total_words} words of memory, "
                             f"which has {2**ADDRESS_BITS}: choose a smaller picture or fewer buffers than {self.buffers}")

    @property
    def line_words(self) -> int:
        """Words of a line; the last one is padded."""
        return -(-self.width // WORD_BYTES)

    @property
    def pitch(self) -> int:
        """Words from a line to the next one."""
        return 1 << (self.line_words - 1).bit_length()

    @property
    def picture_words(self) -> int:
        """Words from a picture to the next one."""
        return self.pitch * self.height

    @property
    def frames(self) -> int:
        """Buffers of each of the cameras' planes, with the host's."""
        return self.buffers + self.host

    def buffers_of(self, plane: Plane) -> int:
        """Buffers of a plane."""
        return self.frames if plane in (Plane.LEFT, Plane.RIGHT) else self.buffers

    @property
    def pictures(self) -> int:
        """Number of all pictures."""
        return len(Plane) * self.buffers + 2 * self.host

    @property
    def total_words(self) -> int:
        """Words of all pictures."""
        return self.pictures * self.picture_words

    def line(self, plane: Plane, buffer: int) -> int:
        """Number of the picture's first line, counted in lines from address 0."""
        buffers = self.buffers_of(plane)
        if not 0 <= buffer < buffers:
            raise ValueError(f"buffer must be from 0 to {buffers - 1}, not {buffer!r}")
        if buffer == self.buffers:
            return (len(Plane) * self.buffers + plane) * self.height
        return (plane * self.buffers + buffer) * self.height

    def base(self, plane: Plane, buffer: int) -> int:
        """Address of the picture's first word."""
        return self.line(plane, buffer) * self.pitch

    def words(self, picture: NDArray[Any]) -> dict[int, int]:
        """A picture as words, by their addresses from :meth:`base` on; padding is zero."""
        if np.shape(picture) != (self.height, self.width):
            raise ValueError(f"a picture of this map is ({self.height}, {self.width}), not {np.shape(picture)}")
        padded = np.zeros((self.height, self.line_words * WORD_BYTES), np.uint8)
        padded[:, :self.width] = picture
        return {y * self.pitch + n: int.from_bytes(row[n * WORD_BYTES:(n + 1) * WORD_BYTES].tobytes(), "little")
                for y, row in enumerate(padded) for n in range(self.line_words)}

    def picture(self, words: dict[int, int]) -> NDArray[np.uint8]:
        """The picture of which :meth:`words` made the words; padding is ignored."""
        lines = [b"".join(words[y * self.pitch + n].to_bytes(WORD_BYTES, "little") for n in range(self.line_words))[:self.width]
                 for y in range(self.height)]
        return np.frombuffer(b"".join(lines), np.uint8).reshape(self.height, self.width)
