"""Which packages there are, what is refused, and what is found in the ports of a core."""

import re
from dataclasses import replace

import pytest

from hdl.build import main
from hdl.packages.core import Protocol, find_buses
from tests.kit import bus_core, manifest, packed_core, packed_ports


CORE = ["--core", "--width", "8", "--height", "4", "--disparities", "4"]


@pytest.mark.parametrize("options, told", [
    ([*CORE, "--package", "spice"],
     "there is no package 'spice'; choose one of: fusesoc, quartus, vivado, litex, vhdl, registers"),
    ([*CORE, "--package", "vhdl,"], "there is no package ''; choose one of: fusesoc, quartus, vivado, litex, vhdl, registers"),
    (["--board", "cyclone3", "--package", "registers", "--package", "vhdl"],
     "--package vhdl is for a core in another design, and --board makes a whole project; choose --core, or leave --package vhdl out"),
    ([*CORE, "--package", "registers"], "--package registers describes registers, and this core has ports in their place; "
     "choose --interface axi or avalon, or leave --package registers out"),
])
def test_refused(options, told, tmp_path, capsys):
    assert main([*options, "--output", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err == f"hdl.build: {told}\n"
    assert list(tmp_path.iterdir()) == []


def test_missing_library(tmp_path, capsys, monkeypatch):
    """Is told before minutes of work."""
    monkeypatch.setattr("importlib.util.find_spec", lambda name: None if name == "peakrdl_cheader" else True)
    assert main(["--board", "cyclone3", "--package", "registers", "--output", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err == (
        "hdl.build: the Python package peakrdl-cheader is not installed; install it with `pip install peakrdl-cheader`\n")


@pytest.mark.parametrize("interface", ["stream", "axi"])
def test_files(interface):
    """The manifest has them, so that a later build without them removes them."""
    folder = packed_core(interface)
    names = {"left_eye.v", "left_eye.core", "left_eye_hw.tcl", "component.xml", "left_eye_litex.py", "left_eye_pkg.vhd"}
    if interface == "axi":
        names |= {"left_eye.rdl", "left_eye.h", "left_eye_registers.py"}
    assert names <= set(manifest(folder)["files"])
    assert {path.name for path in folder.iterdir()} == {*manifest(folder)["files"], "manifest.json"}


# Frame timing signals: no stream is whole.
TIMING = {"line_valid": ("input", 1), "disparity": ("output", 3), "disparity_valid": ("output", 1), "disparity_ready": ("input", 1)}


@pytest.mark.parametrize("interface, found", [
    ("stream", {"i": (Protocol.NATIVE, False), "o": (Protocol.NATIVE, True)}),
    ("axi", {"s_axi": (Protocol.AXI_LITE, False), "s_axis": (Protocol.AXI_STREAM, False), "m_axis": (Protocol.AXI_STREAM, True)}),
    ("avalon", {"avs": (Protocol.AVALON_MEMORY, False), "asi": (Protocol.AVALON_STREAM, False), "aso": (Protocol.AVALON_STREAM, True)}),
    ("frame timing", {}),
])
def test_buses(interface, found):
    ports = packed_ports("stream") if interface == "stream" else TIMING if interface == "frame timing" else bus_core(interface).ports
    buses = find_buses(ports)
    assert {bus.name: (bus.protocol, bus.drives) for bus in buses} == found
    for bus in buses:
        assert bus.ports == {name.removeprefix(f"{bus.name}_"): name for name in ports if name.startswith(f"{bus.name}_")}


def test_every_port_has_a_place():
    assert bus_core("axi").others == bus_core("avalon").others == {}
    core = replace(bus_core("avalon"), ports=packed_ports("stream"))
    assert (core.clock, core.reset) == ("clk", ("rst", False))
    assert {*core.others} == {name for name in core.ports if not re.match("(clk|rst)$|[io]_", name)}
