"""The display's side as emitted Verilog; see ``display_tb.py``."""

import pytest
from amaranth.lib.wiring import In

from golden.config import MatcherConfig
from hdl.emit import port_name, write_verilog
from hdl.video.dvi import DisplayOutput
from sim.kit.display_cases import FORMATS
from sim.kit.simulators import build, run


def bench(simulator, name, size, folder, *, disparities, depth, plans):
    """Each of ``plans`` is the modes and colours to show, or nothing for the plan of faults."""
    output = DisplayOutput(MatcherConfig(labels=disparities), FORMATS[name], *size, depth=depth)
    inputs = [port_name(path) for path, member, _ in output.signature.flatten(output) if member.flow is In]
    source = write_verilog(output, folder / "display.v", name="display_output")
    build(simulator, [source], "display_output", folder)
    env = {"DISPLAY_FORMAT": name, "SIZE": f"{size[0]} {size[1]}", "DISPARITIES": disparities, "INPUTS": " ".join(inputs)}
    for modes in plans:
        assert run(simulator, "display_output", folder, "sim.benches.display_tb", env={**env, "MODES": modes}) == 1


def test_small(tmp_path):
    bench("icarus", "small", (12, 8), tmp_path, disparities=5, depth=16, plans=["0 0 0 1 1 0 2 1 3 0", ""])


@pytest.mark.slow
@pytest.mark.parametrize("name", ["720x576", "1024x768"])
def test_real_formats(name, tmp_path):
    """720x576 pixels: two frames, timing and pictures. Mode ``both`` on 1024x768 reads 0.93 words a cycle."""
    bench("verilator", name, (720, 576), tmp_path, disparities=80, depth=512, plans=["0 1 2 1"])
