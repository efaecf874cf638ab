"""golden.pictures.dataset: reduction worked by hand, and properties of the benchmark's pairs."""

import shutil
import sys

import numpy as np
import pytest

from golden.errors import UserError
from golden.pictures import dataset
from golden.pictures.images import write_picture
from tests.kit import middlebury, reduced_motorcycle


def test_reduced_levels():
    # Means 2.5 (half up) and 255; the third column and the third row are dropped.
    picture = np.array([[1, 2, 255, 255, 9], [3, 4, 255, 255, 9], [9, 9, 9, 9, 9]], dtype=np.uint8)
    assert dataset._reduce_levels(picture, 2).tolist() == [[3, 255]]
    np.testing.assert_array_equal(dataset._reduce_levels(picture, 1), picture)


@pytest.mark.parametrize("block, expected", [
    ([8, 8, 8, 8], 4),
    ([6, 20, 20, 6], 3),          # lower median: one of the two, not 6.5
    ([6, 20, 20, 20], 10),
    ([np.inf, np.inf, 8, 20], 4),  # half known is enough
    ([np.inf, np.inf, np.inf, 8], np.inf),
    ([np.inf] * 4, np.inf),
])
def test_reduced_truth(block, expected):
    assert dataset._reduce_truth(np.array(block).reshape(2, 2), 2).tolist() == [[expected]]


@pytest.mark.parametrize("name, shape, disparities, known", [
    ("tsukuba", (288, 384), 16, 87696),  # a border of 18 pixels is not known
    ("venus", (383, 434), 20, 0), ("teddy", (375, 450), 60, 0), ("cones", (375, 450), 60, 0),
])
def test_middlebury(name, shape, disparities, known):
    pair = middlebury(name)
    assert pair.name == name and pair.disparities == disparities
    assert pair.left.shape == pair.right.shape == pair.truth.shape == shape
    assert list(pair.masks) == ["nonocc", "all", "disc"]
    # Each mask is within the one before, as the benchmark defines them.
    nonocc, everything, disc = pair.masks.values()
    assert not (nonocc & ~everything).any() and not (disc & ~nonocc).any()
    assert 0 < disc.sum() < nonocc.sum() < everything.sum()
    assert np.isfinite(pair.truth[everything]).all()
    assert pair.truth[everything].max() <= disparities


def test_motorcycle():
    pair = reduced_motorcycle()
    assert pair.left.shape == pair.right.shape == pair.truth.shape == (120, 180)
    assert pair.left.dtype == pair.right.dtype == np.uint8
    known = pair.masks["known"]
    np.testing.assert_array_equal(known, np.isfinite(pair.truth))
    assert known.mean() > 0.9
    assert pair.disparities - 2 < pair.truth[known].max() <= pair.disparities - 1
    # left(x) matches right(x - d): the truth explains the pictures, its negative and another scale do not.
    y, x = np.nonzero(known)
    d = np.round(pair.truth[y, x]).astype(int)

    def difference(shift):
        inside = (x - shift >= 0) & (x - shift < 180)
        return np.abs(pair.left[y, x].astype(int) - pair.right[y, np.clip(x - shift, 0, 179)])[inside].mean()

    assert difference(d) < 0.5 * min(difference(-d), difference(d // 2), difference(2 * d))


def test_motorcycle_sizes():
    reduced_motorcycle()  # skips
    assert dataset.motorcycle(8).left.shape == (62, 92)
    assert dataset.motorcycle(8, max_width=40, max_height=20).left.shape == (20, 40)


def test_motorcycle_without_scikit_image(monkeypatch):
    monkeypatch.setitem(sys.modules, "skimage.data", None)
    with pytest.raises(UserError, match="scikit-image, which is not installed"):
        dataset.motorcycle()


def test_data_folder(tmp_path, monkeypatch):
    monkeypatch.setenv("STEREO_DATA", str(tmp_path))
    assert dataset.data_folder() == tmp_path
    (tmp_path / "other").mkdir()
    assert dataset.data_folder(tmp_path / "other") == tmp_path / "other"
    monkeypatch.setenv("STEREO_DATA", str(tmp_path / "none"))
    with pytest.raises(UserError, match="none does not exist; name the one that holds tsukuba"):
        dataset.data_folder()


def small(folder):
    """A folder as the benchmark has it, with pictures of 2x1 pixels."""
    (folder / "teddy").mkdir()
    files = {"left": (1, 2), "right": (3, 4), "disp_left": (0, 10), "nonocc": (255, 0), "all": (255, 255), "disc": (128, 255)}
    for name, values in files.items():
        write_picture(folder / "teddy" / f"{name}.png", np.array([values], dtype=np.uint8))
    return folder


def test_load_pair(tmp_path):
    pair = dataset.load_pair(small(tmp_path), "teddy")
    assert (pair.left.tolist(), pair.right.tolist(), pair.truth.tolist()) == ([[1, 2]], [[3, 4]], [[np.inf, 2.5]])
    assert {name: mask.tolist() for name, mask in pair.masks.items()} == {
        "nonocc": [[True, False]], "all": [[True, True]], "disc": [[False, True]]}


@pytest.mark.parametrize("name", ["disp_left", "disc"])
def test_load_pair_refuses_other_sizes(tmp_path, name):
    write_picture(small(tmp_path) / "teddy" / f"{name}.png", np.zeros((2, 2), np.uint8))
    with pytest.raises(UserError, match=f"{name}.png and its left picture differ in size"):
        dataset.load_pair(tmp_path, "teddy")


def test_load_pair_incomplete(tmp_path):
    (small(tmp_path) / "teddy" / "all.png").unlink()
    with pytest.raises(UserError, match=r"all\.png does not exist"):
        dataset.load_pair(tmp_path, "teddy")
    shutil.rmtree(tmp_path / "teddy")
    with pytest.raises(UserError, match=r"left\.png does not exist"):
        dataset.load_pair(tmp_path, "teddy")
