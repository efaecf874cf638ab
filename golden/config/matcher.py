"""The configuration of a matcher: its size, its engine and its method."""

from collections.abc import Mapping
from dataclasses import dataclass, replace
from typing import Any, ClassVar, TypeVar, cast

from .limits import IN_USE_BITS, LEAST_MINIMUM, MINIMUM_BITS, Engine, MatchingCost, Setting, Weights, check_limits
from .method import Method, RefinedMethod, RuleMethod
from .one_pass import OnePass


__all__ = ["MatcherConfig"]


M = TypeVar("M")


@dataclass(frozen=True)
class MatcherConfig:
    """Size, engine and method of a matcher. The parameters of the method are in ``method``, so that none is given that it ignores.

    Parameters
    ----------
    labels : int
        Number of labels ``D``; disparities are ``minimum .. minimum + D-1`` pixels.
    max_width : int
        Longest line, in pixels, that the gateware's memories hold.
    minimum : int
        Least disparity ``m``, pixels: label ``l`` is the disparity ``m + l``. Below 0 for cameras that converge; gateware built with
        such a value takes any from there on as a setting, other gateware from 0 on.
    in_use : int or None
        Labels in use, ``0 .. in_use - 1``: those above have the cost of a candidate outside the picture. ``None``: all. Build-time default
        of the gateware's input.
    engine : Engine or None
        Which gateware; ``None`` becomes the first of the method's.
    method : Method
        One of :data:`golden.config.METHODS`, with its parameters.
    """
    labels: int = 80
    max_width: int = 720
    minimum: int = 0
    in_use: int | None = None
    engine: Engine | None = None
    method: Method = OnePass()

    LABELS: ClassVar[range] = range(2, 257)
    SEQUENTIAL_LABELS: ClassVar[range] = range(2, 129)
    WIDTHS: ClassVar[range] = range(1, 4097)
    MINIMUMS: ClassVar[range] = range(LEAST_MINIMUM, 2**MINIMUM_BITS)

    def __post_init__(self) -> None:
        check_limits(vars(self), {"labels": self.LABELS, "max_width": self.WIDTHS, "minimum": self.MINIMUMS})
        if self.in_use is not None:
            check_limits({"in_use": self.in_use}, {"in_use": range(1, self.labels + 1)})
        engines = self.method.engines
        if self.engine is None:
            object.__setattr__(self, "engine", engines[0] if engines else None)
        elif not engines:
            raise ValueError(f"engine {self.engine} does not compute the method {self.method.name}, which has no gateware; leave it out")
        elif Engine(self.engine) in engines:
            object.__setattr__(self, "engine", Engine(self.engine))
        else:
            raise ValueError(f"engine {self.engine} does not compute the method {self.method.name} in the arithmetic "
                             f"{self.method.arithmetic}; choose {' or '.join(engines)}")

    def method_as(self, kind: type[M]) -> M:
        """The method, which must be of this class; :class:`ValueError` if it is another."""
        if not isinstance(self.method, kind):
            raise ValueError(f"the method must be {kind.name}, not {self.method.name}")  # type: ignore[attr-defined]
        return cast(M, self.method)

    @property
    def rule(self) -> RuleMethod:
        """The method, which must label by the disparity rule; :class:`ValueError` if it does not."""
        if not hasattr(self.method, "weights"):
            raise ValueError(f"the method must label by the disparity rule, and {self.method.name} does not")
        return cast(RuleMethod, self.method)

    @property
    def refined(self) -> RefinedMethod:
        """The method, whose labels must be refined; :class:`ValueError` if they are not."""
        if not hasattr(self.method, "refinement"):
            raise ValueError(f"the method must refine its labels, and {self.method.name} does not")
        return cast(RefinedMethod, self.method)

    @property
    def matching_cost(self) -> MatchingCost:
        """Widths of the matching cost."""
        return MatchingCost(self.method.arithmetic)

    @property
    def lead(self) -> int:
        """Columns by which the right picture is ahead of the left one, so that negative disparities can be compared."""
        return max(-self.minimum, 0)

    @property
    def line_width(self) -> int:
        """Columns of the longest line with its :attr:`lead`."""
        return self.max_width + self.lead

    @property
    def labels_in_use(self) -> int:
        """Number of labels that may be chosen freely."""
        return self.labels if self.in_use is None else self.in_use

    @property
    def smooth_max(self) -> int:
        """Largest smoothness term: the labels ``0`` and ``D-1`` side by side in equal pixels."""
        return self.rule.smooth_step_max * (self.labels - 1)

    @property
    def data_bits(self) -> int:
        """Bits of a data term."""
        return self.method.data_max.bit_length()

    @property
    def energy_max(self) -> int:
        """Largest energy that the rule compares."""
        return (self.method.data_max << self.rule.energy_shift) + 3 * self.smooth_max

    @property
    def energy_bits(self) -> int:
        """Bits of an energy."""
        return self.energy_max.bit_length()

    @property
    def result_fields(self) -> Mapping[str, int]:
        """Fields of a result, ``disparity`` first, and their bits."""
        return self.method.result_fields(self.labels, self.minimum)

    @property
    def settings(self) -> Mapping[str, Setting]:
        """What the host may set from frame to frame, by name: the labels in use, and the settings of the method."""
        in_use = Setting(2**IN_USE_BITS - 1, self.labels_in_use, "labels in use: disparities from 0 to one less", 1, "labels")
        settings = dict(self.method.settings(self.minimum))
        weights = {name: settings.pop(name) for name in Weights._fields if name in settings}
        return {**weights, "in_use": in_use, **settings}

    @property
    def defaults(self) -> dict[str, int]:
        """Values of the settings until they are set."""
        return {name: setting.default for name, setting in self.settings.items()}

    def with_settings(self, values: Mapping[str, int]) -> "MatcherConfig":
        """The configuration that this matcher has once ``values`` are set, for the golden model; the others keep their default."""
        given: dict[str, Any] = {name: values[name] for name in ("in_use", "minimum") if name in values}
        return replace(self, **given, method=self.method.with_settings(values))
