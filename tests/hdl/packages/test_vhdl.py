"""The component in a VHDL design, analysed and elaborated by GHDL."""

import re
import shutil
import subprocess
from dataclasses import replace

import pytest

from golden.config import FUSED_1, RECURSIVE_2, MatcherConfig, OnePass
from golden.rig.config import RigConfig
from hdl.build import fields_of, ports_of
from hdl.matcher.framed import FramedMatcher
from hdl.matcher.matcher import Matcher
from hdl.packages.core import Core
from hdl.packages.vhdl import vhdl_files
from hdl.rectified import RectifiedMatcher
from tests.kit import bus_core, packed_core, packed_ports, refused_components


def ghdl(folder, *arguments):
    """Run GHDL; status and what it prints."""
    if not shutil.which("ghdl"):
        pytest.skip("ghdl is not on this machine; install the package ghdl-mcode")
    run = subprocess.run(["ghdl", arguments[0], "--std=08", *arguments[1:]], cwd=folder, stdout=subprocess.PIPE, stderr=subprocess.STDOUT,
                         text=True, timeout=60)
    return run.returncode, run.stdout


def vector(width):
    return "std_logic" if width == 1 else f"std_logic_vector({width - 1} downto 0)"


def design(ports, assertions=""):
    """An entity with the ports of the Verilog, which the component is bound to, and an instance above it."""
    head = "library ieee; use ieee.std_logic_1164.all;\n"
    declared = ";\n".join(f"{name} : {'in' if direction == 'input' else 'out'} {vector(width)}"
                          for name, (direction, width) in ports.items())
    signals = "".join(f"signal s_{name} : {vector(width)};\n" for name, (_, width) in ports.items())
    connected = ", ".join(f"{name} => s_{name}" for name in ports)
    return (f"{head}entity left_eye is port (\n{declared});\nend entity;\narchitecture none of left_eye is begin end architecture;\n"
            f"{head}use work.left_eye_pkg.all;\nentity above is end entity;\narchitecture test of above is\n{signals}begin\n"
            f"core : left_eye port map ({connected});\nprocess begin\n{assertions}wait; end process;\nend architecture;\n")


def elaborate(folder, package, text):
    (folder / "left_eye_pkg.vhd").write_text(package)
    (folder / "above.vhd").write_text(text)
    status, told = ghdl(folder, "-a", "left_eye_pkg.vhd", "above.vhd")
    return (status, told) if status else ghdl(folder, "--elab-run", "above", "--assert-level=error")


@pytest.mark.parametrize("interface, fields", [
    ("stream", [("i_payload", "right", 8, 8), ("i_payload", "end", 1, 18), ("o_payload", "first", 1, 2)]),
    ("axi", [("s_axis_tdata", "left", 8, 0), ("s_axis_tdata", "right", 8, 8), ("m_axis_tdata", "disparity", 2, 0)]),
])
def test_component(interface, fields, tmp_path):
    """The ports are those of the Verilog, and the fields of a payload are where they are."""
    assertions = "".join(f"assert s_{port}({port}_{field})'length = {width} and s_{port}({port}_{field})'right = {low};\n"
                         for port, field, width, low in fields)
    package = (packed_core(interface) / "left_eye_pkg.vhd").read_text()
    assert elaborate(tmp_path, package, design(packed_ports(interface), assertions)) == (0, "")


@pytest.mark.parametrize("method", [OnePass(), FUSED_1, RECURSIVE_2], ids=lambda method: method.name)
def test_names_of_ports(method, tmp_path):
    """No method, and no stage in front of it, has a port that VHDL does not take as an identifier."""
    config = MatcherConfig(16, 64, method=method)
    with refused_components():  # components that are not built
        for component in (Matcher(config), FramedMatcher(config, RectifiedMatcher(config, 48, RigConfig()))):
            core = Core("left_eye", "0.2.0", "Of a test", ["left_eye.v"], ports_of(component), fields_of(component))
            (tmp_path / "left_eye_pkg.vhd").write_text(vhdl_files(core)["left_eye_pkg.vhd"])
            assert ghdl(tmp_path, "-a", "left_eye_pkg.vhd") == (0, "")
        del component


def test_avalon(tmp_path):
    core = bus_core("avalon")
    assert elaborate(tmp_path, vhdl_files(core)["left_eye_pkg.vhd"], design(core.ports)) == (0, "")


@pytest.mark.parametrize("port", [("input", 3), None], ids=["width", "missing"])
def test_what_is_wrong_is_seen(port, tmp_path):
    core = bus_core("axi")
    ports = {name: given for name, given in {**core.ports, "s_axis_tdata": port}.items() if given}
    package = vhdl_files(replace(core, ports=ports, payloads={}))["left_eye_pkg.vhd"]
    assert elaborate(tmp_path, package, design(core.ports))[0] != 0


def test_directions():
    """GHDL binds a component to an entity whose ports have other directions."""
    core = bus_core("axi")
    found = re.findall(r"(?m)^ +(\w+) +: (in |out) (.*?);?$", vhdl_files(core)["left_eye_pkg.vhd"])
    assert found == [(name, {"input": "in ", "output": "out"}[direction], vector(width)) for name, (direction, width) in core.ports.items()]
