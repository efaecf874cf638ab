"""golden.pictures.netpbm: headers as programs write them, both byte orders, and files that contradict their header."""

from pathlib import Path

import numpy as np
import pytest

from golden.errors import UserError
from golden.pictures.netpbm import read_netpbm


FLOATS = np.array([[1.5, -2], [np.inf, 4], [5, 6]], dtype=np.float32)


def read(data):
    return read_netpbm(data, Path("a.pgm"))


def pfm(header, kind="<f4", tail=b""):
    return header + FLOATS[::-1].astype(kind).tobytes() + tail


@pytest.mark.parametrize("data, expected, greatest", [
    (b"P5 3 1 255\n\x00\x0a\xff", [[0, 10, 255]], 255),
    (b"P5\n# a comment\n3 # and another\r\n1\n255\n\x00\x0a\xff", [[0, 10, 255]], 255),
    (b"P5\r\n3 1\r\n255\r\n\x00\x0a\xff", [[0, 10, 255]], 255),
    (b"P5\n3 1\n255\n\n\x0a\xff", [[10, 10, 255]], 255),   # the second line end is a number
    (b"P5\n3 1\n255 \n\x0a\xff", [[10, 10, 255]], 255),    # as is this one, for there would be too few without
    (b"P5\n1 2\n1023\n\x03\xff\x00\x01\n\n", [[1023], [1]], 1023),
    (b"P2\n# c\n2 1\n1023\n1023 # white\n 0\n", [[1023, 0]], 1023),
    (b"P3 1 1 15 1 2 15", [[[1, 2, 15]]], 15),
    (b"P6 1 1 4095\n\x0f\xff\x00\x00\x00\x01", [[[4095, 0, 1]]], 4095),
])
def test_whole_numbers(data, expected, greatest):
    numbers, told = read(data)
    assert numbers.tolist() == expected and told == greatest
    assert numbers.dtype == (np.uint16 if greatest > 255 else np.uint8)


@pytest.mark.parametrize("data", [
    pfm(b"Pf\n2 3\n-1.0\n"), pfm(b"Pf\n2 3\n-0.003922\n"), pfm(b"Pf\n2 3\n1\n", ">f4"), pfm(b"Pf\r\n2 3\r\n-1.0\r\n"),
    pfm(b"Pf\n2 3 \n-1.000000 \n"), pfm(b"Pf\n2\n3\n-1e0\t \r\n"), pfm(b"Pf\n2 3\n-1\n", tail=b"\n"),
    pfm(b"Pf\n2 3\n-1 \r\n", tail=b"\r\n \n"), pfm(b"Pf 2 3 1\n", ">f4"),
])
def test_floats(data):
    numbers, greatest = read(data)
    assert numbers.dtype == np.float32 and greatest is None
    np.testing.assert_array_equal(numbers, FLOATS)


def test_floats_in_colour():
    numbers, _ = read(b"PF\n1 2\n-1\n" + np.arange(6, dtype="<f4").tobytes())
    assert numbers.tolist() == [[[3, 4, 5]], [[0, 1, 2]]]


@pytest.mark.parametrize("data, message", [
    (b"P5\n1 2\n1023\n\x04\x00\x00\x01", "holds the number 1024, above 1023, the greatest that its header allows"),
    (b"P5\n2 1\n100\n\x00\x65", "holds the number 101, above 100"),
    (b"P2 2 1 255 0 256", "holds the number 256, above 255"),
    (b"P5\n2 2\n255\n\x00\x01\x02", "ends after 3 bytes of its numbers, but its header says 4"),
    (b"P5\n2 2\n255", "ends after 0 bytes of its numbers"),
    (b"P5\n2 1\n255\n\x00\x01\x02", "is longer than its header says, by 1 bytes"),
    (pfm(b"Pf\n2 3\n-1.0\n")[:-1], "ends after 23 bytes of its numbers, but its header says 24"),
    (pfm(b"Pf\n2 3\n-1.0\n", tail=b"\0\0"), "is longer than its header says, by 2 bytes"),
    (pfm(b"Pf\n2 3\n-1.0 \n", tail=b"\0"), "is longer than its header says, by 1 bytes"),
    (pfm(b"Pf\n2 3\n0\n"), "has the scale 0 in its header; write -1"),
    (pfm(b"Pf\n2 3\nnan\n"), "has the scale nan"),
    (pfm(b"Pf\n2 3\nlittle\n"), "has the scale little"),
    (b"P5\n2 -2\n255\n", "has the height -2 in its header, which is not a whole number above 0"),
    (b"P5\n0 2\n255\n", "has the width 0 in its header"),
    (b"P5\n2 2\n65536\n", "has the greatest value 65536 in its header, which is not a whole number from 1 to 65535"),
    (b"P5\n2", "has no height in its header"),
    (b"P2 2 1 255 0", "holds 1 numbers, but its header says 2"),
    (b"P2 2 1 255 0 1 2", "holds 3 numbers, but its header says 2"),
    (b"P2 2 1 255 0 -1", "holds '-1' where a whole number is expected"),
])
def test_refused(data, message):
    with pytest.raises(UserError) as caught:
        read(data)
    assert message in str(caught.value) and str(caught.value).count("a.pgm") == 1
