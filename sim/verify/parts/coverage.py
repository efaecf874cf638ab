"""Coverage of the emitted Verilog by the benches: ``python -m sim.verify coverage``."""

import argparse
from collections.abc import Iterable, Mapping
from typing import Any

from rich.table import Table

from golden.tables import print_table
from sim.kit.simulators import require

from ..campaign import Part, add_campaign_options, digest_of_sources, run_campaign, write_record
from ..coverage.designs import DESIGNS
from ..coverage.measure import measure
from ..coverage.origins import room
from ..coverage.points import KINDS
from ..coverage_explained import EXPLAINED
from ..coverage_holes import Judged, holes_of, judge, merged


__all__ = ["LEAST_LINES", "PART"]


#: Share of the lines that the benches must reach.
LEAST_LINES = 0.98

Pairs = dict[str, list[int]]    # points that are covered, and all, by their kind


def _add_options(parser: argparse.ArgumentParser) -> None:
    add_campaign_options(parser)
    parser.add_argument("--design", action="append", choices=DESIGNS, metavar="NAME", help=f"only this one, and each other that is named "
                        f"so: {', '.join(DESIGNS)}")


def _sum(modules: Iterable[Mapping[str, str]]) -> Pairs:
    total = {kind: [0, 0] for kind in KINDS}
    for module in modules:
        for kind, bits in module.items():
            total[kind] = [total[kind][0] + bits.count("1"), total[kind][1] + len(bits)]
    return total


def _figures(results: Mapping[str, Mapping[str, Any]], judged: Judged) -> dict[str, Any]:
    modules = merged(results)
    rooms: dict[str, list[Mapping[str, str]]] = {}
    for key, found in modules.items():
        rooms.setdefault(room(key.partition(" ")[0]), []).append(found)
    return {
        "designs": {name: {"runs": result["runs"], "seconds": result["seconds"], **_sum(result["modules"].values())}
                    for name, result in results.items()},
        "all_designs": len(DESIGNS),
        "rooms": {name: _sum(found) for name, found in sorted(rooms.items())},
        "total": _sum(modules.values()),
        "explained": [{"reason": EXPLAINED[number].reason, **{kind: sum(hole.kind == kind for hole in holes) for kind in KINDS}}
                      for number, holes in sorted(judged.explained.items())],
        "open": [list(hole) for hole in judged.open],
    }


def _share(pair: list[int]) -> str:
    """Cut, not rounded: 100 % is all.

    Examples
    --------
    >>> _share([1999, 2000]), _share([0, 0])
    ('99.9 % of 2,000', '')
    """
    hit, total = pair
    return f"{1000 * hit // total / 10} % of {total:,}" if total else ""


def _run(options: argparse.Namespace) -> int:
    require("verilator")
    names = options.design or list(DESIGNS)
    cases = {name: (measure, name) for name in names}
    sources = ("golden", "hdl", "sim/kit", "sim/benches", "sim/models", "sim/verify/coverage")
    results = run_campaign("coverage", cases, options, digest_of_sources(*sources))
    judged = judge(holes_of(results))
    figures = _figures(results, judged)
    table = Table("design", "runs", "seconds", *KINDS)
    for name, found in [*figures["designs"].items(), ("modules of all", {"runs": "", "seconds": "", **figures["total"]})]:
        table.add_row(name, str(found["runs"]), str(found["seconds"]), *(_share(found[kind]) for kind in KINDS))
    print_table(table)
    for hole in judged.open:
        print(f"not covered: {hole.design}: {hole.origin}: {hole.kind} {hole.text!r} ({hole.module}, line {hole.line})")
    whole = set(names) == set(DESIGNS)
    useless = judged.useless if whole else []
    for entry in useless:
        print(f"explains nothing: {entry}")
    if options.record:
        write_record("coverage", "python -m sim.verify coverage" + "".join(f" --design '{name}'" for name in options.design or ()), figures)
    hit, total = figures["total"]["line"]
    return int(bool(judged.open or useless or hit < LEAST_LINES * total))


def _rows(entries: Iterable[tuple[str, Mapping[str, Any]]], title: str) -> list[str]:
    return [f"| {title} | lines | branches | toggles of control |", "|---|---|---|---|",
            *(f"| {name} | " + " | ".join(_share(found[kind]) for kind in KINDS) + " |" for name, found in entries)]


def _section(record: Mapping[str, Any]) -> list[str]:
    designs, explained, left = record["designs"], record["explained"], record["open"]
    runs, seconds = (sum(found[name] for found in designs.values()) for name in ("runs", "seconds"))
    by_origin: dict[str, list[str]] = {}
    for design, origin, kind, text, module, line in left:
        by_origin.setdefault(f"`{origin}`", []).append(f"{kind} `{text}` ({design}: {module}, line {line})")
    return [
        f"{len(designs)} of {record['all_designs']} designs, in the smallest sizes that have all parts, by {runs} runs of the suite's "
        f"benches on Verilator, {round(seconds / 60)} minutes.",
        "",
        "A line is one with a statement, and covered if all of its statements were executed; the default of a choice whose selectors "
        "are complete, which Yosys writes as unknown, is none. Yosys writes a register as an `always` block with its reset and its "
        "enable, a choice among many as a `casez`, and a choice between two as `?:`: each such way is a line or a branch, while a logic "
        "operation between signals is a continuous assignment, of which nothing is counted. Control is each named signal of one bit and "
        "each bit of the state of a state machine, in both directions; words of data are left out. Points are those of modules: "
        "instances of one module count together, and so do modules of several designs whose text is the same. Verilator 5.48 cannot "
        "look for state machines in this Verilog.",
        "",
        *_rows([*designs.items(), ("**modules of all**", record["total"])], "design"),
        "",
        *_rows(record["rooms"].items(), "room"),
        "",
        f"Holes that are explained, {sum(entry[kind] for entry in explained for kind in KINDS):,} points, in "
        "`sim/verify/coverage_explained.py`; an entry that explains no hole is an error:",
        "",
        "| lines | branches | toggles | why |",
        "|---|---|---|---|",
        *("| " + " | ".join(str(entry[kind] or "") for kind in KINDS) + f" | {entry['reason']} |" for entry in explained),
        "",
        f"Open holes: {len(left)}." if left else "There is no open hole.",
        *[line for origin, holes in sorted(by_origin.items()) for line in ("", f"{origin}: {'; '.join(holes)}")],
    ]


PART = Part("coverage", "coverage of the emitted Verilog by the benches: lines, branches, toggles of control", _add_options, _run, _section)
