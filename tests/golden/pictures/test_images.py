"""golden.pictures.images: every format, both ways, and what is refused."""

import numpy as np
import pytest
from PIL import Image

from golden.errors import UserError
from golden.pictures.images import colour_map, grey, read_pair, read_picture, write_picture


GREY = np.array([[0, 1, 2], [127, 128, 255]], dtype=np.uint8)
RGB = np.array([[[255, 0, 0], [0, 255, 0]], [[0, 0, 255], [255, 255, 255]]], dtype=np.uint8)
RGB_GREY = [[76, 150], [29, 255]]  # 76.2195, 149.685, 29.07, 254.9745


def test_grey():
    assert grey(RGB).tolist() == RGB_GREY
    # 0.2989 * 0 + 0.5870 * 0 + 0.1140 * 250 = 28.5 exactly: half up. In floating point it is 28.499999999999996 or 28.5, as one adds.
    assert grey(np.array([0, 0, 250])) == 29
    assert grey(RGB).dtype == np.uint8


@pytest.mark.parametrize("suffix", [".png", ".pgm", ".pfm", ".npy", ".txt", ".PNG"])
def test_grey_round_trip(tmp_path, suffix):
    write_picture(tmp_path / f"a{suffix}", GREY)
    result = read_picture(tmp_path / f"a{suffix}")
    assert result.dtype == np.uint8
    np.testing.assert_array_equal(result, GREY)
    assert len(list(tmp_path.iterdir())) == 1


@pytest.mark.parametrize("suffix", [".png", ".ppm", ".npy"])
def test_colour_round_trip(tmp_path, suffix):
    write_picture(tmp_path / f"a{suffix}", RGB)
    assert read_picture(tmp_path / f"a{suffix}").tolist() == RGB_GREY


@pytest.mark.parametrize("suffix", [".jpg", ".jpeg"])
def test_jpeg(tmp_path, suffix):
    smooth = np.linspace(0, 255, 64).astype(np.uint8).reshape(1, 64).repeat(16, axis=0)
    write_picture(tmp_path / f"a{suffix}", smooth)
    assert np.abs(read_picture(tmp_path / f"a{suffix}").astype(int) - smooth).max() <= 8


def save(path, array, mode=None, **options):
    picture = Image.fromarray(np.asarray(array))
    (picture.convert(mode) if mode else picture).save(path, **options)
    return path


def test_other_kinds(tmp_path):
    wide = np.array([[0, 128, 129, 65535]], dtype=np.uint16)  # 128 / 257 = 0.498, 129 / 257 = 0.502
    for name in ("a.png", "a.pgm"):
        assert read_picture(save(tmp_path / name, wide)).tolist() == [[0, 0, 1, 255]]
    assert read_picture(save(tmp_path / "b.png", RGB, "P")).tolist() == RGB_GREY
    assert read_picture(save(tmp_path / "c.png", RGB, "RGBA")).tolist() == RGB_GREY
    assert read_picture(save(tmp_path / "d.png", GREY, "LA")).tolist() == GREY.tolist()
    assert read_picture(save(tmp_path / "e.png", GREY >= 128, "1")).tolist() == [[0, 0, 0], [0, 255, 255]]
    np.save(tmp_path / "f.npy", GREY.astype(np.float64))
    assert read_picture(tmp_path / "f.npy").tolist() == GREY.tolist()
    (tmp_path / "g.pgm").write_bytes(b"P2\n# comment\n2 1\n15\n0 15\n")
    assert read_picture(tmp_path / "g.pgm").tolist() == [[0, 255]]
    exif = Image.Exif()
    exif[0x0112] = 6  # the camera was turned: to be shown turned clockwise
    assert read_picture(save(tmp_path / "h.png", GREY, exif=exif)).tolist() == np.rot90(GREY, -1).tolist()


def test_little_and_big_endian_pfm_bottom_line_first(tmp_path):
    rows = np.array([[1, 2], [3, 4]])
    for kind, scale in (("<f4", b"-1.0"), (">f4", b"1.0")):
        (tmp_path / "a.pfm").write_bytes(b"Pf\n2 2\n" + scale + b"\n" + rows[::-1].astype(kind).tobytes())
        assert read_picture(tmp_path / "a.pfm").tolist() == rows.tolist()


