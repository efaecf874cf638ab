"""Parameters of the method :class:`golden.config.Fused`, by name or in files."""

import os
import tomllib
from pathlib import Path

from ..config import FUSED_1, FUSED_2, FUSED_3, Fused, changed, value_of
from ..errors import UserError
from ..files import atomic


__all__ = ["NAMED", "PARAMETER_SUFFIX", "read_parameters", "write_parameters"]


PARAMETER_SUFFIX = ".toml"
TABLE = "fused"

#: Sets that need no file.
NAMED = {"fused-1": FUSED_1, "fused-2": FUSED_2, "fused-3": FUSED_3}


def read_parameters(path: str | os.PathLike[str]) -> Fused:
    """The set of that name of :data:`NAMED`, or the parameters in the table ``[fused]`` of a TOML file.

    Parameters that the file does not name are those of *fused-1*. :class:`UserError` if it is neither.
    """
    path = Path(path)
    if str(path) in NAMED:
        return NAMED[str(path)]
    try:
        document = tomllib.loads(path.read_text(encoding="utf-8"))
    except OSError as error:
        named = ", ".join(NAMED)
        raise UserError(f"cannot read {path}: {error.strerror or error}; name {named} or a file that golden tune has written") from error
    except ValueError as error:  # what is no TOML, or no text
        raise UserError(f"{path} is not a TOML file: {error}; name one that golden tune has written") from error
    values = document.get(TABLE)
    if not isinstance(values, dict) or len(document) > 1:
        raise UserError(f"{path} is not one table [{TABLE}]; name a file that golden tune has written")
    for name in values:
        if name not in Fused.LIMITS:
            raise UserError(f"{path} names {name}, which is no parameter; those are {', '.join(Fused.LIMITS)}")
    try:
        return changed(FUSED_1, **values)
    except ValueError as error:
        raise UserError(f"{path}: {error}; correct the file") from None


def write_parameters(path: str | os.PathLike[str], parameters: Fused, note: str) -> None:
    """Write parameters for :func:`read_parameters`, below a line of comment for each line of ``note``."""
    lines = [*(f"# {line}" for line in note.splitlines()), f"[{TABLE}]"]
    lines += [f"{name} = {value_of(parameters, name)}" for name in Fused.LIMITS]
    with atomic(path) as file:
        file.write("".join(f"{line}\n" for line in lines).encode())
