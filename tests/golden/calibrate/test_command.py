"""`python -m golden calibrate`: from pictures, drawn and real, to files that other commands read; bad input."""

import json

import numpy as np
import pytest
import yaml

from golden.__main__ import main
from golden.calibrate.rectified import rig_dy
from golden.calibrate.views import Board, find_corners, view
from golden.pictures.calibration_files import read_calibration
from golden.pictures.images import read_picture, write_picture
from golden.rig.files import read_rig
from golden.rig.maps import pack
from golden.rig.rectify import move_rows, rectify
from tests.kit import calibration_folder

from .boards import BASELINE, BOARD, SIZE, Cameras, opencv


BOARD_OPTIONS = ["--board", f"{BOARD.columns}x{BOARD.rows}", "--square", "25"]
FILES = ["rig.json", "left.yaml", "right.yaml", "calib.txt", "epipolar.png", "report.json"]


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """A folder of drawn pictures, and their names."""
    folder = tmp_path_factory.mktemp("drawn")
    names = Cameras().write(folder)
    write_picture(folder / "grey.png", np.full(SIZE[::-1], 200, np.uint8))
    write_picture(folder / "small.png", np.full((100, 100), 200, np.uint8))
    return folder, names


def run(folder, monkeypatch, *arguments):
    monkeypatch.chdir(folder)
    return main(["calibrate", *arguments])


def test_drawn_pictures(drawn, monkeypatch, tmp_path, capsys):
    folder, names = drawn
    lenses = ["--flat", "grey.png", "grey.png"]
    assert run(folder, monkeypatch, *names, *BOARD_OPTIONS, *lenses, "--output", str(tmp_path)) == 0
    printed = capsys.readouterr()
    assert "10 views used, 0 dropped, 0 without corners" in printed.out and printed.err == ""
    assert {path.name for path in tmp_path.iterdir()} == {*FILES}
    report = json.loads((tmp_path / "report.json").read_text())
    assert report["files"] == FILES[:-1] and report["rms_pixels"] < 0.1 and report["dy"]["rectified"] < 0.1 < 1 < report["dy"]["before"]
    # What is written is one calibration: for depth in either format, of the pictures, and of the matcher's rig.
    depth = read_calibration([tmp_path / "calib.txt"])
    ros = read_calibration([tmp_path / "left.yaml", tmp_path / "right.yaml"])
    assert depth.baseline == pytest.approx(np.hypot(BASELINE, 2), abs=0.3) == pytest.approx(1000 * ros.baseline, abs=0.3)
    assert depth.focal == pytest.approx(ros.focal) == pytest.approx(report["focal_pixels"])
    assert depth.size == ros.size == SIZE == read_rig(tmp_path).size
    assert (read_rig(tmp_path).left.gain == 128).all() and "grey_levels_from_remap" not in report    # --flat
    assert read_picture(tmp_path / "epipolar.png").shape == (2 * SIZE[1] + 36, 2 * SIZE[0])
    # The pictures themselves are rectified: the corners are found in them on the same lines.
    pair = read_rig(tmp_path).rectified(*(read_picture(folder / name) for name in ("left4.png", "right4.png")))
    each = view("", *(find_corners(side, BOARD) for side in pair))
    assert np.abs(each.left[:, 1] - each.right[:, 1]).mean() < 0.15
    assert main(["match", "left4.png", "right4.png", "--rig", str(tmp_path), "--disparities", "64", "--output", str(tmp_path / "d.npy"),
                 "--calib", str(tmp_path / "calib.txt"), "--depth", str(tmp_path / "z.npy")]) == 0


