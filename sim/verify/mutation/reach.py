"""Which tests reach which line: recorded once for each file of tests, and again when it or what it reaches has changed."""

import hashlib
import json
import os
import sys
import tempfile
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from golden.errors import UserError
from golden.files import write_json
from golden.processes import run_program

from .mutants import Mutant


__all__ = ["Chosen", "Reach", "environment", "files_of_tests", "record"]


PLUGIN = ("-p", "sim.verify.mutation.plugin", "-p", "no:cacheprovider", "-p", "no:xdist")


def content(path: Path) -> str:
    """Digest of a file: 16 hexadecimal digits."""
    return hashlib.sha256(path.read_bytes()).hexdigest()[:16] if path.exists() else ""


def files_of_tests(root: Path, folders: Sequence[str]) -> list[str]:
    """Files of tests below folders, and sources with examples in their docstrings."""
    found = []
    for folder in folders:
        for path in sorted((root / folder).rglob("*.py")):
            if path.name.startswith("test_") or (not folder.startswith("tests") and ">>> " in path.read_text(encoding="utf-8")):
                found.append(str(path.relative_to(root)))
    return found


def environment(root: Path) -> dict[str, str]:
    """So that programs that tests start take the project from ``root`` too, and leave nothing compiled there."""
    return {**os.environ, "PYTHONPATH": str(root), "PYTHONDONTWRITEBYTECODE": "1"}


def record(root: Path, tests: str, sources: Sequence[str], kept: Path, seconds: int) -> bool:
    """Record what a file of tests reaches, unless the record is of the files as they are; whether it was recorded now.

    Of a file that takes longer than ``seconds`` the record has the tests that had run by then.
    """
    path = kept / f"{tests.replace('/', '.')}.json"
    if path.exists():
        have = json.loads(path.read_text(encoding="utf-8"))
        if all(content(root / file) == digest for file, digest in have["files"].items()):
            return False
    kept.mkdir(parents=True, exist_ok=True)
    with tempfile.TemporaryDirectory(prefix="reach-") as folder:
        out = Path(folder, "reach.json")
        options = [option for source in sources for option in ("--reach-of", source)]
        command = [sys.executable, "-m", "pytest", "-q", *PLUGIN, "--reach", str(out), *options, "--processor-seconds", str(seconds), tests]
        with Path(folder, "said").open("wb") as said:
            run_program(command, cwd=root, env=environment(root), stdout=said, stderr=said)
        found: list[dict[str, Any]] = [json.loads(line) for line in out.read_text(encoding="utf-8").splitlines()] if out.exists() else []
    reached = {file for test in found for file in test["lines"]}
    write_json(path, {"files": {file: content(root / file) for file in sorted({tests, *reached})}, "tests": found})
    return True


class Chosen(NamedTuple):
    """Tests of a mutant.

    Members
    -------
    tests : list of str
        The cheapest first, but those of the file's own tests before others.
    seconds : float
        What they take without the mutant.
    left_out : int
        Others that reach the mutant, and would take too long.
    """
    tests: list[str]
    seconds: float
    left_out: int


class Reach:
    """What the records say, to choose the tests of a mutant."""
    def __init__(self, kept: Path, tests: Iterable[str]):
        self.seconds: dict[str, float] = {}
        self._by_line: dict[tuple[str, int], set[str]] = {}
        self._by_file: dict[str, set[str]] = {}
        for name in tests:
            path = kept / f"{name.replace('/', '.')}.json"
            if not path.exists():
                raise UserError(f"{path} does not exist: what {name} reaches has not been recorded; choose the same --work again")
            for entry in json.loads(path.read_text(encoding="utf-8"))["tests"]:
                test = entry["test"]
                self.seconds[test] = entry["seconds"]
                for file, lines in entry["lines"].items():
                    self._by_file.setdefault(file, set()).add(test)
                    for line in lines:
                        self._by_line.setdefault((file, line), set()).add(test)

    def of(self, mutant: Mutant) -> set[str]:
        """Tests that execute a mutant's statement; of one that is executed at import, those that execute anything of its file.

        What no test executes but at import, such as a file of constants, is tested by the file's own tests.
        """
        if mutant.function:
            first, last = mutant.lines
            return set().union(*(self._by_line.get((mutant.file, line), set()) for line in range(first, last + 1)))
        return self._by_file.get(mutant.file) or {test for test in self.seconds if _is_own(test, mutant.file)}

    def choose(self, mutant: Mutant, budget: float) -> Chosen:
        """Tests that reach a mutant and take no more than ``budget`` seconds of a processor together, but one at least."""
        own: Callable[[str], bool] = lambda test: _is_own(test, mutant.file)    # noqa: E731
        order = sorted(self.of(mutant), key=lambda test: (not own(test), self.seconds[test], test))
        total = 0.0
        kept: list[str] = []
        for test in order:
            if kept and total + self.seconds[test] > budget:
                continue
            kept.append(test)
            total += self.seconds[test]
        return Chosen(kept, total, len(order) - len(kept))


def _is_own(test: str, file: str) -> bool:
    """Whether a test stands where the tests of a file do."""
    folder, _, name = file.rpartition("/")
    return test.startswith((f"tests/{folder}/test_{name}::", f"{file}::"))
