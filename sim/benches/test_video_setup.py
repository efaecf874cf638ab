"""The set-up of the video chips as emitted Verilog, with models of the chips; see ``video_setup_tb.py``."""

from hdl.emit import write_verilog
from sim.benches.video_setup import VideoSetup
from sim.kit.simulators import build, run


# Benches in video_setup_tb.py.
TESTS = 2


def test_video_setup(tmp_path):
    source = write_verilog(VideoSetup(), tmp_path / "video_setup.v", name="video_setup")
    build("icarus", [source], "video_setup", tmp_path / "icarus")
    assert run("icarus", "video_setup", tmp_path / "icarus", "sim.benches.video_setup_tb") == TESTS
