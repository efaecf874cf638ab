"""Whether a design fits its device: an estimate, before anything is written."""

from collections.abc import Sequence
from dataclasses import dataclass

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


__all__ = ["WARNED", "Fit", "remedies"]


#: A figure above this share of the device, in percent, is warned of: routing is slow there, and the clock lower.
WARNED = 85

#: What is compared with the device: memory bits are in blocks.
_FIGURES = ("logic_elements", "m9k", "multipliers_9x9")
_WITHIN = {"logic_elements": LOGIC_ERROR}


def remedies(config: MatcherConfig, rig: RigConfig | None) -> dict[str, str]:
    """What makes a design on a board smaller: figure to the options of ``python -m hdl.build`` that the design leaves."""
    smaller = [f"fewer --disparities than {config.labels}"]
    if config.method.name in NAMED:
        smaller.append("other --parameters or another --method")
    if rig is not None:
        smaller += [f"fewer --rectify-lines than {rig.lines}"] * (rig.lines > LINES[0]) + ["--no-rectify"]
    # A method that has a choice of where it multiplies, and has not made it.
    soft = "soft_multipliers" in parameters_of(config.method) and not value_of(config.method, "soft_multipliers")
    told = " or ".join([", ".join(smaller[:-1]), smaller[-1]] if len(smaller) > 1 else smaller)
    return {"logic_elements": told, "m9k": told, "multipliers_9x9": "--soft-multipliers" if soft else smaller[0]}


@dataclass(frozen=True)
class Fit:
    """A design beside the device that it is for.

    Parameters
    ----------
    estimated : Resources
        Of :func:`hdl.resources.estimate.estimate`.
    allowance : Resources
        For what an estimate cannot see.
    allowed_for : str
        What that is, in words.
    device : Device
        A capacity of 0 is unknown, and nothing is refused for it.
    """
    estimated: Resources
    allowance: Resources
    allowed_for: str
    device: Device

    def _figures(self, figure: str) -> tuple[int, int, int]:
        """Estimate, allowance, capacity."""
        estimated, allowance, capacity = (getattr(part, figure) for part in (self.estimated, self.allowance, self.device.capacity))
        return estimated, allowance, capacity

    def check(self, smaller: dict[str, str]) -> None:
        """Refuse a design that does not fit even if the estimate is as much too high as it can be.

        Parameters
        ----------
        smaller : dict
            Of :func:`remedies`.

        Raises
        ------
        UserError
            The sentence has the figure, its limit and the remedy.
        """
        for figure in _FIGURES:
            estimated, allowance, capacity = self._figures(figure)
            least = round(estimated / (1 + _WITHIN.get(figure, 0) / 100)) + allowance
            if 0 < capacity < least:
                at_least = "at least " if figure in _WITHIN else ""
                included = f", {allowance:,} of them allowed for {self.allowed_for}" if allowance else ""
                raise UserError(f"the design needs {at_least}{least:,} {TITLES[figure]}{included}, and an {self.device.name} has "
                                f"{capacity:,}; choose {smaller[figure]}")

    def warning(self) -> str | None:
        """A sentence on what is above :data:`WARNED` percent; ``None`` if nothing is."""
        shares = {figure: 100 * (estimated + allowance) / capacity for figure in _FIGURES
                  for estimated, allowance, capacity in [self._figures(figure)] if capacity}
        high = [f"{share:.1f} % of the {TITLES[figure]}" for figure, share in shares.items() if share > WARNED]
        if not high:
            return None
        return f"the design takes {' and '.join(high)} of an {self.device.name}; above {WARNED} % it may miss its clock, or not be placed"

    def table(self) -> Table:
        """Estimate, allowance and device, a row for each figure."""
        shown = Table(title=f"resources of an {self.device.name}", title_justify="left")
        shown.add_column("")
        for column in ("design", "allowance", "together", "device", "share"):
            shown.add_column(column, justify="right")
        for figure in _FIGURES:
            estimated, allowance, capacity = self._figures(figure)
            together = estimated + allowance
            share = f"{100 * together / capacity:.1f} %" if capacity else "-"
            shown.add_row(TITLES[figure], *(f"{number:,}" for number in (estimated, allowance, together, capacity)), share)
        return shown

    def told(self) -> Sequence[str]:
        """What the figures are."""
        lines = [ESTIMATED, "Count: python -m hdl.resources --system, in minutes."]
        return [*lines, f"Allowance: {self.allowed_for}, which neither sees."] if any(self.allowance) else lines
