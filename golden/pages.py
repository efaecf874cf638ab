"""Generated pages: which command wrote a page, and a digest of what it was made from, so that a stale page is noticed."""

import hashlib
import json
import re
from collections.abc import Sequence
from typing import Any


__all__ = ["digest", "origin", "read_origin", "table"]


_ORIGIN = re.compile(r"Written by `([^`]+)`\. Digest of its inputs: `([0-9a-f]{16})`\.")


def digest(*values: Any) -> str:
    """A digest of numbers, words, and lists and dictionaries of them: 16 hexadecimal digits.

    Examples
    --------
    >>> digest("streaming", 80) == digest("streaming", 80) != digest("streaming", 81)
    True
    """
    return hashlib.sha256(json.dumps(values, sort_keys=True).encode("utf-8")).hexdigest()[:16]


def origin(command: str, inputs: str) -> str:
    """The sentences of a page that name its command and the digest of its inputs.

    Examples
    --------
    >>> origin("python -m golden thesis", digest(1))
    'Written by `python -m golden thesis`. Digest of its inputs: `080a9ed428559ef6`.'
    """
    return f"Written by `{command}`. Digest of its inputs: `{inputs}`."


def read_origin(text: str) -> tuple[str, str]:
    """Command and digest that a page, Markdown or HTML, names; :class:`ValueError` unless it names one of each.

    Examples
    --------
    >>> read_origin("# Page" + chr(10) + origin("make page", digest(1)))
    ('make page', '080a9ed428559ef6')
    """
    found = _ORIGIN.findall(re.sub("</?code>", "`", text))
    if len(found) != 1:
        raise ValueError(f"the page names {len(found)} commands and digests, not 1; write it again with its command")
    command, inputs = found[0]
    return command, inputs


def table(head: Sequence[object], rows: Sequence[Sequence[object]], words: int = 1) -> list[str]:
    """Lines of a table in Markdown; the first ``words`` columns are words, the others numbers.

    Examples
    --------
    >>> table(["pair", "bad"], [["a|b", 1.5]])
    ['| pair | bad |', '| --- | ---: |', '| a\\\\|b | 1.5 |']
    """
    rule = ["---" if column < words else "---:" for column in range(len(head))]
    return [_row(cells) for cells in (head, rule, *rows)]


def _row(cells: Sequence[object]) -> str:
    """A line of a table; a bar within a cell must not end it."""
    return "| " + " | ".join(str(cell).replace("|", "\\|") for cell in cells) + " |"
