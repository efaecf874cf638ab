"""A bitstream in a board's folder: what place and route says of it, and whether it is of the same sources as one that is there already."""

import hashlib
import importlib.metadata
import json
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import asdict, dataclass
from pathlib import Path
from typing import Any, NamedTuple

from rich.table import Table

from golden.files import parsed


__all__ = ["Bitstream", "ClockRate", "Placed", "digest", "placed_before"]


class ClockRate(NamedTuple):
    """A clock's name, its frequency in MHz, and the highest one that the placed design allows."""
    name: str
    needed_mhz: float
    reached_mhz: float

    @property
    def met(self) -> bool:
        return self.reached_mhz >= self.needed_mhz


@dataclass(frozen=True)
class Placed:
    """A design that has been placed and routed.

    Parameters
    ----------
    device : str
    files : sequence of str
        Names of the files of the bitstream; the first one is what is loaded.
    logs : sequence of str
        Names of the files in which the tools tell what they did.
    used : mapping
        Kind of cell to the number used and the number that the device has.
    clocks : sequence of ClockRate
    seconds : float
        How long it took.
    """
    device: str
    files: Sequence[str]
    logs: Sequence[str]
    used: Mapping[str, Sequence[int]]
    clocks: Sequence[ClockRate]
    seconds: float

    def table(self) -> Table:
        """The cells beside those of the device."""
        shown = Table(title=f"placed on an {self.device}", title_justify="left")
        shown.add_column("")
        for column in ("used", "device", "share"):
            shown.add_column(column, justify="right")
        for kind, (used, available) in self.used.items():
            shown.add_row(kind, f"{used:,}", f"{available:,}", f"{100 * used / available:.1f} %")
        return shown

    def told(self) -> list[str]:
        """A line for each clock, and one for the time."""
        return [*(f"Clock {clock.name}: {clock.needed_mhz:g} MHz needed, {clock.reached_mhz:.1f} MHz reached." for clock in self.clocks),
                f"It took {self.seconds / 60:.1f} minutes; logs: {', '.join(self.logs)}"]

    def missed(self) -> str | None:
        """A sentence on the clocks that are missed; ``None`` if all are met."""
        slow = [f"the clock {name} reaches {reached:.1f} MHz, {needed - reached:.1f} less than its {needed:g}"
                for name, needed, reached in (clock for clock in self.clocks if not clock.met)]
        return f"timing is not met: {', '.join(slow)}; choose a lower --clock, or fewer --disparities" if slow else None

    def about(self, sources: str) -> dict[str, Any]:
        """The entry of the manifest; ``sources`` is the :func:`digest` of what it was made of."""
        return {"sources": sources, **asdict(self), "clocks": [clock._asdict() for clock in self.clocks]}


@dataclass(frozen=True)
class Bitstream:
    """A bitstream: the contents of :attr:`Placed.files`, by name."""
    placed: Placed
    contents: Mapping[str, bytes]


def digest(files: Mapping[str, str], packages: Iterable[str]) -> str:
    """A number of 64 digits that differs if any file does, or the version of a Python package that makes the bitstream."""
    versions = {package: importlib.metadata.version(package) for package in packages}
    return hashlib.sha256(json.dumps([versions, files], sort_keys=True).encode()).hexdigest()


def placed_before(folder: Path, manifest: str, sources: str) -> Placed | None:
    """What an earlier run told of the bitstream in ``folder``, if it is there and was made of the same sources; ``None`` otherwise."""
    try:
        entry = parsed(json.loads, (folder / manifest).read_text(encoding="utf-8"))["bitstream"]
        if entry.pop("sources") != sources:
            return None
        placed = Placed(**{**entry, "clocks": [ClockRate(**clock) for clock in entry["clocks"]]})
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None
    return placed if all((folder / name).is_file() for name in placed.files) else None
