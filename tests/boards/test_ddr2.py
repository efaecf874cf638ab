"""The script that compares the generated memory controller with the project, run by tclsh as by Quartus's own Tcl."""
import re
import shutil
import subprocess

import pytest

from sim.kit.simulators import STUBS
from sim.models.board_core import board_project


STUB, = (path.read_text() for path in STUBS if path.name == "stereo_ddr2.v")
AGAIN = "; set what README.md lists in step 2 and generate it again\n"

# As Altera's generator writes it: comments, tabs, a keyword "wire" here and there; a port list with types in the header.
HEADER = re.sub(r"(?s)module stereo_ddr2 \(.*?\);\n(.*?)\n\n.*?endmodule", lambda match: "module stereo_ddr2 (\n" + re.sub(
    r"(?: = [^;]+)?;", ",", match[1]).rstrip(",") + ");\nendmodule", STUB)
assert HEADER.count(";") < 5 < STUB.count(";")


@pytest.fixture
def compare(tmp_path):
    """Runs the script beside a module; exit status and what it says."""
    if not shutil.which("tclsh"):
        pytest.skip("tclsh is not on this machine; install the package tcl")
    (tmp_path / "check_ddr2.tcl").write_text(board_project("720x576").files["check_ddr2.tcl"])

    def run(module):
        if module is not None:
            (tmp_path / "stereo_ddr2.v").write_text(module)
        done = subprocess.run(["tclsh", str(tmp_path / "check_ddr2.tcl")], cwd="/", capture_output=True, text=True)
        assert done.stderr == ""
        return done.returncode, done.stdout.removeprefix("check_ddr2: ")
    return run


@pytest.mark.parametrize("module", [
    STUB, HEADER, STUB.replace("  input [", "\tinput\t[").replace("  output ", "\toutput wire\t").replace("wire\treg", "reg"),
    f"/* module stereo_ddr2 (a); input a; endmodule */\nmodule other (b); input b; endmodule\n{STUB}module after (c); input c; endmodule\n",
    STUB.replace("input local_read_req;\n", "").replace("input local_write_req;", "input local_write_req, local_read_req;"),
    STUB.replace("endmodule", "output [7:0] aux_scan_clk;\nendmodule"),     # an output that nobody needs
], ids=["declarations", "header", "tabs", "other modules", "two in one", "spare output"])
def test_agrees(module, compare):
    assert compare(module) == (0, "the ports of stereo_ddr2.v are those that this project connects\n")


@pytest.mark.parametrize("pattern, replacement, told", [
    (r"input \[22:0\] local_address", "input [23:0] local_address", "local_address has the width 24, not 23"),
    (r"input \[127:0\] local_wdata", "input [63:0] local_wdata", "local_wdata has the width 64, not 128"),
    (r"input \[127:0\] local_wdata", "input local_wdata", "local_wdata has the width 1, not 128"),
    (r"input \[0:0\] local_size", "input [N-1:0] local_size", "local_size has the width unknown, not 1"),
    (r"  input local_burstbegin;\n", "", "local_burstbegin is missing"),
    (r"  output reset_request_n;\n", "  // output reset_request_n;\n", "reset_request_n is missing"),
    (r"  input soft_reset_n;\n", "  input soft_reset_n;\n  input local_refresh_req;\n", "local_refresh_req is not connected"),
    (r"  input \[15:0\] local_be;\n  input \[0:0\] local_size;", "", "local_be is missing, local_size is missing"),
])
def test_differs(pattern, replacement, told, compare):
    module, times = re.subn(pattern, replacement, STUB)
    assert times == 1
    assert compare(module) == (1, f"stereo_ddr2.v does not fit this project: {told}{AGAIN}")


@pytest.mark.parametrize("module, told", [
    (None, "there is no stereo_ddr2.v beside this script; generate the memory controller first, as in step 2 of README.md\n"),
    ("", f"stereo_ddr2.v has no module stereo_ddr2{AGAIN}"),
    (STUB.replace("module stereo_ddr2 ", "module stereo_ddr2_phy "), f"stereo_ddr2.v has no module stereo_ddr2{AGAIN}"),
    (STUB.replace("endmodule", ""), f"stereo_ddr2.v ends within the module stereo_ddr2{AGAIN}"),
])
def test_no_module(module, told, compare):
    assert compare(module) == (1, told)
