"""The steps around placing and routing of the stand-in: names, the worst path, the floor plan."""

import json
from dataclasses import fields
from itertools import pairwise

import pytest

from golden.errors import UserError
from hdl.emit import verilog_text
from hdl.netlist import Cell, Netlist, read_netlist
from hdl.parts.delay import Delay
from hdl.resources import lattice
from hdl.resources.clock import _worst_path, our_name, place_and_route
from hdl.resources.ecp5 import ECP5
from hdl.resources.floorplan import _selection, place_labels
from hdl.resources.lattice import Lattice
from hdl.resources.report import seeds_text


@pytest.mark.parametrize("name, ours", [
    ("matcher.engine.busy_TRELLIS_FF_Q_DI_LUT4_Z_1", "matcher.engine.busy"),
    ("matcher.engine.edata_memory.column[2]", "matcher.engine.edata_memory.column"),
    ("matcher.engine.memory.0.12", "matcher.engine.memory"),
    ("$abc$12$auto$34", ""),
    ("matcher.engine.busy_FD1P3IX_Q_12_D_CCU2_S0$ccu2_comb[0]$", "matcher.engine.busy"),
    ("matcher.engine.product_MULT18X18_Z/PREADD9_CORE_x0_z0", "matcher.engine.product"),
    ("matcher.engine.product/PREADD9_CORE_x0_z0", "matcher.engine.product"),
    ("matcher.engine.best_WIDEFN9_Z$widefn_comb[1]$", "matcher.engine.best"),
])
def test_our_name(name, ours):
    assert our_name(name) == ours


def test_worst_path():
    def step(kind, delay, begin, end, net=""):
        return {"type": kind, "delay": delay, "from": {"cell": begin}, "to": {"cell": end}, "net": net}
    report = {"critical_paths": [
        {"from": "<async>", "to": "posedge clk", "path": [step("logic", 99, "pin", "pin")]},
        {"from": "posedge clk", "to": "posedge clk", "path": [
            step("clk-to-q", 0.5, "a_TRELLIS_FF_Q_1", "a_TRELLIS_FF_Q_1"), step("routing", 2, "a_TRELLIS_FF_Q_1", "$x", "a[3]"),
            step("logic", 0.25, "$x", "$x"), step("routing", 1, "$x", "b_TRELLIS_FF_Q", "b_TRELLIS_FF_Q_DI"),
        ]}]}
    assert _worst_path(report, "clk") == (("a", "b"), 0.75, 3)


@pytest.mark.parametrize("found, soft", [
    ([(156, 208)], False), ([(157, 1), (64, 1)], True), ([(400, 1), (200, 1), (0, 300), (0, 208)], True)])
def test_device_with_too_few_multipliers(found, soft, tmp_path, monkeypatch):
    """First narrow products become tables, then all; memories of tables only where blocks do not suffice."""
    scripts = []

    def netlist(path):
        multipliers, memories = found[len(scripts) - 1]
        cells = {f"{kind}_{n}": Cell(kind, {}) for kind, count in (("MULT18X18D", multipliers), ("DP16KD", memories)) for n in range(count)}
        return {"top": Netlist({}, cells, {})}

    monkeypatch.setattr(lattice, "run_yosys", lambda tool, script, folder, report: scripts.append(script))
    monkeypatch.setattr(lattice, "read_netlist", netlist)
    types, of_tables = ECP5.synthesise(tmp_path, "top", print)
    assert (types["MULT18X18D"], types["DP16KD"], of_tables, len(scripts)) == (*found[-1], soft, len(found))
    assert ["mul2dsp" in script for script in scripts] == [False, True, False, False][:len(found)]
    assert ["-nodsp" in script for script in scripts] == [False, True, True, True][:len(found)]
    assert ["-nolutram" in script for script in scripts] == [True, True, True, False][:len(found)]


def register(q):
    return {"type": "TRELLIS_FF", "port_directions": {"D": "input", "Q": "output"}, "connections": {"D": [1], "Q": [q]}}


