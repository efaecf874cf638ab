"""golden.pictures.calibration_files: Middlebury's and KITTI's text as programs write it, and files that contradict themselves."""

import pytest

from golden.errors import UserError
from golden.pictures.calibration import Calibration
from golden.pictures.calibration_files import read_calibration


MIDDLEBURY = """\
cam0=[3979.911 0 1244.772; 0 3979.911 1019.507; 0 0 1]
cam1=[3979.911 0 1369.115; 0 3979.911 1019.507; 0 0 1]
doffs=124.343
baseline=193.001
width=2964
height=1988
ndisp=270
isint=0
"""
EXPECTED = Calibration(3979.911, 193.001, 124.343, (1244.772, 1019.507), (2964, 1988), 1, 3979.911)

# Grey cameras 0.5 m apart; colour cameras 0.25 m apart, the left one 0.06 m left of the grey one.
KITTI = """\
P0: 7.0e+02 0.0 600 0.0 0.0 7.0e+02 180 0.0 0.0 0.0 1.0 0.0
P1: 7.0e+02 0.0 600 -350 0.0 7.0e+02 180 0.0 0.0 0.0 1.0 0.0
P2: 7.0e+02 0.0 600 42 0.0 7.0e+02 180 0.2 0.0 0.0 1.0 0.003
P3: 7.0e+02 0.0 610 -133 0.0 7.0e+02 180 2.1 0.0 0.0 1.0 0.003
Tr: 1 0 0 0 0 1 0 0 0 0 1 0
"""
RAW = """\
calib_time: 09-Jan-2012 13:57:47
corner_dist: 9.950000e-02
S_rect_00: 1.242e+03 3.75e+02
K_00: 9.8e+02 0 6.9e+02 0 9.7e+02 2.4e+02 0 0 1
P_rect_00: 700 0 600 0 0 700 180 0 0 0 1 0
S_rect_01: 1.242e+03 3.75e+02
P_rect_01: 700 0 600 -350 0 700 180 0 0 0 1 0
"""
GREY = Calibration(700, 0.5, 0, (600, 180), None, 1000, 700)


@pytest.fixture
def read(tmp_path):
    """Reads a text, or bytes, as a calibration."""
    def read(text, **arguments):
        file = tmp_path / "calib.txt"
        file.write_bytes(text if isinstance(text, bytes) else text.encode())
        return read_calibration([file], **arguments)

    return read


@pytest.fixture
def message(read):
    """The sentence with which a text is refused."""
    def message(text, **arguments):
        with pytest.raises(UserError) as error:
            read(text, **arguments)
        return str(error.value)

    return message


@pytest.mark.parametrize("encoding", ["utf-8", "utf-8-sig", "utf-16"])
@pytest.mark.parametrize("end", ["\n", "\r\n", "\r", "  \n", "\n\n"])
def test_middlebury(read, capsys, encoding, end):
    assert read(MIDDLEBURY.replace("\n", end).encode(encoding)) == EXPECTED
    assert read(MIDDLEBURY.replace("=", " = ").replace("\n", end).encode(encoding)) == EXPECTED
    assert capsys.readouterr().err == ""


def test_doffs_follow_from_the_cameras(read, capsys):
    found = read(MIDDLEBURY.replace("doffs=124.343\n", ""))
    assert found.offset == pytest.approx(124.343, abs=1e-9) and capsys.readouterr().err == ""


def test_what_may_be_missing(read, capsys):
    assert read("cam0 = [10 0 4; 0 10 3; 0 0 1]\nbaseline = 2\nwidth=8\n") == Calibration(10, 2, 0, (4, 3), None, 1, 10)
    assert "has neither doffs nor cam1" in capsys.readouterr().err
    assert read("cam0=[10 0 4; 0 10 3; 0 0 1]\nbaseline=2\ndoffs=5\n").offset == 5
    assert capsys.readouterr().err == ""


def test_focal_lengths_may_differ(read):
    found = read(MIDDLEBURY.replace("0 3979.911 1019", "0 3000 1019"))
    assert (found.focal, found.focal_y) == (3979.911, 3000)


