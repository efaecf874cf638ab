"""`python -m golden match`: results, and what a careless user meets."""

import subprocess
import sys

import numpy as np
import pytest
from PIL import Image

from golden.__main__ import main
from golden.config import FUSED_1, METHODS, RECURSIVE_1, MatcherConfig, OnePass, changed
from golden.matcher.fused import match as match_fused
from golden.matcher.labelling import match as match_thesis
from golden.matcher.matcher import match
from golden.pictures.images import read_picture, write_picture
from golden.pictures.metrics import bad_pixels
from golden.pictures.scenes import scene
from tests.kit import reduced_motorcycle


@pytest.fixture
def folder(tmp_path, monkeypatch):
    """A working folder with a pair, and files that are none."""
    monkeypatch.chdir(tmp_path)
    left, right, _ = scene(150, 33, 80, seed=1)
    write_picture("left.png", left)
    write_picture("right.pgm", right)
    write_picture("small.png", left[:-1])
    write_picture("wide.png", np.zeros((1, 4097), np.uint8))
    (tmp_path / "text.png").write_text("no picture")
    (tmp_path / "folder.npy").mkdir()
    (tmp_path / "old.npy").write_bytes(b"old")
    return tmp_path


def expected(minimum=0, **parameters):
    config = MatcherConfig(labels=80, minimum=minimum, method=changed(OnePass(), **parameters))
    return match_thesis(read_picture("left.png"), read_picture("right.pgm"), config)


@pytest.mark.parametrize("suffix", [".npy", ".png", ".pgm", ".pfm", ".txt"])
def test_output(folder, capsys, suffix):
    assert main(["match", "left.png", "right.pgm", "--disparities", "80", "--output", f"a{suffix}"]) == 0
    np.testing.assert_array_equal(read_picture(f"a{suffix}"), expected())
    printed = capsys.readouterr()
    assert f"a{suffix}: 150x33 pixels, 80 disparities, method thesis, thesis arithmetic" in printed.out and "bad pixels" not in printed.out
    assert printed.err == ""


@pytest.mark.parametrize("arguments, settings", [
    (["--arithmetic", "float"], {"arithmetic": "float"}),
    (["--arithmetic", "linear"], {"arithmetic": "linear"}),
    (["--arithmetic", "linear", "--fraction-bits", "0"], {"arithmetic": "linear", "fraction_bits": 0}),
    (["--u1", "1"], {"u1": 1}),
    (["--u2", "40"], {"u2": 40}),
    (["--u3", "60"], {"u3": 60}),
])
def test_options(folder, arguments, settings):
    assert main(["match", "left.png", "right.pgm", "--disparities", "80", *arguments, "--output", "old.npy"]) == 0
    np.testing.assert_array_equal(np.load("old.npy"), expected(**settings))
    others = [{}, {"arithmetic": "linear"}] if "fraction_bits" in settings else [{}]
    assert all((expected(**settings) != expected(**other)).any() for other in others)


@pytest.mark.parametrize("arguments, settings", [
    ([], {}), (["--parameters", "recursive-2"], {"from_below": True}), (["--census-threshold", "3"], {"census_threshold": 3}),
    (["--no-fill", "--minimum", "-3"], {"fill": False}),
])
def test_recursive(folder, arguments, settings):
    assert main(["match", "left.png", "right.pgm", "--disparities", "80", "--method", "recursive", *arguments, "--output", "old.npy"]) == 0
    pair = read_picture("left.png"), read_picture("right.pgm")
    minimum = -3 if "--minimum" in arguments else 0

    def disparity(**values):
        return match(*pair, MatcherConfig(80, minimum=minimum, method=changed(RECURSIVE_1, **values)))["disparity"]

    np.testing.assert_array_equal(np.load("old.npy"), disparity(**settings))
    assert not settings or (disparity(**settings) != disparity()).any()


def expected_fused(minimum=0, **stages):
    config = MatcherConfig(labels=80, minimum=minimum, method=changed(FUSED_1, **stages))
    return match_fused(read_picture("left.png"), read_picture("right.pgm"), config)


