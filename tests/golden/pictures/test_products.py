"""`python -m golden match`: its further outputs, comparison with a truth, and bad input to either."""

import numpy as np
import pytest
from PIL import Image

from golden.__main__ import main
from golden.pictures.calibration import Calibration
from golden.pictures.depth import depth, millimetres
from golden.pictures.disparities import read_disparity
from golden.pictures.images import colour_map, write_picture
from golden.pictures.metrics import bad_pixels
from golden.pictures.scenes import scene


PAIR = ["match", "left.png", "right.png", "--disparities", "20", "--output", "d.npy"]
TRUTH = ["--truth", "truth.png", "--truth-scale", "8"]
CALIB = "cam0=[50 0 20; 0 50 10; 0 0 1]\ndoffs=1.5\nbaseline=4\nwidth=60\nheight=24\n"


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A working folder with a pair, its truth in several forms, masks and calibrations, good and bad."""
    monkeypatch.chdir(tmp_path)
    left, right, truth = scene(60, 24, 20, seed=1)
    known = np.isfinite(truth) & (truth > 0)
    half = np.zeros(truth.shape, np.uint8)
    half[:, 30:] = 255
    pictures = {
        "left.png": left, "right.png": right, "truth.png": np.where(known, 8 * np.where(known, truth, 0), 0).astype(np.uint8),
        "truth.npy": truth, "truth.pfm": 3 * truth, "unknown.npy": np.full(truth.shape, np.nan), "unknown.png": np.zeros_like(left),
        "narrow.npy": truth[:, :-1], "negative.npy": -truth, "mask.png": half, "empty.png": half // 2, "narrow.png": half[:, :-1],
        "lines.png": np.where(np.isinf(truth), 255, 0).astype(np.uint8),
    }
    for name, picture in pictures.items():
        write_picture(name, picture)
    (tmp_path / "calib.txt").write_text(CALIB)
    (tmp_path / "short.txt").write_text(CALIB.replace("baseline=4\n", ""))
    (tmp_path / "minus.txt").write_text(CALIB.replace("1.5", "-19"))
    (tmp_path / "other.txt").write_text(CALIB.replace("width=60", "width=600"))
    return tmp_path


@pytest.mark.parametrize("file, scale, least", [("truth.png", "8", 1), ("truth.npy", "1", 0), ("truth.pfm", "3", 0)])
@pytest.mark.parametrize("mask", [[], ["--mask", "mask.png"]])
def test_truth(folder, capsys, file, scale, least, mask):
    assert main([*PAIR, "--truth", file, "--truth-scale", scale, *mask]) == 0
    truth = np.load("truth.npy")
    counted = np.isfinite(truth) & (truth >= least)
    if mask:
        counted[:, :30] = False
    bad = bad_pixels(np.load("d.npy"), truth, counted)
    assert f"bad pixels: {bad:.2f} % of the {counted.sum()} that count" in capsys.readouterr().out
    assert bad > 0


def colours(path):
    with Image.open(path) as picture:
        return np.asarray(picture.convert("RGB"))


def test_threshold(folder, capsys):
    printed = []
    for threshold in ("0", "1", "19"):
        assert main([*PAIR, *TRUTH, "--threshold", threshold]) == 0
        printed.append(float(capsys.readouterr().out.partition("bad pixels: ")[2].split()[0]))
    assert printed[0] > printed[1] > printed[2] == 0


def test_pictures(folder):
    assert main([*PAIR, *TRUTH, "--colour", "c.png", "--sheet", "s.png"]) == 0
    np.testing.assert_array_equal(colours("c.png"), colour_map(np.load("d.npy"), 20))
    assert main([*PAIR, "--sheet", "two.png"]) == 0
    assert len(colours("s.png")) > 1.8 * len(colours("two.png"))


def test_colours_begin_at_the_minimum(folder):
    assert main([*PAIR, "--minimum", "3", "--colour", "c.png"]) == 0
    np.testing.assert_array_equal(colours("c.png"), colour_map(np.load("d.npy") - 3, 20))


def test_the_sheet_s_scale_is_what_is_searched(folder, monkeypatch):
    calls = []
    monkeypatch.setattr("golden.pictures.products.write_sheet", lambda *arguments: calls.append(arguments))
    assert main([*PAIR, "--minimum", "3", "--sheet", "s.png", *TRUTH, "--threshold", "2"]) == 0
    path, _, disparity, limits, truth, threshold = calls[0]
    assert (str(path), limits, threshold) == ("s.png", (3, 22), 2) and truth[0].shape == disparity.shape


def test_fractions_have_products_too(folder):
    options = ["--method", "fused", "--sub-pixel", "--colour", "c.png", "--depth", "z.npy", "--focal", "50", "--baseline", "2"]
    assert main([*PAIR, *options]) == 0
    disparity = np.load("d.npy")
    assert (disparity != np.rint(disparity)).any()
    np.testing.assert_array_equal(np.load("z.npy"), depth(disparity, Calibration(50, 2)).astype(np.float32))


@pytest.mark.parametrize("arguments, calibration", [
    (["--focal", "50", "--baseline", "0.25"], Calibration(50, 0.25)), (["--calib", "calib.txt"], Calibration(50, 4, 1.5))])
def test_depth(folder, arguments, calibration):
    assert main([*PAIR, "--depth", "z.pfm", *arguments]) == 0
    expected = depth(np.load("d.npy"), calibration).astype(np.float32)
    np.testing.assert_array_equal(read_disparity("z.pfm"), expected)
    assert main([*PAIR, "--depth", "z.ply", *arguments]) == 0
    assert f"element vertex {np.isfinite(expected).sum()}\n".encode() in (folder / "z.ply").read_bytes()


def test_depth_in_millimetres(folder, capsys):
    """Whatever the unit of the baseline; not of what is beyond 16 bits, which is told."""
    assert main([*PAIR, "--depth", "z.png", "--calib", "calib.txt"]) == 0   # Middlebury's unit is the millimetre
    expected = np.floor(depth(np.load("d.npy"), Calibration(50, 4, 1.5)) + 0.5)
    with Image.open("z.png") as picture:
        np.testing.assert_array_equal(np.asarray(picture), expected)
    for baseline, unit in (("4", "mm"), ("0.4", "cm"), ("0.004", "m")):
        assert main([*PAIR, "--depth", "y.png", "--focal", "50", "--baseline", baseline, "--baseline-unit", unit]) == 0
        with Image.open("y.png") as picture:
            np.testing.assert_array_equal(np.asarray(picture), millimetres(depth(np.load("d.npy"), Calibration(50, 4, 0, None, None, 1)),
                                                                           Calibration(50, 4, 0, None, None, 1))[0])
    assert capsys.readouterr().err == ""
    assert main([*PAIR, "--depth", "far.png", "--calib", "calib.txt", "--baseline-unit", "m"]) == 0
    with Image.open("far.png") as picture:
        levels = np.asarray(picture)
    far = 1000 * 200 / (np.load("d.npy") + 1.5) >= 65535.5
    assert 0 < far.sum() < far.size and (levels[far] == 0).all() and (levels[~far] > 0).all()
    assert f"note: {far.sum()} pixels are farther than 65535 mm" in capsys.readouterr().err


def test_no_depth_is_told(folder, capsys):
    """Of two pictures that are the same, all disparities are 0, at the first label where there is no texture."""
    write_picture("flat.png", np.full((24, 60), 9, np.uint8))
    arguments = ["match", "flat.png", "flat.png", "--disparities", "20", "--output", "d.npy", "--depth", "z.ply"]
    assert main([*arguments, "--focal", "50", "--baseline", "1"]) == 0
    assert not np.load("d.npy").any()
    assert "note: no pixel has a depth in z.ply: no disparity plus the cameras' offset, 0, is above 0" in capsys.readouterr().err
    assert main([*arguments, "--calib", "calib.txt"]) == 0
    assert capsys.readouterr().err == ""


def test_two_calibrations(folder):
    """ROS has a file for each camera, left first."""
    for name, cx, tx in (("l.yaml", 20, 0), ("r.yaml", 21.5, -200)):
        (folder / name).write_text(f"width: 60\nheight: 24\nP: [50, 0, {cx}, {tx}, 0, 50, 10, 0, 0, 0, 1, 0]\n")
    assert main([*PAIR, "--depth", "a.ply", "--calib", "l.yaml", "--calib", "r.yaml"]) == 0
    assert main([*PAIR, "--depth", "b.ply", "--calib", "calib.txt"]) == 0
    assert (folder / "a.ply").read_bytes() == (folder / "b.ply").read_bytes()


@pytest.mark.parametrize("arguments, message", [
    (["--truth", "none.png"], "none.png does not exist"),
    (["--truth", "narrow.npy"], "narrow.npy has 59x24 pixels, but the pictures have 60x24"),
    (["--truth", "unknown.npy"], "unknown.npy holds no known disparity"),
    (["--truth", "unknown.png"], "unknown.png holds no known disparity"),
    (["--truth", "negative.npy"], "negative.npy holds the disparity -19, which is below 0"),
    (["--truth", "truth.png"], "holds a median disparity of 80 pixels, more than the 19 that are searched; correct --truth-scale 1"),
    (["--truth", "truth.png", "--truth-scale", "160"], "below 1 pixel only with --truth-scale 160"),
    (["--truth", "truth.png", "--truth-scale", "0"], "--truth-scale must be a number above 0, not 0"),
    (["--truth", "truth.png", "--truth-scale", "nan"], "--truth-scale must be a number above 0, not nan"),
    (["--truth", "calib.txt"], "calib.txt has the suffix .txt"),
    ([*TRUTH, "--threshold", "-1"], "--threshold must be a number of pixels from 0, not -1"),
    ([*TRUTH, "--mask", "none.png"], "none.png does not exist"),
    ([*TRUTH, "--mask", "empty.png"], "empty.png has no pixel of level 255"),
    ([*TRUTH, "--mask", "narrow.png"], "narrow.png has 59x24 pixels, but the pictures have 60x24"),
    ([*TRUTH, "--mask", "lines.png"], "lines.png marks only pixels whose disparity truth.png does not know"),
    (["--truth-scale", "8"], "--truth-scale 8 is for --truth, which is missing"),
    (["--mask", "mask.png"], "mask.png masks a ground truth, but there is none"),
    (["--depth", "z.npy"], "--focal is missing, without which there is no depth"),
    (["--depth", "z.npy", "--focal", "50"], "--baseline is missing"),
    (["--depth", "z.npy", "--focal", "-5", "--baseline", "1"], "--focal must be a number above 0, not -5"),
    (["--depth", "z.npy", "--calib", "short.txt"], "short.txt has no baseline"),
    (["--depth", "z.npy", "--calib", "other.txt"], "other.txt is for 600x24 pixels, but the pictures have 60x24"),
    (["--depth", "z.npy", "--calib", "calib.txt", "--focal", "2"], "--focal is given with --calib calib.txt"),
    (["--depth", "z.tif", "--calib", "calib.txt"], "z.tif has the suffix .tif"),
    (["--depth", "z.png", "--focal", "50", "--baseline", "0.1"], "z.png holds millimetres, but the unit of the baseline, 0.1, is not"),
    (["--depth", "z.npy", "--calib", "calib.txt", "--baseline-unit", "m"], "--baseline-unit m is for --depth FILE.png: z.npy is in"),
    (["--baseline-unit", "m"], "--baseline-unit m is for --depth, which is missing"),
    (["--kitti-cameras", "0,1"], "--kitti-cameras 0,1 is for --depth, which is missing"),
    (["--depth", "z.npy", "--kitti-cameras", "0,1", "--focal", "1", "--baseline", "1"], "--kitti-cameras 0,1 is for --calib"),
    (["--depth", "z.npy", "--calib", "calib.txt", "--kitti-cameras", "0,1"], "calib.txt is no calib.txt of KITTI"),
    (["--depth", "z.npy", "--calib", "minus.txt"], "up to 19 are searched, and with doffs, which is -19 in minus.txt"),
    (["--depth", "z.npy", "--calib", "calib.txt", "--calib", "calib.txt"], "only camera_info of ROS has a file for each camera"),
    (["--calib", "calib.txt"], "--calib calib.txt is for --depth, which is missing"),
    (["--baseline", "1"], "--baseline 1.0 is for --depth, which is missing"),
    (["--colour", "c.npy"], "c.npy has the suffix .npy"),
    (["--sheet", "s.ppm"], "s.ppm has the suffix .ppm"),
    (["--colour", "c.png", "--sheet", "c.png"], "c.png is given for --colour and for --sheet"),
    ([*TRUTH, "--colour", "truth.png"], "truth.png is one of the files that are read; choose another --colour"),
])
def test_bad_input(folder, capsys, arguments, message):
    before = {path.name: path.read_bytes() for path in folder.iterdir()}
    assert main([*PAIR, *arguments]) == 2
    printed = capsys.readouterr()
    assert printed.out == "" and message in printed.err and printed.err.count("\n") == 1
    assert {path.name: path.read_bytes() for path in folder.iterdir()} == before
