"""hdl.host.calibrate: seen and real pictures as what the cameras send, pairs that are no good, regions, and an end by the user."""

import json

import numpy as np
import pytest

from golden.__main__ import main as golden_main
from golden.calibrate.views import read_board
from golden.errors import UserError
from golden.pictures.images import read_picture, write_picture
from golden.rig.files import read_rig
from golden.rig.maps import pack
from hdl.host import calibrate as module
from hdl.host import load_map
from hdl.host.calibrate import DEFAULT_PAIRS, Session, calibrate, check_calibration
from hdl.host.chip import Chip
from hdl.host.console import main as console
from tests.golden.calibrate.boards import BOARD, SIZE, Cameras, opencv
from tests.kit import calibration_folder

from .rig_chip import RigChip


FLAT = np.full(SIZE[::-1], 200, np.uint8)


@pytest.fixture(autouse=True)
def no_wait(monkeypatch):
    monkeypatch.setattr(load_map.time, "sleep", lambda seconds: None)


@pytest.fixture
def seen(monkeypatch):
    """Ten pairs, each picture of one grey level, for which the corners that cameras see of a board are found; in others there are none."""
    opencv()
    corners, pairs = {}, []
    for number, view in enumerate(Cameras().views()):
        corners |= {10 * number: view.left, 10 * number + 5: view.right}
        pairs.append(tuple(np.full(SIZE[::-1], 10 * number + side, np.uint8) for side in (0, 5)))
    monkeypatch.setattr(module, "find_corners", lambda picture, board: corners.get(int(picture[0, 0])))
    return pairs


def grabbing(pairs):
    """What is grabbed: these pairs, then the user ends it."""
    rest = iter(pairs)

    def grab():
        for pair in rest:
            return pair
        raise KeyboardInterrupt
    return grab


def in_use(chip, folder):
    """Whether the maps of the folder are in use."""
    rig = read_rig(folder)
    return chip.in_use == [pack(rig.left), pack(rig.right)] and chip.failures == [] and chip.values["row_offset"] == rig.row_offset


def test_guided(seen, tmp_path, capsys):
    """With pairs that are no good in between, ended by the user, and loaded."""
    chip, folder = RigChip(*SIZE), tmp_path / "rig"
    pairs = [*seen[:3], (seen[0][0], FLAT), seen[2], (FLAT, FLAT), *seen[3:]]
    told = calibrate(Chip(chip), grabbing(pairs), BOARD, folder)
    assert told.startswith("320x240 pixels, ") and "maps loaded, map_fault no" in told and in_use(chip, folder)
    out, err = capsys.readouterr()
    assert "left03.png and right03.png: corners in both, 3 of 13 good pairs\n  left    right\n" in out
    assert "left04.png and right04.png: no corners in the right picture; show the whole board" in out
    assert "left05.png and right05.png: the board is where it was in left03.png and right03.png, and the pair is not used" in out
    assert "left05.png and right05.png: no corners in the left and the right picture" in out
    assert "left12.png and right12.png: corners in both, 10 of 13" in out and err == "note: ended after 10 good pairs\n"
    assert "10 views used, 0 dropped, 2 without corners" in out
    # The pictures are what was grabbed, but for the pair in the same place.
    assert sorted(path.name for path in folder.glob("*[0-9].png")) == sorted(f"{side}{n:02}.png" for side in ("left", "right")
                                                                           for n in range(1, 13))
    assert (read_picture(folder / "right12.png") == seen[9][1]).all() and (read_picture(folder / "right04.png") == FLAT).all()
    assert json.loads((folder / "report.json").read_text())["without_corners"] == ["right04.png", "left05.png", "right05.png"]


