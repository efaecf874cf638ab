"""Rectification and balance of two mounted cameras as emitted Verilog, on both simulators; see ``rig_tb.py``."""

import json

import pytest

from golden.rig.lines import lines_needed
from golden.rig.maps import pack
from hdl.emit import write_verilog
from hdl.rig.stages import RigStages
from sim.benches.rig import maps_of
from sim.kit.simulators import build, run


SMALL = {"width": 37, "height": 11, "labels": 8, "minimum": 0, "lines": 22, "stall": 0.3, "frames": 5}
MORE = {"width": 160, "height": 100, "labels": 40, "minimum": -9, "lines": 22, "stall": 0.0, "frames": 5}


# Slow: larger pictures, and windows that are apart.
@pytest.mark.parametrize("simulator, case", [
    pytest.param("icarus", SMALL, id="icarus"),
    # Slow: the same on the other simulator, which compiles for long; more lines.
    pytest.param("verilator", SMALL, id="verilator", marks=pytest.mark.slow),
    pytest.param("icarus", MORE, id="icarus-160x100", marks=pytest.mark.slow),
])
def test_rig(simulator, case, tmp_path):
    maps = maps_of(case, False)
    assert max(lines_needed(maps), lines_needed(maps_of(case, True))) <= case["lines"]
    stages = RigStages(case["width"], case["height"], case["labels"], case["lines"], maps=dict(zip(("left", "right"), map(pack, maps))))
    source = write_verilog(stages, tmp_path / "rig.v", name="rig")
    build(simulator, [source], "rig", tmp_path / simulator)
    assert run(simulator, "rig", tmp_path / simulator, "sim.benches.rig_tb", env={"CASE": json.dumps(case)}) == 1
