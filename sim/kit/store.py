"""Compiled models kept by content: what one run has compiled serves the next one, and the other workers of the same run."""

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
    """A folder of files, each under a key that says all it was made from.

    A file is there whole or not at all, however many processes store the same one, and whenever one of them is interrupted. Once the
    files exceed ``limit`` bytes, those that were used least recently are removed. A store that cannot be written holds nothing; it is
    no error.

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
        """Copy the file of ``key`` to ``target``; whether there is one."""
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
        """While the block runs, other processes that are about to make the file of ``key`` wait; a process that ends waits no longer."""
        with contextlib.ExitStack() as stack:
            with contextlib.suppress(OSError):
                self.folder.mkdir(parents=True, exist_ok=True)
                lock = stack.enter_context((self.folder / _LOCK).open("a"))
                # A byte of the file for each key: no file is left behind for each. Closing the file ends the lock.
                fcntl.lockf(lock, fcntl.LOCK_EX, 1, int.from_bytes(key.encode()[-7:]))
            yield

    def _shrink(self) -> None:
        """Remove files, the one that was used least recently first, until the rest is within the limit."""
        files = []
        for path in self.folder.iterdir():
            # Another process may remove it meanwhile.
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
    """Copy a file with its mode; ``target`` is replaced at once, so that who runs or reads it is not disturbed."""
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
    """Removed as the process ends."""
    return tempfile.TemporaryDirectory(prefix="models-")


@functools.cache
def models() -> Store:
    """The store of compiled models: ``build/models`` of the project, which ``make clean`` removes.

    Where there is no such folder to write in, as in an installed copy, it is a temporary one of this process alone.
    """
    folder = ROOT / "build" / "models"
    try:
        if not (ROOT / "pyproject.toml").is_file():
            raise OSError("an installed copy")
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):    # only an attempt tells: permission bits say nothing of a read-only file system
            pass
    except OSError:
        folder = Path(_temporary().name)
    return Store(folder)
