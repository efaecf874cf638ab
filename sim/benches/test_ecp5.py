"""Top levels of boards with an ECP5 as emitted Verilog, with stand-ins for Lattice's blocks and for the system; see ``ecp5_tb.py``."""

import pytest

from hdl.build import main
from sim.kit.display_cases import SMALL_DISPLAY
from sim.kit.simulators import ECP5_STUBS, SIMULATORS, SimulationError, build, lint, run
from sim.models.loop_double import double_project, memory_project


TESTS = 2


def written(folder, project):
    path = folder / "stereo.v"
    path.write_text(project.files["stereo.v"])
    return path


def verilog(folder, board, display):
    return written(folder, double_project(board, display))


def memory_verilog(folder):
    return written(folder, memory_project("ulx3s", 60_000_000))


def test_pins(tmp_path):
    """With a small monitor; on Icarus, whose model of so little is there at once."""
    build("icarus", [verilog(tmp_path, "ulx3s", SMALL_DISPLAY), *ECP5_STUBS], "stereo", tmp_path)
    assert run("icarus", "stereo", tmp_path, "sim.benches.ecp5_tb") == TESTS


def test_pins_of_the_memory(tmp_path):
    """Words through the registers of the pins to a memory whose clock is inverted, and back."""
    build("icarus", [memory_verilog(tmp_path), *ECP5_STUBS], "stereo", tmp_path)
    assert run("icarus", "stereo", tmp_path, "sim.benches.ecp5_memory_tb") == 1


@pytest.mark.parametrize("board, display, simulator", [
    *(("ulx3s", SMALL_DISPLAY, simulator) for simulator in SIMULATORS), ("ecpix5", None, "verilator")])
def test_lint(board, display, simulator, tmp_path):
    lint(simulator, [verilog(tmp_path, board, display), *ECP5_STUBS], "stereo")


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_lint_with_a_memory(simulator, tmp_path):
    lint(simulator, [memory_verilog(tmp_path), *ECP5_STUBS], "stereo")


def test_lint_complains(tmp_path):
    path = verilog(tmp_path, "ulx3s", SMALL_DISPLAY)
    path.write_text(path.read_text().replace(".CLKFB_DIV(", ".CLKFB_DIVIDER(", 1))
    with pytest.raises(SimulationError, match="icarus rejects stereo"):
        lint("icarus", [path, *ECP5_STUBS], "stereo")


# Slow: the system itself takes ten seconds to write, and is simulated without the board around it.
@pytest.mark.slow
@pytest.mark.parametrize("board, method, width, height", [
    ("ulx3s", "thesis", 16, 8), ("ulx3s", "thesis", 640, 480), ("ecpix5", "recursive", 16, 8)])
def test_lint_of_the_real_system(board, method, width, height, tmp_path):
    assert main(["--board", board, "--width", str(width), "--height", str(height), "--disparities", "4", "--method", method,
                 "--no-bitstream", "--output", str(tmp_path)]) == 0
    for simulator in SIMULATORS:
        lint(simulator, [tmp_path / "stereo.v", *ECP5_STUBS], "stereo")
