"""Long runs of the verification, and the report of their figures: ``python -m sim.verify``."""

import argparse
import importlib
import pkgutil
import sys
from collections.abc import Sequence

from golden.cli import Parser
from golden.errors import run_cli

from . import parts
from .campaign import Part
from .report import PAGE, write_page


__all__ = ["main", "parts_of_verification"]


def parts_of_verification() -> list[Part]:
    """The parts that there are, by name."""
    modules = [importlib.import_module(f"{parts.__name__}.{module.name}") for module in pkgutil.iter_modules(parts.__path__)]
    return sorted((module.PART for module in modules if hasattr(module, "PART")), key=lambda part: part.name)


def _report(options: argparse.Namespace) -> int:
    write_page(parts_of_verification())
    print(f"Written: {PAGE}")
    return 0


def _run(argv: Sequence[str] | None) -> int:
    parser = Parser(prog="python -m sim.verify", description=(
        "Verify the project by hundreds of seeded cases. A run that was ended goes on where it was. Exit status 1 if something was found."))
    commands = parser.add_subparsers(dest="part", required=True, metavar="PART")
    for part in parts_of_verification():
        command = commands.add_parser(part.name, help=part.help, description=f"{part.help.capitalize()}.")
        part.add_options(command)
        command.set_defaults(run=part.run)
    commands.add_parser("report", help="write docs/verification.md from the figures in docs/verification/").set_defaults(run=_report)
    options = parser.parse_args(argv)
    return int(options.run(options))


def main(argv: Sequence[str] | None = None) -> int:
    """Run the command; the exit status is the result."""
    return run_cli(_run, argv, "sim.verify")


if __name__ == "__main__":
    sys.exit(main())
