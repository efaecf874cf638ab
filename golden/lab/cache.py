"""Results kept on disk, found again by what they were computed from: function, arguments and sources."""

import ast
import functools
import hashlib
import inspect
import os
import zipfile
from collections.abc import Callable, Hashable, Iterable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

from ..errors import UserError
from ..files import atomic
from .workers import Job, Run


__all__ = ["Cache", "run_kept", "source_digest", "source_files"]


Result = dict[str, NDArray[Any]]


def source_files(path: str | os.PathLike[str]) -> set[Path]:
    """A source file and, transitively, all modules that it imports by relative imports."""
    found: set[Path] = set()
    waiting = [Path(path).resolve()]
    while waiting:
        file = waiting.pop()
        if file in found or not file.is_file():
            continue
        found.add(file)
        for node in ast.walk(ast.parse(file.read_bytes())):
            if isinstance(node, ast.ImportFrom) and node.level:
                base = file.parents[node.level - 1].joinpath(*(node.module or "").split("."))
                waiting += [base.with_suffix(".py"), base / "__init__.py", *(base / f"{alias.name}.py" for alias in node.names)]
    return found


def source_digest(files: Iterable[str | os.PathLike[str]]) -> str:
    """A digest of the code in some source files, in any order; comments, docstrings and layout do not count."""
    return hashlib.sha256("".join(sorted(map(_code, files))).encode("utf-8")).hexdigest()


def _code(file: str | os.PathLike[str]) -> str:
    """The syntax tree of a source file without its docstrings, as text."""
    tree = ast.parse(Path(file).read_bytes())
    for node in ast.walk(tree):
        if isinstance(node, ast.Module | ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef) and ast.get_docstring(node) is not None:
            del node.body[0]
    return ast.dump(tree)


@functools.cache
def _sources(file: str) -> str:
    """Digest of a source file and of all that it imports from its package, as they were at the first call."""
    return source_digest(source_files(file))


class Cache:
    """A folder of results, each found by the function's name, the content of its arguments, and the sources of the function's module.

    Parameters
    ----------
    folder : path
        Made when the first result is kept.
    """
    def __init__(self, folder: str | os.PathLike[str]) -> None:
        self.folder = Path(folder)

    def path(self, job: Job) -> Path:
        """Where the result of a job is, or would be."""
        from dask.base import tokenize  # here, because it takes longer to load than all the rest

        function, *arguments = job
        name: str = tokenize(_sources(inspect.getfile(function)), f"{function.__module__}.{function.__qualname__}", arguments)
        return self.folder / f"{name}.npz"

    def load(self, job: Job) -> Result | None:
        """The result of a job; ``None`` if it is not kept or its file is damaged."""
        try:
            # Opened here: NumPy leaves the file open when it finds it damaged.
            with self.path(job).open("rb") as file, np.load(file, allow_pickle=False) as arrays:
                return dict(arrays)
        except (OSError, ValueError, EOFError, zipfile.BadZipFile):
            return None

    def keep(self, job: Job, result: Result) -> None:
        """Keep the result of a job: arrays by name."""
        path = self.path(job)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise UserError(f"cannot make the folder {path.parent}: {error.strerror}; choose another --cache") from error
        with atomic(path) as file:
            np.savez_compressed(file, allow_pickle=False, **result)


def run_kept(run: Run, cache: Cache | None, jobs: Mapping[Hashable, Job], begin: Callable[[int], object] = lambda count: None,
             advance: Callable[[], object] = lambda: None) -> dict[Any, Result]:
    """Results of jobs, by the same keys: from the cache, or computed and kept there.

    Parameters
    ----------
    run : Run
        Of :func:`golden.lab.workers.workers`.
    cache : Cache or None
        ``None``: nothing is kept.
    jobs : dict of any to Job
    begin, advance : callable
        Called with the number of jobs that are computed, and after each of them.
    """
    results = {key: kept for key, job in jobs.items() if cache and (kept := cache.load(job)) is not None}
    missing = [(key, job) for key, job in jobs.items() if key not in results]
    begin(len(missing))

    def done(number: int, result: Result) -> None:
        key, job = missing[number]
        if cache:
            cache.keep(job, result)
        results[key] = result
        advance()

    if missing:
        run([job for _, job in missing], done)
    return results
