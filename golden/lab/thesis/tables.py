"""Tables 1, 2 and 3: what the thesis prints, and what other commands have measured, side by side."""

import json
from pathlib import Path
from typing import Any

from ...errors import UserError
from ...pictures.dataset import MASKS
from ..published import TABLE_1, TABLE_2, TABLE_3
from . import sweeps
from .laboratory import Laboratory, difference, percent
from .page import Section, Table


__all__ = ["read_resources", "read_rivals", "table_1", "table_2", "table_3"]


Rivals = dict[str, dict[str, Any]]

# Row of Table 1 that each of our methods stands beside.
OURS = {"float": "Proposed Method", "thesis": "Proposed Method", "linear": "Proposed Method", "fused": None}


def read_rivals(path: Path) -> Rivals:
    """The methods in the JSON file that `python -m golden rivals --output` writes; :class:`UserError` if it is not one.

    Returns
    -------
    dict
        By method: ``about``; ``published``, the name of a row of Table 1; ``pairs``, with ``figures`` (percent) and ``seconds`` of each.
    """
    try:
        methods = json.loads(path.read_text(encoding="utf-8"))["methods"]
        rivals = {name: {"about": str(method["about"]), "published": method.get("published"), "pairs": {
            pair: {"figures": {mask: float(one["figures"][mask]) for mask in MASKS}, "seconds": float(one["seconds"])}
            for pair, one in method["pairs"].items()}} for name, method in methods.items()}
    except OSError as error:
        raise UserError(f"cannot read {path}: {error.strerror}; write it with python -m golden rivals --output {path}") from error
    except (ValueError, KeyError, TypeError, AttributeError) as error:
        raise UserError(f"{path} is not what python -m golden rivals --output writes ({error!r}); write it so") from None
    if not rivals:
        raise UserError(f"{path} holds no method; write it with python -m golden rivals --output {path}")
    return rivals


def read_resources(path: Path) -> dict[int, Table]:
    """Tables 2 and 3 in the Markdown page that `python -m hdl.resources.tables` writes; :class:`UserError` if it is not one."""
    try:
        lines = path.read_text(encoding="utf-8").splitlines()
    except (OSError, UnicodeDecodeError) as error:
        raise UserError(f"cannot read {path} ({error}); write it with python -m hdl.resources.tables") from error
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
            raise UserError(f"{path} holds no table under '## Table {each}:'; write it with python -m hdl.resources.tables")
    return {each: Table(rows[0], rows[2:], words=1) for each, rows in found.items()}  # rows[1] is the rule


def table_1(lab: Laboratory, rivals: Rivals | None) -> Section:
    """Methods on Tsukuba, and on all pairs."""
    results = lab.by_method()
    methods: Rivals = {
        f"one pass, {method}": {"published": OURS[method], "pairs": {
            name: {"figures": dict(zip(MASKS, results[name, method]["bad"].tolist(), strict=True)),
                   "seconds": float(results[name, method]["seconds"])} for name in lab.pairs}} for method in sweeps.METHODS}
    # Ours are measured here; those of the other command are the same ones.
    methods |= {name: each for name, each in (rivals or {}).items() if not name.startswith("one-pass") or name == "one-pass-expansion"}

    rows = []
    for name, method in methods.items():
        row = TABLE_1.get(method.get("published") or "")
        one = method["pairs"].get("tsukuba")
        if one is None:
            continue
        figures = [one["figures"][mask] for mask in MASKS]
        rows.append([name, *(percent([row.figures[mask] for mask in MASKS]) if row else ["-"] * 3), *percent(figures),
                     *(difference(figures, row.figures) if row else ["-"] * 3), f"{row.seconds:g} {row.tool}" if row else "-",
                     f"{one['seconds']:.2f}"])
    printed = [[name, *percent([row.figures[mask] for mask in MASKS]), *["-"] * 6, f"{row.seconds:g} {row.tool}", "-"]
               for name, row in TABLE_1.items() if name not in {method.get("published") for method in methods.values()}]
    head = ["Tsukuba", *(f"{mask}, {whose}" for whose in ("thesis", "measured", "difference") for mask in MASKS), "s, thesis", "s, here"]

    whole = []
    for name, method in methods.items():
        cells = [method["pairs"][pair]["figures"][mask] for pair in lab.pairs if pair in method["pairs"] for mask in MASKS]
        if len(cells) == len(MASKS) * len(lab.pairs):
            whole.append([name, *percent(cells), f"{sum(cells) / len(cells):.2f}"])
    wide = ["all pairs", *(f"{pair} {mask}" for pair in lab.pairs for mask in MASKS), "average"]
    about = [f"{name} is {each['about']}" for name, each in (rivals or {}).items() if name in methods]
    return Section("Table 1: previous methods and the proposed one", [
        "Bad pixels in percent, and seconds. Columns of the thesis are as printed, on machines of its time; the others are measured, on "
        "the same pictures and masks. Seconds here are processor time of software, not of the gateware.",
        *(["Rivals: " + "; ".join(about) + "."] if about else
          ["No rival was measured for this page: give what python -m golden rivals --output FILE wrote as --rivals FILE."])],
        [Table(head, rows + printed), Table(wide, whole)])


def table_2(resources: dict[int, Table] | None) -> Section:
    """FPGA resources."""
    if resources is None:
        rows = [[name, f"{available:,}", f"{used:,}", "not given"] for name, (used, available) in TABLE_2.items()]
        return Section("Table 2: FPGA resources", [_missing()], [Table(["EP3C120", "available", "thesis 720x576x80", "ours"], rows)])
    found = resources[2]
    return Section("Table 2: FPGA resources", [
        "Ours, as python -m hdl.resources.tables counts them; python -m hdl.resources states the method and its error. "
        f"{_less(found)}"], [found])


def _less(found: Table) -> str:
    """Ours less the thesis's at its own size, in words."""
    whose = next(number for number, title in enumerate(found.head) if title.startswith("thesis"))
    words = []
    for row in found.rows:
        for number, title in enumerate(found.head):
            # At the thesis's size, in both numbers that are whole.
            if title.endswith("720x576x80") and number != whose:
                ours, theirs = (row[column].replace(",", "") for column in (number, whose))
                if ours.isdigit() and theirs.isdigit():
                    words.append(f"{row[0]} {int(ours) - int(theirs):+,} ({title.split()[0]})")
    return f"Ours less the thesis's at its size: {'; '.join(words)}." if words else ""


def table_3(resources: dict[int, Table] | None) -> Section:
    """Rates of real-time systems."""
    if resources is None:
        rows = [[hardware, f"{width}x{height}", str(disparities), method, str(rate)]
                for hardware, width, height, disparities, method, rate in TABLE_3]
        head = ["hardware", "picture", "disparities", "method", "frames/s"]
        return Section("Table 3: real-time systems", [_missing()], [Table(head, rows)])
    return Section("Table 3: real-time systems", [
        "Rows but ours are as the thesis prints them. Ours are at the clock rate that place and route reaches on an ECP5, a stand-in, "
        "because no open tool routes a Cyclone III."], [resources[3]])


def _missing() -> str:
    return "Printed by the thesis. Ours are not here: write them with python -m hdl.resources.tables and give the page as --resources."