@pytest.mark.parametrize("arguments, stages", [
    ([], {}),
    (["--refine"], {}),
    (["--arithmetic", "linear", "--u1", "17", "--u2", "30", "--u3", "22"], {}),
    (["--no-check", "--no-fill", "--no-median"], {"check": False, "fill": False, "median": False}),
    (["--no-refine"], {"check": False, "fill": False, "median": False}),
    (["--no-refine", "--median"], {"check": False, "fill": False}),
    (["--no-fill"], {"fill": False}),
    (["--no-median"], {"median": False}),
    (["--sub-pixel"], {"sub_pixel": True}),
    (["--minimum", "5"], {"minimum": 5}),
])
def test_fused(folder, capsys, arguments, stages):
    outputs = ["--output", "a.npy", "--passed", "b.npy", "--confidence", "c.png"]
    assert main(["match", "left.png", "right.pgm", "--disparities", "80", "--method", "fused", *arguments, *outputs]) == 0
    result = expected_fused(**stages)
    np.testing.assert_array_equal(np.load("a.npy"), result.pixels)
    np.testing.assert_array_equal(np.load("b.npy"), result.passed)
    np.testing.assert_array_equal(read_picture("c.png"), result.confidence)
    assert not stages or (result.pixels != expected_fused().pixels).any()
    assert "80 disparities, method fused, linear arithmetic" in capsys.readouterr().out


def test_fused_weights(folder):
    for weight in ("--u1", "--u2", "--u3"):
        assert main(["match", *PAIR, "--disparities", "80", "--method", "fused", "--no-refine", weight, "2", "--output", "a.npy"]) == 0
        assert (np.load("a.npy") != expected_fused(check=False, fill=False, median=False).pixels).any()


@pytest.mark.parametrize("suffix, dtype", [(".npy", np.uint16), (".pfm", np.float32)])
def test_far_disparities(folder, suffix, dtype):
    assert main(["match", *PAIR, "--disparities", "80", "--minimum", "200", "--output", f"a{suffix}"]) == 0
    with Image.open("a.pfm") if suffix == ".pfm" else open("a.npy", "rb") as file:
        labels = np.asarray(file) if suffix == ".pfm" else np.load(file)
    assert labels.dtype == dtype
    np.testing.assert_array_equal(labels, expected(minimum=200))


def test_motorcycle(capsys, tmp_path):
    pair = reduced_motorcycle()
    assert main(["match", "--output", str(tmp_path / "a.npy")]) == 0
    labels = np.load(tmp_path / "a.npy")
    np.testing.assert_array_equal(labels, match_thesis(pair.left, pair.right, MatcherConfig(labels=pair.disparities)))
    bad = bad_pixels(labels, pair.truth, pair.masks["known"])
    assert 5 < bad < 40
    assert f"bad pixels: {bad:.2f} %" in capsys.readouterr().out
    assert main(["match", "--disparities", "8", "--output", str(tmp_path / "b.npy")]) == 0
    assert np.load(tmp_path / "b.npy").max() == 7


PAIR = ["left.png", "right.pgm"]
OUTPUT = ["--output", "new.npy"]
NUMBER = ["--disparities", "13"]
FUSED = ["--method", "fused"]
LIMITS = f"must be a whole number from 2 to {MatcherConfig.LABELS[-1]}"


