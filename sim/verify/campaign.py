"""A campaign: cases by key, computed in parallel, each result kept as soon as it is known, with a bar of progress."""

import argparse
import hashlib
import os
import subprocess
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any, NamedTuple

from golden.cli import progress
from golden.errors import UserError
from golden.files import write_json
from golden.lab.workers import Job, workers

from .journal import Journal


__all__ = ["RECORDS", "ROOT", "Part", "add_campaign_options", "digest_of_sources", "run_campaign", "write_record"]


ROOT = Path(__file__).parents[2]
#: Where the figures of each part are, that the report is made from.
RECORDS = ROOT / "docs" / "verification"


class Part(NamedTuple):
    """A part of the verification, as a command and as a section of the report.

    Members
    -------
    name : str
        That of the command, and of the file of figures.
    help : str
    add_options : function
        Adds the command's options to a parser.
    run : function
        Takes the options; the exit status, 1 if something was found.
    section : function
        Lines of Markdown of the figures that ``run`` has written.
    """
    name: str
    help: str
    add_options: Callable[[argparse.ArgumentParser], None]
    run: Callable[[argparse.Namespace], int]
    section: Callable[[Mapping[str, Any]], list[str]]


def add_campaign_options(parser: argparse.ArgumentParser) -> None:
    """Options of each campaign: ``--workers``, ``--work``, ``--restart`` and ``--record``."""
    parser.add_argument("--workers", type=int, default=os.cpu_count() or 1, metavar="N", help="processes (default: %(default)s)")
    parser.add_argument("--work", type=Path, default=Path("build/verify"), metavar="DIR",
                        help="where results are kept, so that the command goes on if it was ended (default: %(default)s)")
    parser.add_argument("--restart", action="store_true", help="discard the results that are kept there")
    parser.add_argument("--record", action="store_true", help="write the figures into docs/verification/ too, for the report")


def digest_of_sources(*packages: str) -> str:
    """Digest of the Python and Verilog files of packages or folders of the project, such as ``hdl/matcher``: 16 hexadecimal digits."""
    files = sorted(path for package in packages for kind in ("*.py", "*.v") for path in (ROOT / package).rglob(kind))
    if not files:
        raise ValueError(f"no sources in {', '.join(packages)}")
    total = hashlib.sha256()
    for path in files:
        total.update(str(path.relative_to(ROOT)).encode() + b"\0" + hashlib.sha256(path.read_bytes()).digest())
    return total.hexdigest()[:16]


def run_campaign(name: str, cases: Mapping[str, Job], options: argparse.Namespace, sources: str,
                 again: Callable[[Any], bool] = lambda result: False) -> dict[str, Any]:
    """Results of all cases, in their order; those that the journal has are not computed again.

    Parameters
    ----------
    name : str
        Of the journal, ``NAME.jsonl`` in ``--work``.
    cases : mapping
        Keys to functions with their arguments, which processes can be sent. Results are values that JSON has.
    options : Namespace
        With those of :func:`add_campaign_options`.
    sources : str
        As of :class:`Journal`.
    again : function
        Whether a result that the journal has is computed again.
    """
    if options.workers < 1:
        raise UserError(f"--workers must be at least 1, not {options.workers}; choose a greater one")
    with Journal(options.work / f"{name}.jsonl", sources, restart=options.restart) as journal, progress() as bar:
        missing = [key for key in cases if key not in journal.results or again(journal.results[key])]
        task = bar.add_task(name, total=len(cases), completed=len(cases) - len(missing))

        def done(number: int, result: Any) -> None:
            journal.add(missing[number], result)
            bar.advance(task)

        if missing:
            with workers(min(options.workers, len(missing))) as run:
                run([cases[key] for key in missing], done)
        return {key: journal.results[key] for key in cases}


def write_record(name: str, command: str, figures: Mapping[str, Any]) -> None:
    """Write the figures of a part, with the command that gave them and the commit of the sources, for the report."""
    RECORDS.mkdir(exist_ok=True)
    write_json(RECORDS / f"{name}.json", {"command": command, "commit": _commit(), **figures})


def _commit() -> str:
    """Commit of the sources, with ``+`` if they differ from it; empty where there is no repository."""
    command = ["git", "describe", "--always", "--abbrev=7", "--dirty=+", "--exclude=*"]
    run = subprocess.run(command, cwd=ROOT, capture_output=True, text=True)
    return run.stdout.strip() if run.returncode == 0 else ""
