"""The refinement of labels, and what the methods have in common whose labels are refined."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass, replace
from typing import Any, ClassVar

from .limits import MINIMUM_BITS, Arithmetic, Engine, Setting, check_limits


__all__ = ["CONFIDENCE_BITS", "RefinedLabels", "Refinement"]


#: Bits of a result's confidence.
CONFIDENCE_BITS = 4


@dataclass(frozen=True)
class Refinement:
    """Stages after the labelling. A stage that is off passes its input on.

    Parameters
    ----------
    check : bool
        Left-right check; off, every pixel passes.
    fill : bool
        Pixels that fail the check are given a disparity from their scanline.
    median : bool
        Median of the disparities.
    sub_pixel : bool
        Disparities get three fraction bits between check and fill.
    tolerance : int
        Largest difference of left and right view that passes the check, pixels, ``0..7``.
    median_size : int
        Side of the median's window, pixels; 3 or 5.
    """
    check: bool = True
    fill: bool = True
    median: bool = True
    sub_pixel: bool = False
    tolerance: int = 1
    median_size: int = 5

    LIMITS: ClassVar[Mapping[str, range]] = {"tolerance": range(8), "median_size": range(3, 6, 2)}
    #: Whether it needs the left grey level of every label.
    USES_GREY: ClassVar[bool] = False
    SWITCHES: ClassVar[Mapping[str, str]] = {
        "check": "left-right check", "fill": "fill of the pixels that fail the check", "median": "median of the disparities"}

    def __post_init__(self) -> None:
        check_limits(asdict(self), self.LIMITS)


class RefinedLabels:
    """Of a method with a fused ``cost`` whose labels are checked and refined: its engine, the fields of its results, some settings."""
    cost: Any
    refinement: Any

    SWITCHES: ClassVar[Mapping[str, str]] = Refinement.SWITCHES

    @property
    def arithmetic(self) -> Arithmetic:
        """The matching cost is that of ``LINEAR``."""
        return Arithmetic.LINEAR

    @property
    def engines(self) -> tuple[Engine, ...]:
        """The streaming engine only."""
        return (Engine.STREAMING,)

    @property
    def cost_max(self) -> int:
        """Largest cost ``C`` of a candidate."""
        return int(self.cost.maximum)

    @property
    def disparity_scale(self) -> int:
        """Units of a disparity a pixel: 8 with sub-pixel disparities, three fraction bits."""
        return 8 if self.refinement.sub_pixel else 1

    def result_fields(self, labels: int, minimum: int) -> Mapping[str, int]:
        """Fields of a result, and their bits: the disparity at the greatest least disparity that may be set, with a sign if ``minimum``,
        which was built in, is below 0."""
        greatest = (labels - 1 + 2**MINIMUM_BITS) * self.disparity_scale - 1
        return {"disparity": greatest.bit_length() + (minimum < 0), "passed": 1, "confidence": CONFIDENCE_BITS}

    def refinement_settings(self, minimum: int) -> dict[str, Setting]:
        """The least disparity, and the switches of the refinement."""
        switches = {name: Setting(1, int(getattr(self.refinement, name)), what) for name, what in self.SWITCHES.items()}
        return {"minimum": Setting(2**MINIMUM_BITS - 1, minimum, "least disparity", min(minimum, 0), "pixels"), **switches}

    def refinement_with(self, values: Mapping[str, int]) -> Any:
        """The refinement with those switches."""
        return replace(self.refinement, **{name: bool(values[name]) for name in self.SWITCHES if name in values})
