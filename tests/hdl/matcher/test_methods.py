"""Methods as parts: a third one is three files and a row, and everything that composes, simulates and builds takes it as it is."""

import json
import pathlib
import re

import numpy as np
import pytest
from amaranth.hdl import Fragment

from golden.__main__ import main as golden_main
from golden.config import METHODS, Engine, MatcherConfig, changed, parameters_of
from golden.matcher.matcher import match
from golden.pictures.scenes import discriminates, scene
from hdl import build
from hdl.matcher import methods
from hdl.matcher.matcher import Matcher
from hdl.matcher.methods import Parts
from hdl.matcher.stage import CostArray, LabelOutput, Stage
from sim import run
from sim.kit.cases import noise, pixel_words
from sim.kit.harness import mismatches, simulate
from sim.kit.streams import run_stream
from tests.hdl.matcher.toy_method.gateware import ToyArray
from tests.hdl.matcher.toy_method.parameters import Toy
from tests.hdl.matcher.toy_method.reference import match as toy_match


ROOT = pathlib.Path(__file__).parents[3]


@pytest.mark.parametrize("contract, missing", [(Stage, "latency"), (CostArray, "columns_of"), (CostArray, "latency_of")])
def test_part_that_answers_not_all(contract, missing):
    """A part without what the contract asks for is refused as it is made, not where the answer would be used."""
    given = {name: None for name in contract.__abstractmethods__ if name != missing}
    with pytest.raises(TypeError, match=f"abstract method {missing}|abstract method '{missing}'"):
        type("Part", (contract,), given)({})


@pytest.fixture
def row(monkeypatch):
    monkeypatch.setitem(methods.METHODS, Toy, Parts(costs=ToyArray))


@pytest.mark.parametrize("labels, width, height", [(2, 1, 1), (6, 40, 4), (13, 5, 3), (13, 60, 3)])
def test_third_method_matches_golden(row, labels, width, height):
    """Frames in a row, with stalls, bit-exact: engine and line store learn all from the array that they are given."""
    config = MatcherConfig(labels, max(width, 8), method=Toy())
    assert config.engine is Engine.STREAMING
    pairs = [scene(width, height, labels, seed=3)[:2] if width > 2 else noise(width, height, seed=3), noise(8, 2, seed=4)]
    pairs = [[np.asarray(side, dtype=np.uint8) for side in pair] for pair in pairs]
    expected = [match(*pair, config)["disparity"] for pair in pairs]
    if width > 2 * labels:
        assert discriminates(expected[0], config)
    given = run_stream(Matcher(config), [word for pair in pairs for word in pixel_words(*pair)], rng=np.random.default_rng(1),
                       stall_i=0.2, stall_o=0.2)
    assert [word.disparity for word in given] == np.concatenate([labels.ravel() for labels in expected]).tolist()
    assert (expected[0] == toy_match(*pairs[0], config)["disparity"]).all()


def test_third_method_in_the_harness(row, tmp_path):
    """Its Verilog, its settings and its result's fields, as the benches and commands take them."""
    config = MatcherConfig(6, 40, method=Toy())
    left, right, _ = scene(40, 4, 6, seed=5)
    result = simulate(config, [left, left], [right, right], simulator="icarus", work_dir=tmp_path, settings={"u1": 63, "in_use": 4})
    weighted = config.with_settings({"u1": 63, "in_use": 4})
    assert [mismatches(result, number, left, right, weighted) for number in (0, 1)] == [0, 0]
    assert mismatches(result, 0, left, right, config) > 0
    matcher = Matcher(config)
    Fragment.get(matcher, None)
    told = build.manifest_of("matcher", matcher, {}, 4, {})
    assert told["parameters"]["method"] == "toy" and told["parameters"]["method_parameters"] == {"weights": (20, 10, 5)}


@pytest.fixture
def chosen(row, monkeypatch):
    monkeypatch.setitem(METHODS, "toy", Toy)


