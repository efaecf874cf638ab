"""golden.lab.boards: the plane of a board is its truth, drawn boards are measured, rectified ones are better."""

import re

import numpy as np
import pytest

from golden.__main__ import main
from golden.calibrate.rectified import corners_after, make_rig, rectification
from golden.lab.boards import MARGIN, plane
from golden.rig.files import Rig, write_rig
from golden.rig.maps import identity
from tests.golden.calibrate.boards import BOARD, SIZE, Cameras


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    """Pictures of two pairs, the rig of their cameras and one of another size."""
    path, cameras = tmp_path_factory.mktemp("boards"), Cameras(roll=4, lower=6)
    assert cameras.write(path, 2) == ["left0.png", "left1.png", "right0.png", "right1.png"]
    rectified = rectification(SIZE, *[cameras.matrix, cameras.distortion] * 2, cameras.rotation, cameras.translation)
    write_rig(path / "rig.json", make_rig(rectified.maps(0), rectified.maps(1), 34))
    write_rig(path / "small.json", Rig(identity(9, 9), identity(9, 9)))
    return path


def test_plane_of_a_known_board():
    """Of rectified pictures it goes through all corners, and labels cover it."""
    cameras = Cameras()
    rectified = rectification(SIZE, *[cameras.matrix, cameras.distortion] * 2, cameras.rotation, cameras.translation)
    rig = make_rig(rectified.maps(0), rectified.maps(1), 34)
    each = next(cameras.views(noise=0))
    left, right = corners_after(rig.left, each.left), corners_after(rig.right, each.right)
    found = plane(left, right, BOARD, SIZE)
    x, y = np.rint(left).astype(int).T
    assert np.abs(found.truth[y, x] - (left - right)[:, 0]).max() < 0.3
    seen = found.truth[found.mask]
    assert found.least == int(np.floor(seen.min())) - MARGIN and found.least + found.labels - 1 == int(np.ceil(seen.max())) + MARGIN
    area = np.prod(np.ptp(left, axis=0))
    assert 0.5 * area < found.mask.sum() < area


def test_command(folder, monkeypatch, capsys):
    monkeypatch.chdir(folder)
    names = [f"{side}{number}.png" for side in ("left", "right") for number in (0, 1)]
    assert main(["boards", *names, "--rig", "rig.json", "--board", "7x5", "--methods", "fused"]) == 0
    printed = capsys.readouterr().out
    before, after, balanced = (float(each) for each in re.findall(r"(\d+\.\d\d) +│$", printed, re.MULTILINE))
    assert "of 2 pairs" in printed and max(after, balanced) < 3 < 40 < before


@pytest.mark.parametrize("arguments, message", [
    (["left0.png", "--rig", "rig.json", "--board", "7x5"], "1 pictures are given, and 1 of the left camera are needed at least"),
    (["left0.png", "right0.png", "--rig", "small.json", "--board", "7x5"], "the pictures have 320x240 pixels and small.json is for 9x9"),
    (["left0.png", "right0.png", "--rig", "none.json", "--board", "7x5"], "cannot read none.json"),
])
def test_refused(folder, monkeypatch, capsys, arguments, message):
    monkeypatch.chdir(folder)
    assert main(["boards", *arguments]) == 2
    printed = capsys.readouterr().err
    assert message in printed and printed.count("\n") == 1
