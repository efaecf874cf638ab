"""The interface of a method, and its parameters by name."""

import dataclasses
from collections.abc import Mapping
from typing import Any, ClassVar, Protocol, TypeVar

from .fused import FusedCost
from .limits import Arithmetic, Engine, Setting, Weights
from .refinement import Refinement


__all__ = ["Method", "RefinedMethod", "RuleMethod", "changed", "parameters_of", "value_of"]


class Method(Protocol):
    """A way from two pictures to disparities: its parameters, as a frozen dataclass, and what follows from them.

    A method's golden functions are found by its class in :mod:`golden.matcher.matcher`, its gateware in ``hdl.matcher.methods``. All
    parameters have defaults: of a method that is named only, they are used.
    """
    name: ClassVar[str]
    #: What it does, in a few words for the help of the command lines.
    ABOUT: ClassVar[str]
    #: Those of its parameters that switch a stage on or off, and what the stage is.
    SWITCHES: ClassVar[Mapping[str, str]]

    @property
    def arithmetic(self) -> Arithmetic:
        """Number formats of the matching cost."""

    @property
    def engines(self) -> tuple[Engine, ...]:
        """Engines that compute it, the default first."""

    @property
    def data_max(self) -> int:
        """Largest data term of a label."""

    @property
    def disparity_scale(self) -> int:
        """Units of a disparity a pixel."""

    def result_fields(self, labels: int, minimum: int) -> Mapping[str, int]:
        """Fields of a result, ``disparity`` first, and their bits."""

    def settings(self, minimum: int) -> Mapping[str, Setting]:
        """Settings other than the labels in use, by name; ``minimum`` is the least disparity that was built in."""

    def with_settings(self, values: Mapping[str, int]) -> "Method":
        """The method of the gateware once its settings have these values."""

    def about(self) -> Mapping[str, Any]:
        """All parameters for reports, as JSON can hold them."""


class RuleMethod(Method, Protocol):
    """A method that labels by the disparity rule: weights of three neighbours, and widths of its energies."""
    @property
    def weights(self) -> Weights:
        """Weights of the three neighbours."""

    @property
    def energy_shift(self) -> int:
        """Fraction bits of the integer energies: a data term enters them shifted left by this."""

    @property
    def energy_scale(self) -> int:
        """Factor of a data term in the energy."""

    @property
    def slope_max(self) -> int:
        """Largest slope of a smoothness term."""

    @property
    def slope_shift(self) -> int:
        """Bits by which weight times likeness (8 fraction bits) is shifted left before its fraction is dropped."""

    @property
    def smooth_step_max(self) -> int:
        """Largest smoothness term between labels that differ by one."""


class Support(Protocol):
    """Pixels that a label was found from."""
    @property
    def support_max(self) -> int:
        """Most pixels of a support."""


class RefinedMethod(Method, Protocol):
    """A method whose labels come from supports along the line and are checked and refined."""
    @property
    def cost(self) -> FusedCost:
        """The cost of a candidate, fused with a census."""

    @property
    def census_above(self) -> bool:
        """Whether the pixel two lines above comes with a census."""

    @property
    def view_max(self) -> int:
        """Largest cost that the right view compares."""

    @property
    def arms(self) -> Support:
        """The support of a pixel."""

    @property
    def refinement(self) -> Refinement:
        """The stages behind the labelling."""


M = TypeVar("M")


def _homes(method: Any) -> dict[str, str]:
    """Parameter to the part of the method that holds it, a dataclass or a named tuple; '' for the parts and what is in none."""
    homes = {}
    for field in dataclasses.fields(method):
        part = getattr(method, field.name)
        homes[field.name] = ""
        if dataclasses.is_dataclass(part):
            homes.update({inner.name: field.name for inner in dataclasses.fields(part)})
        elif hasattr(part, "_fields"):
            homes.update(dict.fromkeys(part._fields, field.name))
    return homes


def parameters_of(method: Any) -> tuple[str, ...]:
    """Names of the parameters that :func:`changed` takes: the parts of a method, and what is in them.

    Examples
    --------
    >>> from golden.config import OnePass
    >>> parameters_of(OnePass())
    ('arithmetic', 'fraction_bits', 'weights', 'u1', 'u2', 'u3')
    """
    return tuple(_homes(method))


def value_of(method: Any, name: str) -> Any:
    """The parameter ``name`` of a method, whichever part holds it."""
    home = _homes(method)[name]
    return getattr(getattr(method, home) if home else method, name)


def changed(method: M, **values: Any) -> M:
    """A method with other values of parameters, whichever part holds them, or other parts.

    :class:`ValueError` if it has no such parameter.

    Examples
    --------
    >>> from golden.config import OnePass
    >>> changed(OnePass(), u3=7, fraction_bits=2).weights
    Weights(u1=15, u2=10, u3=7)
    """
    homes = _homes(method)
    parts: dict[str, dict[str, Any]] = {}
    for name, value in values.items():
        if name not in homes:
            raise ValueError(f"{name} is no parameter of the method {method.name}; "  # type: ignore[attr-defined]
                             f"those are {', '.join(homes)}")
        parts.setdefault(homes[name], {})[name] = value
    direct = parts.pop("", {})
    for home, inside in parts.items():
        part = direct.get(home, getattr(method, home))
        direct[home] = part._replace(**inside) if hasattr(part, "_fields") else dataclasses.replace(part, **inside)
    return dataclasses.replace(method, **direct)  # type: ignore[type-var]
