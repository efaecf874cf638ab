"""golden.pictures.white and samples: cameras of 8 to 16 bits in every format of 16, and what would be five grey levels."""

import struct
import subprocess
import sys
import zlib

import numpy as np
import pytest
from PIL import Image

from golden.__main__ import main
from golden.errors import UserError
from golden.pictures.images import read_pair, read_picture, write_picture
from golden.pictures.samples import Samples
from golden.pictures.scenes import scene
from golden.pictures.white import levels, whites


LEFT, RIGHT, _ = scene(40, 12, 8, seed=3)
LEFT[0, 0] = 255  # so that white is in the pair


def png(path, numbers, colour_type):
    """A PNG of 16 bits, of kinds that Pillow does not write."""
    lines = b"".join(b"\0" + row.astype(">u2").tobytes() for row in numbers)
    chunks = {b"IHDR": struct.pack(">IIBBBBB", numbers.shape[1], numbers.shape[0], 16, colour_type, 0, 0, 0),
              b"IDAT": zlib.compress(lines), b"IEND": b""}
    path.write_bytes(b"\x89PNG\r\n\x1a\n" + b"".join(struct.pack(">I", len(data)) + name + data + struct.pack(">I", zlib.crc32(name + data))
                                                    for name, data in chunks.items()))


def tiff(path, numbers, order="<", bits=16, photometric=1, packed=None):
    """A TIFF without compression, of kinds that Pillow does not write."""
    height, width, *channels = numbers.shape
    data = packed or numbers.astype(f"{order}u2").tobytes()
    samples = channels[0] if channels else 1
    tags = {256: width, 257: height, 258: bits, 259: 1, 262: photometric, 273: 8, 277: samples, 278: height, 279: len(data)}
    at = 8 + len(data)
    entries = b""
    for tag, value in tags.items():
        if tag == 258 and samples > 1:
            entries += struct.pack(f"{order}HHII", tag, 3, samples, at + 6 + 12 * len(tags))
        else:
            entries += struct.pack(f"{order}HHII", tag, 4, 1, value)
    path.write_bytes((b"II" if order == "<" else b"MM") + struct.pack(f"{order}HI", 42, at) + data
                     + struct.pack(f"{order}H", len(tags)) + entries + bytes(4) + struct.pack(f"{order}{samples}H", *[bits] * samples))


def pgm(path, numbers, greatest=65535):
    path.write_bytes(b"P5\n%d %d\n%d\n" % (*numbers.shape[::-1], greatest) + numbers.astype(">u2").tobytes())


WRITERS = {
    "png": lambda path, numbers: Image.fromarray(numbers).save(path, format="PNG"),
    "tif": lambda path, numbers: Image.fromarray(numbers).save(path, format="TIFF"),
    "tiff": tiff,
    "TIF": lambda path, numbers: tiff(path, numbers, ">"),
    "pgm": pgm,
}


def camera(picture, white):
    """What a camera with that white gives of grey levels; its reduction to 8 bits gives them again, because ``white`` is above 255."""
    return np.rint(picture * (white / 255)).astype(np.uint16)


def as_pair(folder, suffix, white, write=None):
    names = [folder / f"{side}.{suffix}" for side in ("left", "right")]
    for name, picture in zip(names, (LEFT, RIGHT)):
        (write or WRITERS[suffix])(name, camera(picture, white))
    return names


@pytest.mark.parametrize("suffix", WRITERS)
@pytest.mark.parametrize("bits", [9, 10, 12, 14, 15, 16])
def test_white_of_the_pair(tmp_path, capsys, suffix, bits):
    names = as_pair(tmp_path, suffix, 2**bits - 1)
    for read, expected in zip(read_pair(*names), (LEFT, RIGHT)):
        np.testing.assert_array_equal(read, expected)
    told = capsys.readouterr().err
    assert told == "" if bits == 16 else f"use {bits} of 16 bits: {2**bits - 1} is taken as white" in told and told.count("\n") == 1


@pytest.mark.parametrize("suffix", WRITERS)
def test_white_of_the_option(tmp_path, capsys, suffix):
    for read, expected in zip(read_pair(*as_pair(tmp_path, suffix, 3000), white=3000), (LEFT, RIGHT)):
        np.testing.assert_array_equal(read, expected)
    assert capsys.readouterr().err == ""
    with pytest.raises(UserError, match=r"left\..*3000 at most, not all of which are whole numbers from 0 to 2999"):
        read_pair(*as_pair(tmp_path, suffix, 3000), white=2999)


