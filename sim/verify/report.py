"""`docs/verification.md` from the figures that the parts of the verification have written."""

import json
from collections.abc import Sequence
from typing import Any

from golden.errors import UserError
from golden.files import atomic
from golden.pages import digest, origin

from .campaign import RECORDS, ROOT, Part


__all__ = ["COMMAND", "PAGE", "page", "write_page"]


PAGE = ROOT / "docs" / "verification.md"
COMMAND = "python -m sim.verify report"


def _record(part: Part) -> dict[str, Any]:
    path = RECORDS / f"{part.name}.json"
    if not path.exists():
        raise UserError(f"{path.relative_to(ROOT)} does not exist; write it with python -m sim.verify {part.name} --record")
    return dict(json.loads(path.read_text(encoding="utf-8")))


def page(parts: Sequence[Part]) -> str:
    """The page, in Markdown; :class:`UserError` if a part has written no figures."""
    records = [_record(part) for part in parts]
    lines = ["# Verification: what is proved, what is tested, and how well", "", origin(COMMAND, digest(records)), "",
             "Each section names the command that gave its figures; all are seeded, resumable and show their progress."]
    for part, record in zip(parts, records, strict=True):
        measured = f"`{record['command']}`" + (f", at commit {record['commit']}" if record["commit"] else "")
        lines += ["", f"## {part.name.capitalize()}", "", f"{part.help.capitalize()}: {measured}.", "", *part.section(record)]
    return "\n".join(lines) + "\n"


def write_page(parts: Sequence[Part]) -> None:
    """Write ``docs/verification.md``."""
    text = page(parts)
    with atomic(PAGE) as file:
        file.write(text.encode())
