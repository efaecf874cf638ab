"""BT.656: pictures as the bytes of an interlaced camera, and back."""

from dataclasses import dataclass, field
from typing import Any

import numpy as np

from .formats import CameraFormat


__all__ = ["BLANK_CHROMA", "BLANK_LUMA", "CORRECTED", "LUMA_MAX", "LUMA_MIN", "PREAMBLE", "Decoded", "clip", "decode", "encode",
           "encode_line", "lost_bytes", "xy"]


#: The bytes before the last one of a timing code.
PREAMBLE = (0xFF, 0x00, 0x00)
#: 0 and 255 are reserved for timing codes: no sample of a picture has these values.
LUMA_MIN, LUMA_MAX = 1, 254
#: Blanking.
BLANK_CHROMA, BLANK_LUMA = 0x80, 0x10
# A signal is lost after so many lines without a valid code.
_LOST_LINES = 2


def xy(f: int, v: int, h: int) -> int:
    """Last byte of a timing code: ``1 F V H P3 P2 P1 P0``; four protection bits.

    Parameters
    ----------
    f : int
        Field: 0 top, 1 bottom.
    v : int
        1 in a line of vertical blanking.
    h : int
        0 for SAV, start of active video, 1 for EAV, its end.

    Examples
    --------
    >>> [f"{xy(*bits):02X}" for bits in [(0, 0, 0), (0, 0, 1), (0, 1, 0), (0, 1, 1), (1, 0, 0), (1, 0, 1), (1, 1, 0), (1, 1, 1)]]
    ['80', '9D', 'AB', 'B6', 'C7', 'DA', 'EC', 'F1']
    """
    return 0x80 | f << 6 | v << 5 | h << 4 | (v ^ h) << 3 | (f ^ h) << 2 | (f ^ v) << 1 | f ^ v ^ h


def _corrected() -> Any:
    """For each byte, the code within one bit of it; -1 if there is none. Codes differ from one another in at least four bits."""
    table = np.full(256, -1, np.int16)
    for code in (xy(n >> 2, n >> 1 & 1, n & 1) for n in range(8)):
        table[[code, *(code ^ 1 << bit for bit in range(8))]] = code
    return table


#: By byte: the code itself, or corrected in one bit; -1 where more bits are wrong.
CORRECTED = _corrected()


def clip(picture):
    """A picture as a camera can send it: 0 becomes 1, and 255 becomes 254.

    Parameters
    ----------
    picture : integer ndarray
        Grey levels.

    Returns
    -------
    uint8 ndarray

    Examples
    --------
    >>> clip(np.array([0, 1, 128, 255])).tolist()
    [1, 1, 128, 254]
    """
    return np.clip(picture, LUMA_MIN, LUMA_MAX).astype(np.uint8)


def encode_line(f, v, luma, chroma, format: CameraFormat):
    """Bytes of a line: EAV, blanking, SAV, ``Cb Y Cr Y`` for each two pixels.

    Parameters
    ----------
    f, v : int
        As in :func:`xy`.
    luma, chroma : (W,) integer ndarray
        Grey levels; Cb of even and Cr of odd pixels.

    Returns
    -------
    (format.line_bytes,) uint8 ndarray
    """
    eav, sav = ([*PREAMBLE, xy(f, v, h)] for h in (1, 0))
    blanking = np.resize([BLANK_CHROMA, BLANK_LUMA], format.blanking)
    return np.concatenate([eav, blanking, sav, np.column_stack([chroma, luma]).ravel()]).astype(np.uint8)


def encode(picture, format: CameraFormat, chroma=None):
    """Bytes of a frame, from its first blank line on: the picture's even lines in the top field, then the odd ones in the bottom field.

    Parameters
    ----------
    picture : (H, W) integer ndarray
        Grey levels; :func:`clip` is applied.
    chroma : (H, W) integer ndarray
        Cb in even columns, Cr in odd ones; clipped too. By default grey: 128.

    Returns
    -------
    (format.frame_bytes,) uint8 ndarray
    """
    luma = clip(picture)
    chroma = np.full_like(luma, BLANK_CHROMA) if chroma is None else clip(chroma)
    if luma.shape != (format.height, format.width) or chroma.shape != luma.shape:
        raise ValueError(f"luma {luma.shape} and chroma {chroma.shape} must be of {format.height} lines and {format.width} columns")
    blank_luma, blank_chroma = (np.full(format.width, value) for value in (BLANK_LUMA, BLANK_CHROMA))
    lines = []
    for f, before, after in ((0, format.before_top, format.after_top), (1, format.before_bottom, format.after_bottom)):
        blank = encode_line(f, 1, blank_luma, blank_chroma, format)
        lines += [blank] * before
        lines += [encode_line(f, 0, *pair, format) for pair in zip(luma[f::2], chroma[f::2], strict=True)]
        lines += [blank] * after
    return np.concatenate(lines)


