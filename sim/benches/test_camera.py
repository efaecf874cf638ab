"""The camera's receiver as emitted Verilog, through cocotb; see ``camera_tb.py``."""

import pytest

from golden.video.formats import PAL
from hdl.emit import write_verilog
from hdl.video.bt656 import CameraInput
from sim.benches.camera import FORMAT
from sim.kit.simulators import build, run


# Benches in camera_tb.py: one with two cameras, two others.
TESTS = 2 + 2


def test_camera(tmp_path):
    source = write_verilog(CameraInput(FORMAT, "camera", depth=16), tmp_path / "camera_input.v", name="camera_input")
    build("icarus", [source], "camera_input", tmp_path / "icarus")
    assert run("icarus", "camera_input", tmp_path / "icarus", "sim.benches.camera_tb") == TESTS


@pytest.mark.slow
def test_camera_at_full_size(tmp_path):
    source = write_verilog(CameraInput(PAL, "camera"), tmp_path / "camera_input.v", name="camera_input")
    build("verilator", [source], "camera_input", tmp_path / "verilator")
    assert run("verilator", "camera_input", tmp_path / "verilator", "sim.benches.camera_pal_tb") == 1
