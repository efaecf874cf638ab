"""sim.evaluate: how it ends on bad input, and what it makes of a simulation. No simulator runs here."""

import json
import re

import numpy as np
import pytest
from amaranth.hdl import Fragment

from golden.config import MatcherConfig, OnePass
from golden.lab.cameras import pictures
from golden.lab.mounting import Mounting
from golden.matcher.matcher import match
from golden.pictures import dataset
from golden.pictures.dataset import StereoPair
from golden.pictures.metrics import bad_pixels
from golden.pictures.scenes import scene
from golden.rig.balance import Auto
from hdl.rig.balance import BalanceMode
from sim import evaluate
from sim.kit import mounted
from sim.kit.harness import Frame, Result
from sim.kit.simulators import SimulationError


@pytest.fixture
def never(monkeypatch):
    """Nothing may be read, looked for or simulated."""
    for name in ("require", "data_folder", "load_pair", "simulate"):
        def fail(*_, name=name, **__):
            pytest.fail(f"{name} was called")
        monkeypatch.setattr(evaluate, name, fail)


@pytest.mark.parametrize("arguments, told", [
    ("--simulator questa", "--simulator"),
    ("--disparities 8", "--disparities"),
    ("--arithmetic float", "--arithmetic float has no gateware; choose"),
    ("--cost fused", "--cost is now --method; write --method fused"),
    ("--engine sequential --method fused", "--engine sequential has no method fused; choose"),
    ("--minimum 3", "--minimum 3 belongs to the method fused"),
    ("--method fused --minimum 256", "--minimum must be a whole number from -64 to 255, not 256; choose"),
    ("--mounted --method fused --minimum 3", "--mounted is for pairs whose least disparity is 0, not 3; leave --minimum out"),
    ("--pairs moon", "'moon'"),
    ("--refine", "--refine belongs to the method fused"),
    ("--method fused --parameters none.toml", "cannot read none.toml"),
    ("--json figures.txt", "figures.txt has the suffix .txt"),
    ("--json none/figures.json", "the folder none of figures.json does not exist"),
])
def test_bad_arguments(never, tmp_path, monkeypatch, capsys, arguments, told):
    monkeypatch.chdir(tmp_path)
    assert evaluate.main(arguments.split()) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert err.startswith("sim.evaluate: ") and told in err
    assert err.count("\n") == 1 and err.endswith("\n")
    assert list(tmp_path.iterdir()) == []


def test_no_data(tmp_path, monkeypatch, capsys):
    monkeypatch.setattr(evaluate, "require", lambda simulator: None)
    assert evaluate.main(["--data", str(tmp_path / "none"), "--json", str(tmp_path / "a.json")]) == 2
    assert "none does not exist; name the one" in capsys.readouterr().err
    assert list(tmp_path.iterdir()) == []


