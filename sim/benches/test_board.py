"""The board's top level as emitted Verilog, with stand-ins for Altera's blocks and for the video system; see ``board_tb.py``.

The real video system is only read here: ``system_tb.py`` runs it.
"""

import pytest

from hdl.build import main
from sim.kit.simulators import ROOT, SIMULATORS, STUBS, SimulationError, build, lint, run
from sim.models.board_core import board_project


TESTS = 8


@pytest.fixture(scope="module")
def verilog(tmp_path_factory):
    path = tmp_path_factory.mktemp("board") / "stereo.v"
    path.write_text(board_project("1024x768").files["stereo.v"])
    return path


def test_pins(verilog, tmp_path):
    """On Icarus: Verilator knows no pull-up that several drivers share."""
    build("icarus", [verilog, ROOT / "sim" / "benches" / "board.v", *STUBS], "board", tmp_path)
    assert run("icarus", "board", tmp_path, "sim.benches.board_tb") == TESTS


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_lint(simulator, verilog):
    lint(simulator, [verilog, *STUBS], "stereo")


# Slow: other matchers; what is around them is the same.
@pytest.mark.parametrize("labels, options", [
    (4, []), pytest.param(80, [], marks=pytest.mark.slow),
    pytest.param(3, ["--method", "recursive", "--parameters", "recursive-2"], marks=pytest.mark.slow),
], ids=lambda value: str(value) if isinstance(value, int) else value[-1] if value else "thesis")
def test_lint_of_the_real_system(labels, options, tmp_path):
    """A project that passes the checks of the build, and that both simulators accept."""
    assert main(["--board", "cyclone3", "--disparities", str(labels), *options, "--output", str(tmp_path)]) == 0
    for simulator in SIMULATORS:
        lint(simulator, [tmp_path / "stereo.v", *STUBS], "stereo")


@pytest.mark.parametrize("simulator", SIMULATORS)
@pytest.mark.parametrize("fault", [("[7:0] blue;", "[6:0] blue;"), ("altpll #(", "altpllx #("), (".pll_ref_clk(", ".pll_ref(")])
def test_lint_complains(simulator, fault, verilog, tmp_path):
    text = verilog.read_text()
    assert fault[0] in text
    wrong = tmp_path / "stereo.v"
    wrong.write_text(text.replace(*fault))
    with pytest.raises(SimulationError, match=f"{simulator} rejects stereo"):
        lint(simulator, [wrong, *STUBS], "stereo")