@pytest.mark.parametrize("white", [1023, 1000, 4095, 16383])
def test_a_pgm_says_what_is_white(tmp_path, capsys, white):
    names = as_pair(tmp_path, "pgm", white, lambda path, numbers: pgm(path, numbers, white))
    np.testing.assert_array_equal(read_pair(*names)[1], RIGHT)
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("suffix, greatest, bright", [("png", 65535, 1), ("pgm", 65535, 4), ("pgm", 16383, 0)])
def test_few_levels_are_told(tmp_path, capsys, suffix, greatest, bright):
    """Ten bits under a white that some hot pixels, or a header, set: five grey levels, or sixteen."""
    names = [tmp_path / f"{side}.{suffix}" for side in ("left", "right")]
    for name, picture in zip(names, (LEFT, RIGHT)):
        numbers = camera(picture, 1000)
        numbers.flat[:bright] = greatest
        pgm(name, numbers, greatest) if suffix == "pgm" else WRITERS[suffix](name, numbers)
    assert read_pair(*names)[0].max() == (255 if bright else 16)
    told = capsys.readouterr().err
    assert f"note: 99% of the pixels of {names[0]} and {names[1]} are below 16 of 255 grey levels, because white is {greatest}" in told
    pgm(tmp_path / "bright.pgm", camera(RIGHT, greatest), greatest)
    read_pair(names[0], tmp_path / "bright.pgm")
    assert "below 16" not in capsys.readouterr().err   # one dark picture of two is what it is