def test_command(seen, tmp_path, capsys, monkeypatch):
    """The command, with its options; what is grabbed is that chip's."""
    chip, grab = RigChip(*SIZE), grabbing(seen)

    def grab_pair(chip, report):
        assert isinstance(chip, Chip)
        report(1, 480)
        return grab()

    monkeypatch.setattr("hdl.host.console.grab_pair", grab_pair)
    arguments = ["--port", "none", "calibrate", "--board", "7x5", "--square", "25", "--output", str(tmp_path), "--pairs"]
    assert console([*arguments, "9"], chip.connect) == 0
    out, _ = capsys.readouterr()
    assert "left09.png and right09.png: corners in both, 9 of 9 good pairs" in out and in_use(chip, tmp_path)
    assert out.splitlines()[-1].startswith(f"{tmp_path}: 320x240 pixels, ")
    # Once more: before the port is opened.
    for pairs, message in (("9", "has a calibration already"), ("7", "--pairs must be from 8 to 99, not 7")):
        assert console([*arguments, pairs], None) == 2
        assert message in capsys.readouterr().err


def test_too_few_and_gone_on_with(seen, tmp_path, capsys):
    chip, folder = RigChip(*SIZE), tmp_path / "rig"
    with pytest.raises(UserError, match="5 good pairs were taken, and 8 are needed to calibrate; run this again to go on"):
        calibrate(Chip(chip), grabbing(seen[:5]), BOARD, folder)
    assert not chip.LOADING & {*chip.names} and len([*folder.iterdir()]) == 10
    capsys.readouterr()
    calibrate(Chip(chip), grabbing(seen[5:]), BOARD, folder)
    out, err = capsys.readouterr()
    assert "has 5 pairs of an earlier run, which are used" in err and "left06.png and right06.png: corners in both, 6 of 13" in out
    assert in_use(chip, folder) and (read_picture(folder / "left10.png") == seen[9][0]).all()


def test_pictures_of_another_size_in_the_folder(seen, tmp_path):
    for side in ("left", "right"):
        write_picture(tmp_path / f"{side}01.png", FLAT[:100])
    with pytest.raises(UserError, match=r"left01.png has 320x100 pixels and the chip's pictures have 320x240; choose another --output"):
        calibrate(Chip(RigChip(*SIZE)), grabbing([]), BOARD, tmp_path)


def places(monkeypatch, corners):
    """Corners that are found in the pictures, in turn."""
    rest = iter(corners)
    monkeypatch.setattr(module, "find_corners", lambda picture, board: next(rest))


def at(*points):
    return np.array(points, dtype=np.float32)


def test_regions(tmp_path, monkeypatch):
    """Of 320x240 pixels: columns end at 106.67 and 213.33, lines at 80 and 160; corners may be a little outside of the picture."""
    session = Session(tmp_path, BOARD, SIZE, 8)
    places(monkeypatch, [at((320.2, -0.3), (214, 79)), at((-0.4, 240.3), (106, 160)), at((107, 80), (213, 159)), None])
    told = session.take(FLAT, FLAT)
    assert told.endswith("good pairs\n  left    right\n  . . #   . . .\n  . . .   . . .\n  . . .   # . .")
    session.take(FLAT, FLAT)
    # Without corners in the right picture, the left one's do not count.
    assert session.regions() == "  left    right\n  . . #   . . .\n  . . .   . . .\n  . . .   # . ."


