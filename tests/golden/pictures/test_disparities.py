"""golden.pictures.disparities: labels and ground truth in every form that others write, and what is refused."""

import numpy as np
import pytest
from PIL import Image

from golden.errors import UserError
from golden.pictures.disparities import LABEL_SUFFIXES, check_disparity_output, read_disparity, write_disparity, write_labels
from golden.pictures.images import read_picture, write_picture


def save(path, array, mode=None, **options):
    picture = Image.fromarray(np.asarray(array))
    (picture.convert(mode) if mode else picture).save(path, **options)
    return path


@pytest.mark.parametrize("suffix", LABEL_SUFFIXES)
def test_labels(tmp_path, suffix):
    labels = np.array([[0, 1], [127, 79], [5, 6]], dtype=np.int32)
    path = tmp_path / f"a{suffix}"
    write_labels(path, labels)
    np.testing.assert_array_equal(read_picture(path), labels)
    if suffix == ".npy":
        assert np.load(path).dtype == np.int32


@pytest.mark.parametrize("labels", [np.array([[256]]), np.array([[-1]]), np.array([[0.0]]), np.array([0])])
def test_labels_refused(tmp_path, labels):
    with pytest.raises(ValueError, match="labels are"):
        write_labels(tmp_path / "a.png", labels)
    assert not list(tmp_path.iterdir())


def test_labels_of_other_suffixes_refused(tmp_path):
    for name in ("a.jpg", "a.tif", "a"):
        with pytest.raises(UserError, match="suffix"):
            write_labels(tmp_path / name, np.zeros((2, 2), int))
    assert not list(tmp_path.iterdir())


def test_disparity(tmp_path):
    save(tmp_path / "a.png", np.array([[0, 4, 255]], dtype=np.uint8))
    assert read_disparity(tmp_path / "a.png", 4).tolist() == [[np.inf, 1, 63.75]]
    save(tmp_path / "b.png", np.array([[0, 1, 65535]], dtype=np.uint16))
    assert read_disparity(tmp_path / "b.png", 256).tolist() == [[np.inf, 1 / 256, 65535 / 256]]
    for name in ("c.pfm", "c.npy"):
        write_picture(tmp_path / name, np.array([[0, 1.5, np.inf, np.nan]]))
        assert read_disparity(tmp_path / name).tolist() == [[0, 1.5, np.inf, np.inf]]
    with pytest.raises(UserError, match="suffix"):
        read_disparity(tmp_path / "a.jpg")
    save(tmp_path / "d.png", np.array([[[255, 0, 0], [0, 255, 0]]], np.uint8))
    with pytest.raises(UserError, match="holds colours"):
        read_disparity(tmp_path / "d.png")


NUMBERS = np.array([[0, 4, 255], [16, 0, 1]], np.uint8)
PIXELS = [[np.inf, 1, 63.75], [4, np.inf, 0.25]]


@pytest.mark.parametrize("name, mode", [("a.png", None), ("a.pgm", None), ("a.tif", None), ("a.png", "RGB"), ("a.ppm", "RGB"),
                                        ("a.tiff", "RGB"), ("a.png", "P"), ("a.png", "RGBA"), ("a.PGM", None)])
def test_grey_levels_however_stored(tmp_path, name, mode):
    assert read_disparity(save(tmp_path / name, NUMBERS, mode, **({"format": "PPM"} if name == "a.PGM" else {})), 4).tolist() == PIXELS


@pytest.mark.parametrize("name", ["a.png", "a.tif", "a.pgm"])
def test_kitti(tmp_path, name):
    assert read_disparity(save(tmp_path / name, np.array([[0, 1, 65535, 256]], np.uint16)), 256).tolist() == [
        [np.inf, 1 / 256, 65535 / 256, 1]]


@pytest.mark.parametrize("greatest", [15, 255, 1023, 65535])
def test_a_pgm_is_not_scaled(tmp_path, greatest):
    (tmp_path / "a.pgm").write_text(f"P2 3 1 {greatest} 0 3 15")
    assert read_disparity(tmp_path / "a.pgm").tolist() == [[np.inf, 3, 15]]


@pytest.mark.parametrize("kind, scale", [("<f4", b"-1"), (">f4", b"1.0")])
@pytest.mark.parametrize("end", [b"\n", b" \n", b"\r\n"])
@pytest.mark.parametrize("tail", [b"", b"\n\n"])
def test_pfm(tmp_path, kind, scale, end, tail):
    values = np.array([[1.5, np.inf], [np.nan, 0], [-np.inf, 7]])
    (tmp_path / "a.pfm").write_bytes(end.join([b"Pf", b"2 3", scale, values[::-1].astype(kind).tobytes()]) + tail)
    assert read_disparity(tmp_path / "a.pfm").tolist() == [[1.5, np.inf], [np.inf, 0], [np.inf, 7]]


