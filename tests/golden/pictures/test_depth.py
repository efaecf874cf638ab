"""golden.pictures.depth: equation (1-1) by hand, and the three files."""

import numpy as np
import pytest

from golden.pictures.calibration import Calibration
from golden.pictures.depth import depth, millimetres, points, write_depth
from golden.pictures.disparities import read_disparity


CALIBRATION = Calibration(focal=100, baseline=0.5, offset=2, centre=(1, 0))


def test_depth():
    disparity = np.array([[0, 3, -2], [8, -3, 0.5]])
    np.testing.assert_array_equal(depth(disparity, CALIBRATION), [[25, 10, np.inf], [5, np.inf, 20]])


def test_points_project_back():
    z = depth(np.arange(12).reshape(3, 4), CALIBRATION)
    left = np.arange(12, dtype=np.uint8).reshape(3, 4)
    positions, levels = points(z, left, CALIBRATION)
    x, y = (positions[:, k] * CALIBRATION.focal / positions[:, 2] for k in (0, 1))
    np.testing.assert_allclose(x + 1, np.tile(np.arange(4), 3), atol=1e-9)
    np.testing.assert_allclose(y, np.repeat(np.arange(3), 4), atol=1e-9)
    np.testing.assert_array_equal(levels, left.ravel())


def test_the_middle_is_the_principal_point():
    positions, _ = points(np.full((3, 5), 2.0), np.zeros((3, 5), np.uint8), Calibration(focal=1, baseline=1))
    np.testing.assert_array_equal(positions[7], [0, 0, 2])
    np.testing.assert_array_equal(positions[0], [-4, -2, 2])


def test_focal_lengths_differ():
    calibration = Calibration(focal=100, baseline=1, centre=(0, 0), focal_y=80)
    positions, _ = points(np.full((2, 2), 4.0), np.zeros((2, 2), np.uint8), calibration)
    np.testing.assert_array_equal(positions[3], [4 / 100, 4 / 80, 4])


def test_millimetres():
    z = np.array([[np.inf, 0.0004, 0.0014, 0.0015], [1, 65.535, 65.5354, 65.5356]])
    whole, far = millimetres(z, Calibration(1, 1, millimetres=1000))
    assert whole.tolist() == [[0, 1, 1, 2], [1000, 65535, 65535, 0]] and far == 1
    with pytest.raises(ValueError, match="unit"):
        millimetres(z, Calibration(1, 1))


@pytest.mark.parametrize("suffix", [".npy", ".pfm"])
def test_numbers(tmp_path, suffix):
    z = np.array([[1.5, np.inf, 0.25], [2, 3, 4]])
    write_depth(tmp_path / f"z{suffix}", z, np.zeros(z.shape, np.uint8), CALIBRATION)
    np.testing.assert_array_equal(read_disparity(tmp_path / f"z{suffix}"), z)
    if suffix == ".npy":
        assert np.load(tmp_path / "z.npy").dtype == np.float32


def test_cloud(tmp_path):
    z = np.array([[1.0, np.inf, 4.0]])
    write_depth(tmp_path / "z.ply", z, np.array([[7, 8, 9]], np.uint8), CALIBRATION)
    header, _, body = (tmp_path / "z.ply").read_bytes().partition(b"end_header\n")
    assert header.startswith(b"ply\nformat binary_little_endian 1.0\nelement vertex 2\nproperty float x\n")
    cloud = np.frombuffer(body, dtype=[("x", "<f4"), ("y", "<f4"), ("z", "<f4"), ("red", "u1"), ("green", "u1"), ("blue", "u1")])
    np.testing.assert_allclose(cloud["x"], [-0.01, 0.04], rtol=1e-6)
    assert cloud["y"].tolist() == [0, 0] and cloud["z"].tolist() == [1, 4]
    assert cloud["red"].tolist() == cloud["green"].tolist() == cloud["blue"].tolist() == [7, 9]
