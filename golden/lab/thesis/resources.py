"""Tables 2 and 3 of `python -m hdl.resources.tables`: the kept page, or one that is counted now."""

import importlib.util
import subprocess
import sys
import tempfile
from collections.abc import Sequence
from pathlib import Path

from ...errors import UserError
from ...files import check_output
from ...processes import run_program
from ..cache import source_digest
from .page import Table


__all__ = ["KEPT", "find_resources", "read_resources"]


#: The page of the repository, a quarter of an hour of counting; and its clock rate, half an hour of place and route.
KEPT, CLOCK = Path("docs/resources.md"), Path("docs/clock.json")

COMMAND = "python -m hdl.resources.tables"
REMEDY = "name a page of that command with --resources, or leave tables 2 and 3 out with --quick"


def read_resources(path: Path) -> dict[int, Table]:
    """Tables 2 and 3 of a page; :class:`UserError` if it does not hold them."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(f"cannot read {path} ({error}); write it with {COMMAND}") from error
    found: dict[int, list[list[str]]] = {}
    number = None
    for line in lines:
        if line.startswith("## "):
            number = next((each for each in (2, 3) if line.startswith(f"## Table {each}:")), None)
        elif number and line.startswith("|"):
            found.setdefault(number, []).append([cell.strip() for cell in line.strip().strip("|").split("|")])
    for each in (2, 3):
        rows = found.get(each, [])
        if len(rows) < 3 or len({len(row) for row in rows}) > 1:
            raise UserError(f"{path} holds no table under '## Table {each}:'; write it with {COMMAND}")
    return {each: Table(rows[0], rows[2:]) for each, rows in found.items()}  # rows[1] is the rule


def find_resources(cache: Path, quick: bool) -> dict[int, Table] | None:
    """Tables of :data:`KEPT`, else of a page in the folder ``cache``, which is counted first if it is not there.

    The page in ``cache`` is found by the sources of the gateware. ``quick`` counts nothing: ``None`` without a page.
    """
    if KEPT.exists():
        return read_resources(KEPT)
    # The package is looked up, not imported: the golden model is below it.
    package = importlib.util.find_spec("hdl")
    if package is None or not package.submodule_search_locations:
        if quick:
            return None
        raise UserError(f"the package hdl, which counts the resources, is not installed; {REMEDY}")
    sources = [path for folder in package.submodule_search_locations for path in Path(folder).rglob("*.py")]
    page = cache / f"resources-{source_digest(sources)[:16]}.md"
    if not page.exists():
        if quick:
            return None
        check_output(page, (".md",), "--cache")
        clock = ["--clock", str(CLOCK)] if CLOCK.exists() else []
        _count([sys.executable, "-m", COMMAND.split()[-1], "--output", str(page), *clock])
    return read_resources(page)


def _count(command: Sequence[str]) -> None:
    """Run the command that counts. Its bar is shown on a terminal; its sentence, if it ends otherwise than well, is part of ours."""
    with tempfile.TemporaryFile() as told:
        status = run_program(command, stdout=subprocess.DEVNULL, stderr=None if sys.stderr and sys.stderr.isatty() else told)
        told.seek(0)
        reason = told.read().decode(errors="replace").strip().rpartition("\n")[2]
    if status:
        raise UserError(f"{COMMAND} ended with status {status}{reason and f' ({reason})'}; {REMEDY}")
