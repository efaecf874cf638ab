"""Holes that are explained, each in a line: a hole that no entry explains is open, and an entry that explains none is an error."""

import re
from collections.abc import Mapping, Sequence
from typing import Any, NamedTuple

from .coverage.measure import either
from .coverage_explained import EXPLAINED, Explained


__all__ = ["Hole", "Judged", "holes_of", "judge", "merged"]


class Hole(NamedTuple):
    """A point that no run has covered: its design, the class of the gateware, its kind and text, module and line of the Verilog."""
    design: str
    origin: str
    kind: str
    text: str
    module: str
    line: int


class Judged(NamedTuple):
    """Holes that are explained, by the number of the entry; those that are not; and entries that explain nothing."""
    explained: dict[int, list[Hole]]
    open: list[Hole]
    useless: list[Explained]


def merged(results: Mapping[str, Mapping[str, Any]]) -> dict[str, dict[str, str]]:
    """Modules of all designs, as of :func:`sim.verify.coverage.measure.measure`: one that is in several is covered where it is in any."""
    found: dict[str, dict[str, str]] = {}
    for result in results.values():
        for key, kinds in result["modules"].items():
            before = found.setdefault(key, dict(kinds))
            found[key] = {kind: either(before[kind], bits) for kind, bits in kinds.items()}
    return found


def holes_of(results: Mapping[str, Mapping[str, Any]]) -> list[Hole]:
    """Holes of all designs, each once."""
    modules = merged(results)
    holes: dict[tuple[str, str, int], Hole] = {}
    for design, result in results.items():
        for key, kind, place, text, module, line in result["holes"]:
            if modules[key][kind][place] == "0":
                holes.setdefault((key, kind, place), Hole(design, key.partition(" ")[0], kind, text, module, line))
    return list(holes.values())


def judge(holes: Sequence[Hole], entries: Sequence[Explained] = EXPLAINED) -> Judged:
    """Sort holes by the first entry that explains them.

    Examples
    --------
    >>> entry = Explained("toggle", "hdl.parts.uart.Receiver", r"break_.*", "no bench sends a break")
    >>> holes = [Hole("loop", "hdl.parts.uart.Receiver", "toggle", text, "loop_uart", 7) for text in ("break_:0->1", "busy:0->1")]
    >>> judged = judge(holes, [entry, entry])
    >>> [hole.text for hole in judged.explained[0]], [hole.text for hole in judged.open], len(judged.useless)
    (['break_:0->1'], ['busy:0->1'], 1)
    """
    explained: dict[int, list[Hole]] = {}
    unexplained = []
    for hole in holes:
        found = next((number for number, entry in enumerate(entries) if _explains(entry, hole)), None)
        if found is None:
            unexplained.append(hole)
        else:
            explained.setdefault(found, []).append(hole)
    return Judged(explained, unexplained, [entry for number, entry in enumerate(entries) if number not in explained])


def _explains(entry: Explained, hole: Hole) -> bool:
    fields = ((entry.kind, hole.kind), (entry.origin, hole.origin), (entry.text, hole.text), (entry.design, hole.design))
    return all(re.fullmatch(pattern, text) for pattern, text in fields)