@pytest.fixture
def pairs(monkeypatch):
    """Two small pairs in the place of the benchmark's, of different sizes and numbers of disparities."""
    small = {}
    for name, (width, height, labels) in {"tsukuba": (20, 6, 5), "venus": (31, 7, 8)}.items():
        left, right, truth = scene(width, height, labels, seed=3)
        every = np.ones(truth.shape, dtype=bool)
        # Off by a pixel and a half in the right half: there alone disparities are bad.
        truth = np.where(np.isfinite(truth), truth, 0) + 1.5 * (np.arange(width) >= width // 2)
        small[name] = StereoPair(name, left, right, truth, dict.fromkeys(dataset.MASKS, every), labels)
    monkeypatch.setattr(evaluate, "PAIRS", list(small))
    monkeypatch.setattr(evaluate, "data_folder", lambda data: data)
    monkeypatch.setattr(evaluate, "load_pair", lambda folder, name: small[name])
    monkeypatch.setattr(evaluate, "require", lambda simulator: None)
    return small


def fake(monkeypatch, fault):
    """A simulation that takes no time: what the golden model gives, but for ``fault`` pixels of each of three parts of a word."""
    configs = []

    def simulate(config, lefts, rights, **_):
        configs.append(config)
        height, width = lefts[0].shape
        about = [Frame(width, height, 1000, 2 * width * height, 1, 300, 100)], {"clocks": 1000}, 0.5, 0.0
        fields = {name: values.astype(np.int32) for name, values in match(lefts[0], rights[0], config).items()}
        for line, values in enumerate(fields.values()):
            values[line, :fault] = values[line, :fault] == 0
        return Result([fields], *about)

    monkeypatch.setattr(evaluate, "simulate", simulate)
    return configs


@pytest.mark.parametrize("fault", [0, 2])
@pytest.mark.parametrize("method", [[], ["--method", "fused"], ["--method", "fused", "--sub-pixel", "--u1", "9"]], ids=" ".join)
def test_figures(pairs, monkeypatch, tmp_path, capsys, method, fault):
    """Every part of every word counts; disparities are judged in pixels; exit status 1 if a pixel is wrong."""
    configs = fake(monkeypatch, fault)
    assert evaluate.main([*method, "--json", str(tmp_path / "a.json")]) == int(fault > 0)
    told = json.loads((tmp_path / "a.json").read_text())
    assert told["mismatches"] == fault * len(pairs) * (3 if method else 1)
    out = capsys.readouterr().out
    assert f"Mismatching pixels against golden: {told['mismatches']}" in out
    assert re.search(rf"┃ method +┃.*\n[^\n]*\n│ {'fused' if method else 'thesis'} +│ tsukuba", out)
    assert [(config.labels, config.max_width) for config in configs] == [(5, 20), (8, 31)]
    assert {config.rule.weights[0] for config in configs} == {9 if "--u1" in method else 17 if method else 15}
    figures = told["bad_pixels_percent"]
    assert told["average"] == pytest.approx(np.mean([value for pair in figures.values() for value in pair.values()]))
    for (name, pair), config in zip(pairs.items(), configs):
        disparity = match(pair.left, pair.right, config)["disparity"].copy()
        disparity[0, :fault] = disparity[0, :fault] == 0
        bad = 100 * np.mean(np.abs(disparity / config.method.disparity_scale - pair.truth) > 1)
        assert figures[name] == pytest.approx(dict.fromkeys(dataset.MASKS, bad))
        assert 0 < bad < 100
        assert told["rates"][name] == {"clocks_per_pixel": 2.0, "seconds": 0.5}


# Slow: with no pixel but golden's the same, and status 0.
@pytest.mark.parametrize("fault", [pytest.param(0, marks=pytest.mark.slow), 2])
def test_mounted_cameras(pairs, monkeypatch, tmp_path, capsys, fault):
    """What golden cameras computes, if the gateware rectifies and balances as its settings tell; any other pixel is counted."""
    left, right, truth = scene(80, 50, 8, seed=3)
    pair = StereoPair("venus", left, right, truth, {"nonocc": np.isfinite(truth), "all": np.isfinite(truth), "disc": np.isfinite(truth)}, 8)
    pairs["venus"] = pair
    calls = []

    def simulate(config, lefts, rights, *, core, settings, progress, **_):
        calls.append(len(lefts))
        progress(50 * len(lefts))
        auto, fields = Auto(0, 8), []
        for seen in zip(lefts, rights):
            first, second = core.rig.rig.rectified(*seen) if settings["rectify"] else seen
            if settings["balance"] == BalanceMode.AUTO:
                second = auto.pair(first, second)
            fields.append(match(first, second, config))
            fields[-1]["disparity"] = fields[-1]["disparity"].astype(np.int32)
            fields[-1]["disparity"][0, :fault] ^= 1
        return Result(fields, [Frame(80, 50, 1, 1, 1, 1, 1, 4000 * number**2) for number in range(len(lefts))], {}, 0.25, 0.0)

    monkeypatch.setattr(mounted, "simulate", simulate)
    monkeypatch.setattr(mounted, "write_verilog", lambda core, path, name: Fragment.get(core, None) and path)
    json_file = tmp_path / "a.json"
    assert evaluate.main(["--mounted", "--pairs", "venus", "venus", "--json", str(json_file)]) == int(fault > 0)
    told = json.loads(json_file.read_text())
    assert sum(calls) == mounted.FRAMES == 10
    assert told["mismatches"] == 8 * fault
    # From the second to the third frame of the last run; all runs.
    assert told["rates"] == {"venus": {"frame_clocks": 12000, "seconds": 1.0}}
    config = MatcherConfig(8, 80, engine="streaming", method=OnePass("linear"))
    wanted = {name: np.array(match(*each, config)["disparity"]) for name, each in pictures(pair, Mounting()).items() if name != "exact"}
    for disparity in wanted.values():
        disparity[0, :fault] ^= 1
    figures = {name: bad_pixels(disparity, truth, np.isfinite(truth)) for name, disparity in wanted.items()}
    assert told["bad_pixels_percent"] == {name: {"venus": pytest.approx(dict.fromkeys(pair.masks, bad))} for name, bad in figures.items()}
    assert told["averages"] == pytest.approx(figures)
    assert figures["both"] > figures["both cured"] and len(set(figures.values())) == 8
    out = capsys.readouterr().out
    assert f"Mismatching pixels against golden: {8 * fault}\n" in out and "venus: 12000 clocks a frame" in out
    assert [line for line in out.splitlines() if "and balanced" in line]


def test_mounted_cameras_that_are_too_far_from_level(pairs, monkeypatch, capsys):
    monkeypatch.setattr(evaluate, "Mounting", lambda: Mounting(roll=24))
    left, right, truth = scene(80, 80, 8, seed=3)
    pairs["venus"] = StereoPair("venus", left, right, truth, {}, 8)
    assert evaluate.main(["--mounted", "--pairs", "venus"]) == 2
    assert re.fullmatch(r"sim.evaluate: venus: this map needs \d+ lines and .*\n", capsys.readouterr().err)


def test_failed_simulation(pairs, monkeypatch, tmp_path, capsys):
    def simulate(*_, **__):
        raise SimulationError("the harness saw faults: hang 1")
    monkeypatch.setattr(evaluate, "simulate", simulate)
    assert evaluate.main(["--json", str(tmp_path / "a.json")]) == 1
    assert capsys.readouterr().err == "sim.evaluate: the harness saw faults: hang 1\n"
    assert list(tmp_path.iterdir()) == []
