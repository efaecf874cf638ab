"""The coverage of a design, as values of JSON."""

import re
import tempfile
import time
from pathlib import Path
from typing import Any

from sim.kit.simulators import COVERAGE

from .designs import DESIGNS, collecting
from .origins import origins
from .points import KINDS, covered, measured, modules, text_of


__all__ = ["UNKNOWN", "either", "measure"]


#: Text of what is no line: where the selectors of a choice are complete, Yosys writes its default as unknown.
UNKNOWN = re.compile(r"default: \d+'hx+")


def measure(name: str) -> dict[str, Any]:
    """Run the benches of a design.

    Returns
    -------
    dict
        ``modules``: of each module, by its class and the digest of its text, a string of 0 and 1 for each kind: which points are covered.
        ``holes``: of those that are not, module and kind in that, place in the string, text, module and line of the Verilog. ``runs`` of
        a simulator, and ``seconds``.
    """
    drive, arguments = DESIGNS[name]
    start = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="coverage-") as temporary:
        folder, data = Path(temporary) / "work", Path(temporary) / "data"
        for place in (folder, data):
            place.mkdir()
        with collecting(COVERAGE, data):
            driven = drive(folder, *arguments)
        files = sorted(data.iterdir())
        counts = covered(files)
        source = driven.verilog.read_text().splitlines()
        kinds = origins(driven.component, driven.top)
    found: dict[str, dict[str, str]] = {}
    holes = []
    for module, digest in modules(source).items():
        key = f"{kinds[module]} {digest}"
        before = found.setdefault(key, {})
        for kind in KINDS:
            points = [(point, hit) for point, hit in measured(counts, module, kind) if not UNKNOWN.fullmatch(text_of(point, source))]
            bits = "".join(str(int(hit)) for _, hit in points)
            # Modules with the same text but other children.
            before[kind] = either(before.get(kind, bits), bits)
            holes += [[key, kind, place, text_of(point, source), module, point.line]
                      for place, (point, hit) in enumerate(points) if not hit]
    return {"modules": found, "holes": holes, "runs": len(files), "seconds": round(time.monotonic() - start)}


def either(one: str, other: str) -> str:
    """Points that are covered in either of two.

    Examples
    --------
    >>> either("0101", "0011")
    '0111'
    """
    return "".join(map(max, zip(one, other, strict=True)))
