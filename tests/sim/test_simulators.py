"""Compilation by content: what makes another model, what does not, and what a build leaves. Most compilers here are stand-ins."""

import os
import subprocess
from pathlib import Path

import pytest

from sim.kit import simulators
from sim.kit.simulators import SimulationError, build, run
from sim.kit.store import Store


class Compiler:
    """Stands in for cocotb's runner: a model holds what it was built from."""
    def __init__(self):
        self.builds = []
        self.fault = None

    def build(self, *, sources, hdl_toplevel, build_dir, log_file, **options):
        self.builds.append(options | {"flags": os.environ.get("MAKEFLAGS", "").split()})
        folder = Path(build_dir)
        (folder / "objects").mkdir()
        # Half of it is there when the fault strikes.
        for name in ("sim.vvp", hdl_toplevel):
            (folder / name).write_text("".join(source.read_text() for source in sources))
        log_file.write_text("the last line of the log\n")
        if self.fault:
            raise self.fault


@pytest.fixture
def compiler(monkeypatch):
    compiler = Compiler()
    monkeypatch.setattr(simulators, "_runner", lambda simulator: compiler)
    monkeypatch.setattr(simulators, "require", lambda simulator: None)
    monkeypatch.setattr(simulators, "_versions", lambda simulator: "1")
    monkeypatch.setattr(simulators, "_verilator", lambda: (Path("/none"), (5, 48)))
    return compiler


@pytest.fixture
def store(tmp_path):
    return Store(tmp_path / "store")


@pytest.fixture
def source(tmp_path):
    path = tmp_path / "top.v"
    path.write_text("module top; endmodule")
    return path


def names(store):
    return {path.name.partition("-")[0] for path in store.folder.iterdir()}


@pytest.mark.parametrize("simulator, file", [("verilator", "top"), ("icarus", "sim.vvp")])
def test_built_once(compiler, store, source, tmp_path, simulator, file):
    """The same content elsewhere, and of another name, is the same model; its folder holds nothing else."""
    other = tmp_path / "other.v"
    other.write_bytes(source.read_bytes())
    assert build(simulator, [source], "top", tmp_path / "a", store=store) > 0
    assert build(simulator, [source], "top", tmp_path / "a", store=store) == 0
    assert build(simulator, [other], "top", tmp_path / "b c", store=store) == 0
    assert len(compiler.builds) == 1
    for folder in ("a", "b c"):
        assert [path.name for path in (tmp_path / folder).iterdir()] == [file]
        assert (tmp_path / folder / file).read_text() == "module top; endmodule"


@pytest.mark.parametrize("simulator", simulators.SIMULATORS)
def test_change_makes_another_model(compiler, store, source, tmp_path, monkeypatch, simulator):
    second = tmp_path / "second.v"
    second.write_text("module second; endmodule")
    folder = tmp_path / "model"
    changes = [{}, {"parameters": {"A": 1}}, {"parameters": {"A": 2}}, {"parameters": {"B": 1}}, {"defines": {"A": 1}},
               {"defines": {"A": 2}}, {"waves": True}, *([{"debug": True}, {"brief": True}] if simulator == "verilator" else [])]
    for count, options in enumerate(changes):
        assert len(compiler.builds) == count
        build(simulator, [source], "top", folder, store=store, **options)
    compiler.builds.clear()
    for options in changes:
        build(simulator, [source], "top", folder, store=store, **options)
    assert compiler.builds == []                            # all are kept

    build(simulator, [source, second], "top", folder, store=store)
    build(simulator, [second, source], "top", folder, store=store)
    build(simulator, [source, second], "second", folder, store=store)
    assert len(compiler.builds) == 3
    source.write_text("module top; wire a; endmodule")
    build(simulator, [source], "top", folder, store=store)
    monkeypatch.setattr(simulators, "_versions", lambda simulator: "2")
    build(simulator, [source], "top", folder, store=store)
    monkeypatch.setattr(simulators, "_WARNINGS", ())
    monkeypatch.setattr(simulators, "_MAKEFLAGS", "-- OPT_FAST={fast}")
    build(simulator, [source], "top", folder, store=store)
    assert len(compiler.builds) == (6 if simulator == "verilator" else 5)


def test_makefile_is_told_what_is_short(compiler, store, source, tmp_path, monkeypatch):
    """Short Verilog is compiled as one file, whatever the number of its files; a model for a brief run without the optimiser."""
    one_file = simulators._AS_ONE_FILE.strip()
    monkeypatch.setattr(simulators, "_ONE_FILE", 2 * source.stat().st_size)
    for number, (sources, options, fast, whole) in enumerate((
            ([source], {}, "-O1", True), ([source, source], {"brief": True}, "-O0", True), (3 * [source], {}, "-O1", False),
            (3 * [source], {"debug": True}, "-O0", False))):
        assert build("verilator", sources, "top", tmp_path / "model", store=store, **options) > 0
        flags = compiler.builds[number]["flags"]
        assert f"OPT_FAST={fast}" in flags and (one_file in flags) == whole


