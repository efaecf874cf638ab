"""The campaign of netlists: a fault becomes a result, and the page tells it."""

import argparse
from collections import Counter

import pytest

from sim.kit.simulators import SimulationError
from sim.verify.parts import netlist


class Bench:
    """Stands in for a netlist."""
    def __init__(self, case, family, folder):
        self.cells = Counter({"LUT4": 1200, "$scopeinfo": 3})
        self.family = family


@pytest.mark.parametrize("error, told", [
    (None, ""), (AssertionError(), "pixels differ from golden"), (SimulationError("hang 1"), "hang 1")])
def test_fault_is_told(error, told, tmp_path, monkeypatch, capsys):
    def check(bench, simulator):
        if error and bench.family == "ECP5":
            raise error
        return 1234

    monkeypatch.setattr(netlist, "GateBench", Bench)
    monkeypatch.setattr(netlist, "check_pictures", check)
    records = {}
    monkeypatch.setattr(netlist, "write_record", lambda name, command, figures: records.update({command: figures}))
    parser = argparse.ArgumentParser()
    netlist.PART.add_options(parser)
    options = parser.parse_args(["--workers", "1", "--work", str(tmp_path), "--matcher", "linear", "--record"])
    assert netlist.PART.run(options) == bool(error)
    out = " ".join(capsys.readouterr().out.split())
    assert out.count("1,203") == 2 and (not told or told.split()[0] in out)
    (command, figures), = records.items()
    assert command == "python -m sim.verify netlist --matcher linear"
    assert {name: result["fault"] for name, result in figures["netlists"].items()} == {"linear, ECP5": told, "linear, Cyclone III": ""}
    text = "\n".join(netlist.PART.section(figures))
    clocks = "0" if error else "1,234"
    assert text.startswith("2 of 8 netlists") and f"| linear, ECP5 | 1,200 LUT4 | {clocks} | {told or 'equals golden'} |" in text
