"""Output files that are written whole or not at all."""

import contextlib
import json
import os
from collections.abc import Collection, Iterator
from pathlib import Path
from typing import Any, BinaryIO

from .errors import UserError


__all__ = ["atomic", "check_output", "write_json"]


@contextlib.contextmanager
def atomic(path: str | os.PathLike[str]) -> Iterator[BinaryIO]:
    """A binary file that replaces ``path`` when the block succeeds, and is removed when it raises.

    :class:`UserError` if the folder cannot be written, or the disk is full.
    """
    target = Path(path).resolve()  # a link stays one: its target is replaced
    # Next to the target, because a rename is atomic within one file system only. Not `tempfile`: its files are private (0600).
    temporary = target.with_name(f".{os.getpid()}.{target.name}")
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
    if not path.parent.is_dir():
        raise UserError(f"the folder {path.parent} of {path.name} does not exist; create it or choose another {option}")
    if path.exists() and not (path.is_file() and os.access(path, os.W_OK)):
        raise UserError(f"{path} exists and must not be written over; choose another {option}")
    # Only an attempt shows it: permission bits do not cover a read-only file system, nor root.
    probe = path.resolve().with_name(f".{os.getpid()}.{path.name}")
    try:
        probe.open("xb").close()
        probe.unlink()
    except OSError as error:
        raise UserError(f"the folder {path.parent} cannot be written: {error.strerror}; choose another {option}") from error
    return path