@pytest.mark.parametrize("arguments, message", [
    ([*PAIR, *NUMBER], "required: --output"),
    ([*PAIR, *OUTPUT], "--disparities is missing"),
    ([*PAIR, "--disp", "13", *OUTPUT], "unrecognized arguments: --disp"),
    (["left.png", *NUMBER, *OUTPUT], "left.png has no right picture"),
    ([*PAIR, "third.png", *NUMBER, *OUTPUT], "unrecognized arguments: third.png"),
    (["left.png", "small.png", *NUMBER, *OUTPUT], "differ in size: left.png has 150x33 pixels, small.png has 150x32"),
    (["left.png", "none.png", *NUMBER, *OUTPUT], "none.png does not exist"),
    (["text.png", "right.pgm", *NUMBER, *OUTPUT], "text.png is not a PNG"),
    (["folder.npy", "right.pgm", *NUMBER, *OUTPUT], "folder.npy is a folder"),
    (["wide.png", "wide.png", *NUMBER, *OUTPUT], "4097 pixels wide, more than the 4096"),
    ([*PAIR, "--disparities", "1", *OUTPUT], f"--disparities {LIMITS}, not 1"),
    ([*PAIR, "--disparities", "1000", *OUTPUT], f"--disparities {LIMITS}, not 1000"),
    ([*PAIR, "--disparities", "many", *OUTPUT], "invalid int value: 'many'"),
    (["--disparities", "0", *OUTPUT], f"--disparities {LIMITS}, not 0"),
    ([*PAIR, *NUMBER, "--arithmetic", "decimal", *OUTPUT], "decimal"),
    ([*PAIR, *NUMBER, "--fraction-bits", "5", *OUTPUT], "--fraction-bits must be a whole number from 0 to 4, not 5"),
    ([*PAIR, *NUMBER, "--u1", "64", *OUTPUT], "--u1 must be a whole number from 0 to 63, not 64"),
    ([*PAIR, *NUMBER, "--u2", "-1", *OUTPUT], "--u2 must be a whole number from 0 to 63, not -1"),
    ([*PAIR, *NUMBER, "--u3", "64", *OUTPUT], "--u3 must be a whole number from 0 to 63, not 64"),
    ([*PAIR, *NUMBER, "--minimum", "256", *OUTPUT], "--minimum must be a whole number from -64 to 255, not 256"),
    ([*PAIR, *NUMBER, "--minimum", "-65", *OUTPUT], "--minimum must be a whole number from -64 to 255, not -65"),
    ([*PAIR, *NUMBER, "--minimum", "250", "--output", "new.png"], "new.png holds disparities up to 255, but"),
    ([*PAIR, *NUMBER, "--method", "census", *OUTPUT], "census"),
    ([*PAIR, *NUMBER, "--cost", "fused", *OUTPUT], "--cost is now --method; write --method fused"),
    ([*PAIR, *NUMBER, "--cost=thesis", *OUTPUT], "--cost is now --method; write --method thesis"),
    ([*PAIR, *NUMBER, *OUTPUT, "--cost"], f"--cost is now --method; write --method {'|'.join(METHODS)}"),
    ([*PAIR, *NUMBER, *FUSED, "--cost", "census", *OUTPUT], f"--cost is now --method; write --method {'|'.join(METHODS)}"),
    ([*PAIR, *NUMBER, *FUSED, "--arithmetic", "thesis", *OUTPUT], "--arithmetic thesis cannot compute the method fused; choose"),
    ([*PAIR, *NUMBER, *FUSED, "--arithmetic", "float", *OUTPUT], "--arithmetic float cannot compute the method fused; choose"),
    ([*PAIR, *NUMBER, *FUSED, "--fraction-bits", "3", *OUTPUT], "--fraction-bits 3 belongs to the method thesis; choose --method thesis"),
    ([*PAIR, *NUMBER, *FUSED, "--census-threshold", "1", *OUTPUT], "--census-threshold 1 belongs to the method recursive; choose"),
    ([*PAIR, *NUMBER, "--method", "recursive", "--census-threshold", "8", *OUTPUT],
     "--census-threshold must be a whole number from 0 to 7, not 8"),
    ([*PAIR, *NUMBER, "--method", "recursive", "--u1", "8", *OUTPUT], "--u1 8 belongs to the method thesis or fused; choose"),
    ([*PAIR, *NUMBER, *FUSED, "--u2", "64", *OUTPUT], "--u2 must be a whole number from 0 to 63, not 64"),
    ([*PAIR, *NUMBER, *FUSED, "--minimum", "256", *OUTPUT], "--minimum must be a whole number from -64 to 255, not 256"),
    ([*PAIR, *NUMBER, *FUSED, "--no-check", "--fill", *OUTPUT], "--fill has nothing to do without the left-right check"),
    ([*PAIR, *NUMBER, *FUSED, "--sub-pixel", "--output", "new.png"], "new.png holds whole numbers only"),
    ([*PAIR, *NUMBER, *FUSED, "--passed", "new.jpg", *OUTPUT], "new.jpg has the suffix .jpg"),
    ([*PAIR, *NUMBER, *FUSED, "--confidence", "new.npy", *OUTPUT], "new.npy is given for --output and for --confidence"),
    ([*PAIR, *NUMBER, *FUSED, "--confidence", "left.png", *OUTPUT], "left.png is one of the files that are read; choose another"),
    ([*PAIR, *NUMBER, "--refine", *OUTPUT], "--refine belongs to the method fused"),
    ([*PAIR, *NUMBER, "--no-median", *OUTPUT], "--no-median belongs to the method fused"),
    ([*PAIR, *NUMBER, "--sub-pixel", *OUTPUT], "--sub-pixel belongs to the method fused"),
    ([*PAIR, *NUMBER, "--passed", "p.npy", *OUTPUT], "--passed belongs to the method fused"),
    (["--method", "fused", "--arithmetic", "thesis", *OUTPUT], "--arithmetic thesis cannot compute the method fused"),
    ([*PAIR, *NUMBER, "--output", "new.jpg"], "suffix .jpg"),
    ([*PAIR, *NUMBER, "--output", "new"], "suffix (none)"),
    ([*PAIR, *NUMBER, "--output", "folder.npy"], "folder.npy is a folder"),
    ([*PAIR, *NUMBER, "--output", "none/new.npy"], "the folder none of new.npy does not exist"),
    ([*PAIR, *NUMBER, "--output", "left.png"], "left.png is one of the files that are read"),
    (["none.png", "none.png", *NUMBER, "--output", "old.npy"], "none.png does not exist"),
])
def test_bad_input(folder, capsys, arguments, message):
    before = {path.name: path.is_file() and path.read_bytes() for path in folder.iterdir()}
    assert main(["match", *arguments]) == 2
    printed = capsys.readouterr()
    assert printed.out == ""
    assert printed.err.startswith("golden match: ") and message in printed.err
    assert printed.err.count("\n") == 1
    assert {path.name: path.is_file() and path.read_bytes() for path in folder.iterdir()} == before