@pytest.mark.parametrize("old, new, part", [
    ("baseline=193.001\n", "", "has no baseline; add the line baseline="),
    ("cam0", "cam2", "has no cam0; add the line cam0="),
    ("baseline=193.001", "baseline=long", "has the baseline 'long', which is not a number"),
    ("width=2964", "width=wide", "has the width 'wide', which is not a number"),
    ("baseline=193.001", "baseline=0", "baseline must be a number above 0, not 0"),
    ("baseline=193.001", "baseline=nan", "baseline must be a number above 0, not nan"),
    ("cam0=[3979.911 0 1244", "cam0=[-1 0 1244", "is not the projection of a rectified camera"),
    ("cam0=[3979.911 0 1244", "cam0=[3979.911 2 1244", "is not the projection of a rectified camera"),
    ("0 0 1]\ncam1", "0 1 1]\ncam1", "is not the projection of a rectified camera"),
    ("cam0=[3979.911 0 1244.772", "cam0=[3979.911 0 nan", "is not a matrix of 3x4 numbers"),
    ("cam0=[3979.911 0 1244", "cam0=[f 0 1244", "has the number in cam0 'f', which is not a number"),
    ("doffs=124.343", "doffs=-124.343", "has the doffs -124.343, but the principal points of cam1 and cam0 are 124.343 pixels apart"),
    ("doffs=124.343", "doffs=31", "has the doffs 31, but"),   # a quarter of the size, but for this
    ("cam1=[3979.911", "cam1=[4000", "has the fx 3979.91 and cam1 of"),
    ("1369.115; 0 3979.911 1019.507", "1369.115; 0 3979.911 1021", "has the cy 1019.51 and cam1 of"),
    ("1369.115; 0 3979.911", "1369.115; 0 3900", "has the fy 3979.91 and cam1 of"),
    ("cam0=[3979.911 0 1244.772;", "cam0=[3979.911 1244.772;",
     "has the cam0 '[3979.911 1244.772; 0 3979.911 1019.507; 0 0 1]'; write it as"),
    ("width=2964", "width=inf", "cannot be a calibration: cannot convert"),
])
def test_bad_middlebury(message, old, new, part):
    assert old in MIDDLEBURY
    assert part in message(MIDDLEBURY.replace(old, new, 1))


def test_doffs_without_cameras_must_be_a_number(message):
    text = MIDDLEBURY.replace("cam1", "cam9").replace("doffs=124.343", "doffs=inf")
    assert "offset must be a number, not inf" in message(text)


@pytest.mark.parametrize("text, arguments, expected", [
    (KITTI, {"kitti": "0,1"}, GREY),
    (KITTI, {"kitti": "2,3"}, Calibration(700, 0.25, 10, (600, 180), None, 1000, 700)),
    ("".join(KITTI.splitlines(True)[:2]).replace("\n", "\r\n"), {}, GREY),
    (RAW, {}, Calibration(700, 0.5, 0, (600, 180), (1242, 375), 1000, 700)),
    (RAW.encode("utf-8-sig"), {"kitti": "0,1"}, Calibration(700, 0.5, 0, (600, 180), (1242, 375), 1000, 700)),
])
def test_kitti(read, capsys, text, arguments, expected):
    assert read(text, **arguments) == expected
    assert capsys.readouterr().err == ""


def test_kitti_says_which_cameras(read, capsys):
    assert read(KITTI) == GREY
    assert "P0 and P1, are taken; --kitti-cameras 2,3 takes" in capsys.readouterr().err
    assert read("".join(KITTI.splitlines(True)[2:])).baseline == 0.25
    assert capsys.readouterr().err == ""


@pytest.mark.parametrize("old, new, arguments, part", [
    ("P1:", "P9:", {"kitti": "0,1"}, "has not both cameras of --kitti-cameras 0,1; give 2,3"),
    ("P0: 7.0e+02 0.0 600 0.0", "P0: 7.0e+02 0.0 600 -700", {"kitti": "0,1"}, "has a baseline of -0.5 to the right of P0 of"),
    ("P1: 7.0e+02 0.0 600 -350", "P1: 7.0e+02 0.0 600", {"kitti": "0,1"}, "P1 of"),
    ("600 -350 0.0 7.0e+02 180 0.0", "600 -3 0.0 7.0e+02 180 -350", {"kitti": "0,1"}, "one above the other"),
    ("P1: 7.0e+02", "P1: 7.0e+02 x", {"kitti": "0,1"}, "has the number in P1 'x', which is not a number"),
    ("P1: 7.0e+02", "P1: 8.0e+02", {"kitti": "0,1"}, "has the fx 700 and P1 of"),
])
def test_bad_kitti(message, old, new, arguments, part):
    assert old in KITTI
    assert part in message(KITTI.replace(old, new), **arguments)


def test_kitti_with_one_camera(message):
    assert "has P0, but a pair is P0 and P1, or P2 and P3" in message(KITTI.partition("\n")[0])
    assert "is no calib.txt of KITTI; leave --kitti-cameras 2,3 out" in message(MIDDLEBURY, kitti="2,3")


def test_other_files(tmp_path, message):
    (tmp_path / "bytes").write_bytes(b"\xff\xfe\x00")
    (tmp_path / "latin").write_bytes("Kalibrierung für".encode("latin-1"))
    for name, part in (("none", "cannot read"), ("bytes", "is not text"), ("latin", "is not text")):
        with pytest.raises(UserError, match=part):
            read_calibration([tmp_path / name])
    assert "is not a calibration that can be read; give a calib.txt of Middlebury 2014 or KITTI, camera_info" in message("hello\n")
    assert "is not a calibration" in message("")


def test_two_files_of_one_pair(tmp_path):
    for name, text in (("a.txt", MIDDLEBURY), ("b.txt", KITTI)):
        (tmp_path / name).write_text(text)
        with pytest.raises(UserError, match="only camera_info of ROS has a file for each camera; give one --calib"):
            read_calibration([tmp_path / name, tmp_path / name])
