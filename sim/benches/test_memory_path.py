"""Writers, arbiter and readers as emitted Verilog, at the memory model; see ``memory_path_tb.py``."""

import json

import pytest
from amaranth.lib.wiring import In

from golden.config import MatcherConfig
from golden.video.memory_map import MemoryMap
from hdl.emit import port_name, write_verilog
from sim.benches.memory_path import MemoryPath
from sim.kit.simulators import build, run


@pytest.mark.parametrize("width, height, burst, size, depth", [(37, 6, 16, 1, 32), (40, 4, 2, 4, 6)])
def test_memory_path(width, height, burst, size, depth, tmp_path):
    path = MemoryPath(MemoryMap(width, height), MatcherConfig(labels=256), burst=burst, size=size, depth=depth)
    inputs = [port_name(place) for place, member, _ in path.signature.flatten(path) if member.flow is In]
    source = write_verilog(path, tmp_path / "memory_path.v", name="memory_path")
    build("icarus", [source], "memory_path", tmp_path / "icarus")
    env = {"PATH_SIZE": json.dumps([width, height, size, depth]), "INPUTS": " ".join(inputs)}
    assert run("icarus", "memory_path", tmp_path / "icarus", "sim.benches.memory_path_tb", env=env) == 2