@pytest.fixture
def design(tmp_path):
    """Answers of three labels, two bits each, through two registers; the last ones of label 1 are merged."""
    names = {"engine.array.transition_0": [10, 11, 12, 13, 14, 15], "engine.array.transition_": [20, 21, 22, 22, 23, 24],
             "engine.array.transition_9": [10, 11, 12], "engine.other_transition_9": [40, 41], "engine.transition": [20, 21]}
    cells = {f"ff_{q}": register(q) for q in (*range(10, 16), *range(20, 25), 40, 41)}
    blocks = ["engine.array.wait_0.memory.0.0", "engine.array.wait_1.memory.0.0"]
    cells |= {name: {"type": "DP16KD", "connections": {}} for name in blocks}
    cells = {name: {**cell, "parameters": {}, "attributes": {}} for name, cell in cells.items()}
    path = tmp_path / "design.json"
    path.write_text(json.dumps({"modules": {"matcher": {
        "ports": {}, "cells": cells, "netnames": {name: {"bits": bits} for name, bits in names.items()}}}}))
    return path


def test_selection(design):
    assert _selection(read_netlist(design)["matcher"]) == {
        "ff_20": (0, 0), "ff_21": (0, 1), "ff_22": (1, 1), "ff_23": (2, 0), "ff_24": (2, 1)}
    assert _selection(Netlist({}, {}, {"clk": [2]})) == {}


def test_plan(design):
    place_labels(design, "matcher")
    cells = read_netlist(design)["matcher"].cells
    placed = {name: cell.attributes["BEL"] for name, cell in cells.items() if cell.attributes}
    assert set(placed) == {"ff_20", "ff_21", "ff_22", "ff_23", "ff_24", *(name for name in cells if "wait" in name)}
    assert all(("EBR" in place) == ("wait" in name) for name, place in placed.items())
    assert len(set(placed.values())) == 7


def test_marked_memory_needs_no_logic(tmp_path):
    """Synthesis reads in the Verilog that a word is never read as it is written: one block, registers of output and addresses."""
    text = verilog_text(Delay(18, 500), name="top")
    found = {}
    for name, source in (("marked", text), ("unmarked", text.replace("(* no_rw_check *)", ""))):
        folder = tmp_path / name
        folder.mkdir()
        (folder / "design.v").write_text(source)
        found[name], _ = ECP5.synthesise(folder, "top", lambda step: None)
    assert found["marked"]["DP16KD"] == found["unmarked"]["DP16KD"] == 1
    assert found["marked"]["TRELLIS_FF"] == 18 + 9 + 9 < found["unmarked"]["TRELLIS_FF"]


class Tools(Lattice):
    """Stand-in whose tools take no time: a rate for each seed, or a reason."""
    def synthesise(self, folder, top, report):
        return {"LUT4": 5}, True

    def run_nextpnr(self, folder, arguments, log, report=print):
        given = dict(pairwise(arguments))
        assert list(self.options) == arguments[:len(self.options)] and given["--json"] == "design.json"
        rate = {"1": 100, "2": 130, "3": 90, "4": 105}[given["--seed"]]
        (folder / "report.json").write_text(json.dumps({"critical_paths": [], "fmax": {"clk": {"achieved": rate}}}))
        (folder / "delays.sdf").write_text("")
        return "no Bels left" if rate == 105 else None


@pytest.fixture
def tools():
    prepared = []
    known = {field.name: getattr(ECP5, field.name) for field in fields(ECP5)}
    return Tools(**known | {"prepare": lambda design, top: prepared.append((design.name, top))}), prepared


def test_seeds(tools):
    """One after another, the fastest first; one netlist for all."""
    stand_in, prepared = tools
    found = place_and_route(Delay(1, 2), stand_in, seeds=3)
    assert [(clock.mhz, clock.seed) for clock in found] == [(130, 2), (100, 1), (90, 3)] and prepared == [("design.json", "matcher")]
    assert {(clock.device, clock.cells["LUT4"], clock.soft_multipliers) for clock in found} == {(ECP5.device, 5, True)}
    assert seeds_text(found) == (
        "Of 3 placements the fastest, of seed 2, reaches 130.0 MHz, the slowest 90.0 MHz, the median is 100.0 MHz.")


def test_what_does_not_fit(tools, monkeypatch):
    stand_in, _ = tools
    with pytest.raises(UserError, match=r"on the stand-in ECP5-85F, speed grade 6 \(no Bels left\); choose fewer disparities"):
        place_and_route(Delay(1, 2), stand_in, seeds=4)
    monkeypatch.setattr(Tools, "synthesise", lambda *_: ({"DP16KD": 209}, False))
    with pytest.raises(UserError, match="takes 209 memory blocks and the stand-in ECP5-85F, speed grade 6, has 208; choose fewer"):
        place_and_route(Delay(1, 2), stand_in)
