"""golden.pictures.calibration_yaml: files of OpenCV, written by it where it is installed, and of ROS, saved or printed."""

import numpy as np
import pytest

from golden.errors import UserError
from golden.pictures.calibration import Calibration
from golden.pictures.calibration_files import read_calibration


P1 = "500., 0., 320., 0., 0., 500., 240., 0., 0., 0., 1., 0."
P2 = "500., 0., 350., -3.0e+04, 0., 500., 240., 0., 0., 0., 1., 0."
Q = "1., 0., 0., -320., 0., 1., 0., -240., 0., 0., 0., 500., 0., 0.,\n       1.6666666666666666e-02, 5.0e-01"
EXPECTED = Calibration(500, 60, 30, (320, 240), None, None, 500)


def matrix(name, data, rows=3, cols=4):
    return f"{name}: !!opencv-matrix\n   rows: {rows}\n   cols: {cols}\n   dt: d\n   data: [ {data} ]\n"


def opencv(*matrices, header="%YAML:1.0\n---\n"):
    return header + "calibration_time: \"Thu 01 Jan 2026\"\nnframes: 20\n" + "".join(matrices)


def saved(tx, cx=320, width=640):
    """As ``camera_calibration`` saves it."""
    return (f"image_width: {width}\nimage_height: 480\ncamera_name: narrow_stereo/x\ncamera_matrix:\n  rows: 3\n  cols: 3\n"
            "  data: [1, 0, 2, 0, 1, 2, 0, 0, 1]\ndistortion_model: plumb_bob\nprojection_matrix:\n  rows: 3\n  cols: 4\n"
            f"  data: [500.0, 0.0, {cx}, {tx}, 0.0, 500.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0]\n")


def printed(tx, key="P"):
    """As a topic is printed."""
    flow = f"{key}: [500.0, 0.0, 320.0, {tx}, 0.0, 500.0, 240.0, 0.0, 0.0, 0.0, 1.0, 0.0]\n"
    block = f"{key}:\n" + "".join(f"- {each}\n" for each in (500.0, 0, 320.0, tx, 0, 500.0, 240.0, 0, 0, 0, 1.0, 0))
    return f"header:\n  stamp: 1\nheight: 480\nwidth: 640\n{flow if key == 'P' else block}binning_x: 0\n---\n"


ROS = Calibration(500, 0.12, 0, (320, 240), (640, 480), 1000, 500)


@pytest.fixture
def read(tmp_path):
    """Reads texts, one or two, as a calibration."""
    def read(*texts):
        for number, text in enumerate(texts):
            (tmp_path / f"{number}.yaml").write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_calibration([tmp_path / f"{number}.yaml" for number in range(len(texts))])

    return read


@pytest.mark.parametrize("text", [
    opencv(matrix("P1", P1), matrix("P2", P2), matrix("Q", Q, 4, 4)), opencv(matrix("P1", P1), matrix("P2", P2)),
    opencv(matrix("P1", P1), matrix("P2", P2), header="%YAML 1.2\n---\n"), opencv(matrix("P1", P1), matrix("P2", P2), header="---\n"),
    opencv(matrix("P1", P1), matrix("P2", P2)).replace("\n", "\r\n").encode("utf-8-sig"),
    f'{{"P1": {{"type_id": "opencv-matrix", "rows": 3, "cols": 4, "dt": "d", "data": [{P1}]}}, "P2": [{P2}]}}',
])
def test_opencv(read, capsys, text):
    assert read(text) == EXPECTED
    assert capsys.readouterr().err == ""


def test_opencv_q(read):
    found = read(opencv(matrix("Q", Q, 4, 4)))
    assert (found.focal, found.centre, found.millimetres) == (500, (320, 240), None)
    assert (found.baseline, found.offset) == (pytest.approx(60, rel=1e-12), pytest.approx(30, rel=1e-12))


