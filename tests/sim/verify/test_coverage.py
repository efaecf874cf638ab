"""Coverage of emitted Verilog: a design that a bench drives in part has exactly the holes that it has, and the list is checked."""

import argparse
import json
import os
import re

import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hdl.emit import write_verilog
from sim.kit import simulators
from sim.kit.simulators import build, run
from sim.verify.campaign import RECORDS
from sim.verify.coverage import designs, measure
from sim.verify.coverage.designs import Driven, collecting
from sim.verify.coverage.points import Point, covered, measured, modules, text_of
from sim.verify.coverage_explained import Explained
from sim.verify.coverage_holes import Hole, judge
from sim.verify.parts import coverage


RECORD = "C '\1f\2{file}\1l\2{line}\1n\2{column}\1t\2{kind}\1page\2v_{kind}/{module}\1o\2{what}\1h\2top' {count}\n"


PORTS = {"go": In(1), "twice": In(1), "out": Out(4)}


class Gate(wiring.Component):
    """A machine of two states."""
    def __init__(self):
        super().__init__(PORTS)

    def elaborate(self, platform):
        m = Module()
        with m.FSM():
            with m.State("IDLE"):
                with m.If(self.go):
                    m.d.sync += self.out.eq(5)
                    m.next = "BUSY"
            with m.State("BUSY"):
                with m.If(self.twice):
                    m.d.sync += self.out.eq(0)
                    m.next = "IDLE"
        return m


class Around(wiring.Component):
    """So that the machine is a module of its own."""
    def __init__(self):
        super().__init__(PORTS)

    def elaborate(self, platform):
        m = Module()
        m.submodules.gate = gate = Gate()
        m.d.comb += [gate.go.eq(self.go), gate.twice.eq(self.twice), self.out.eq(gate.out)]
        return m


def record(path, *points):
    """A file as Verilator leaves it, of points (source, kind, module, line, column, what, count)."""
    names = ("file", "kind", "module", "line", "column", "what", "count")
    path.write_bytes(b"# SystemC::Coverage-3\n" + b"".join(RECORD.format(**dict(zip(names, point))).encode() for point in points))
    return path


def test_points(tmp_path):
    """Runs are added; harness and data are left out; a line is covered if all of its statements are."""
    first = record(tmp_path / "a.dat", ("0_x.v", "line", "top", 7, 3, "block", 0), ("0_x.v", "line", "top", 7, 9, "elsif", 0),
                   ("0_x.v", "branch", "top", 9, 5, "if", 0), ("0_x.v", "branch", "top", 9, 6, "else", 0),
                   ("0_x.v", "toggle", "top", 1, 1, "word[2]:0->1", 0), ("0_x.v", "toggle", "top", 1, 1, "go:0->1", 0),
                   ("1_harness.v", "line", "harness", 7, 3, "block", 1))
    second = record(tmp_path / "b.dat", ("0_x.v", "line", "top", 7, 3, "block", 4), ("0_x.v", "branch", "top", 9, 6, "else", 1))
    counts = covered([first, second])
    assert len(counts) == 5 and sum(counts.values()) == 5
    assert [hit for _, hit in measured(counts, "top", "line")] == [False]
    assert [hit for _, hit in measured(counts, "top", "branch")] == [False, True]
    with pytest.raises(ValueError, match="points of the kind user"):
        covered([record(tmp_path / "c.dat", ("0_x.v", "user", "top", 7, 3, "block", 0))])


def test_texts():
    """A choice is told by what it gives, its default by the value; numbers that Yosys gives are left out."""
    source = ["      4'b1???:", "        _7_ = b[1:1];", "      default:", "        _7_ = a;", "  endfunction",
              "  assign _9_ = _7_(2'hx, { _1_, _2_ }, { _3_, _4_ });"]
    assert text_of(Point("top", "line", 1, 0, ""), source) == "4'b1???: _ = b[1:1];"
    assert text_of(Point("top", "line", 3, 0, ""), source) == "default: 2'hx"