def test_simulators_do_not_share(compiler, store, source, tmp_path):
    for simulator in simulators.SIMULATORS:
        build(simulator, [source], "top", tmp_path / simulator, store=store)
    assert len(compiler.builds) == 2 and names(store) == {"verilator", "icarus", "lock"}


@pytest.mark.parametrize("fault, told", [(RuntimeError("status 1"), SimulationError), (KeyboardInterrupt(), KeyboardInterrupt)])
def test_failed_build_leaves_nothing(compiler, store, source, tmp_path, fault, told):
    compiler.fault = fault
    with pytest.raises(told) as raised:
        build("verilator", [source], "top", tmp_path / "model", store=store)
    assert told is KeyboardInterrupt or "the last line of the log" in str(raised.value)
    assert list((tmp_path / "model").iterdir()) == [] and names(store) == {"lock"}
    compiler.fault = None
    assert build("verilator", [source], "top", tmp_path / "model", store=store) > 0
    assert len(compiler.builds) == 2


def test_versions_name_the_tools():
    for simulator, tool in (("icarus", "Icarus Verilog"), ("verilator", "c++")):
        assert tool in simulators._versions(simulator)


class Objects:
    """The script that Verilator's makefile calls in front of a compiler, and a compiler that writes its arguments and counts."""
    def __init__(self, folder):
        self.folder, self.kept = folder, folder / "kept"
        self.kept.mkdir()
        (folder / "objects.sh").write_text(simulators._OBJECTS)
        (folder / "compiler").write_text('echo >>count\n[ -z "$FAIL" ] || exit 3\necho "$*" >"$4"\n')

    def compile(self, source, option="-O1", version="1", fail="", kept=None):
        """Whether it succeeded, number of compilations up to now, what the object holds."""
        target = self.folder / f"{Path(source).stem}.o"
        target.unlink(missing_ok=True)
        environment = {"OBJECTS": f"{kept or self.kept}/{version}-", "FAIL": fail, "PATH": "/usr/bin:/bin"}
        done = subprocess.run(["sh", "./objects.sh", "sh", "./compiler", option, "-c", "-o", target.name, source], cwd=self.folder,
                              env=environment, capture_output=True, text=True)
        assert done.stdout + done.stderr == ""
        return done.returncode == 0, (self.folder / "count").read_text().count("\n"), target.read_text() if target.is_file() else None


def test_objects_of_the_runtime_are_kept(tmp_path):
    objects = Objects(tmp_path)
    runtime = "/v/include/verilated.cpp"
    expected = f"-O1 -c -o verilated.o {runtime}\n"
    assert objects.compile(runtime, fail="1") == (False, 1, None)
    assert list(objects.kept.iterdir()) == []
    assert objects.compile(runtime) == (True, 2, expected)
    assert objects.compile(runtime) == (True, 2, expected)          # kept
    assert objects.compile(runtime, option="-O0") == (True, 3, expected.replace("-O1", "-O0"))
    assert objects.compile(runtime, version="2") == (True, 4, expected)
    assert objects.compile("/w/include/verilated.cpp")[1] == 5
    assert objects.compile(runtime) == (True, 5, expected)
    for count in (6, 7):                                            # those of a model are not
        assert objects.compile("Vtop.cpp") == (True, count, "-O1 -c -o Vtop.o Vtop.cpp\n")
    main = "/v/share/verilator.cpp"     # has the size of the model in it
    for count in (8, 9):
        assert objects.compile(main) == (True, count, f"-O1 -c -o verilator.o {main}\n")
    assert len(list(objects.kept.iterdir())) == 4
    for count in (10, 11):                                          # nowhere to keep them
        assert objects.compile(runtime, kept="/none") == (True, count, expected)


def test_models_work(tmp_path):
    """Two models of a simulator, told apart by a parameter; a kept one runs as it does where it was built."""
    source = tmp_path / "top.v"
    source.write_text("module top #(parameter A = 0) (output [7:0] a); assign a = A[7:0]; endmodule\n")
    store = Store(tmp_path / "store")
    for folder, value in (("a", 5), ("b", 6), ("c d", 5)):
        seconds = build("icarus", [source], "top", tmp_path / folder, parameters={"A": value}, store=store)
        assert (seconds > 0) == (folder != "c d")
        assert run("icarus", "top", tmp_path / folder, "sim.benches.constant_tb", env={"A": value}) == 1
    with pytest.raises(SimulationError, match="1 of 1 tests"):
        run("icarus", "top", tmp_path / "a", "sim.benches.constant_tb", env={"A": 6})
