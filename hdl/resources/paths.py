"""The slowest paths of a placed and routed design, by classes: paths between registers whose names differ only in numbers.

The place and route tool names one path, the slowest. Those behind it that matter are often hundreds alike, one a label. Its file of delays
(SDF) has what is needed to find them: every connection, and every cell's delays and set-up times.
"""

import re
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from graphlib import TopologicalSorter
from typing import NamedTuple


__all__ = ["PathClass", "class_of", "path_classes"]


@dataclass(frozen=True)
class PathClass:
    """Paths from ``begin`` to ``end``, names of registers or memories with ``*`` in place of numbers.

    ``logic`` and ``routing``: of the slowest one, ns; its set-up time is logic. ``ends``: inputs of registers whose slowest path is one of
    these.
    """
    begin: str
    end: str
    logic: float
    routing: float
    ends: int

    @property
    def delay(self) -> float:
        """Of the slowest path, ns."""
        return self.logic + self.routing


class _Arrival(NamedTuple):
    """The latest signal at a pin: ns since the clock, those in logic, and the cell that it began at."""
    delay: float
    logic: float
    begin: str


def class_of(name: str) -> str:
    """A name without what tells labels apart.

    Examples
    --------
    >>> class_of("engine.array.up_12.energy"), class_of("transition_2")
    ('engine.array.up_*.energy', 'transition_*')
    """
    return re.sub(r"_\d+", "_*", name)


_DELAYS = r"\([^:]*:[^:]*:([^:]*)\)"
_WIRE = re.compile(rf"\(INTERCONNECT (\S+) (\S+) {_DELAYS}")
_INSTANCE = re.compile(r"\(INSTANCE (\S+)\)")
_THROUGH = re.compile(rf"\(IOPATH (\S+) (\S+) {_DELAYS}")
_SETUP = re.compile(rf"\(SETUPHOLD \(posedge (\S+)\) \(\w+ (\S+)\) {_DELAYS}")
_CLOCK = re.compile(r"W?CL?K[A-Z]?\d*$")  # a clock input: a path begins with the delay from it to an output


class _Delays:
    """Delays of a file, in ns: pin to its sources, each with the delay from there; a pin is (cell, port)."""
    def __init__(self, lines: Iterable[str]):
        self.before: dict[tuple[str, str], list[tuple[tuple[str, str], float]]] = {}
        self.setup: dict[tuple[str, str], float] = {}
        self.wires: set[tuple[str, str]] = set()
        cell = ""
        for line in lines:
            text = line.replace("\\", "")
            if match := _WIRE.search(text):
                begin, end = (tuple(pin.rsplit("/", 1)) for pin in match.groups()[:2])
                self.before[end] = [(begin, float(match[3]) / 1000)]  # type: ignore[index,list-item]
                self.wires.add(end)  # type: ignore[arg-type]
            elif match := _INSTANCE.search(text):
                cell = match[1]
            elif match := _THROUGH.search(text):
                self.before.setdefault((cell, match[2]), []).append(((cell, match[1]), float(match[3]) / 1000))
            elif match := _SETUP.search(text):
                self.setup[cell, match[1]] = float(match[3]) / 1000

    def arrivals(self) -> dict[tuple[str, str], _Arrival]:
        """The latest signal at each pin that a clock leads to."""
        graph = {pin: [source for source, _ in sources if not _CLOCK.match(source[1])] for pin, sources in self.before.items()}
        found: dict[tuple[str, str], _Arrival] = {}
        for pin in TopologicalSorter(graph).static_order():
            of_wire = pin in self.wires
            for source, delay in self.before.get(pin, ()):
                at = _Arrival(0, 0, source[0]) if _CLOCK.match(source[1]) else found.get(source)
                if at and (pin not in found or at.delay + delay > found[pin].delay):
                    found[pin] = _Arrival(at.delay + delay, at.logic + (0 if of_wire else delay), at.begin)
        return found


def path_classes(lines: Iterable[str], our_name: Callable[[str], str] = str) -> Iterator[PathClass]:
    """Classes of the paths between registers, the slowest first.

    Parameters
    ----------
    lines : iterable of str
        Of a file of delays (SDF) of nextpnr.
    our_name : callable
        Name of a cell to that of the source; a cell without one keeps its own.
    """
    delays = _Delays(lines)
    worst: dict[tuple[str, str], tuple[float, float]] = {}
    ends: dict[tuple[str, str], int] = {}
    arrivals = delays.arrivals()
    for pin, setup in delays.setup.items():
        if at := arrivals.get(pin):
            begin, end = (class_of(our_name(cell) or cell) for cell in (at.begin, pin[0]))
            worst[begin, end] = max(worst.get((begin, end), (0, 0)), (at.delay + setup, at.logic + setup))
            ends[begin, end] = ends.get((begin, end), 0) + 1
    for names, (delay, logic) in sorted(worst.items(), key=lambda item: -item[1][0]):
        yield PathClass(*names, logic, delay - logic, ends[names])