@pytest.mark.parametrize("suffix", [".yml", ".json"])
@pytest.mark.parametrize("cx", [320, 350])
@pytest.mark.parametrize("keys", [("P1", "P2"), ("Q",)])
def test_what_opencv_writes(tmp_path, suffix, cx, keys):
    """The depth of a point is the one from which its pixels were computed."""
    cv2 = pytest.importorskip("cv2", reason="cv2, of the extra lab, is not installed")
    matrices = [np.array([[500.0, 0, each], [0, 500, 240], [0, 0, 1]]) for each in (320, cx)]
    _, _, p1, p2, q, *_ = cv2.stereoRectify(matrices[0], np.zeros(5), matrices[1], np.zeros(5), (640, 480), np.eye(3),
                                            np.array([[-60.0], [0], [0]]), flags=0, alpha=-1)
    storage = cv2.FileStorage(str(tmp_path / f"a{suffix}"), cv2.FILE_STORAGE_WRITE)
    for name, each in (("P1", p1), ("P2", p2), ("Q", q)):
        if name in keys:
            storage.write(name, each)
    storage.release()
    found = read_calibration([tmp_path / f"a{suffix}"])
    left, right = (projection @ [100.0, 50, 1500, 1] for projection in (p1, p2))
    disparity = left[0] / left[2] - right[0] / right[2]
    assert found.focal * found.baseline / (disparity + found.offset) == pytest.approx(1500, rel=1e-9)
    assert found.centre == pytest.approx((320, 240))


@pytest.mark.parametrize("texts", [(saved(0), saved(-60.0)), (printed(0), printed(-60.0)), (printed(0, "p"), printed(-60.0, "p")),
                                   (saved(0), printed(-60.0))])
def test_ros(read, capsys, texts):
    assert read(*texts) == ROS
    assert capsys.readouterr().err == ""


def test_ros_right_camera(read, capsys):
    assert read(saved(-60.0)) == ROS
    assert "is of the right camera: the principal point of the left one is taken as the same (doffs=0)" in capsys.readouterr().err
    assert read(saved(0), saved(-60.0, cx=325)).offset == 5
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("texts, part", [
    ((saved(0),), "0.yaml has no baseline (P[3] is 0), as camera_info of the left camera; give camera_info of both cameras, --calib LEFT"),
    ((saved(-60.0), saved(0)), "has a baseline of -0.12 to the right of"),
    ((saved(60.0),), "has a baseline of -0.12"),
    ((saved(0), saved(-60.0, width=641)), "are for pictures of different sizes, (640, 480) and (641, 480)"),
    ((saved(0), saved(-60.0), saved(0)), "--calib is given 3 times"),
    ((saved(0), opencv(matrix("P1", P1), matrix("P2", P2))), "1.yaml is no camera_info of ROS"),
    ((saved(0).replace("projection", "rotation"),), "has no projection_matrix (P), which alone describes the rectified pictures"),
    ((printed(0).replace("500.0", "0.0"),), "has a projection_matrix of zeros: the camera is not calibrated"),
    ((saved(-60.0).replace("image_width: 640", "image_width: wide"),), "has the size widex480"),
    ((saved(-60.0).replace("cols: 4", "cols: 3"),), "has the matrix projection_matrix of 3x3 numbers; it must be 3x4"),
    ((printed(-60.0).replace("240.0", "down"),), "has a matrix P that is not 12 numbers"),
    ((printed(-60.0).replace("240.0, ", ""),), "has a matrix P that is not 12 numbers"),
    ((opencv(matrix("P1", P1), matrix("R1", P2)),), "has neither P1 and P2 nor Q; write what stereoRectify gives into it"),
    ((opencv(matrix("P1", P1), matrix("P2", P2.replace("-3.0e+04", "3.0e+04"))),), "has a baseline of -60"),
    ((opencv(matrix("P1", P1), matrix("P2", "500., 0., 320., 0., 0., 500., 240., -3.0e+04, 0., 0., 1., 0.")),), "one above the other"),
    ((opencv(matrix("Q", Q.replace("1.666", "-1.666"), 4, 4)),), "has a Q that is not stereoRectify's"),
    ((opencv(matrix("Q", Q.replace("1., 0., 0., -320.", "2., 0., 0., -320."), 4, 4)),), "has a Q that is not stereoRectify's"),
    ((opencv(matrix("Q", Q.replace("0., 500.", ".Nan, 500."), 4, 4)),), "has a matrix Q that is not 16 numbers"),
    (("<?xml version=\"1.0\"?>\n<opencv_storage>\n</opencv_storage>\n",), "is XML; let OpenCV's FileStorage write it to a file with"),
    (("P1: [1, 2\n",), "cannot be read as YAML"),
    (("Q: " + "[" * 20_000,), "cannot be read as YAML: its brackets are nested too deeply"),
    (("Q: 1\nday: 2001-13-32\n",), "cannot be read as YAML: month must be in 1..12"),
    (("- Q: 1\n",), "is not a calibration that can be read"),
    (("[{\nQ: 1}]\n",), "holds no names and values"),
])
def test_refused(read, texts, part):
    with pytest.raises(UserError) as error:
        read(*texts)
    assert part in str(error.value)
