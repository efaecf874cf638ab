"""A mutant against its tests, in a copy of the project of its own."""

import json
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path
from typing import Any

from golden.processes import started

from .mutants import Mutant
from .reach import PLUGIN, Chosen, environment


__all__ = ["MARGIN", "MOST_SECONDS", "run_mutant"]


#: Of a processor, for all tests of a mutant.
MOST_SECONDS = 60
#: Beyond three times what the tests take without the mutant.
MARGIN = 10
# On a machine with much else to do.
_WALL = 8 * MOST_SECONDS
_NOT_COPIED = shutil.ignore_patterns(".*", "build", "*.egg-info", "__pycache__")


def run_mutant(root: str, mutant: Mutant, chosen: Chosen) -> dict[str, Any]:
    """What became of a mutant.

    Returns
    -------
    dict
        ``verdict``: ``comparison`` or ``crash`` by what its first failing ``test`` said, ``time`` if it ran too long, ``survived``, or
        ``unreached`` if there is no test; ``seconds`` that it took; ``left_out``, the number of tests that would have taken too long.
    """
    begin = time.monotonic()
    found: dict[str, Any] = {"verdict": "unreached"}
    if chosen.tests:
        with tempfile.TemporaryDirectory(prefix="mutant-") as folder:
            found = _run(Path(root), Path(folder), mutant, chosen)
    return {**found, "seconds": round(time.monotonic() - begin, 1), "left_out": chosen.left_out}


def _run(root: Path, folder: Path, mutant: Mutant, chosen: Chosen) -> dict[str, Any]:
    copy = folder / "copy"
    shutil.copytree(root, copy, ignore=_NOT_COPIED, symlinks=True)
    (copy / mutant.file).write_bytes(mutant.apply((root / mutant.file).read_bytes()))
    (folder / "chosen").write_text(json.dumps(chosen.tests), encoding="utf-8")
    limit = min(MOST_SECONDS, round(MARGIN + 3 * chosen.seconds))
    files = dict.fromkeys(test.partition("::")[0] for test in chosen.tests)
    command = [sys.executable, "-m", "pytest", "-q", "-x", *PLUGIN, "--chosen", str(folder / "chosen"),
               "--verdict", str(folder / "verdict"), "--processor-seconds", str(limit), *files]
    with (folder / "said").open("wb") as said:
        try:
            with started(command, cwd=copy, env=environment(copy), stdout=said, stderr=said) as process:
                process.wait(_WALL)
        except subprocess.TimeoutExpired:
            return {"verdict": "time", "test": ""}
    if (folder / "verdict").exists():
        return dict(json.loads((folder / "verdict").read_text(encoding="utf-8")))
    if process.returncode == 0:
        return {"verdict": "survived", "tests": len(chosen.tests)}
    if process.returncode < 0:      # a signal: of the limit of seconds, but for a crash of the interpreter
        return {"verdict": "time", "test": ""}
    return {"verdict": "crash", "test": "", "error": (folder / "said").read_text(encoding="utf-8", errors="replace")[-300:]}
