"""Results of a long run, a line of JSON each, so that a run that was ended goes on where it was."""

import json
from pathlib import Path
from types import TracebackType
from typing import Any, Self

from golden.errors import UserError


__all__ = ["Journal"]


class Journal:
    """Results by the keys of their cases, kept in a file from the moment that they are known.

    Parameters
    ----------
    path : Path
        The file; made if it does not exist, with its folder.
    sources : str
        Digest of what the results depend on beside their cases. Results of other sources are no results.
    restart : bool
        Discard what is there.

    Raises
    ------
    UserError
        If the file was begun with other sources, or cannot be read or written.

    Members
    -------
    results : dict
        Those so far.
    """
    def __init__(self, path: Path, sources: str, *, restart: bool = False):
        self.path = path
        self.results: dict[str, Any] = {}
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            if restart:
                path.unlink(missing_ok=True)
            whole = self._read(path.read_bytes() if path.exists() else b"", sources)
            self._file = path.open("r+b" if path.exists() else "xb")
            self._file.truncate(whole)      # a line that a killed run began
            self._file.seek(whole)
            if not whole:
                self._write({"sources": sources})
        except OSError as error:
            raise UserError(f"cannot keep results in {path}: {error.strerror or error}; choose another folder with --work") from error

    def _read(self, contents: bytes, sources: str) -> int:
        """Take over the whole lines of a file; their length in bytes."""
        whole = contents[:contents.rfind(b"\n") + 1]
        if not whole:
            return 0
        try:
            head, *entries = (json.loads(line) for line in whole.splitlines())
            begun_with = head["sources"]
            self.results = {entry["case"]: entry["result"] for entry in entries}
        except (ValueError, KeyError, TypeError) as error:
            raise UserError(f"{self.path} is no journal of results; remove it, or say --restart") from error
        if begun_with != sources:
            raise UserError(f"{self.path} has results of other sources ({begun_with}, now {sources}); say --restart to begin again")
        return len(whole)

    def _write(self, entry: Any) -> None:
        self._file.write(f"{json.dumps(entry)}\n".encode())
        self._file.flush()

    def add(self, case: str, result: Any) -> None:
        """Keep a result, of values that JSON has."""
        self._write({"case": case, "result": result})
        self.results[case] = result

    def __enter__(self) -> Self:
        return self

    def __exit__(self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None) -> None:
        self._file.close()