def test_output_is_checked_before_computing(folder, monkeypatch):
    monkeypatch.setattr("golden.match.read_pair", lambda *sides: pytest.fail("read"))
    assert main(["match", *PAIR, *NUMBER, "--output", "none/new.npy"]) == 2


@pytest.mark.parametrize("arguments, message", [([], "required"), (["mach"], "invalid choice: 'mach'"), (["--what"], "required")])
def test_bad_command(capsys, arguments, message):
    assert main(arguments) == 2
    printed = capsys.readouterr()
    assert printed.err.startswith("golden: ") and message in printed.err and printed.err.count("\n") == 1


def test_help_names_the_commands(capsys):
    with pytest.raises(SystemExit) as end:
        main(["--help"])
    assert end.value.code == 0
    printed = capsys.readouterr().out
    assert "match" in printed and "evaluate" in printed


def test_process(folder):
    """The real thing: statuses reach the shell, and nothing but the sentence is on stderr."""
    def run(*arguments):
        command = [sys.executable, "-m", "golden", "match", *arguments]
        return subprocess.run(command, capture_output=True, text=True, timeout=60, env={"PYTHONPATH": str(folder_of_golden())})

    good = run(*PAIR, *NUMBER, *OUTPUT)
    assert (good.returncode, good.stderr) == (0, "")
    bad = run("left.png", "none.png", *NUMBER, *OUTPUT)
    assert (bad.returncode, bad.stdout) == (2, "")
    assert bad.stderr == "golden match: none.png does not exist; give the name of a picture\n"


def folder_of_golden():
    import golden
    return golden.__path__[0].rpartition("golden")[0]
