"""Mutants of a source file: where a change can be made, and the text with it made."""

import hashlib
from collections.abc import Iterable, Iterator
from typing import NamedTuple

from .operators import OPERATORS
from .places import Places


__all__ = ["Mutant", "draw", "mutants_of"]


class Mutant(NamedTuple):
    """A file with one change.

    Members
    -------
    file : str
        Path from the project's root.
    operator : str
        Kind of the change, of :data:`sim.verify.mutation.operators.OPERATORS`.
    start, end : int
        Bytes of the file that are replaced.
    new : str
        What replaces them.
    line : int
        Number of the line where they begin.
    was, shown : str
        That line, or these lines in one, before the change and with it.
    lines : tuple of int
        First and last line of the statement, or of the head of a compound one.
    function : bool
        The change is within a function, and not executed when the module is imported.
    """
    file: str
    operator: str
    start: int
    end: int
    new: str
    line: int
    was: str
    shown: str
    lines: tuple[int, int]
    function: bool

    def apply(self, source: bytes) -> bytes:
        """The file with the change."""
        return source[:self.start] + self.new.encode() + source[self.end:]

    def key(self, contents: str) -> str:
        """Of the journal: the mutant and the file that it was made of, whose digest is ``contents``."""
        return f"{self.file}@{contents}:{self.start}-{self.end}:{self.operator}:{self.new}"


def mutants_of(file: str, source: bytes) -> list[Mutant]:
    """All mutants of a source file, in the order of their places."""
    places = Places(source)
    found: dict[tuple[int, int, str], Mutant] = {}
    for place in places.walk():
        for operator, change in OPERATORS.items():
            for start, end, new in change(places, place):
                found.setdefault((start, end, new), Mutant(
                    file, operator, start, end, new, source.count(b"\n", 0, start) + 1, _line(source, start, end),
                    _line(source, start, end, new), place.lines, place.in_function))
    return sorted(found.values(), key=lambda mutant: (mutant.start, mutant.end, mutant.new))


def _line(source: bytes, start: int, end: int, new: str | None = None) -> str:
    """The line, or the lines in one, around a part of a file, perhaps with another part in its place."""
    first = source.rfind(b"\n", 0, start) + 1
    last = source.find(b"\n", end)
    part = source[start:end] if new is None else new.encode()
    whole = source[first:start] + part + source[end:None if last < 0 else last]
    return " ".join(whole.decode().split())


def _rank(seed: int, mutant: Mutant) -> bytes:
    """A random number that an edit elsewhere in the file does not change."""
    identity = f"{seed} {mutant.file} {mutant.operator} {mutant.was} {mutant.shown}"
    return hashlib.sha256(identity.encode()).digest()


def draw(mutants: Iterable[Mutant], seed: int) -> Iterator[Mutant]:
    """Mutants in a random order of which each beginning is a fair sample: of each room (a folder), its share.

    The first of each room come first.
    """
    rooms: dict[str, list[Mutant]] = {}
    for mutant in mutants:
        rooms.setdefault(mutant.file.rpartition("/")[0], []).append(mutant)
    placed = []
    for room, members in rooms.items():
        members.sort(key=lambda mutant: (_rank(seed, mutant), mutant.start))
        placed += [(number / len(members), room, number) for number in range(len(members))]
    for _, room, number in sorted(placed):
        yield rooms[room][number]
