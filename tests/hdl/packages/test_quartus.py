"""The component for Platform Designer, read by a strict stand-in for it in tclsh."""

import re
import shutil
import subprocess
from dataclasses import replace
from pathlib import Path

import pytest

from hdl.packages.quartus import quartus_files
from tests.kit import bus_core, packed_core, packed_ports


STAND_IN = Path(__file__).with_name("qsys.tcl")


def read(path):
    """What the stand-in says of a component: port to direction, width, interface and type; or its last error."""
    if not shutil.which("tclsh"):
        pytest.skip("tclsh is not on this machine; install the package tcl")
    run = subprocess.run(["tclsh", str(STAND_IN), str(path)], cwd="/", capture_output=True, text=True, timeout=60)
    if run.returncode:
        return run.stderr.splitlines()[0]
    lines = [line.split() for line in run.stdout.splitlines()]
    return {port: (direction.lower(), int(width), interface, kind) for port, direction, width, interface, kind in lines}


def of_core(interface, folder, change=lambda text: text):
    (folder / "left_eye.v").touch()
    (folder / "left_eye_hw.tcl").write_text(change(quartus_files(bus_core(interface))["left_eye_hw.tcl"]))
    return read(folder / "left_eye_hw.tcl")


def widths(told):
    return {port: (direction, width) for port, (direction, width, *_) in told.items()}


@pytest.mark.parametrize("interface, kinds", [
    ("stream", {"i_payload": "avalon_streaming", "o_ready": "avalon_streaming", "u1": "conduit", "rst": "reset"}),
    ("axi", {"aclk": "clock", "aresetn": "reset", "s_axi_awaddr": "axi4lite", "s_axis_tdata": "axi4stream", "m_axis_tlast": "axi4stream"}),
])
def test_component(interface, kinds):
    """All ports of the Verilog, in the interfaces of their protocols."""
    told = read(packed_core(interface) / "left_eye_hw.tcl")
    assert widths(told) == packed_ports(interface)
    assert {port: told[port][3] for port in kinds} == kinds


def test_avalon(tmp_path):
    """All ports but those of responses."""
    told = of_core("avalon", tmp_path)
    left = ["avs_response", "avs_writeresponsevalid"]
    assert widths(told) == {port: given for port, given in bus_core("avalon").ports.items() if port not in left}
    kinds = {"avs_address": "avalon", "asi_data": "avalon_streaming", "aso_endofpacket": "avalon_streaming"}
    assert {port: told[port][3] for port in kinds} == kinds


@pytest.mark.parametrize("reset, edges", [("rst", "BOTH"), ("reset_n", "NONE")])
def test_reset(reset, edges):
    """One that is synchronised within the core has no edges that Platform Designer must synchronise."""
    core = replace(bus_core("axi"), ports={"clk": ("input", 1), reset: ("input", 1)})
    text = quartus_files(core)["left_eye_hw.tcl"]
    assert f"set_interface_property reset synchronousEdges {edges}\n" in text
    assert f"add_interface_port reset {reset} {'reset_n' if reset == 'reset_n' else 'reset'} Input 1\n" in text


@pytest.mark.parametrize("pattern, replacement, told", [
    ("Output 1", "Input 1", "direction of s_axi_awready"),
    ("tdata Input 16", "tdat Input 16", "no role tdat in axi4stream"),
    ("axi4lite end", "axi4lit end", "no interface type axi4lit"),
    ("qsys 18.1", "qsys 13.1", "axi4lite needs a later version"),
    ("left_eye.v VERILOG PATH left_eye.v", "left_eye.v VERILOG PATH eye.v", "no file eye.v"),
    (r"add_interface_port m_axis m_axis_tready.*\n", "", "interface m_axis without tready"),
    ("set_interface_property s_axi associatedReset.*\n", "", "interface s_axi without a reset"),
])
def test_stand_in_is_strict(pattern, replacement, told, tmp_path):
    assert of_core("axi", tmp_path, lambda text: re.sub(pattern, replacement, text, count=1)) == told
