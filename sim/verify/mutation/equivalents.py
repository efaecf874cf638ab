"""Mutants that compute the same as the file itself, each with its reason: ``equivalents.toml``."""

import tomllib
from collections.abc import Iterable, Sequence
from pathlib import Path
from typing import NamedTuple

from golden.errors import UserError

from .mutants import Mutant


__all__ = ["Equivalents", "LIST"]


LIST = Path(__file__).with_name("equivalents.toml")


class _Entry(NamedTuple):
    file: str
    operator: str
    was: str
    now: str


class Equivalents:
    """A list in TOML: tables ``[[mutant]]`` with ``file``, ``operator``, the line ``was`` and ``now``, and the ``reason``."""
    def __init__(self, path: Path = LIST):
        self.path = path
        self._reasons: dict[_Entry, str] = {}
        try:
            entries = tomllib.loads(path.read_text(encoding="utf-8")).get("mutant", [])
            for entry in entries:
                reason = entry.pop("reason")
                key = _Entry(**entry)
                if not reason.strip() or "\n" in reason or key in self._reasons:
                    raise UserError(f"{path}: the mutant {key.now!r} of {key.file} needs one entry with a reason of one line")
                self._reasons[key] = reason
        except (OSError, ValueError, KeyError, TypeError) as error:
            raise UserError(f"{path} is no list of equivalent mutants ({error}); mend it") from error

    def __len__(self) -> int:
        return len(self._reasons)

    @property
    def files(self) -> set[str]:
        """Files of which there are entries."""
        return {key.file for key in self._reasons}

    def reason(self, mutant: Mutant) -> str | None:
        """Why a mutant is equivalent; ``None`` if the list does not have it."""
        return self._reasons.get(_Entry(mutant.file, mutant.operator, mutant.was, mutant.shown))

    def check(self, mutants: Iterable[Mutant]) -> None:
        """Raise :class:`UserError` if an entry is of none of ``mutants``, all those of the project."""
        left = set(self._reasons) - {_Entry(mutant.file, mutant.operator, mutant.was, mutant.shown) for mutant in mutants}
        if left:
            raise UserError(self._stale(sorted(left)))

    def _stale(self, left: Sequence[_Entry]) -> str:
        return f"{self.path} has {len(left)} entries of no mutant, the first {left[0].now!r} of {left[0].file}; remove or mend them"
