"""TMDS, the code of DVI 1.0: ten bits for a byte or for two control bits, few transitions, as many ones as zeros in the long run."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple


__all__ = ["CONTROL_WORDS", "LARGEST_DISPARITY", "WORD_BITS", "Received", "decode", "encode", "encode_byte"]


#: Bits of a word; the lowest one is sent first.
WORD_BITS = 10

#: Words of the control bits: those in place of pixels outside the active area, by ``2 * C1 + C0``. Channel 0 has hsync as C0, vsync as C1.
CONTROL_WORDS = (0b1101010100, 0b0010101011, 0b0101010100, 0b1010101011)

#: The running disparity, ones less zeros of all words since the last control word, is at most this, either way.
LARGEST_DISPARITY = 8

_BYTE = 0xFF
_EXCLUSIVE_OR, _INVERTED = 1 << 8, 1 << 9


class Received(NamedTuple):
    """A word as the monitor understands it: a pixel's ``level`` if ``de``, else the two bits of ``control``."""
    de: bool
    level: int
    control: int


def _minimised(level: int) -> int:
    """Nine bits with few transitions: each bit of the byte compared with the result before it, by XOR if bit 8 is 1, by XNOR if it is 0."""
    ones = level.bit_count()
    exclusive_or = not (ones > 4 or (ones == 4 and not level & 1))
    bit = level & 1
    word = bit | exclusive_or << 8
    for place in range(1, 8):
        bit ^= level >> place & 1 ^ (not exclusive_or)
        word |= bit << place
    return word


def encode_byte(level: int, disparity: int) -> tuple[int, int]:
    """The word of a byte, and the running disparity after it.

    Parameters
    ----------
    level : int
        ``0..255``; :class:`ValueError` otherwise.
    disparity : int
        Running disparity before, even, ``-8..8``; 0 after a control word.

    Examples
    --------
    >>> encode_byte(0x00, 0), encode_byte(0x00, -8), encode_byte(0x55, 0)
    ((256, -8), (1023, 2), (307, 0))
    """
    if not 0 <= level <= _BYTE:
        raise ValueError(f"a byte has a value from 0 to {_BYTE}, not {level}")
    word = _minimised(level)
    exclusive_or = word >> 8
    excess = 2 * (word & _BYTE).bit_count() - 8     # ones less zeros of the eight bits
    if disparity == 0 or excess == 0:
        inverted = not exclusive_or
    else:
        inverted = (disparity > 0) == (excess > 0)
    if inverted:
        word = word ^ _BYTE | _INVERTED
    return word, disparity + 2 * word.bit_count() - WORD_BITS


def encode(pixels: Iterable[tuple[bool, int, int]]) -> list[int]:
    """Words of a channel, one a pixel.

    Parameters
    ----------
    pixels : iterable of (de, level, control)
        ``level``, ``0..255``, counts where ``de`` is true, and ``control``, ``0..3``, elsewhere.

    Returns
    -------
    list of int
    """
    disparity, words = 0, []
    for de, level, control in pixels:
        if de:
            word, disparity = encode_byte(level, disparity)
        else:
            word, disparity = CONTROL_WORDS[control], 0
        words.append(word)
    return words


def decode(words: Sequence[int]) -> list[Received]:
    """What a monitor reads out of the words; each of them means something.

    Examples
    --------
    >>> decode([0b1101010100, 256, 1023])
    [Received(de=False, level=0, control=0), Received(de=True, level=0, control=0), Received(de=True, level=0, control=0)]
    """
    found = []
    for word in words:
        if word in CONTROL_WORDS:
            found.append(Received(False, 0, CONTROL_WORDS.index(word)))
            continue
        bits = word & _BYTE ^ (_BYTE if word & _INVERTED else 0)
        level = bits ^ bits << 1 & _BYTE
        if not word & _EXCLUSIVE_OR:
            level ^= 0xFE
        found.append(Received(True, level, 0))
    return found
