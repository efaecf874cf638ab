"""The points of a design's Verilog that Verilator counts, from the files that its runs leave."""

import hashlib
import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import NamedTuple


__all__ = ["KINDS", "Point", "covered", "is_control", "measured", "modules", "text_of"]


#: What is measured: lines with a statement, the two ways of each ``if`` and each ``?:``, the two directions of each control signal.
KINDS = ("line", "branch", "toggle")

_RECORD = re.compile(r"C '(.*)' (\d+)")
# Signals of one bit are control, and so are the states of state machines, but not what Yosys made: intermediate results, and registers of
# single bits of a word.
_TEMPORARY = re.compile(r"_\d+_+|\w+_reg_\d+_")
_NUMBER = re.compile(r"\b_\d+_+(?!\w)")
_MODULE = re.compile(r"(?m)^module (\w+)")
_STATE = re.compile(r"fsm_state(_\d+)?\[\d+\]")


class Point(NamedTuple):
    """A place in the Verilog. ``what``: which way of a branch, or which signal and direction; with the column it tells points apart."""
    module: str
    kind: str
    line: int
    column: int
    what: str


def is_control(signal: str) -> bool:
    """Whether a signal, or a bit of one, is control and no data.

    Examples
    --------
    >>> [is_control(name) for name in ("valid", "fsm_state[1]", "label[1]", "_012_", "word_reg_38_")]
    [True, True, False, False, False]
    """
    return _STATE.fullmatch(signal) is not None or ("[" not in signal and not _TEMPORARY.fullmatch(signal))


def covered(files: Iterable[Path]) -> Counter[Point]:
    """How often each point of the first source was passed, in all runs together; 0 for a point that no run has passed.

    Parameters
    ----------
    files : iterable of path
        Of runs of one design, as :data:`sim.kit.simulators.COVERAGE` has them. Data signals are left out.
    """
    counts: Counter[Point] = Counter()
    for path in files:
        for record in path.read_text(encoding="latin1").splitlines():
            if not (found := _RECORD.fullmatch(record)):
                continue
            fields = dict(field.split("\2", 1) for field in found[1].split("\1") if field)
            kind, _, module = fields["page"].removeprefix("v_").partition("/")
            # Sources are numbered; what is around the design has further files.
            if not fields["f"].startswith("0_"):
                continue
            if kind not in KINDS:
                raise ValueError(f"{path} has points of the kind {kind}, which is unknown")
            if kind == "toggle" and not is_control(fields["o"].partition(":")[0]):
                continue
            counts[Point(module, kind, int(fields["l"]), int(fields["n"]), fields["o"])] += int(found[2])
    return counts


def measured(counts: Mapping[Point, int], module: str, kind: str) -> list[tuple[Point, bool]]:
    """Points of a module and kind in the order of the text, and whether they are covered. A line has one: if each of its statements is."""
    found = {point: count > 0 for point, count in sorted(counts.items()) if (point.module, point.kind) == (module, kind)}
    if kind != "line":
        return list(found.items())
    lines: dict[Point, bool] = {}
    for point, hit in found.items():
        line = point._replace(column=0, what="")
        lines[line] = lines.get(line, True) and hit
    return list(lines.items())


def text_of(point: Point, source: Sequence[str]) -> str:
    """What a point is, in words that do not depend on the numbers that Yosys gives: for an explanation.

    Examples
    --------
    >>> text_of(Point("top", "branch", 1, 15, "cond_then"), ["  assign _12_ = clear ? 1'h0 : _013_;"])
    "cond_then: assign _ = clear ? 1'h0 : _;"
    """
    if point.kind == "toggle":
        return point.what
    text = source[point.line - 1].strip()
    if text == "default:":
        text += f" {_default(point.line, source)}"
    elif text.endswith(":"):
        text += f" {source[point.line].strip()}"
    return (f"{point.what}: " if point.what else "") + _NUMBER.sub("_", text)


def _default(line: int, source: Sequence[str]) -> str:
    """What a ``casez`` of Yosys gives by default: the first argument of the function that holds it, behind which is its one call."""
    call = next((text for text in source[line:] if text.lstrip().startswith("assign ")), "")
    found = re.search(r"= _\d+_\(([^,]+), ", call)
    return found[1] if found else ""


def modules(source: Sequence[str]) -> dict[str, str]:
    """A digest of each module by its name: equal for modules whose text differs by numbers of names and by names of modules only."""
    text = "\n".join(source)
    names = re.compile(rf"\b(?:{'|'.join(sorted(_MODULE.findall(text), key=len, reverse=True))})\b")
    parts = re.split(r"(?m)^(?=module )", text)[1:]
    plain = {_MODULE.findall(part)[0]: re.sub(r"_\d+\b", "_", _NUMBER.sub("_", names.sub("M", part))) for part in parts}
    return {name: hashlib.sha256(part.encode()).hexdigest()[:12] for name, part in plain.items()}