def test_equal_modules():
    """Modules of two designs are the same if numbers and names of modules make the difference."""
    source = ["module {0}(a);", "  wire _{1}_;", "  wire valid_{1};", "  {0}_fifo fifo (", "endmodule", "module {0}_fifo(b);", "endmodule"]
    first, second = (modules([line.format(*names) for line in source]) for names in (("core", 7), ("system_core", 12)))
    assert list(first.values()) == list(second.values()) and second.keys() == {"system_core", "system_core_fifo"}
    other = [line.format("core", 7) for line in [*source[:2], "  reg x;", *source[2:]]]
    assert modules(other)["core"] != first["core"] and modules(other)["core_fifo"] == first["core_fifo"]


def drive(folder, tests):
    component = Around()
    verilog = write_verilog(component, folder / "around.v", name="around")
    build("verilator", [verilog], "around", folder, brief=True)
    assert run("verilator", "around", folder, "tests.sim.verify.coverage_tb", env={"COCOTB_TEST_FILTER": tests}) == 1
    return Driven(component, verilog, "around")


@pytest.fixture
def toys(monkeypatch):
    """Two designs: the second one's bench reaches more."""
    found = {"short": (drive, (r"\bonce$",)), "long": (drive, (r"\bagain$",))}
    for module in (designs, measure, coverage):
        monkeypatch.setattr(module, "DESIGNS", found)
    return found


GATE = f"{__name__}.Gate"


def command(folder, *options):
    parser = argparse.ArgumentParser()
    coverage.PART.add_options(parser)
    return coverage.PART.run(parser.parse_args(["--workers", "1", "--work", str(folder), *options]))


def explained(monkeypatch, *entries):
    monkeypatch.setattr(coverage, "EXPLAINED", entries)
    monkeypatch.setattr(coverage, "judge", lambda holes: judge(holes, entries))


def test_holes_of_a_run(toys, tmp_path, capsys, monkeypatch):
    """What the short bench does not reach is listed, with its class and its line; the long bench closes it, or an explanation."""
    explained(monkeypatch)
    assert command(tmp_path, "--design", "short") == 1
    told = capsys.readouterr().out
    for text in ("twice:0->1", "fsm_state:1->0"):
        assert f"not covered: short: {GATE}: toggle {text!r} (around_gate, line " in told
    assert re.search(rf"not covered: short: {GATE}: (branch|line) ", told)
    assert command(tmp_path) == 0
    assert "not covered" not in capsys.readouterr().out

    # Explanations in place of the long bench, one of which explains nothing.
    del toys["long"]
    explained(monkeypatch, Explained(".*", ".*Gate|.*Around", ".*", "no bench"), Explained("line", "nothing", ".*", "none"))
    assert command(tmp_path) == 1
    told = capsys.readouterr().out
    assert "not covered" not in told and "explains nothing: Explained(kind='line', origin='nothing'" in told


def test_environment(tmp_path, monkeypatch):
    """Coverage is collected for the block alone."""
    monkeypatch.delenv(simulators.COVERAGE, raising=False)
    with collecting(simulators.COVERAGE, tmp_path):
        assert os.environ[simulators.COVERAGE] == str(tmp_path)
    assert simulators.COVERAGE not in os.environ


def test_section():
    """The page tells designs, rooms, explanations and open holes."""
    pair = {"line": [99, 100], "branch": [3, 4], "toggle": [0, 0]}
    figures = {"designs": {"toy": {"runs": 2, "seconds": 61, **pair}}, "all_designs": 3, "rooms": {"hdl.matcher": pair}, "total": pair,
               "explained": [{"reason": "constant", "line": 1, "branch": 0, "toggle": 0}],
               "open": [["toy", "hdl.matcher.lines.LineStore", "branch", "if: if (x)", "toy_lines", 7]]}
    text = "\n".join(coverage.PART.section(figures))
    assert text.startswith("1 of 3 designs") and "by 2 runs" in text
    assert "| toy | 99.0 % of 100 | 75.0 % of 4 |  |" in text and "| hdl.matcher | 99.0 %" in text
    assert "| 1 |  |  | constant |" in text
    assert "`hdl.matcher.lines.LineStore`: branch `if: if (x)` (toy: toy_lines, line 7)" in text


def test_designs_are_those_of_the_record():
    """The record is of designs that there are, and each of its open holes is unexplained."""
    record = json.loads((RECORDS / "coverage.json").read_text())
    assert set(record["designs"]) <= set(designs.DESIGNS) and record["all_designs"] == len(designs.DESIGNS)
    judged = judge([Hole(*hole) for hole in record["open"]])
    assert len(judged.open) == len(record["open"])
