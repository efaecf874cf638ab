"""The packages by name, as ``python -m hdl.build --package`` takes them."""

import argparse
import importlib.metadata
from collections.abc import Callable, Mapping, Sequence
from typing import NamedTuple

from golden.errors import UserError

from ..options import need
from .core import Core
from .fusesoc import fusesoc_files
from .litex import litex_files
from .quartus import quartus_files
from .registers import register_files
from .vhdl import vhdl_files
from .vivado import vivado_files


__all__ = ["PACKAGES", "Package", "add_package_option", "chosen_packages", "package_files", "project_version"]


class Package(NamedTuple):
    """A package: what it is for; the function that makes its files; modules that this needs beyond the project's, and their packages."""
    summary: str
    files: Callable[[Core], dict[str, str]]
    needs: Mapping[str, str] = {}


def _registers(core: Core) -> dict[str, str]:
    assert core.space
    return register_files(core.name, core.space)


#: All packages by name.
PACKAGES: Mapping[str, Package] = {
    "fusesoc": Package("FuseSoC", fusesoc_files),
    "quartus": Package("Platform Designer", quartus_files),
    "vivado": Package("Vivado, IP-XACT", vivado_files),
    "litex": Package("LiteX", litex_files),
    "vhdl": Package("VHDL component", vhdl_files),
    "registers": Package("registers as SystemRDL, C header and Python", _registers, {
        "systemrdl": "systemrdl-compiler", "peakrdl_systemrdl": "peakrdl-systemrdl", "peakrdl_cheader": "peakrdl-cheader"}),
}

#: What needs registers that a host reaches, and what a board's project can have: it is no part of another design.
_REGISTERS = "registers"


def add_package_option(parser: argparse.ArgumentParser) -> None:
    """Add the option that :func:`chosen_packages` reads."""
    parser.add_argument("--package", action="append", default=[], metavar="NAME[,NAME]", help=(
        "what tools need to take the core, beside its Verilog; may be repeated: " +
        ", ".join(f"{name} ({package.summary})" for name, package in PACKAGES.items()) + "; with --board only registers"))


def chosen_packages(options: argparse.Namespace, *, board: bool, registers: bool) -> list[str]:
    """Names of the packages that were chosen, each once, in the order of :data:`PACKAGES`.

    Parameters
    ----------
    options : Namespace
    board : bool
        Whether a board's project is built, not a core.
    registers : bool
        Whether there are registers that a host reaches.

    Raises
    ------
    UserError
        If there is no such package, it does not go with what is built, or needs a Python package that is not installed.
    """
    names = {name for names in options.package for name in names.split(",")}
    for name in sorted(names):
        if name not in PACKAGES:
            raise UserError(f"there is no package {name!r}; choose one of: {', '.join(PACKAGES)}")
        if board and name != _REGISTERS:
            raise UserError(f"--package {name} is for a core in another design, and --board makes a whole project; choose --core, "
                            f"or leave --package {name} out")
        if name == _REGISTERS and not registers:
            raise UserError("--package registers describes registers, and this core has ports in their place; choose --interface axi or "
                            "avalon, or leave --package registers out")
        for module, package in PACKAGES[name].needs.items():
            need(module, package)
    return [name for name in PACKAGES if name in names]


def package_files(names: Sequence[str], core: Core) -> dict[str, str]:
    """Files of packages, name to text."""
    return {file: text for name in names for file, text in PACKAGES[name].files(core).items()}


def project_version() -> str:
    """Version of this project, as it is installed."""
    return importlib.metadata.version("stereo-graph-cut")