def test_until_all_regions_are_covered(tmp_path, monkeypatch, capsys):
    """Eight good pairs are not enough while a region is without corners."""
    session = Session(tmp_path, BOARD, SIZE, 8)
    everywhere = [at((50 + 100 * (n % 3), 40 + 80 * (n // 3)), (50, 40)) for n in range(8)]
    last = at((250, 200), (50, 40))
    places(monkeypatch, [corners for each in [*everywhere, last] for corners in (each, each)])
    module._collect(session, grabbing([(FLAT, FLAT)] * 20))
    assert len(session.found.views) == 9 and session.complete
    out = capsys.readouterr().out
    assert out.count("show the board where the regions are without corners") == 1 and out.endswith("  # # #   # # #\n")


def test_covered_by_few_pairs(tmp_path, monkeypatch):
    """All regions in one pair: not enough before as many as are wanted."""
    session = Session(tmp_path, BOARD, SIZE, 8)
    everywhere = at(*((50 + 100 * (n % 3), 40 + 80 * (n // 3)) for n in range(9)))
    places(monkeypatch, [everywhere + 4 * n for n in range(8) for _ in range(2)])
    completed = []
    for _ in range(8):
        session.take(FLAT, FLAT)
        completed.append(session.complete)
    assert completed == [False] * 7 + [True]


def test_same_place(tmp_path, monkeypatch):
    """Nearer than a hundredth of the width, on average; corners may be found from the other end."""
    session = Session(tmp_path, BOARD, SIZE, 8)
    here = at((100, 100), (150, 100), (100, 120), (150, 120))
    places(monkeypatch, [corners for left in (here, here + 3.1, here[::-1] + 3.1, here + 3.3) for corners in (left, here)])
    told = [session.take(FLAT, FLAT) for _ in range(4)]
    assert ["is where it was" in each for each in told] == [False, True, True, False]


def test_refused(tmp_path, monkeypatch):
    with pytest.raises(UserError, match="the chip has no rectifiers"):
        calibrate(Chip(RigChip(*SIZE, lines=0)), grabbing([]), BOARD, tmp_path)
    with pytest.raises(UserError, match="--board is 9, but must be its inner corners"):
        check_calibration("9", 25, tmp_path)
    (tmp_path / "file").touch()
    opencv()
    with pytest.raises(UserError, match="a file, not a folder; choose another --output"):
        check_calibration("9x6", 25, tmp_path / "file")
    (tmp_path / "rig.json").touch()
    with pytest.raises(UserError, match="has a calibration already, whose pictures would be used again; load it with rectify"):
        check_calibration("9x6", 25, tmp_path)
    assert check_calibration("9x6", 25, tmp_path / "new") == read_board("9x6", 25) and not (tmp_path / "new").exists()


def test_without_opencv(tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "cv2", None)
    with pytest.raises(UserError, match=r"calibration needs OpenCV, which is not installed; install the extra lab: pip install"):
        check_calibration("9x6", 25, tmp_path)


@pytest.mark.slow   # 50 pictures are searched for a board, half a second each; known corners go the same way above
def test_real_cameras(tmp_path, capsys):
    """Thirteen pairs and three in which no corners are found: it ends by itself, as all regions are covered."""
    opencv()
    paths = sorted(calibration_folder().glob("left[01][0-9].jpg"))
    pairs = [(read_picture(path), read_picture(path.with_name(path.name.replace("left", "right")))) for path in paths]
    assert len(pairs) == DEFAULT_PAIRS
    half = pairs[0][0].copy()
    half[:, 300:] = 0
    spoilt = [(half, pairs[0][1]), (pairs[1][0], np.full_like(half, 90)), (half, half)]
    chip, folder = RigChip(640, 480), tmp_path / "rig"
    told = calibrate(Chip(chip), grabbing([*pairs[:4], *spoilt, *pairs[4:]]), read_board("9x6", 25), folder)
    assert "34 lines of 34, the right picture moved by 4 lines" in told and in_use(chip, folder)
    out, err = capsys.readouterr()
    assert out.count("no corners in the") == 3 and out.count("corners in both") == 13 and "13 of 13 good pairs" in out and err == ""
    report = json.loads((folder / "report.json").read_text())
    assert report["rms_pixels"] < 0.27 and report["dy"]["rectified"] < 0.12 and len(report["without_corners"]) == 4
    # golden calibrate of the pictures in the folder gives the same.
    pictures = [str(path) for side in ("left", "right") for path in sorted(folder.glob(f"{side}*.png"))]
    assert golden_main(["calibrate", *pictures, "--board", "9x6", "--square", "25", "--output", str(tmp_path / "again")]) == 0
    assert all((folder / name).read_bytes() == (tmp_path / "again" / name).read_bytes() for name in ("rig.json", "calib.txt"))