def test_calibration_of_others_gives_the_same_maps(drawn, monkeypatch, tmp_path, capsys):
    """What the report's cameras are in ROS's files, given as OpenCV's."""
    folder, names = drawn
    assert run(folder, monkeypatch, *names, *BOARD_OPTIONS, "--output", str(tmp_path / "a")) == 0
    cv2 = opencv()
    left, right = (yaml.safe_load((tmp_path / "a" / f"{side}.yaml").read_text()) for side in ("left", "right"))
    matrices = {f"M{number}": np.reshape(each["camera_matrix"]["data"], (3, 3)) for number, each in ((1, left), (2, right))}
    bent = {f"D{number}": np.array(each["distortion_coefficients"]["data"]) for number, each in ((1, left), (2, right))}
    # R = R2' R1 and T = -R2' (baseline, 0, 0), as stereoRectify turns both.
    turns = [np.reshape(each["rectification_matrix"]["data"], (3, 3)) for each in (left, right)]
    baseline = -right["projection_matrix"]["data"][3] / right["projection_matrix"]["data"][0]
    storage = cv2.FileStorage(str(tmp_path / "all.yml"), cv2.FILE_STORAGE_WRITE)
    for name, value in {**matrices, **bent, "R": turns[1].T @ turns[0], "T": turns[1].T @ [[-baseline], [0.0], [0.0]]}.items():
        storage.write(name, value)
    storage.release()
    assert main(["calibrate", str(tmp_path / "all.yml"), "--size", "320x240", "--baseline-unit", "m", "--output", str(tmp_path / "b")]) == 0
    assert sorted(path.name for path in (tmp_path / "b").iterdir()) == sorted({*FILES} - {"epipolar.png"})
    rigs = [read_rig(tmp_path / name) for name in "ab"]
    assert [pack(rig.left) for rig in rigs[:1]] == [pack(rig.left) for rig in rigs[1:]] and rigs[0].row_offset == rigs[1].row_offset


@pytest.mark.parametrize("arguments, message", [
    (["left0.png"] * 15, "15 pictures are given, and 8 of the left camera are needed at least"),
    (["left0.png"] * 14, "14 pictures are given, and 8"),
    (["grey.png"] * 16, "the corners of a 7x5 board are found in no pair, not in grey.png, grey.png"),
    (["left0.png"] * 7 + ["grey.png"] + ["right0.png"] * 8, "1 pairs are left out"),
    (["left0.png"] * 15 + ["small.png"], "small.png has 100x100 pixels and left0.png has 320x240"),
    (["left0.png", "absent.png"] * 8, "absent.png"),
    (["left0.png", "a.yml"] * 8, "are pictures and calibrations; give one or the other"),
])
def test_refused(drawn, monkeypatch, tmp_path, capsys, arguments, message):
    folder, _ = drawn
    assert run(folder, monkeypatch, *arguments, *BOARD_OPTIONS, "--output", str(tmp_path / "out")) == 2
    printed = capsys.readouterr().err
    assert message in printed and "Traceback" not in printed and not (tmp_path / "out").exists()


@pytest.mark.parametrize("arguments, message", [
    (["a.png", "--board", "9x6"], "--square is missing"),
    (["a.png", "--square", "9"], "--board is missing; give the chessboard as in --board 9x6 --square 25"),
    (["a.png", "--board", "9", "--square", "9"], "--board is 9, but must be its inner corners, as in 9x6, from 3 to 64 each"),
    (["a.png", "--board", "9x2", "--square", "9"], "--board is 9x2"),
    (["a.png", "--board", "9x6", "--square", "0"], "--square must be the side of a square in millimetres, from 0.1 to 10000, not 0"),
    (["a.png", "--board", "9x6", "--square", "9", "--size", "3x3"], "--size 3x3 belongs to calibrations of others"),
    (["a.yml", "--board", "9x6"], "--board 9x6 belongs to pictures"),
    (["a.yml", "--size", "3"], "--size is 3, but must be two numbers from 2 to 4096"),
    (["a.yml", "--rectify-lines", "35"], "--rectify-lines"),
    (["a.yml"], "cannot read a.yml"),
])
def test_refused_before_anything_is_read(monkeypatch, tmp_path, capsys, arguments, message):
    assert run(tmp_path, monkeypatch, *arguments, "--output", "out") == 2
    printed = capsys.readouterr().err
    assert message in printed and printed.count("\n") == 1 and not (tmp_path / "out").exists()


