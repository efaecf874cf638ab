"""Whether a design fits its device: an estimate, before anything is written."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

from rich.table import Table

from golden.config import MatcherConfig, parameters_of, value_of
from golden.errors import UserError
from golden.matcher.parameters import NAMED
from golden.rig.config import RigConfig
from golden.rig.lines import LINES

from .resources.count import Resources
from .resources.devices import Device
from .resources.estimate import LOGIC_ERROR
from .resources.report import ESTIMATED, TITLES


__all__ = ["WARNED", "Figure", "Fit", "cyclone3_fit", "remedies"]


#: A figure above this share of the device, in percent, is warned of: routing is slow there, and the clock lower.
WARNED = 85

#: What is compared with a Cyclone III: memory bits are in blocks.
_CYCLONE3 = {"logic_elements": "logic", "m9k": "memory", "multipliers_9x9": "multipliers"}


def remedies(config: MatcherConfig, rig: RigConfig | None, size: tuple[int, int] | None = None) -> dict[str, str]:
    """What makes a design on a board smaller: kind of figure to the options of ``python -m hdl.build`` that the design leaves.

    ``size`` is the width and height of pictures that the board stores in memory blocks, if they can be chosen.
    """
    smaller = [f"fewer --disparities than {config.labels}"]
    if config.method.name in NAMED:
        smaller.append("other --parameters or another --method")
    if rig is not None:
        smaller += [f"fewer --rectify-lines than {rig.lines}"] * (rig.lines > LINES[0]) + ["--no-rectify"]
    # A method that has a choice of where it multiplies, and has not made it.
    soft = "soft_multipliers" in parameters_of(config.method) and not value_of(config.method, "soft_multipliers")

    def told(options: Sequence[str]) -> str:
        return " or ".join([", ".join(options[:-1]), options[-1]] if len(options) > 1 else options)

    stored = [f"a smaller picture than --width {size[0]} --height {size[1]}"] if size else []
    return {"logic": told(smaller), "memory": told(stored + smaller), "multipliers": "--soft-multipliers" if soft else smaller[0]}


class Figure(NamedTuple):
    """A figure of a design, and of its device.

    Parameters
    ----------
    kind : str
        ``logic``, ``memory`` or ``multipliers``.
    title : str
    estimated : int
    allowance : int
        For what an estimate cannot see.
    capacity : int
        Of the device; 0 is unknown, and nothing is refused for it.
    error : float
        By how much an estimate may be too high, in percent.
    """
    kind: str
    title: str
    estimated: int
    allowance: int
    capacity: int
    error: float = 0

    @property
    def together(self) -> int:
        return self.estimated + self.allowance

    @property
    def share(self) -> float:
        """Percent of the device; 0 if its capacity is unknown."""
        return 100 * self.together / self.capacity if self.capacity else 0


@dataclass(frozen=True)
class Fit:
    """A design beside the device that it is for.

    Parameters
    ----------
    device : str
        Its name.
    figures : sequence of Figure
    allowed_for : str
        What the allowances are for, in words.
    about : sequence of str
        What the figures are.
    manifest : mapping
        The figures for machines.
    """
    device: str
    figures: Sequence[Figure]
    allowed_for: str
    about: Sequence[str]
    manifest: Mapping[str, Any]

    def check(self, smaller: Mapping[str, str]) -> None:
        """Refuse a design that does not fit even if the estimate is as much too high as it can be.

        Parameters
        ----------
        smaller : mapping
            Of :func:`remedies`.

        Raises
        ------
        UserError
            The sentence has the figure, its limit and the remedy.
        """
        for figure in self.figures:
            least = round(figure.estimated / (1 + figure.error / 100)) + figure.allowance
            if 0 < figure.capacity < least:
                at_least = "at least " if figure.error else ""
                included = f", {figure.allowance:,} of them allowed for {self.allowed_for}" if figure.allowance else ""
                raise UserError(f"the design needs {at_least}{least:,} {figure.title}{included}, and an {self.device} has "
                                f"{figure.capacity:,}; choose {smaller[figure.kind]}")

    def warning(self) -> str | None:
        """A sentence on what is above :data:`WARNED` percent; ``None`` if nothing is."""
        high = [f"{figure.share:.1f} % of the {figure.title}" for figure in self.figures if figure.share > WARNED]
        if not high:
            return None
        return f"the design takes {' and '.join(high)} of an {self.device}; above {WARNED} % it may miss its clock, or not be placed"

    def table(self) -> Table:
        """Estimate, allowance and device, a row for each figure."""
        shown = Table(title=f"resources of an {self.device}", title_justify="left")
        shown.add_column("")
        for column in ("design", "allowance", "together", "device", "share"):
            shown.add_column(column, justify="right")
        for figure in self.figures:
            numbers = figure.estimated, figure.allowance, figure.together, figure.capacity
            shown.add_row(figure.title, *(f"{number:,}" for number in numbers), f"{figure.share:.1f} %" if figure.capacity else "-")
        return shown

    def told(self) -> Sequence[str]:
        """What the figures are."""
        allowed = any(figure.allowance for figure in self.figures)
        return [*self.about, f"Allowance: {self.allowed_for}, which neither sees."] if allowed else [*self.about]


#: What the figures of the system with cameras are.
_COUNTED = (ESTIMATED, "Count: python -m hdl.resources --system, in minutes.")


def cyclone3_fit(estimated: Resources, allowance: Resources, allowed_for: str, device: Device,
                 about: Sequence[str] = _COUNTED) -> Fit:
    """A design beside a Cyclone III, or a Cyclone IV, which has the same logic elements, memory blocks and multipliers.

    Parameters
    ----------
    estimated : Resources
        Of :func:`hdl.resources.estimate.estimate`.
    allowance : Resources
        For what an estimate cannot see.
    allowed_for : str
        What that is, in words.
    device : Device
    about : sequence of str
        As of :class:`Fit`.
    """
    figures = [Figure(kind, TITLES[name], getattr(estimated, name), getattr(allowance, name), getattr(device.capacity, name),
                      LOGIC_ERROR if kind == "logic" else 0) for name, kind in _CYCLONE3.items()]
    manifest = {"estimated": estimated._asdict(), "allowance": allowance._asdict(), "device": device.capacity._asdict()}
    return Fit(device.name, figures, allowed_for, about, manifest)
