"""The board in the loop, simulated: ``sim.run --hardware`` and the console against the emitted Verilog, through a pseudo-terminal, bit by
bit on the serial line; over lines with faults too.
"""

import json
import re

import pytest

from golden.config import RECURSIVE_1, MatcherConfig, OnePass, changed
from golden.pictures.images import read_picture, write_picture
from golden.pictures.scenes import scene
from hdl.host import console
from hdl.netlist import read_netlist
from sim import loop, run
from sim.kit.gate_level import gate_level
from sim.kit.loop_port import TOP, simulated_port, small_board


# Slow: a build takes most of a minute, a pair ten seconds. tests/sim/test_hardware.py has the same commands and faults with a model of the
# board, and tests/hdl/loop compares the gateware with this model, byte by byte.
pytestmark = pytest.mark.slow

WIDTH, HEIGHT, LABELS = 32, 16, 8
LINEAR = changed(OnePass(), arithmetic="linear")
SCENE = scene(WIDTH, HEIGHT, LABELS, seed=5)


def board(method):
    return small_board(MatcherConfig(LABELS, WIDTH, method=method), HEIGHT)


@pytest.fixture(scope="module")
def thesis(tmp_path_factory):
    """A folder with the Verilog of a board."""
    folder = tmp_path_factory.mktemp("board")
    return board(LINEAR), folder


@pytest.fixture(autouse=True)
def pair(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    for name, picture in zip(("left", "right"), SCENE):
        write_picture(tmp_path / f"{name}.png", picture)


def matched(port, *options, pair=("left.png", "right.png")):
    """The report of the command, which ends with status 0."""
    # A low rate lets the host send little ahead: a simulated line is slow.
    assert run.main([*pair, "--hardware", port, "--timeout", "3", "--baud", "9600", *options]) == 0
    with open("build/run/report.json") as file:
        return json.load(file)


def test_pair_and_console(thesis, tmp_path, capsys):
    """A pair of the thesis's method, and what the console shows of it."""
    system, folder = thesis
    with simulated_port(system, folder) as port:
        report = matched(port, "--disparities", str(LABELS))
        assert (report["mismatches"], report["repeated"]) == (0, 0)
        assert WIDTH * HEIGHT < report["clocks"] <= system.core.pair_clocks(WIDTH, HEIGHT)
        capsys.readouterr()
        assert console.main(["--port", port, "--timeout", "2", "get", "identity", "pairs", "uart_errors", "kept"]) == 0
        assert capsys.readouterr().out == "identity = stereo loop\npairs = 1 pairs\nuart_errors = 0 events\nkept = yes\n"
        assert console.main(["--port", port, "--timeout", "2", "grab", "left", "grabbed.png"]) == 0
        assert (read_picture(tmp_path / "grabbed.png") == SCENE[0]).all()


@pytest.mark.parametrize("direction", ["to_board", "to_host"])
@pytest.mark.parametrize("fault", ["lost", "doubled", "changed"])
def test_faults(thesis, direction, fault):
    """A byte in 211, after the registers that tell which board it is."""
    system, folder = thesis
    with simulated_port(system, folder, faults={direction: {"kind": fault, "every": 211, "after": 100}}) as port:
        report = matched(port)
    assert report["mismatches"] == 0 and report["repeated"] > 0


def test_unplugged_and_silent(thesis, capsys):
    system, folder = thesis
    with simulated_port(system, folder, faults={"unplugged": 700}) as port:
        assert run.main(["left.png", "right.png", "--hardware", port]) == 2
        assert re.fullmatch(rf"sim\.run: the serial port {port} is lost: .*; plug it in again\n", capsys.readouterr().err)
    with simulated_port(system, folder, faults={"dead": True}) as port:
        assert run.main(["left.png", "right.png", "--hardware", port]) == 2
        assert "no answer in 4 attempts of 0.2 s" in capsys.readouterr().err


def test_sdram(tmp_path):
    """Pictures in an SDRAM, whose strict model is at the board's ports."""
    system = small_board(MatcherConfig(LABELS, WIDTH, method=LINEAR), HEIGHT, sdram=True)
    with simulated_port(system, tmp_path / "board") as port:
        report = matched(port)
    assert (report["mismatches"], report["repeated"]) == (0, 0)
    assert 2 * WIDTH * HEIGHT < report["clocks"] <= system.core.pair_clocks(WIDTH, HEIGHT)


def test_method_recursive(tmp_path):
    with simulated_port(board(RECURSIVE_1), tmp_path / "board") as port:
        report = matched(port, "--method", "recursive")
    assert (report["mismatches"], report["repeated"], report["method"]) == (0, 0, "recursive")


def test_command(capsys):
    """A board at a port for whoever has none, of another size than the pair."""
    def wait(port):
        assert f"is at {port}:\npython -m sim.run LEFT RIGHT --hardware {port} --baud 9600 --timeout 5\n" in capsys.readouterr().out
        assert matched(port)["mismatches"] == 0
        raise KeyboardInterrupt
    assert loop.main(["--width", str(WIDTH), "--height", str(HEIGHT), "--disparities", str(LABELS)], wait) == 0


def test_gate_level(tmp_path):
    """The netlist that nextpnr takes: tables, carry chains, registers, multipliers, and stores in both kinds of memory."""
    pytest.importorskip("pyosys", reason="pyosys, of the extra resources, is not installed")
    system = small_board(MatcherConfig(4, WIDTH, method=LINEAR), HEIGHT)
    gates = gate_level(system, TOP, tmp_path / "gates")
    kinds = {cell.kind for cell in read_netlist(tmp_path / "gates" / "design.json")[TOP].cells.values()}
    assert kinds >= {"LUT4", "CCU2C", "TRELLIS_FF", "MULT18X18D", "DP16KD"}
    for name, picture in zip(("small_left", "small_right"), SCENE):
        write_picture(tmp_path / f"{name}.png", picture[5:11, 8:24])
    with simulated_port(system, tmp_path / "board", verilog=gates) as port:
        report = matched(port, pair=("small_left.png", "small_right.png"))
    assert (report["mismatches"], report["repeated"], report["width"], report["height"]) == (0, 0, 16, 6)
