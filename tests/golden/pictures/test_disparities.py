"""golden.pictures.disparities: labels and ground truth in every form that others write, and what is refused."""

import numpy as np
import pytest
from PIL import Image

from golden.errors import UserError
from golden.pictures.disparities import LABEL_SUFFIXES, read_disparity, write_labels
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
    with pytest.raises(UserError, match="shape"):
        read_disparity(tmp_path / "d.png")