def test_a_dark_picture_of_8_bits_is_what_it_is(tmp_path, capsys):
    write_picture(tmp_path / "a.png", LEFT // 32)
    read_pair(tmp_path / "a.png", tmp_path / "a.png")
    assert capsys.readouterr().err == ""


def test_an_array_has_the_white_of_the_option_only(tmp_path):
    names = as_pair(tmp_path, "npy", 1023, np.save)
    np.testing.assert_array_equal(read_pair(*names, white=1023)[0], LEFT)
    with pytest.raises(UserError, match="from 0 to 255"):
        read_pair(*names)


def test_white_is_the_same_for_both(capsys):
    """Though one of them is dark: the two must stay comparable."""
    dark, bright = (Samples(np.array([[number]], np.uint16), None) for number in (3, 513))
    assert whites([dark, bright], "ab") == whites([bright, dark], "ab") == [1023, 1023]
    assert whites([dark, dark], "ab") == [255, 255]
    assert "a and b use 8 of 16 bits: 255 is taken" in capsys.readouterr().err


def test_a_pair_of_8_and_16_bits_is_refused(tmp_path):
    write_picture(tmp_path / "eight.png", LEFT)
    WRITERS["png"](tmp_path / "ten.png", camera(RIGHT, 1023))
    for names in (("eight.png", "ten.png"), ("ten.png", "eight.png")):
        with pytest.raises(UserError, match=r"ten\.png has 16 bits and .*eight\.png has not"):
            read_pair(*(tmp_path / name for name in names))


def test_a_byte_with_an_option(tmp_path):
    write_picture(tmp_path / "a.png", LEFT // 4)
    assert read_pair(tmp_path / "a.png", tmp_path / "a.png", 63)[0].tolist() == levels(LEFT // 4, 63, "").tolist()
    assert read_picture(tmp_path / "a.png").tolist() == (LEFT // 4).tolist()


@pytest.mark.parametrize("white", [1, 63, 255, 256, 1023, 65534, 65535])
def test_rounding_is_half_up(white):
    numbers = np.arange(white + 1)
    expected = [int(2 * 255 * number + white) // (2 * white) for number in range(white + 1)]
    assert levels(numbers, white, "").tolist() == expected
    assert expected[0] == 0 and expected[-1] == 255
    if white == 1023:
        np.testing.assert_array_equal(expected, np.floor(numbers * 255 / 1023 + 0.5))


@pytest.mark.parametrize("number", [-1, 1024, 0.5, np.nan])
def test_numbers_that_are_no_levels(number):
    with pytest.raises(UserError, match="not all of which are whole numbers from 0 to 1023"):
        levels(np.array([number]), 1023, "a")


def test_colours_of_16_bits(tmp_path):
    """A PPM has them; Pillow would cut those of the others to the upper byte, which is 3 of 1023."""
    colours = np.stack([camera(LEFT, 1023)] * 3, axis=-1)
    (tmp_path / "a.ppm").write_bytes(b"P6\n40 12\n1023\n" + colours.astype(">u2").tobytes())
    np.testing.assert_array_equal(read_picture(tmp_path / "a.ppm"), LEFT)
    png(tmp_path / "colour.png", colours, 2)
    png(tmp_path / "alpha.png", colours[..., :2], 4)
    tiff(tmp_path / "colour.tif", colours, photometric=2)
    for name in ("colour.png", "alpha.png", "colour.tif"):
        with pytest.raises(UserError, match=rf"{name} has colours or transparency of 16 bits, which Pillow cuts to 8; convert it"):
            read_picture(tmp_path / name)


def test_other_kinds_of_tiff(tmp_path, capsys):
    for array in (LEFT, LEFT.astype(np.float32), LEFT.astype(np.int32), np.stack([LEFT] * 3, axis=-1)):
        Image.fromarray(array).save(tmp_path / "a.tif")
        np.testing.assert_array_equal(read_picture(tmp_path / "a.tif"), LEFT)
    tiff(tmp_path / "packed.tif", np.zeros((1, 2)), bits=12, packed=bytes([0xff, 0xf0, 0x10]))  # 4095 and 16
    assert read_picture(tmp_path / "packed.tif").tolist() == [[255, 1]]
    assert capsys.readouterr().err == ""


def test_tiff_refused(tmp_path):
    picture = Image.fromarray(LEFT)
    picture.save(tmp_path / "two.tif", save_all=True, append_images=[picture])
    tiff(tmp_path / "white.tif", camera(LEFT, 1023), photometric=0)
    tiff(tmp_path / "ten.tif", np.zeros((1, 4)), bits=10, packed=bytes(5))
    for name, message in (("two.tif", "holds 2 pictures"), ("white.tif", "in which 0 is white"), ("ten.tif", "is a TIFF of a kind")):
        with pytest.raises(UserError, match=message):
            read_picture(tmp_path / name)


def test_match(tmp_path, monkeypatch, capsys):
    """Ten bits give the disparities of eight; the note is all that is on stderr."""
    monkeypatch.chdir(tmp_path)
    write_picture("left8.png", LEFT)
    write_picture("right8.png", RIGHT)
    as_pair(tmp_path, "png", 1023)
    assert main(["match", "left8.png", "right8.png", "--disparities", "8", "--output", "8.npy"]) == 0
    for arguments, notes in (([], 1), (["--white", "1023"], 0)):
        capsys.readouterr()
        assert main(["match", "left.png", "right.png", "--disparities", "8", "--output", "10.npy", *arguments]) == 0
        np.testing.assert_array_equal(np.load("10.npy"), np.load("8.npy"))
        assert capsys.readouterr().err.count("note: left.png and right.png use 10 of 16 bits") == notes


@pytest.mark.parametrize("arguments, message", [
    (["left.png", "right.png", "--white", "0"], "--white must be a whole number from 1 to 65535, not 0"),
    (["left.png", "right.png", "--white", "65536"], "not 65536"),
    (["left.png", "right.png", "--white", "255"], "left.png holds uint16 values, and 1023 at most"),
    (["--white", "1023"], "--white 1023 is for LEFT and RIGHT, which are missing"),
])
def test_option_refused(tmp_path, monkeypatch, capsys, arguments, message):
    monkeypatch.chdir(tmp_path)
    as_pair(tmp_path, "png", 1023)
    pair = [*arguments, "--disparities", "8"] if arguments[0] == "left.png" else arguments
    for command in (lambda: main(["match", *pair, "--output", "a.npy"]), lambda: main(["compare", *pair, "--scenes"])):
        assert command() == 2
        printed = capsys.readouterr()
        assert message in printed.err and printed.err.count("\n") == 1 and printed.out == ""
    assert sorted(path.name for path in tmp_path.iterdir()) == ["left.png", "right.png"]


def test_the_note_is_on_stderr(tmp_path):
    left, right = as_pair(tmp_path, "png", 4095)
    done = subprocess.run([sys.executable, "-m", "golden", "match", str(left), str(right), "--disparities", "8", "--output",
                           str(tmp_path / "a.npy")], capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and done.stderr.startswith("note: ") and "4095" in done.stderr and "4095" not in done.stdout
