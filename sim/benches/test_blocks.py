"""Every block as emitted Verilog, through cocotb on both simulators; see ``blocks_tb.py``."""

import pytest
from amaranth.lib.wiring import In

from hdl.emit import port_name, write_verilog
from sim.benches.blocks import CONFIGS, Blocks
from sim.kit.simulators import SIMULATORS, build, run


# Benches in blocks_tb.py: ten with and without stalls, four without a stream to stall.
TESTS = 2 * 10 + 4


# Slow: Verilator, which takes six times as long; Icarus runs the same, and Verilator whole matchers of either arithmetic.
@pytest.mark.parametrize("simulator, arithmetic", [
    pytest.param(simulator, arithmetic, marks=[pytest.mark.slow] if simulator == "verilator" else [])
    for simulator in SIMULATORS for arithmetic in CONFIGS])
def test_blocks(simulator, arithmetic, tmp_path):
    blocks = Blocks(CONFIGS[arithmetic])
    inputs = [port_name(path) for path, member, _ in blocks.signature.flatten(blocks) if member.flow is In]
    source = write_verilog(blocks, tmp_path / "blocks.v", name="blocks")
    build(simulator, [source], "blocks", tmp_path / simulator)
    ran = run(simulator, "blocks", tmp_path / simulator, "sim.benches.blocks_tb",
              env={"ARITHMETIC": arithmetic, "INPUTS": " ".join(inputs)})
    assert ran == TESTS
