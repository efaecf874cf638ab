"""Compiled models kept by content: each is compiled once for all tests, all workers of a test run, and all later runs."""

import contextlib
import fcntl
import functools
import os
import shutil
import tempfile
from collections.abc import Iterator
from pathlib import Path


__all__ = ["LIMIT", "ROOT", "Store", "models"]


#: Folder that holds the project's packages.
ROOT = Path(__file__).resolve().parents[2]

#: Bytes that a store holds at most. A model has about a million, one of the whole system a few.
LIMIT = 1 << 30

_LOCK = "lock"


class Store:
    """A folder of files, each named by a key that is made from all that the file depends on.

    A file is complete or absent, whichever processes write it at the same time, and whenever one of them is interrupted. If the files
    exceed ``limit`` bytes, the least recently used ones are removed. A store that cannot be written stays empty, without an error.

    Parameters
    ----------
    folder : path
        Made when the first file is stored.
    limit : int
        Bytes.
    """
    def __init__(self, folder: str | os.PathLike[str], limit: int = LIMIT):
        self.folder = Path(folder)
        self.limit = limit

    def fetch(self, key: str, target: Path) -> bool:
        """Copy the file of ``key`` to ``target``; whether the store has it."""
        kept = self.folder / key
        try:
            _copy(kept, target)
        except (FileNotFoundError, NotADirectoryError):
            return False
        with contextlib.suppress(OSError):
            os.utime(kept)
        return True

    def keep(self, key: str, source: Path) -> None:
        """Store a copy of the file ``source`` under ``key``."""
        with contextlib.suppress(OSError):
            self.folder.mkdir(parents=True, exist_ok=True)
            _copy(source, self.folder / key)
            self._shrink()

    @contextlib.contextmanager
    def making(self, key: str) -> Iterator[None]:
        """Lock ``key``: another process that enters this waits until the block is left, or until this process ends."""
        with contextlib.ExitStack() as stack:
            with contextlib.suppress(OSError):
                self.folder.mkdir(parents=True, exist_ok=True)
                lock = stack.enter_context((self.folder / _LOCK).open("a"))
                # Each key locks a byte of one file, so that there is no file for each. Closing the file ends the lock.
                fcntl.lockf(lock, fcntl.LOCK_EX, 1, int.from_bytes(key.encode()[-7:]))
            yield

    def _shrink(self) -> None:
        """Remove the least recently used files until the rest is within the limit."""
        files = []
        for path in self.folder.iterdir():
            # Another process may have removed it.
            with contextlib.suppress(OSError):
                status = path.stat()
                if path.name != _LOCK:
                    files.append((status.st_mtime, status.st_size, path))
        excess = sum(size for _, size, _ in files) - self.limit
        for _, size, path in sorted(files):
            if excess <= 0:
                break
            path.unlink(missing_ok=True)
            excess -= size


def _copy(source: Path, target: Path) -> None:
    """Copy a file with its mode. ``target`` is replaced in one step: a process that runs or reads the old file keeps it."""
    with source.open("rb") as data:
        handle, name = tempfile.mkstemp(prefix=".", dir=target.parent)
        try:
            with open(handle, "wb") as copy:
                shutil.copyfileobj(data, copy)
            os.chmod(name, os.fstat(data.fileno()).st_mode)
            os.replace(name, target)
        except BaseException:
            os.unlink(name)
            raise


@functools.cache
def _temporary() -> "tempfile.TemporaryDirectory[str]":
    """Of this process, which removes it as it ends."""
    return tempfile.TemporaryDirectory(prefix="models-")


@functools.cache
def models() -> Store:
    """The store of compiled models: the project's folder ``build/models``, which ``make clean`` removes.

    Where that cannot be written, and in an installed copy, it is a temporary folder of this process.
    """
    folder = ROOT / "build" / "models"
    try:
        if not (ROOT / "pyproject.toml").is_file():
            raise OSError("an installed copy")
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):    # permission bits do not show a read-only file system
            pass
    except OSError:
        folder = Path(_temporary().name)
    return Store(folder)
