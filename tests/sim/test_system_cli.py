"""The command line of the whole system: what it leaves behind, and what it says of a run that fails. No simulator runs here."""

import json

import numpy as np
import pytest

from golden.files import output_folder
from sim import system
from sim.kit.simulators import SimulationError


@pytest.fixture
def simulated(monkeypatch):
    """Simulations that take no time; each asserts that nothing of an earlier one can be taken for its result."""
    def small(folder, test, REPORT, **_):
        told = folder / "told.json"
        assert str(told) == REPORT and not told.exists()
        told.write_text(json.dumps([{"fault": "a fault", "counter": "a_counter", "count": 3, "frames": 2}]))

    def full(size, pair, folder, *, pairs):
        assert pairs == 1
        (folder / "full.v").touch()
        return {name: 1.0 for name in ("finished", "started", "clocks", "words_read", "words_written", "seconds")} | {
            "finished": 2.0}, np.zeros((576, 720, 3), np.uint8)

    monkeypatch.setattr(system, "require", lambda simulator: None)
    monkeypatch.setattr(system, "_pair", lambda names, white, format: [np.zeros((576, 720), np.uint8)] * 2)
    monkeypatch.setattr(system, "match", lambda left, right, config: np.zeros(left.shape, np.uint8))
    monkeypatch.setattr(system, "run_small", small)
    monkeypatch.setattr(system, "run_full", full)


def names(folder):
    return {path.name for path in folder.iterdir()}


def test_result_of_the_other_kind_is_gone(simulated, tmp_path, capsys):
    (tmp_path / "mine.png").touch()
    arguments = ["--output", str(tmp_path)]
    system.main(arguments)
    assert names(tmp_path) == {"mine.png", "full.v", "monitor.png"}
    for _ in range(2):
        assert system.main([*arguments, "--faults"]) == 0
        assert names(tmp_path) == {"mine.png", "full.v", "told.json"}
    assert "a fault" in capsys.readouterr().out
    system.main(arguments)
    assert names(tmp_path) == {"mine.png", "full.v", "monitor.png"}


@pytest.mark.parametrize("what", ["small", "full"])
def test_failed_simulation(simulated, tmp_path, monkeypatch, capsys, what):
    def run(*_, **__):
        raise SimulationError("the monitor has seen 0 frames, not 1")
    monkeypatch.setattr(system, f"run_{what}", run)
    assert system.main(["--output", str(tmp_path), *(["--faults"] if what == "small" else [])]) == 1
    assert capsys.readouterr() == ("", "sim.system: the monitor has seen 0 frames, not 1\n")


def test_one_run_at_a_time(simulated, tmp_path, capsys):
    with output_folder(tmp_path):
        assert system.main(["--faults", "--output", str(tmp_path)]) == 2
    assert "is in use by another run" in capsys.readouterr().err and names(tmp_path) == set()
