"""The DE2-115's top level as emitted Verilog, with stand-ins for Altera's blocks and for the system; see ``de2_115_tb.py``."""

import pytest

from sim.kit.display_cases import SMALL_DISPLAY
from sim.kit.simulators import SIMULATORS, STUBS, build, lint, run
from sim.models.loop_double import double_project


TESTS = 3


@pytest.fixture
def verilog(tmp_path):
    path = tmp_path / "stereo.v"
    path.write_text(double_project("de2_115", SMALL_DISPLAY).files["stereo.v"])
    return path


def test_pins(verilog, tmp_path):
    """With a small monitor; on Icarus, whose model of so little is there at once."""
    build("icarus", [verilog, *STUBS], "stereo", tmp_path)
    assert run("icarus", "stereo", tmp_path, "sim.benches.de2_115_tb") == TESTS


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_lint(simulator, verilog):
    lint(simulator, [verilog, *STUBS], "stereo")
