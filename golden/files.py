"""Output files that are written whole or not at all, and folders of them that belong to one run."""

import contextlib
import json
import os
import secrets
import tempfile
from collections.abc import Callable, Collection, Iterator
from pathlib import Path
from typing import Any, BinaryIO

from .errors import UserError


__all__ = ["atomic", "check_folder", "check_output", "output_folder", "parsed", "remove_stale", "write_json"]


def _beside(path: Path) -> Path:
    """A name in the same folder that nobody uses; a process's number would not do, which one in another container, or one that was killed,
    may have too. Short, because that of ``path`` may be as long as is possible.
    """
    return path.with_name(f".{secrets.token_hex(8)}.tmp")


@contextlib.contextmanager
def atomic(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """A binary file that replaces ``path`` when the block succeeds, and is removed when it raises.

    :class:`UserError` if the folder cannot be written, or the disk is full.
    """
    target = Path(path).resolve()  # a link stays one: its target is replaced
    # Next to the target, because a rename is atomic within one file system only. Not `tempfile`: its files are private (0600).
    temporary = _beside(target)
    try:
        with temporary.open("xb") as file:
            yield file
        temporary.replace(target)
    except OSError as error:
        raise UserError(f"cannot write {path}: {error.strerror or error}; choose another --output") from error
    finally:
        with contextlib.suppress(OSError):
            temporary.unlink(missing_ok=True)


def write_json(path: str | os.PathLike[str], document: Any) -> None:
    """Write a document of JSON, indented, whole or not at all."""
    with atomic(path) as file:
        file.write(f"{json.dumps(document, indent=2)}\n".encode())


def parsed(parse: Callable[[str], Any], text: str) -> Any:
    """What ``parse`` makes of a text; :class:`ValueError` also if its brackets are nested deeper than Python's own calls may be.

    Examples
    --------
    >>> parsed(json.loads, "[[1]]")
    [[1]]
    """
    try:
        return parse(text)
    except RecursionError:
        raise ValueError("its brackets are nested too deeply") from None


def check_output(path: str | os.PathLike[str], suffixes: Collection[str], option: str = "--output") -> Path:
    """Raise :class:`UserError` unless ``path`` can be written: for use before a long computation.

    Parameters
    ----------
    path : path
        The file to write.
    suffixes : collection of str
        Those that are allowed, lower case, with the dot.
    option : str
        The option that the remedy names.
    """
    path = Path(path)
    if path.suffix.lower() not in suffixes:
        raise UserError(f"{path} has the suffix {path.suffix or '(none)'}, which is not one of {', '.join(suffixes)}; "
                        f"choose one of these for {option}")
    if path.is_dir():
        raise UserError(f"{path} is a folder; name a file in it with {option}")
    _check_ancestors(path.parent, option)
    if not path.parent.is_dir():
        raise UserError(f"the folder {path.parent} of {path.name} does not exist; create it or choose another {option}")
    if path.exists() and not (path.is_file() and os.access(path, os.W_OK)):
        raise UserError(f"{path} exists and must not be written over; choose another {option}")
    # Only an attempt shows it: permission bits do not cover a read-only file system, nor root.
    probe = _beside(path.resolve())
    try:
        probe.open("xb").close()
        probe.unlink()
    except OSError as error:
        raise UserError(f"the folder {path.parent} cannot be written: {error.strerror}; choose another {option}") from error
    return path


def _check_ancestors(folder: Path, option: str) -> None:
    """:class:`UserError` if a file is in the place of ``folder`` or of one above it."""
    for place in (folder, *folder.parents):
        if place.is_dir():
            return
        if place.exists() or place.is_symlink():
            what = "a link that leads nowhere" if place.is_symlink() and not place.exists() else "a file, not a folder"
            raise UserError(f"{place} is {what}; choose another {option}")


def check_folder(path: str | os.PathLike[str], option: str = "--output") -> None:
    """Raise :class:`UserError` unless files can be written into a folder, which need not exist yet and is not made.

    ``option`` is the one that the remedy names.
    """
    path = Path(path)
    _check_ancestors(path, option)
    existing = next((place for place in (path, *path.parents) if place.is_dir()), Path())
    try:
        # By an attempt: permission bits do not show a read-only file system, and root ignores them.
        with tempfile.TemporaryFile(dir=existing):
            pass
    except OSError as error:
        raise UserError(f"the folder {path} cannot be written: {error.strerror}; choose another {option}") from error


@contextlib.contextmanager
def output_folder(path: str | os.PathLike[str], option: str = "--output", wait: bool = False) -> Iterator[Path]:
    """A folder that this process alone writes into during the block, made if it is not there; the path is yielded.

    The lock is on the folder itself and ends with the process, however that ends. Where folders cannot be locked, as on some network file
    systems, there is none.

    Parameters
    ----------
    path : path
        The folder.
    option : str
        The option that the remedy names.
    wait : bool
        Whether to wait for another run that writes there, instead of refusing: for a block that takes no time.

    Raises
    ------
    UserError
        If no file can be written there, or if another run holds the folder.
    """
    path = Path(path)
    check_folder(path, option)
    try:
        path.mkdir(parents=True, exist_ok=True)
        handle = os.open(path, os.O_RDONLY)
    except OSError as error:
        raise UserError(f"the folder {path} cannot be written: {error.strerror}; choose another {option}") from error
    try:
        _lock(handle, path, option, wait)
        yield path
    finally:
        os.close(handle)


def _lock(handle: int, path: Path, option: str, wait: bool) -> None:
    try:
        import fcntl  # of Unix only

        fcntl.flock(handle, fcntl.LOCK_EX | (0 if wait else fcntl.LOCK_NB))
    except BlockingIOError:
        raise UserError(f"the folder {path} is in use by another run; wait for its end, or choose another {option}") from None
    except (ImportError, OSError):
        pass


def remove_stale(folder: Path, manifest: str, keys: Collection[str], written: Collection[str]) -> None:
    """Remove what an earlier run left in ``folder`` and this one has not written: for use before the new manifest is written.

    Parameters
    ----------
    manifest : str
        Name of the JSON file in which a run lists its files, by name, as ``files``.
    keys : collection of str
        What else it holds: without these it is somebody else's file of that name, and nothing is removed.
    written : collection of str
        Names of the files of this run.
    """
    try:
        document = parsed(json.loads, (folder / manifest).read_text(encoding="utf-8"))
        listed = document["files"] if all(key in document for key in keys) else []
        names = [name for name in listed if Path(name).name == name]
    except (OSError, ValueError, KeyError, TypeError):
        return
    for name in {*names} - {*written, manifest}:
        with contextlib.suppress(OSError, ValueError):      # a name may be none that a file can have
            (folder / name).unlink()
