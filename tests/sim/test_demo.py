"""sim.demo: what it leaves behind, how it judges, and how it ends on bad input. Only the slow test runs a simulator."""

import json
import re
from pathlib import Path

import numpy as np
import pytest
from amaranth.hdl import Fragment
from PIL import Image

from golden.matcher.matcher import disparities
from golden.pictures.dataset import StereoPair, motorcycle
from golden.pictures.metrics import bad_pixels
from golden.pictures.scenes import scene
from golden.pictures.sheet import BAD
from hdl.matcher.matcher import Matcher
from sim import demo
from sim.kit.harness import Frame, Result
from sim.kit.simulators import SimulationError


ROOT = Path(__file__).resolve().parents[2]
RESULTS = {"sheet.png", "disparity.png", "report.json"}


@pytest.fixture
def small(monkeypatch):
    """A small pair in the place of the Motorcycle."""
    left, right, truth = scene(40, 24, 11, seed=3)
    pair = StereoPair("motorcycle", left, right, truth, {"known": np.isfinite(truth)}, 11)
    monkeypatch.setattr(demo, "motorcycle", lambda *_, **__: pair)
    return pair


@pytest.fixture
def simulated(monkeypatch):
    """A simulation that takes no time: what the golden model gives, with a number of pixels changed. Returns the configurations seen."""
    def install(fault=0):
        configs = []

        def simulate(config, left, right, simulator, work):
            configs.append(config)
            labels = disparities(left, right, config).copy()
            labels[0, :fault] ^= 8
            height, width = labels.shape
            frame = Frame(width, height, 1000, 2 * width * height, 1, 300, 100)
            return Result([{"disparity": labels}], [frame], {"clocks": 1000}, 0.5, 12.0)

        def mismatches(result, number, left, right, config):
            return int(np.count_nonzero(result.fields[number]["disparity"] != disparities(left, right, config)))

        monkeypatch.setattr(demo, "simulate_shown", simulate)
        monkeypatch.setattr(demo, "mismatches", mismatches)
        monkeypatch.setattr(demo, "require", lambda simulator: None)
        return configs
    return install


@pytest.mark.parametrize("fault", [0, 5])
def test_sheet_and_figures(small, simulated, tmp_path, capsys, fault):
    """The Verilog's disparities are judged, not the golden model's; exit status 1 if they differ."""
    configs = simulated(fault)
    folder = tmp_path / "a" / "b"
    assert demo.main(["--output", str(folder)]) == int(fault > 0)
    assert {path.name for path in folder.iterdir()} == RESULTS
    config, = configs
    thesis, ours = demo.configurations(small)
    assert config == ours and config.labels == thesis.labels == 16 and config.max_width == 40

    labels = disparities(small.left, small.right, ours).copy()
    labels[0, :fault] ^= 8
    expected = {"thesis": disparities(small.left, small.right, thesis), "recursive": labels}
    report = json.loads((folder / "report.json").read_text())
    assert report["mismatches"] == fault and report["clocks_per_pixel"] == 2.0
    assert report["bad_pixels_percent"] == {name: pytest.approx(bad_pixels(each, small.truth, small.masks["known"]), abs=0.006)
                                            for name, each in expected.items()}
    out = capsys.readouterr().out
    for name, title in demo.TITLES.items():
        assert re.search(rf"{re.escape(title)} +│ +{report['bad_pixels_percent'][name]:.2f} %", out)
    assert f"{fault} of the Verilog's pixels differ" in out and str(folder / "sheet.png") in "".join(out.split("\n"))

    with Image.open(folder / "sheet.png") as picture:
        sheet = np.asarray(picture.convert("RGB"))
    left, right = ((sheet[:, part] == BAD).all(axis=-1).sum() for part in (
        slice(0, sheet.shape[1] // 3), slice(sheet.shape[1] // 3, None)))
    assert left < right / 20  # errors are in the columns of the methods; the legend alone may reach to the left


def test_real_pair(simulated, tmp_path):
    """The pair, its size and its number of labels are those that the README tells, with its figures."""
    pytest.importorskip("skimage", reason="scikit-image, which carries the Motorcycle pair, is not installed")
    configs = simulated()
    assert demo.main(["--output", str(tmp_path)]) == 0
    report = json.loads((tmp_path / "report.json").read_text())
    assert (report["width"], report["height"], report["disparities"], configs[0].labels) == (370, 250, 32, 32)
    figures = report["bad_pixels_percent"]
    assert figures["recursive"] < figures["thesis"] / 3
    told = " ".join((ROOT / "README.md").read_text(encoding="utf-8").split())
    assert f"{figures['thesis']:.2f} % to {figures['recursive']:.2f} %" in told


@pytest.mark.parametrize("arguments, told", [
    ("--reduce 0", "--reduce must be a whole number from 1 to 8, not 0; choose a value in that range"),
    ("--reduce 9", "from 1 to 8, not 9"),
    ("--reduce half", "--reduce"),
    ("--simulator questa", "--simulator"),
    ("left.png right.png", "left.png"),
    ("--output file/below", "file is a file, not a folder"),
])
def test_bad_arguments(small, simulated, tmp_path, monkeypatch, capsys, arguments, told):
    configs = simulated()
    monkeypatch.chdir(tmp_path)
    (tmp_path / "file").touch()
    assert demo.main(arguments.split()) == 2
    out, err = capsys.readouterr()
    assert out == "" and configs == []
    assert err.startswith("sim.demo: ") and told in err
    assert err.count("\n") == 1 and err.endswith("\n")
    assert [path.name for path in tmp_path.iterdir()] == ["file"]


def test_failed_simulation(small, simulated, monkeypatch, tmp_path, capsys):
    def simulate(*_, **__):
        raise SimulationError("the harness saw faults: hang 1")
    simulated()
    monkeypatch.setattr(demo, "simulate_shown", simulate)
    assert demo.main(["--output", str(tmp_path)]) == 1
    assert capsys.readouterr().err == "sim.demo: the harness saw faults: hang 1\n"
    assert list(tmp_path.iterdir()) == []


@pytest.mark.slow
def test_verilog(tmp_path):
    """`make demo` itself, set-up aside."""
    pytest.importorskip("skimage", reason="scikit-image, which carries the Motorcycle pair, is not installed")
    assert demo.main(["--output", str(tmp_path)]) == 0
    report = json.loads((tmp_path / "report.json").read_text())
    pair = motorcycle(2)
    height, width = pair.left.shape
    matcher = Matcher(demo.configurations(pair)[1])
    Fragment.get(matcher, None)     # Amaranth complains of a component that is not used
    assert report["mismatches"] == 0
    assert 1 < report["clocks_per_pixel"] <= matcher.frame_clocks(width, height) / (width * height)
    assert report["seconds"] < 180
