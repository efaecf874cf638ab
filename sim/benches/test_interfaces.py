"""The cores with a bus as emitted Verilog, between masters, sources and sinks of kits, see ``axi_tb``, ``avalon_tb`` and ``bus_tb``."""

import pytest

from hdl.emit import write_verilog
from hdl.interfaces.cores import INTERFACES
from sim.benches.bus_cases import CASES
from sim.kit.simulators import build, run


# Benches of either bus, with those that both have; AXI has channels that are to be independent.
TESTS = {"axi": 7, "avalon": 6}


@pytest.mark.parametrize("interface", INTERFACES)
@pytest.mark.parametrize("simulator, case", [
    ("verilator", "thesis"),
    # Slow: the other simulator; further fields of the output, and a register with a sign.
    pytest.param("icarus", "thesis", marks=pytest.mark.slow),
    pytest.param("verilator", "fused", marks=pytest.mark.slow),
])
def test_core(simulator, case, interface, tmp_path):
    pytest.importorskip(f"cocotbext.{interface}", reason=f"cocotbext-{interface}, of the extra sim, is not installed")
    core = INTERFACES[interface](*CASES[case])
    source = write_verilog(core, tmp_path / "core.v", name="stereo_core")
    build(simulator, [source], "stereo_core", tmp_path / simulator, brief=True)
    modules = f"sim.benches.{interface}_tb,sim.benches.bus_tb"
    assert run(simulator, "stereo_core", tmp_path / simulator, modules, env={"CASE": case, "BUS": interface}) == TESTS[interface]
