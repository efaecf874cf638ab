"""Whether a design fits its device: what hdl.build prints, warns of and refuses."""

import json
from dataclasses import replace
from types import SimpleNamespace

import pytest

from boards.cyclone3.board import BOARD
from boards.registry import Project
from golden.config import FUSED_1, RECURSIVE_1, MatcherConfig, OnePass, changed
from golden.errors import UserError
from golden.rig.config import RigConfig
from golden.video.bandwidth import Budget
from hdl.build import main
from hdl.fit import cyclone3_fit, remedies
from hdl.netlist import Netlist
from hdl.resources.count import Resources
from hdl.resources.devices import CONTROLLER, DEFAULT_DEVICE, DEVICES, Device
from hdl.resources.estimate import LOGIC_ERROR


DEVICE = Device("T1", Resources(logic_elements=1000, m9k=100, multipliers_9x9=10))
ALLOWED = Resources(logic_elements=100, m9k=10)
REMEDIES = {"logic": "fewer lights", "memory": "fewer books", "multipliers": "fewer games"}


def fit(**figures):
    return cyclone3_fit(Resources(**figures), ALLOWED, "a toy", DEVICE)


@pytest.mark.parametrize("figures", [
    {}, {"m9k": 90}, {"multipliers_9x9": 10}, {"logic_elements": int(900 * (1 + LOGIC_ERROR / 100))}, {"memory_bits": 10**9},
])
def test_fits(figures):
    """Memory blocks and multipliers up to the last one; logic that may fit, within the error of the estimate."""
    fit(**figures).check(REMEDIES)


@pytest.mark.parametrize("figures, told", [
    ({"m9k": 91}, "the design needs 101 M9K, 10 of them allowed for a toy, and an T1 has 100; choose fewer books"),
    ({"multipliers_9x9": 11}, "the design needs 11 9x9 multipliers, and an T1 has 10; choose fewer games"),
    ({"logic_elements": 1050},
     "the design needs at least 1,100 logic elements, 100 of them allowed for a toy, and an T1 has 1,000; choose fewer lights"),
])
def test_does_not_fit(figures, told):
    with pytest.raises(UserError) as error:
        fit(**figures).check(REMEDIES)
    assert str(error.value) == told


def test_unknown_capacity():
    everything = cyclone3_fit(Resources(10**6, 10**6, 10**6, 10**6), ALLOWED, "a toy", Device("T2", Resources()))
    everything.check(REMEDIES)
    assert everything.warning() is None


@pytest.mark.parametrize("figures, told", [
    ({"m9k": 75}, None),
    ({"m9k": 76}, "the design takes 86.0 % of the M9K of an T1; above 85 % it may miss its clock, or not be placed"),
    ({"logic_elements": 800, "multipliers_9x9": 9},
     "the design takes 90.0 % of the logic elements and 90.0 % of the 9x9 multipliers of an T1; above 85 % it may miss its clock, or not "
     "be placed"),
])
def test_warning(figures, told):
    assert fit(**figures).warning() == told


@pytest.mark.parametrize("method, rig, figure, told", [
    (OnePass(), None, "memory", "fewer --disparities than 16"),
    (FUSED_1, None, "memory", "fewer --disparities than 16 or other --parameters or another --method"),
    (OnePass(), RigConfig(34), "logic", "fewer --disparities than 16, fewer --rectify-lines than 34 or --no-rectify"),
    (OnePass(), None, "multipliers", "fewer --disparities than 16"),
    (RECURSIVE_1, None, "multipliers", "--soft-multipliers"),
    (changed(RECURSIVE_1, soft_multipliers=True), None, "multipliers", "fewer --disparities than 16"),
])
def test_remedies(method, rig, figure, told):
    """Only what the design leaves to choose."""
    assert remedies(MatcherConfig(16, method=method), rig)[figure] == told


def test_remedies_of_stored_pictures():
    """They are in memory blocks."""
    told = remedies(MatcherConfig(16), None, (320, 240))
    assert told["memory"] == "a smaller picture than --width 320 --height 240 or fewer --disparities than 16"
    assert told["logic"] == "fewer --disparities than 16"


@pytest.fixture
def board(monkeypatch):
    """Lets hdl.build make a board whose project is empty and takes these figures."""
    def make(**figures):
        project = Project("stereo", {"stereo.v": ""}, {"stereo": Netlist({}, {}, {})})

        def system(design):
            matcher = SimpleNamespace(config=design.config, clocks_per_pixel=1, full_rate_width=1, latency_lines=1, latency_clocks=1,
                                      frame_clocks=lambda width, height: width * height)
            return SimpleNamespace(matcher=matcher, budget=Budget())
        made = replace(BOARD, system=system, project=lambda core, design: project, check=lambda project: [],
                       fit=lambda _: cyclone3_fit(Resources(**figures), CONTROLLER, "Altera's DDR2 controller", DEVICES[DEFAULT_DEVICE]))
        monkeypatch.setattr("hdl.build.find_board", lambda name: made)
    return make


def test_refused(board, tmp_path, capsys):
    board(m9k=413)
    assert main(["--board", "cyclone3", "--method", "fused", "--output", str(tmp_path / "out")]) == 2
    out, err = capsys.readouterr()
    assert (out, err) == ("", (
        "hdl.build: the design needs 433 M9K, 20 of them allowed for Altera's DDR2 controller, and an EP3C120F780C7 has 432; choose fewer "
        "--disparities than 80, other --parameters or another --method, fewer --rectify-lines than 34 or --no-rectify\n"))
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("blocks, warned", [
    (300, ""),
    (391, "hdl.build: the design takes 95.1 % of the M9K of an EP3C120F780C7; above 85 % it may miss its clock, or not be placed\n"),
])
def test_written(blocks, warned, board, tmp_path, capsys):
    board(m9k=blocks, logic_elements=77_000, multipliers_9x9=8)
    assert main(["--board", "cyclone3", "--output", str(tmp_path)]) == 0
    out, err = capsys.readouterr()
    assert err == warned
    rows = [line.strip("│").split("│") for line in out.splitlines() if line.startswith("│ ")][-3:]
    assert [[cell.strip() for cell in row] for row in rows] == [
        ["logic elements", "77,000", "10,000", "87,000", "119,088", "73.1 %"],
        ["M9K", str(blocks), "20", str(blocks + 20), "432", f"{100 * (blocks + 20) / 432:.1f} %"],
        ["9x9 multipliers", "8", "0", "8", "576", "1.4 %"]]
    told = json.loads((tmp_path / "manifest.json").read_text())["resources"]
    assert told["estimated"] == {"logic_elements": 77_000, "memory_bits": 0, "m9k": blocks, "multipliers_9x9": 8}
    assert (told["allowance"]["m9k"], told["device"]["m9k"]) == (20, 432)
