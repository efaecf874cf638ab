"""golden.calibrate.sources: files of OpenCV and Kalibr describe the same cameras as they do; others are refused."""

from pathlib import Path

import numpy as np
import pytest
import yaml

from golden.calibrate.sources import read_cameras, read_intrinsics
from golden.errors import UserError

from .boards import SIZE, Cameras, opencv


@pytest.fixture
def cameras(tmp_path, monkeypatch):
    """Known cameras, and files of them in the working folder."""
    monkeypatch.chdir(tmp_path)
    cv2, known = opencv(), Cameras()
    for name, entries in (("intrinsics.yml", {"M1": known.matrix, "D1": known.distortion, "M2": known.matrix, "D2": known.distortion}),
                          ("extrinsics.yml", {"R": known.rotation, "T": known.translation / 10})):
        storage = cv2.FileStorage(name, cv2.FILE_STORAGE_WRITE)
        for key, value in entries.items():
            storage.write(key, value)
        storage.release()
    place = np.eye(4)
    place[:3, :3], place[:3, 3:] = known.rotation, known.translation / 1000
    matrix = known.matrix
    camera = {"camera_model": "pinhole", "intrinsics": [float(each) for each in (matrix[0, 0], matrix[1, 1], matrix[0, 2], matrix[1, 2])],
              "distortion_model": "radtan", "distortion_coeffs": known.distortion[:4].tolist(), "resolution": [*SIZE], "rostopic": "/a"}
    write("camchain.yaml", {"cam0": camera, "cam1": {**camera, "T_cn_cnm1": place.tolist()}})
    return known


def write(name, document):
    with open(name, "w", encoding="utf-8") as file:
        yaml.safe_dump(document, file)


def changed(**changes):
    """The camera chain with changes of its ``cam1``."""
    with open("camchain.yaml", encoding="utf-8") as file:
        document = yaml.safe_load(file)
    document["cam1"] |= changes
    write("camchain.yaml", document)


@pytest.mark.parametrize("paths, size, unit", [
    (["intrinsics.yml", "extrinsics.yml"], SIZE, 10), (["extrinsics.yml", "intrinsics.yml"], SIZE, 10),
    (["camchain.yaml"], None, None), (["camchain.yaml"], SIZE, None)])
def test_read(cameras, paths, size, unit):
    found = read_cameras([*map(Path, paths)], size, unit)
    assert found.size == SIZE and np.allclose(found.translation, cameras.translation) and np.allclose(found.rotation, cameras.rotation)
    for matrix, distortion in zip(found.matrices, found.distortions):
        assert np.allclose(matrix, cameras.matrix) and np.allclose(distortion[:4], cameras.distortion[:4])
    left, right = next(cameras.views(noise=0)).left, next(cameras.views(noise=0)).right
    assert np.abs(found.corner_dy(left, right)).max() < 0.01


def test_intrinsics(cameras):
    left, bent, right, _ = read_intrinsics(Path("intrinsics.yml"))
    assert (left == cameras.matrix).all() and (right == cameras.matrix).all() and bent[0] == -0.1


@pytest.mark.parametrize("paths, size, unit, message", [
    (["intrinsics.yml"], SIZE, 1, "intrinsics.yml has no R and no T; give the file that has"),
    (["extrinsics.yml"], SIZE, 1, "extrinsics.yml has no M1 and no D1 and no M2 and no D2"),
    (["intrinsics.yml", "extrinsics.yml"], None, 1, "does not tell the size of the pictures; give --size"),
    (["intrinsics.yml", "extrinsics.yml"], SIZE, None, "does not tell the unit of T; give --baseline-unit"),
    (["camchain.yaml", "extrinsics.yml"], None, None, "camchain.yaml of Kalibr has both cameras; leave extrinsics.yml out"),
    (["camchain.yaml"], None, 1, "camchain.yaml of Kalibr is in metres; leave --baseline-unit out"),
    (["camchain.yaml"], (9, 9), None, "differ in the size of the pictures, or its cameras do: 320x240, 320x240, 9x9"),
    (["absent.yml"], SIZE, 1, "cannot read absent.yml: No such file"),
])
def test_refused(cameras, paths, size, unit, message):
    with pytest.raises(UserError, match=message):
        read_cameras([*map(Path, paths)], size, unit)


@pytest.mark.parametrize("changes, message", [
    ({"camera_model": "omni"}, "has the cam1 of camera_model omni, distortion_model radtan"),
    ({"distortion_model": "equidistant"}, "only pinhole with radtan or none can be rectified"),
    ({"intrinsics": [1, 2, 3]}, "has a cam1.intrinsics that is not 4 numbers"),
    ({"resolution": "a"}, "has a cam1.resolution that is not 2 numbers"),
    ({"T_cn_cnm1": None}, "has a cam1.T_cn_cnm1 that is not 16 numbers"),
    ({"T_cn_cnm1": np.diag([2.0, 1, 1, 1]).tolist()}, "has a cam1.T_cn_cnm1 that is no rotation"),
])
def test_refused_of_kalibr(cameras, changes, message):
    changed(**changes)
    with pytest.raises(UserError, match=message):
        read_cameras([Path("camchain.yaml")], None, None)


def test_not_text(cameras, tmp_path):
    (tmp_path / "a.yml").write_bytes(b"\xff\xfe\x00")
    with pytest.raises(UserError, match=r"a.yml is not text; give OpenCV's"):
        read_cameras([tmp_path / "a.yml"], SIZE, 1)
