"""What files and names may be like that a command did not expect."""

import io
import os
import random
import re
import stat
import struct
import zlib
from collections.abc import Callable
from pathlib import Path

import numpy as np


__all__ = ["NUMBERS", "ODD_INPUTS", "ODD_OUTPUTS", "damaged", "make_odd", "odd_name"]


#: In place of a number, in a file or on the command line.
NUMBERS = ("", "-1", "0", "1", "2", "255", "256", "65535", "65536", "2147483648", "-2147483649", "18446744073709551616", "1e999", "-1e999",
           "1e-320", "1e308", "nan", "NaN", "inf", "-inf", ".nan", ".inf", "0x10", "1_000", "1.5", "½", "٣", "9" * 5000, "null", "true",
           "[]", "{}", '"x"', "''", "x", "- 1", "1,5", "2001-99-99", "0x_", "&a [*a]", "*a", "!!python/name:os.system", "1 2")

# What a whole text file may be.
_TEXTS = (b"", b"\n", b"\0", b"\xef\xbb\xbf", b"\xff\xfea\0", b"\xff" * 40, b"[" * 100_000, b"{\"a\":" * 100_000, b"null", b"[]", b"{}",
          b"1", b"\"x\"", b"- " * 5000, b"%YAML:1.0\n---\n", b"%YAML 9.9\n---\na: 1\n", b"a: &a [*a]\n", b"? [a]\n: b\n", b"a: b: c\n",
          b"\t\n", b"a: &x [1, 1]\nb: &y [*x, *x]\nc: [*y, *y]\n", b"// 0 0\n", b"// 99999999 99999999\n00\n",
          b"// 2 1\n0g 00\n", b"<xml/>\n",
          b"name,value\n1\n2,3,4\n", b"cam0=[1 0 0; 0 1 0; 0 0 1]\nbaseline=inf\n", b"P0: 1 2 3\n", b"{\"scale\": NaN}\n", b"a" * 300_000)

# And a whole picture: magic numbers and headers that claim what is not there.
_PICTURES = (b"P5\n2147483648 1\n255\n", b"P5\n65536 65536\n255\n", b"P5\n24 16\n0\n" + b"\1" * 384, b"P5\n24 16\n65536\n" + b"\1" * 768,
             b"P5\n24 16\n99999\n" + b"\1" * 768, b"P5\n0 16\n255\n", b"P5\n-4 16\n255\n" + b"\1" * 64, b"P5 24", b"P2\n2 1\n255\n300 -1\n",
             b"P6\n24 16\n255\n" + b"\1" * 100, b"P4\n24 16\n" + b"\1" * 48, b"P7\nWIDTH 2\n", b"P1\n2 2\n0 1 2 3\n",
             b"Pf\n24 16\n0\n" + b"\1" * 1536, b"Pf\n24 16\nnan\n" + b"\1" * 1536, b"Pf\n24 16\n-1.0\n" + b"\xff" * 1536,
             b"Pf\n99999 99999\n-1.0\n", b"PF\n2 2\n-1.0\n" + struct.pack("<12f", *[float("inf")] * 12), b"Pf\n2 2\n-1.0\n" + b"\0" * 15,
             b"\x89PNG\r\n\x1a\n", b"II*\0", b"MM\0*\0\0\0\x08", b"II*\0\xff\xff\xff\xff", b"II*\0\x08\0\0\0\xff\xff", b"\xff\xd8\xff\xe0",
             b"\xff\xd8\xff\xd9", b"GIF89a", b"BM", b"\x93NUMPY", b"\x93NUMPY\x01\0\xff\xff", b"PK\x03\x04")


def _png_header(data: bytes, rng: random.Random) -> bytes:
    """A PNG whose header claims something else, with the right checksum."""
    fields = list(struct.unpack(">IIBBBBB", data[16:29]))
    which = rng.randrange(7)
    fields[which] = rng.choice((0, 1, 65536, 2**31 - 1, 2**31, 2**32 - 1) if which < 2 else (0, 1, 2, 3, 4, 6, 16, 255))
    header = b"IHDR" + struct.pack(">IIBBBBB", *fields)
    return data[:12] + header + struct.pack(">I", zlib.crc32(header)) + data[33:]


