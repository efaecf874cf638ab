"""golden.pictures.text: text pictures, both ways."""

import io

import numpy as np
import pytest

from golden.errors import UserError
from golden.pictures.text import read_text, write_text


PICTURES = [np.array([[0, 10, 255]], dtype=np.uint8), np.array([[1], [2]], dtype=np.uint8)]
TEXT = b"// 3 1\n00 0a ff\n// 1 2\n01\n02\n"


def test_bytes(tmp_path):
    write_text(tmp_path / "a.txt", PICTURES)
    assert (tmp_path / "a.txt").read_bytes() == TEXT
    file = io.BytesIO()
    write_text(file, [picture.astype(np.int64) for picture in PICTURES])
    assert file.getvalue() == TEXT
    assert [path.name for path in tmp_path.iterdir()] == ["a.txt"]


@pytest.mark.parametrize("text", [TEXT, TEXT.replace(b"\n", b"\r\n"), TEXT.rstrip()])
def test_read(tmp_path, text):
    (tmp_path / "a.txt").write_bytes(text)
    pictures = read_text(tmp_path / "a.txt")
    assert len(pictures) == len(PICTURES)
    for picture, expected in zip(pictures, PICTURES):
        assert picture.dtype == np.uint8 and picture.flags.writeable
        np.testing.assert_array_equal(picture, expected)


def test_wider_words(tmp_path):
    (tmp_path / "a.txt").write_text("// 3 1\n000000 01fe02 ffffff\n// 1 2\n000100\n000003\n")
    wide, tall = read_text(tmp_path / "a.txt", 6)
    assert wide.tolist() == [[0, 0x01FE02, 0xFFFFFF]] and tall.tolist() == [[256], [3]]
    with pytest.raises(UserError, match="expected 3 bytes of two lower-case"):
        read_text(tmp_path / "a.txt")
    (tmp_path / "b.txt").write_bytes(TEXT)
    with pytest.raises(UserError, match="expected 3 words of four lower-case"):
        read_text(tmp_path / "b.txt", 4)


def test_round_trip(tmp_path):
    rng = np.random.default_rng(1)
    pictures = [rng.integers(0, 256, shape, dtype=np.uint8) for shape in ((1, 1), (5, 3), (16, 16), (1, 300))]
    write_text(tmp_path / "a.txt", pictures)
    for picture, expected in zip(read_text(tmp_path / "a.txt"), pictures, strict=True):
        np.testing.assert_array_equal(picture, expected)


@pytest.mark.parametrize("text, message", [
    (b"", "is empty"),
    (b"\n" + TEXT, "line 1 is '' where a picture must start"),
    (b"00 0a ff\n", "line 1 is '00 0a ff' where a picture must start"),
    (b"// 3\n00 0a ff\n", "line 1 is '// 3' where"),
    (b"// -3 1\n00 0a ff\n", "where a picture must start"),
    (b"// 0 1\n\n", "size 0x1"),
    (b"// 1 0\n", "size 1x0"),
    (b"// 3 1\n00 0a\n", "line 2 holds 2 bytes; expected 3"),
    (b"// 3 1\n00 0a ff 00\n", "line 2 holds 4 bytes; expected 3"),
    (b"// 3 1\n000aff\n", "line 2 is '000aff'"),
    (b"// 3 1\n00  0a ff\n", "line 2 is"),
    (b"// 3 1\n00 xx ff\n", "line 2 is '00 xx ff'"),
    (b"// 3 1\n00 0A ff\n", "line 2 is '00 0A ff'"),
    (b"// 3 1\n0A 00 ff\n", "line 2 is '0A 00 ff'"),
    (b"// 3 1\n00 a ff\n", "line 2 is"),
    (b"// 3 1\n00 0a ff \n", "line 2 is"),
    (b"// 3 2\n00 0a ff\n", "ends after 1 rows of its picture 1; expected 2"),
    (b"// 3 1\n00 0a ff\n00 0a ff\n", "line 3 is '00 0a ff' where a picture must start"),
    (TEXT + b"// 1 2\n00\n", "ends after 1 rows of its picture 3"),
    (b"\x89PNG\r\n", "not ASCII"),
])
def test_malformed(tmp_path, text, message):
    (tmp_path / "a.txt").write_bytes(text)
    with pytest.raises(UserError) as caught:
        read_text(tmp_path / "a.txt")
    assert message in str(caught.value) and "a.txt" in str(caught.value)


def test_not_there(tmp_path):
    with pytest.raises(UserError, match=r"cannot read .*a\.txt"):
        read_text(tmp_path / "a.txt")


@pytest.mark.parametrize("picture", [np.zeros(3, int), np.zeros((0, 3), int), np.array([[256]]), np.array([[-1]]), np.array([[1.0]])])
def test_not_bytes(tmp_path, picture):
    with pytest.raises(ValueError, match="whole numbers from 0 to 255"):
        write_text(tmp_path / "a.txt", [PICTURES[0], picture])
    assert not list(tmp_path.iterdir())
