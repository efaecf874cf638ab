"""Parameters of the methods, by name or in files."""

import os
import tomllib
from collections.abc import Mapping
from pathlib import Path
from typing import Any, ClassVar, Protocol

from ..config import FUSED_1, FUSED_2, FUSED_3, METHODS, RECURSIVE_1, RECURSIVE_2, Method, changed, value_of
from ..errors import UserError
from ..files import atomic, parsed


__all__ = ["NAMED", "PARAMETER_SUFFIX", "NamedMethod", "default_parameters", "read_parameters", "write_parameters"]


PARAMETER_SUFFIX = ".toml"


class NamedMethod(Method, Protocol):
    """A method with named sets and files of parameters."""
    #: Those that a file may have, and their limits.
    LIMITS: ClassVar[Mapping[str, range]]

    @property
    def cost_max(self) -> int:
        """Largest cost of a candidate; its bits are what the gateware's memories for costs hold."""


#: Sets that need no file, for each method that has such, its default first.
NAMED: dict[str, dict[str, NamedMethod]] = {
    "fused": {"fused-1": FUSED_1, "fused-2": FUSED_2, "fused-3": FUSED_3},
    "recursive": {"recursive-1": RECURSIVE_1, "recursive-2": RECURSIVE_2},
}


def default_parameters(method: str) -> Method:
    """The first set of a method of :data:`golden.config.METHODS`, or what its class has."""
    return next(iter(NAMED[method].values())) if method in NAMED else METHODS[method]()


def read_parameters(path: str | os.PathLike[str], method: str) -> Any:
    """The set of that name of a method, or the parameters in a TOML file's table of the method's name.

    Parameters that the file does not name are those of the method's first set. :class:`UserError` if it is neither.

    Parameters
    ----------
    method : str
        One of :data:`NAMED`.
    """
    path, sets = Path(path), NAMED[method]
    for name, others in NAMED.items():
        if str(path) in others and name != method:
            raise UserError(f"{path} has parameters of the method {name}; choose --method {name}, or one of {', '.join(sets)}")
    if str(path) in sets:
        return sets[str(path)]
    try:
        document = parsed(tomllib.loads, path.read_text(encoding="utf-8"))
    except OSError as error:
        named = ", ".join(sets)
        raise UserError(f"cannot read {path}: {error.strerror or error}; name {named} or a file that golden tune has written") from error
    except ValueError as error:  # what is no TOML, or no text
        raise UserError(f"{path} is not a TOML file: {error}; name one that golden tune has written") from error
    values, start = document.get(method), next(iter(sets.values()))
    if not isinstance(values, dict) or len(document) > 1:
        raise UserError(f"{path} is not one table [{method}]; name a file with parameters of the method {method}")
    for name in values:
        if name not in start.LIMITS:
            raise UserError(f"{path} names {name}, which is no parameter; those are {', '.join(start.LIMITS)}")
    try:
        return changed(start, **values)
    except ValueError as error:
        raise UserError(f"{path}: {error}; correct the file") from None


def write_parameters(path: str | os.PathLike[str], parameters: NamedMethod, note: str) -> None:
    """Write parameters for :func:`read_parameters`, below a line of comment for each line of ``note``."""
    lines = [*(f"# {line}" for line in note.splitlines()), f"[{parameters.name}]"]
    lines += [f"{name} = {value_of(parameters, name)}" for name in parameters.LIMITS]
    with atomic(path) as file:
        file.write("".join(f"{line}\n" for line in lines).encode())