@pytest.mark.parametrize("array, message", [
    (np.array([[256]]), "not all of which are whole numbers from 0 to 255"),
    (np.array([[-1]]), "not all"),
    (np.array([[0.5]]), "not all"),
    (np.array([[np.nan]]), "not all"),
    (np.array([[300]], dtype=np.uint16), "not all"),  # no agreed white in an array
    (np.array([[True]]), "not all"),
    (np.array([[1j]]), "not all"),
    (np.zeros(3, np.uint8), r"shape \(3,\)"),
    (np.zeros((2, 2, 4), np.uint8), r"shape \(2, 2, 4\)"),
    (np.zeros((0, 2), np.uint8), r"shape \(0, 2\)"),
])
def test_arrays_refused(tmp_path, array, message):
    np.save(tmp_path / "a.npy", array)
    with pytest.raises(UserError, match=message):
        read_picture(tmp_path / "a.npy")


def test_files_refused(tmp_path):
    def message(path):
        with pytest.raises(UserError) as caught:
            read_picture(path)
        assert str(caught.value).count(path.name) == 1  # one sentence, not one within another
        return str(caught.value)

    assert "does not exist" in message(tmp_path / "none.png")
    assert "is a folder" in message(tmp_path)
    (tmp_path / "a.png").write_text("no picture")
    assert "is not a PNG" in message(tmp_path / "a.png")
    (tmp_path / "empty.png").touch()
    assert "is not a PNG" in message(tmp_path / "empty.png")
    save(tmp_path / "whole.png", np.random.default_rng(1).integers(0, 256, (32, 32), dtype=np.uint8))
    (tmp_path / "half.png").write_bytes((tmp_path / "whole.png").read_bytes()[:600])
    assert "cannot be read as a picture" in message(tmp_path / "half.png")
    (tmp_path / "half.npy").write_bytes(b"\x93NUMPY\x01\x00")
    assert "cannot be read as a picture" in message(tmp_path / "half.npy")
    assert "transparent pixels" in message(save(tmp_path / "b.png", np.array([[[1, 2, 3, 254]]], np.uint8)))
    assert "transparent pixels" in message(save(tmp_path / "c.png", GREY, transparency=127))
    assert "mode CMYK" in message(save(tmp_path / "d.jpg", RGB, "CMYK"))
    write_picture(tmp_path / "e.pfm", np.array([[0.5]]))
    assert "not all of which" in message(tmp_path / "e.pfm")
    (tmp_path / "f.txt").write_text("// 1 1\n00\n// 1 1\n00\n")
    assert "holds 2 pictures" in message(tmp_path / "f.txt")
    (tmp_path / "g.txt").write_text("no picture")
    assert "line 1 is 'no picture'" in message(tmp_path / "g.txt")
    for size in (b"100000 100000", b"12000 12000"):  # Pillow's error and its warning
        (tmp_path / "h.pgm").write_bytes(b"P5\n" + size + b"\n255\n\0")
        assert "more than" in message(tmp_path / "h.pgm")


def test_pair(tmp_path):
    for name, shape in (("a", (2, 3)), ("b", (3, 2)), ("c", (2, 3)), ("widest", (1, 4096)), ("wide", (1, 4097))):
        np.save(tmp_path / f"{name}.npy", np.full(shape, ord(name[0]), np.uint8))
    left, right = read_pair(tmp_path / "a.npy", tmp_path / "c.npy")
    assert (left[0, 0], right[0, 0]) == (ord("a"), ord("c"))
    with pytest.raises(UserError, match=r"differ in size: .*a\.npy has 3x2 pixels, .*b\.npy has 2x3"):
        read_pair(tmp_path / "a.npy", tmp_path / "b.npy")
    read_pair(tmp_path / "widest.npy", tmp_path / "widest.npy")
    with pytest.raises(UserError, match="4097 pixels wide, more than the 4096"):
        read_pair(tmp_path / "wide.npy", tmp_path / "wide.npy")


def test_writing_refused(tmp_path):
    with pytest.raises(UserError, match="suffix"):
        write_picture(tmp_path / "a.tif", GREY)
    for name, picture in (("a.png", GREY.astype(int)), ("a.pgm", RGB), ("a.ppm", GREY), ("a.pfm", RGB), ("a.txt", RGB)):
        with pytest.raises(ValueError):
            write_picture(tmp_path / name, picture)
    assert not list(tmp_path.iterdir())


def test_colour_map():
    colours = colour_map(np.arange(80)[None], 80)
    assert colours.shape == (1, 80, 3) and colours.dtype == np.uint8
    assert (np.diff(grey(colours)[0].astype(int)) > 0).all()  # nearer is brighter, and every label is told from the next
    np.testing.assert_array_equal(colour_map(np.array([[79]]), 80)[0, 0], colours[0, 79])
    for wrong in (80, -1):
        with pytest.raises(ValueError, match=r"not within 0 \.\. 79"):
            colour_map(np.array([[wrong]]), 80)