@pytest.mark.parametrize("unknown, expected", [
    (None, [np.inf, np.inf, -1, -16, 0, 8]), (-1, [np.inf, np.inf, np.inf, -16, 0, 8]), (-16, [np.inf, np.inf, -1, np.inf, 0, 8]),
    (0, [np.inf, np.inf, -1, -16, np.inf, 8]), (np.nan, [np.inf, np.inf, -1, -16, 0, 8]), (np.inf, [np.inf, np.inf, -1, -16, 0, 8])])
@pytest.mark.parametrize("name", ["a.pfm", "a.npy", "a.tif"])
def test_unknown(tmp_path, unknown, expected, name):
    """The number is one of the file, before the division by the scale."""
    values = np.array([[np.nan, np.inf, -1, -16, 0, 8]], np.float32)
    save(tmp_path / name, values) if name == "a.tif" else write_picture(tmp_path / name, values)
    assert read_disparity(tmp_path / name, 2, unknown).tolist() == [[each if np.isinf(each) else each / 2 for each in expected]]


@pytest.mark.parametrize("unknown, expected", [
    (None, [np.inf, 1, 255]), (255, [0, 1, np.inf]), (np.nan, [0, 1, 255]), (0, [np.inf, 1, 255])])
def test_unknown_replaces_0(tmp_path, unknown, expected):
    save(tmp_path / "a.png", np.array([[0, 1, 255]], np.uint8))
    assert read_disparity(tmp_path / "a.png", 1, unknown).tolist() == [expected]


def test_whole_arrays_have_disparities_of_0(tmp_path):
    np.save(tmp_path / "a.npy", np.array([[0, -16, 32]], np.int16))
    assert read_disparity(tmp_path / "a.npy", 16, -16).tolist() == [[0, np.inf, 2]]


@pytest.mark.parametrize("disparity, least, greatest, dtype", [
    (np.array([[0, 255]]), 0, 255, np.uint8), (np.array([[0, 3]]), 0, 256, np.uint16), (np.array([[1, 2]]), -1, 255, np.int16),
    (np.array([[-64, 191]]), -64, 191, np.int16), (np.array([[0.125, 2]]), 0, 3, np.float32), (np.array([[-0.125, 2]]), -1, 3, np.float32)])
def test_the_range_gives_the_type(tmp_path, disparity, least, greatest, dtype):
    for suffix in (".npy", ".pfm"):
        check_disparity_output(f"a{suffix}", least, greatest, disparity.dtype == np.float64, None)
        write_disparity(tmp_path / f"a{suffix}", disparity, least, greatest)
        np.testing.assert_array_equal(read_disparity(tmp_path / f"a{suffix}"), disparity)
    assert np.load(tmp_path / "a.npy").dtype == dtype


def test_png_of_16_bits(tmp_path):
    disparity = np.array([[0, 0.125, 1, 254.875, 255]])
    check_disparity_output("a.png", 0, 255, True, 256)
    write_disparity(tmp_path / "a.png", disparity, 0, 255, 256)
    with Image.open(tmp_path / "a.png") as picture:
        assert picture.mode.startswith("I") and np.asarray(picture).tolist() == [[1, 32, 256, 65248, 65280]]
    assert read_disparity(tmp_path / "a.png", 256).tolist() == [[1 / 256, *disparity[0, 1:]]]
    write_disparity(tmp_path / "b.png", disparity, 0, 255, 4)   # half up
    with Image.open(tmp_path / "b.png") as picture:
        assert np.asarray(picture).tolist() == [[1, 1, 4, 1020, 1020]]


@pytest.mark.parametrize("name, least, greatest, fractions, scale, message", [
    ("a.png", -1, 5, False, None, "a.png holds no disparity below 0, but --minimum is -1; choose one of .npy, .pfm"),
    ("a.txt", -64, 5, False, None, "a.txt holds no disparity below 0"),
    ("a.png", -1, 5, False, 256, "a.png holds no disparity below 0"),
    ("a.pgm", 0, 256, False, None, "a.pgm holds disparities up to 255, but --minimum and --disparities reach 256"),
    ("a.png", 0, 20, True, None, "a.png holds whole numbers only, but --sub-pixel gives fractions; choose one of .npy, .pfm for"),
    ("a.png", 0, 256, False, 256, "--png-scale 256 and --disparities reach 65536; choose a --png-scale up to 255"),
    ("a.png", 0, 20, False, 0, "--png-scale must be a whole number from 1 to 65535, not 0; KITTI's is 256"),
    ("a.png", 0, 1, False, 65536, "--png-scale must be a whole number from 1 to 65535, not 65536"),
    ("a.pgm", 0, 20, False, 256, "--png-scale 256 is for a .png, and a.pgm is none"),
])
def test_output_refused(name, least, greatest, fractions, scale, message):
    with pytest.raises(UserError) as error:
        check_disparity_output(name, least, greatest, fractions, scale)
    assert message in str(error.value)
