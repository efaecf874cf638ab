import json
import math
import os
import subprocess
import sys
from dataclasses import replace
from pathlib import Path

import pytest

from boards.cyclone3.board import BOARD
from boards.registry import Project, board_names, find_board
from golden.errors import UserError
from hdl.netlist import Netlist, Port


ROOT = Path(__file__).parents[2]

# A whole board: a matcher with pins, and a list of them as project.
TOY = '''
from types import SimpleNamespace

from amaranth.back import rtlil

from boards.registry import Board, Project
from golden.video.bandwidth import Budget
from hdl.emit import emit_rtlil
from hdl.matcher.matcher import Matcher


def system(design):
    assert design.clock_hz == 40_000_000
    return SimpleNamespace(matcher=Matcher(design.config), budget=Budget())


def project(core, design):
    verilog, netlist = emit_rtlil(rtlil.convert(core.matcher, name="toy", emit_src=False))
    pins = "".join(f"{name} P{number}\\n" for number, name in enumerate(sorted(netlist["toy"].ports)))
    return Project("toy", {"toy.v": verilog, "toy.pins": pins}, netlist)


def check(project):
    return [] if "clk P" in project.files["toy.pins"] else ["the clock has no pin"]


BOARD = Board(name="toy", device="T1", clock_mhz=40, toolchain="Toys", project=project, check=check, system=system,
              about={"colour": "red"})
'''


def test_names():
    assert board_names() == ["cyclone3", "de2_115", "ecpix5", "ulx3s"]


def test_find():
    assert find_board("cyclone3") is BOARD


@pytest.mark.parametrize("name", ["de2", "", "registry", "ecp5", "cyclone3.board", "../cyclone3"])
def test_no_such_board(name):
    with pytest.raises(UserError, match=rf"^there is no board '{name}'; choose one of: cyclone3, de2_115, ecpix5, ulx3s$"):
        find_board(name)


@pytest.mark.parametrize("wrong", [None, replace(BOARD, name="other")])
def test_module_without_its_board(wrong, monkeypatch):
    monkeypatch.setattr("boards.cyclone3.board.BOARD", wrong)
    with pytest.raises(UserError, match=r"^the module boards.cyclone3.board has .* as BOARD; export a Board named 'cyclone3' there$"):
        find_board("cyclone3")


def test_memory_clocks():
    """The local interface of this board's controller has half of the memory's clock."""
    assert [BOARD.clock_hz(None, clock) for clock in (None, 125, 150)] == [75_000_000, 62_500_000, 75_000_000]
    with pytest.raises(UserError, match=r"^the board cyclone3 does not run its memory at 133 MHz; choose --memory-clock 125 or 150$"):
        BOARD.clock_hz(None, 133)
    with pytest.raises(UserError, match=r"^the board cyclone3 does not run its memory at 150 MHz; leave --memory-clock out$"):
        replace(BOARD, memory_clocks_mhz={}).clock_hz(None, 150)


@pytest.mark.parametrize("clock", [math.nan, math.inf, -math.inf])
def test_clock_that_is_no_number(clock):
    with pytest.raises(UserError, match=rf"^--clock must be a number of MHz, not {clock}; leave it out for 75 MHz$"):
        replace(BOARD, make_clock=round).clock_hz(clock)


def test_ports_of_a_project():
    ports = {"b": Port("inout", [2, 3]), "a": Port("input", [4])}
    project = Project("top", {}, {"top": Netlist(ports, {}, {})})
    assert list(project.ports.items()) == [("a", ("input", 1)), ("b", ("inout", 2))]


@pytest.fixture
def toy(tmp_path):
    """Builds on the toy board, whose folder lies outside of the project; the finished process."""
    folder = tmp_path / "elsewhere" / "boards" / "toy"
    folder.mkdir(parents=True)
    (folder / "__init__.py").touch()
    (folder / "board.py").write_text(TOY)
    for other in ("another", "parts"):
        (folder.parent / other).mkdir()
        (folder.parent / other / "__init__.py").touch()
    (folder.parent / "another" / "board.py").touch()

    def build(*arguments):
        environment = {**os.environ, "PYTHONPATH": str(tmp_path / "elsewhere")}
        return subprocess.run([sys.executable, "-m", "hdl.build", *arguments, "--output", tmp_path / "out"], cwd=ROOT, env=environment,
                              capture_output=True, text=True)
    return build


def test_a_board_is_one_folder(toy, tmp_path):
    """Nothing else is edited: the command finds it, builds it and checks it."""
    run = toy("--board", "toy", "--disparities", "4")
    assert (run.returncode, run.stderr) == (0, "")
    assert sorted(path.name for path in (tmp_path / "out").iterdir()) == ["manifest.json", "toy.pins", "toy.v"]
    told = json.loads((tmp_path / "out" / "manifest.json").read_text())
    about = {"top": "toy", "board": "toy", "device": "T1", "colour": "red", "clock_mhz": 40, "files": ["toy.pins", "toy.v"]}
    assert {name: told[name] for name in about} == about
    assert told["ports"]["clk"] == {"direction": "input", "width": 1}
    assert "The memory controller gives the matcher 40 MHz" in run.stdout
    assert "What to do" not in run.stdout       # this board has no README


@pytest.mark.parametrize("name, told", [
    ("de2", "there is no board 'de2'; choose one of: another, cyclone3, de2_115, ecpix5, toy, ulx3s"),
    ("parts", "there is no board 'parts'; choose one of: another, cyclone3, de2_115, ecpix5, toy, ulx3s"),     # no board's folder
    ("another", "the module boards.another.board has None as BOARD; export a Board named 'another' there"),
])
def test_bad_board(name, told, toy):
    run = toy("--board", name)
    assert (run.returncode, run.stdout, run.stderr) == (2, "", f"hdl.build: {told}\n")