def lost_bytes(format: CameraFormat) -> int:
    """A signal is lost after so many bytes, two lines, without a valid code."""
    return _LOST_LINES * format.line_bytes


@dataclass
class Decoded:
    """Content of a sequence of bytes.

    ``pictures``: complete frames. ``dropped``: incomplete frames, and bottom fields without a top field.
    ``corrected``, ``rejected``: timing codes with one wrong bit, and with more.
    """
    pictures: list[Any] = field(default_factory=list)
    dropped: int = 0
    corrected: int = 0
    rejected: int = 0


class _Receiver:
    """State of the frame in progress: ``lines`` so far, ``None`` between frames; ``awaits``, the code that must be next.

    ``blank``: there was a blank line since the last active one. ``excused``: the next bottom field belongs to a frame that was dropped
    already, or that began before reception did.
    """
    def __init__(self, format: CameraFormat) -> None:
        self.format = format
        self.result = Decoded()
        self.lines: list[Any] | None = None
        self.awaits = ""                # "EAV" in a line, "SAV" between two lines of a field, "field" between the fields
        self.bottom = False
        self.blank = False
        self.excused = True

    def give_up(self) -> None:
        """Drop the frame in progress, if there is one."""
        if self.lines is not None:
            self.result.dropped += 1
            self.lines = None
            self.excused = not self.bottom

    def lose(self) -> None:
        """Loss of signal."""
        self.give_up()
        self.excused = True

    def close_line(self, code: int, between) -> None:
        """A code within an active line, ``between`` its SAV and the code the bytes of the line."""
        assert self.lines is not None
        self.lines.append(between[1::2])
        closed = len(self.lines) in (self.format.field_lines, self.format.height)
        if len(between) != 2 * self.format.width or code != xy(self.bottom, closed, 1):
            self.give_up()
        elif len(self.lines) == self.format.height:
            picture = np.empty((self.format.height, self.format.width), np.uint8)
            picture[0::2], picture[1::2] = np.split(np.array(self.lines), 2)
            self.result.pictures.append(picture)
            self.lines = None
        else:
            self.awaits = "field" if closed else "SAV"

    def open_field(self, bottom: bool) -> None:
        """The first line of a field begins."""
        if bottom and self.lines is not None:
            self.bottom, self.awaits = True, "EAV"
        elif bottom:
            self.result.dropped += not self.excused
            self.excused = False
        else:
            self.give_up()
            self.lines, self.bottom, self.excused, self.awaits = [], False, False, "EAV"

    def code(self, code: int, between) -> None:
        """A timing code, -1 if it is invalid, and the bytes since the one before."""
        sav_of_line = code in (xy(0, 0, 0), xy(1, 0, 0))
        if self.lines is not None and self.awaits == "EAV":
            self.close_line(code, between)
        elif self.lines is not None and self.awaits == "SAV":
            if code == xy(self.bottom, 0, 0):
                self.awaits = "EAV"
            else:
                self.give_up()
        elif sav_of_line and self.blank:
            self.open_field(code == xy(1, 0, 0))
        if sav_of_line:
            self.blank = False
        elif code >= 0 and code & 0x20:
            self.blank = True


def decode(data, format: CameraFormat) -> Decoded:
    """Frames in a sequence of bytes; the reference for how strict a receiver is.

    A field begins with the first active line after a blank one; a frame is a top field and the bottom field that follows it. Each active
    line must have ``2 * width`` bytes and be closed by a valid EAV, whose V tells whether the field goes on; the next code must be the
    next line's SAV. A violation costs the frame. The bottom field of a frame that was dropped in its top field is skipped without being
    counted; so is the first one after the start, or after a loss of signal. Lengths of blanking are free, and an invalid code between the
    fields is allowed.

    A frame that is still in progress at the end is ignored.

    Parameters
    ----------
    data : (N,) uint8 ndarray
    """
    data = np.asarray(data, dtype=np.uint8)
    receiver = _Receiver(format)
    marks = np.all([data[n:len(data) - 3 + n] == value for n, value in enumerate(PREAMBLE)], axis=0)
    readable_at = start = -1
    for at in (np.flatnonzero(marks) + 3).tolist():
        code = int(CORRECTED[data[at]])
        receiver.result.corrected += code not in (-1, data[at])
        receiver.result.rejected += code == -1
        if at - readable_at > lost_bytes(format):
            receiver.lose()
        receiver.code(code, data[start + 1:at - 3])
        start = at
        if code >= 0:
            readable_at = at
    return receiver.result
