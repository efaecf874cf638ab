"""What `golden match` writes is read by other programs as it was meant: OpenCV, imageio, NumPy."""

import imageio.v3
import numpy as np
import pytest

from golden.__main__ import main
from golden.pictures.images import write_picture
from golden.pictures.scenes import scene


def opencv(path):
    cv2 = pytest.importorskip("cv2", reason="cv2, of the extra lab, is not installed")
    return cv2.imread(path, cv2.IMREAD_UNCHANGED)


def pillow(path):
    return imageio.v3.imread(path, plugin="pillow")  # with OpenCV installed imageio would choose it, and reduce all to 8 bits


READERS = pytest.mark.parametrize("read", [opencv, pillow])


@pytest.fixture
def run(tmp_path, monkeypatch):
    """Runs the command in a folder with a pair of odd size; the result is its disparities, from ``d.npy``."""
    monkeypatch.chdir(tmp_path)
    left, right, _ = scene(41, 13, 12, seed=1)
    write_picture("left.png", left)
    write_picture("right.png", right)

    def run(*arguments):
        command = ["match", "left.png", "right.png", "--disparities", "12", *arguments]
        assert main([*command, "--output", "d.npy"]) == 0
        return np.load("d.npy"), command

    return run


@READERS
@pytest.mark.parametrize("arguments", [[], ["--method", "fused", "--sub-pixel"], ["--minimum", "250"]])
def test_disparities(run, read, arguments):
    disparity, command = run(*arguments)
    assert main([*command, "--output", "d.pfm"]) == 0
    found = read("d.pfm")
    assert found.dtype == np.float32
    np.testing.assert_array_equal(found, disparity)
    if not arguments:
        for name in ("d.png", "d.pgm"):
            assert main([*command, "--output", name]) == 0
            assert read(name).dtype == np.uint8
            np.testing.assert_array_equal(read(name), disparity)


@READERS
@pytest.mark.parametrize("arguments", [[], ["--method", "fused", "--sub-pixel"]])
def test_kitti(run, read, arguments):
    disparity, command = run(*arguments)
    assert main([*command, "--output", "d.png", "--png-scale", "256"]) == 0
    found = read("d.png")
    assert found.dtype == np.uint16 and found.shape == disparity.shape
    np.testing.assert_array_equal(found, np.maximum(disparity * 256.0, 1))


@READERS
def test_depth(run, read):
    disparity, command = run("--focal", "100", "--baseline", "0.3", "--depth", "z.pfm")
    expected = np.full(disparity.shape, np.inf)
    np.divide(30, disparity, out=expected, where=disparity > 0)
    np.testing.assert_array_equal(read("z.pfm"), expected.astype(np.float32))
    assert np.isfinite(expected).sum() not in (0, expected.size)
    assert main([*command, "--depth", "z.npy", "--output", "d.npy"]) == 0
    np.testing.assert_array_equal(np.load("z.npy"), expected.astype(np.float32))
    assert main([*command, "--depth", "z.png", "--baseline-unit", "m", "--output", "d.npy"]) == 0
    found = read("z.png")
    assert found.dtype == np.uint16
    np.testing.assert_array_equal(found, np.where(np.isfinite(expected), np.floor(1000 * expected + 0.5), 0))
