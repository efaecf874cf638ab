"""golden.pictures.calibration: Middlebury's calib.txt, and files that are not one."""

import pytest

from golden.errors import UserError
from golden.pictures.calibration import Calibration, read_calibration


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


def test_middlebury(tmp_path):
    file = tmp_path / "calib.txt"
    file.write_text(MIDDLEBURY)
    assert read_calibration(file) == Calibration(3979.911, 193.001, 124.343, (1244.772, 1019.507), (2964, 1988))


def test_what_may_be_missing(tmp_path):
    file = tmp_path / "calib.txt"
    file.write_text("cam0 = [10 0 4; 0 10 3; 0 0 1]\nbaseline = 2\nwidth=8\n")
    assert read_calibration(file) == Calibration(10, 2, 0, (4, 3), None)


@pytest.mark.parametrize("old, new, message", [
    ("baseline=193.001\n", "", "has no baseline; add the line baseline="),
    ("cam0", "cam2", "has no cam0; add the line cam0="),
    ("baseline=193.001", "baseline=long", "has the baseline 'long', which is not a number"),
    ("width=2964", "width=wide", "has the width 'wide', which is not a number"),
    ("baseline=193.001", "baseline=0", "baseline must be a number above 0, not 0"),
    ("baseline=193.001", "baseline=nan", "baseline must be a number above 0, not nan"),
    ("[3979.911 0 1244", "[-1 0 1244", "focal must be a number above 0, not -1"),
    ("doffs=124.343", "doffs=inf", "offset must be a number, not inf"),
    ("cam0=[3979.911 0 1244.772;", "cam0=[3979.911 1244.772;",
     "has the cam0 '[3979.911 1244.772; 0 3979.911 1019.507; 0 0 1]'; write it as"),
    ("width=2964", "width=inf", "cannot be a calibration: cannot convert"),
])
def test_bad_file(tmp_path, old, new, message):
    file = tmp_path / "calib.txt"
    assert old in MIDDLEBURY
    file.write_text(MIDDLEBURY.replace(old, new))
    with pytest.raises(UserError) as error:
        read_calibration(file)
    assert message in str(error.value) and str(error.value).count(str(file)) == 1  # one sentence, not one within another


def test_no_text(tmp_path):
    (tmp_path / "bytes").write_bytes(b"\xff\xfe\x00")
    for name, message in (("none", "cannot read"), ("bytes", "is not text")):
        with pytest.raises(UserError, match=message):
            read_calibration(tmp_path / name)