def _words(data: bytes, rng: random.Random) -> bytes:
    """A few words of a binary file replaced: sizes, offsets and counts among them."""
    result = bytearray(data)
    for _ in range(rng.randint(1, 3)):
        kind, values = rng.choice((("<H", (0, 1, 255, 65535)), ("<I", (0, 1, 65536, 2**31, 2**32 - 1)), (">I", (0, 2**31 - 1))))
        # The fields of a format are at its beginning, or, of TIFF, at its end.
        length = max(1, len(data) - struct.calcsize(kind))
        place = rng.choice((rng.randrange(length), rng.randrange(min(64, length)), max(0, length - 1 - rng.randrange(min(200, length)))))
        packed = struct.pack(kind, rng.choice(values))
        result[place:place + len(packed)] = packed
    return bytes(result)


def _array(rng: random.Random) -> bytes:
    """An NPY file of an array that is no picture, or of numbers that are none."""
    arrays: tuple[Callable[[], np.ndarray], ...] = (
        lambda: np.full((16, 24), np.nan), lambda: np.full((16, 24), np.inf, np.float32), lambda: np.full((16, 24), 1e300),
        lambda: np.full((16, 24), -1), lambda: np.zeros((0, 24), np.uint8), lambda: np.zeros((16, 0), np.uint8), lambda: np.array(7),
        lambda: np.zeros((1, 1), np.uint8), lambda: np.zeros((16, 24, 3, 1), np.uint8), lambda: np.zeros((16, 24, 4), np.uint8),
        lambda: np.zeros((16, 24), complex), lambda: np.zeros((16, 24), bool), lambda: np.full((16, 24), "a"),
        lambda: np.zeros((16, 24), "M8[s]"), lambda: np.zeros((16, 24), [("a", "u1")]), lambda: np.full((16, 24), 2**63, np.uint64),
        lambda: np.full((16, 24), 0.5, np.float16), lambda: np.zeros((1, 4097), np.uint8), lambda: np.zeros((16, 24), ">u2"),
        lambda: np.zeros((16, 24), np.uint8, order="F"))
    stored = io.BytesIO()
    np.lib.format.write_array(stored, rng.choice(arrays)(), allow_pickle=False)
    data = stored.getvalue()
    if rng.random() < 0.4:      # another shape or type than the data have
        changes = ((rb"\(\d+, \d+", b"(99999999, 99999999"), (rb"\(\d+", b"(-1"), (rb"'descr': '[^']*'", b"'descr': '|O'"),
                   (rb"False", b"Fals"), (rb"'descr'", b"'Descr'"), (rb"\(\d+", b"(" * 300))
        pattern, text = rng.choice(changes)
        data = re.sub(pattern, text, data, count=1)
    return data


def _text(data: bytes, rng: random.Random) -> bytes:
    """A text file with a number, a name or a line that is not what it was."""
    result = data
    for _ in range(rng.choice((1, 1, 2))):
        kind = rng.randrange(5)
        lines = result.splitlines(keepends=True) or [b""]
        if kind < 2:
            places = list(re.finditer(rb"-?\d+(?:\.\d+)?(?:e[-+]?\d+)?", result))
            if places:
                place = rng.choice(places)
                result = result[:place.start()] + rng.choice(NUMBERS).encode() + result[place.end():]
        elif kind == 2:
            del lines[rng.randrange(len(lines))]
            result = b"".join(lines)
        elif kind == 3:
            lines.insert(rng.randrange(len(lines) + 1), rng.choice(lines))
            result = b"".join(lines)
        else:
            words = list(re.finditer(rb"[A-Za-z_]\w*", result))
            if words:
                word = rng.choice(words)
                result = result[:word.start()] + rng.choice((b"", b"x", b"null", b"1", b"\xff", "ü".encode())) + result[word.end():]
    return result