def test_third_method_on_the_command_line(chosen, tmp_path, capsys):
    """Software, simulated Verilog and build take it by its name, with the options of its parameters."""
    left, right, _ = scene(40, 4, 6, seed=5)
    for name, picture in (("left", left), ("right", right)):
        np.save(tmp_path / f"{name}.npy", np.asarray(picture, dtype=np.uint8))
    pair = [str(tmp_path / "left.npy"), str(tmp_path / "right.npy"), "--disparities", "6", "--method", "toy", "--u2", "3"]
    expected = toy_match(left, right, MatcherConfig(6, 40, method=changed(Toy(), u2=3)))["disparity"]
    assert (expected != toy_match(left, right, MatcherConfig(6, 40, method=Toy()))["disparity"]).any()
    assert golden_main(["match", *pair, "--output", str(tmp_path / "d.npy")]) == 0
    assert (np.load(tmp_path / "d.npy") == expected).all()
    assert run.main([*pair, "--simulator", "icarus", "--output", str(tmp_path / "run")]) == 0
    assert (np.load(tmp_path / "run" / "disparity.npy") == expected).all()
    report = json.loads((tmp_path / "run" / "report.json").read_text())
    assert (report["method"], report["method_parameters"], report["mismatches"]) == ("toy", {"weights": [20, 3, 5]}, 0)
    assert "6 disparities, method toy, linear arithmetic, streaming engine" in capsys.readouterr().out
    core = ["--core", "--width", "8", "--disparities", "2", "--method", "toy"]
    assert build.main([*core, "--output", str(tmp_path / "core")]) == 0
    assert json.loads((tmp_path / "core" / "manifest.json").read_text())["parameters"]["method"] == "toy"
    refused = {"--engine sequential": "--engine sequential has no method toy; choose --engine streaming or --method thesis",
               "--minimum 3": "--minimum 3 belongs to the method fused or recursive",
               "--arithmetic float": "--arithmetic float has no gateware; choose linear"}
    for options, told in refused.items():
        assert build.main([*core, *options.split(), "--output", str(tmp_path / "none")]) == 2
        assert told in capsys.readouterr().err


def test_every_method_has_its_parts():
    """In the order of the stream, each of its contract; each setting of a method drives a member."""
    assert {kind for kind in METHODS.values() if kind().engines} <= set(methods.METHODS)
    for kind, parts in methods.METHODS.items():
        assert issubclass(parts.label_output, LabelOutput)
        assert (parts.costs is None) != (parts.engine is None)
        assert parts.costs is None or issubclass(parts.costs, CostArray)
        assert all(issubclass(stage, Stage) for stage in (*parts.pixels, *parts.columns, *parts.labels))
        method = changed(kind(), arithmetic="linear") if "arithmetic" in parameters_of(kind()) else kind()
        config = MatcherConfig(4, 16, engine=Engine.STREAMING, method=method)
        matcher = Matcher(config)
        Fragment.get(matcher, None)  # Amaranth complains of a component that is not used
        composed = matcher.parts
        driven = {name for stage in composed.stages for name in stage.settings.values()}
        driven |= {name for name in config.settings if name in composed.engine.signature.members}
        assert driven == set(config.settings)


def test_branches_on_methods_stand_in_their_files():
    """Which method it is decides in the files that list methods, by class or name, and in their golden functions only."""
    branch = re.compile(r"isinstance\([^()]*method, ?[A-Z]\w+\)|\bCost\.|\.fused\b(?! import)|(method\.name|options\.method) [!=]= ")
    found = {}
    for package in ("golden", "hdl", "boards", "sim"):
        for path in (ROOT / package).rglob("*.py"):
            name = path.relative_to(ROOT).as_posix()
            code = [line for line in path.read_text(encoding="utf-8").splitlines() if "matcher.fused" not in line]
            if hits := [line for line in code if branch.search(line)]:
                found[name] = hits
    assert found == {}