def test_exchanged_pictures_and_too_few_lines(drawn, monkeypatch, tmp_path, capsys):
    folder, names = drawn
    out = tmp_path / "out"
    assert run(folder, monkeypatch, *names[10:], *names[:10], *BOARD_OPTIONS, "--output", str(out)) == 2
    assert "the cameras are exchanged" in capsys.readouterr().err and not out.exists()


def test_real_cameras(monkeypatch, tmp_path, capsys):
    """Thirteen pairs of two cameras. OpenCV's own lenses of these pictures are refused: they are much worse."""
    cv2, folder = opencv(), calibration_folder()
    pictures = [str(path) for side in ("left", "right") for path in sorted(folder.glob(f"{side}[01][0-9].jpg"))]
    assert len(pictures) == 26
    options = ["--board", "9x6", "--square", "25"]
    assert main(["calibrate", *pictures, *options, "--output", str(tmp_path / "out")]) == 0
    report = json.loads((tmp_path / "out" / "report.json").read_text())
    dy = report["dy"]
    assert report["rms_pixels"] < 0.27 and report["dropped"] == [] and report["without_corners"] == []
    assert 12 < dy["before"] < 14 and dy["exact"] < 0.11 and abs(dy["rectified"] - dy["exact"]) < 0.05
    assert max(report["grey_levels_from_remap"]) <= 0.3
    assert report["lines"] <= 34 and 0 < report["row_offset"] < 12

    # The same as OpenCV's remap with exact maps, but for some tenths of a grey level.
    rig = read_rig(tmp_path / "out")
    for side, which, offset in (("left", rig.left, 0), ("right", rig.right, rig.row_offset)):
        document = yaml.safe_load((tmp_path / "out" / f"{side}.yaml").read_text())
        matrix, turn, projection = (np.reshape(document[name]["data"], shape) for name, shape in (
            ("camera_matrix", (3, 3)), ("rectification_matrix", (3, 3)), ("projection_matrix", (3, 4))))
        x, y = cv2.initUndistortRectifyMap(matrix, np.array(document["distortion_coefficients"]["data"]), turn, projection[:, :3],
                                           (640, 480), cv2.CV_32FC1)
        picture = move_rows(read_picture(folder / f"{side}01.jpg"), offset)
        theirs = cv2.remap(picture, x, y - offset, cv2.INTER_LINEAR, borderMode=cv2.BORDER_REPLICATE)
        assert np.abs(rectify(picture, which).astype(int) - theirs).mean() <= 0.3

    # And in the pictures themselves: corners found again after rectification.
    pair = rig.rectified(*(read_picture(folder / f"{side}01.jpg") for side in ("left", "right")))
    each = view("", *(find_corners(side, Board(9, 6, 25)) for side in pair))
    assert np.abs(each.left[:, 1] - each.right[:, 1]).mean() < 0.15
    raw = view("", *(find_corners(read_picture(folder / f"{side}01.jpg"), Board(9, 6, 25)) for side in ("left", "right")))
    assert np.abs(rig_dy(rig, raw.left, raw.right)).mean() < 0.15
    capsys.readouterr()
    eight = pictures[:8] + pictures[13:21]
    assert main(["calibrate", *eight, *options, "--intrinsics", str(folder / "intrinsics.yml"), "--output", str(tmp_path / "no")]) == 2
    assert "the corners are off by 1." in capsys.readouterr().err and not (tmp_path / "no").exists()
    assert main(["calibrate", str(folder / "intrinsics.yml"), "--size", "640x480", "--output", str(tmp_path / "no")]) == 2
    assert "has no R and no T" in capsys.readouterr().err