def damaged(name: str, data: bytes, rng: random.Random) -> bytes:
    """Another content for the file ``name``, whose sound content is ``data``."""
    binary = b"\0" in data[:256] or data[:2] in (b"P5", b"P6", b"Pf", b"\xff\xd8") or name.endswith(".npy")
    kind = rng.randrange(8)
    if kind == 0:
        return data[:rng.randrange(len(data) + 1)]
    if kind == 1:
        result = bytearray(data)
        for _ in range(rng.randint(1, 8)):
            if result:
                result[rng.randrange(len(result))] ^= 1 << rng.randrange(8)
        return bytes(result)
    if kind == 2:
        return rng.choice(_PICTURES if binary else _TEXTS)
    if kind == 3 and name.endswith(".npy"):
        return _array(rng)
    if kind <= 5 and data[:8] == _PICTURES[19]:
        return _png_header(data, rng)
    if kind == 6:
        return data + data[:rng.randrange(len(data) + 1)]
    return _words(data, rng) if binary else _text(data, rng)


#: Inputs that are no files, or no usual ones; :func:`make_odd` makes what must be there.
ODD_INPUTS = ("absent", "folder", "fifo", "loop", "dangling", "unreadable", "closed_folder", "in_file", "long", "too_long", "newline",
              "not_utf8", "dash", "option", "empty_name", "here", "above", "endless", "nothing", "slash")

#: Outputs of that sort.
ODD_OUTPUTS = ("folder", "fifo", "loop", "dangling", "unwritable", "closed_folder", "read_only_folder", "in_file", "in_absent", "long",
               "too_long", "newline", "not_utf8", "full", "nothing", "empty_name", "here", "above", "slash", "link", "no_suffix",
               "other_suffix", "option")

# Devices are made in the case's folder, where root may: all names are relative, because no case may reach the machine's own files.
_DEVICES = {"nothing": 3, "endless": 5, "full": 7}

_NAMES = {
    "absent": "absent{}", "folder": "folder{}", "fifo": "fifo{}", "loop": "loop{}", "dangling": "dangling{}", "unreadable": "unreadable{}",
    "unwritable": "unwritable{}", "closed_folder": "closed/a{}", "read_only_folder": "read_only/a{}", "in_file": "file/a{}",
    "in_absent": "nowhere/deep/a{}", "newline": "new\nline: Traceback{}", "not_utf8": "\udcff\udcfe{}", "dash": "-", "option": "--x{}",
    "empty_name": "", "here": ".", "above": "..", "endless": "zero", "nothing": "null", "full": "full",
    "slash": "absent{}/", "link": "link{}", "no_suffix": "output", "other_suffix": "output.exe",
}


def odd_name(kind: str, suffix: str) -> str:
    """The name that goes with one of :data:`ODD_INPUTS` or :data:`ODD_OUTPUTS`."""
    if kind in ("long", "too_long"):    # 255 bytes are the most that a file system takes
        return "n" * (255 - len(suffix) + (kind == "too_long")) + suffix
    return _NAMES[kind].format(suffix)


def make_odd(kind: str, path: Path, data: bytes) -> None:
    """Make what ``kind`` says at that place; a file that is read has this content."""
    if kind == "folder":
        path.mkdir(exist_ok=True)
    elif kind == "fifo":
        if not os.path.lexists(path):
            os.mkfifo(path)
    elif kind in ("loop", "dangling", "link"):
        if not os.path.lexists(path):
            path.symlink_to({"loop": path.name, "dangling": "nowhere/else", "link": "target"}[kind])
        if kind == "link":
            (path.parent / "target").write_bytes(data)
    elif kind in _DEVICES:
        os.mknod(path, stat.S_IFCHR | 0o666, os.makedev(1, _DEVICES[kind]))
        path.chmod(0o666)
    elif kind == "in_file":
        path.parent.write_bytes(b"a file\n")
    elif kind in ("unreadable", "unwritable", "newline", "not_utf8", "long"):
        path.write_bytes(data)
        if kind.startswith("un"):
            path.chmod(0 if kind == "unreadable" else stat.S_IRUSR)
    elif kind in ("closed_folder", "read_only_folder"):
        path.parent.mkdir(exist_ok=True)
        if not path.exists():
            path.write_bytes(data)
