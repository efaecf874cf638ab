"""Whole matchers after synthesis, simulated on pictures: ``python -m sim.verify netlist``."""

import argparse
import tempfile
import time
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from rich.table import Table

from golden.tables import print_table
from sim.benches.gates import FAMILIES, MATCHERS, GateBench, check_pictures
from sim.kit.simulators import SimulationError, require

from ..campaign import Part, add_campaign_options, digest_of_sources, run_campaign, write_record


__all__ = ["PART"]


_SIMULATOR = "icarus"


def _add_options(parser: argparse.ArgumentParser) -> None:
    add_campaign_options(parser)
    parser.add_argument("--matcher", action="append", choices=MATCHERS, metavar="NAME",
                        help=f"only this one, and each other that is named so: {', '.join(MATCHERS)}")


def _checked(matcher: str, family: str) -> dict[str, Any]:
    """Cells by kind and clocks of a netlist; and the fault, empty if it equals golden."""
    start = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="netlist-") as folder:
        bench = GateBench(MATCHERS[matcher], family, Path(folder))
        fault, clocks = "", 0
        try:
            clocks = check_pictures(bench, _SIMULATOR)
        except (AssertionError, SimulationError) as error:
            fault = str(error) or "pixels differ from golden"
    return {"cells": dict(sorted(bench.cells.items())), "clocks": clocks, "fault": fault, "seconds": round(time.monotonic() - start)}


def _run(options: argparse.Namespace) -> int:
    require(_SIMULATOR)
    cases = {f"{matcher}, {family}": (_checked, matcher, family) for matcher in options.matcher or MATCHERS for family in FAMILIES}
    results = run_campaign("netlist", cases, options, digest_of_sources("golden", "hdl", "sim/kit", "sim/benches", "sim/stubs"))
    table = Table("netlist", "cells", "clocks", "seconds", "equals golden")
    for name, result in results.items():
        table.add_row(name, f"{sum(result['cells'].values()):,}", f"{result['clocks']:,}", str(result["seconds"]), result["fault"] or "yes")
    print_table(table)
    if options.record:
        command = " ".join(["python -m sim.verify netlist", *(f"--matcher {name}" for name in options.matcher or ())])
        write_record("netlist", command, {"netlists": results, "all_netlists": len(MATCHERS) * len(FAMILIES)})
    return int(any(result["fault"] for result in results.values()))


def _section(record: Mapping[str, Any]) -> list[str]:
    lines = [f"{len(record['netlists'])} of {record['all_netlists']} netlists: matchers of each method and engine, of 8 labels and lines "
             "of 24 pixels, synthesised for an ECP5 as boards are, and mapped to the elements of a Cyclone III that are counted for it. "
             "Two frames at full rate, then two with stalls and other settings, through the harness of the benches. Memory blocks of the "
             "Cyclone III hold noise at first.", "",
             "| netlist | cells | clocks | result |", "|---|---|---|---|"]
    for name, result in record["netlists"].items():
        kinds = ", ".join(f"{number:,} {kind}" for kind, number in result["cells"].items() if not kind.startswith("$"))
        lines.append(f"| {name} | {kinds} | {result['clocks']:,} | {result['fault'] or 'equals golden'} |")
    return lines


PART = Part("netlist", "matchers after synthesis, simulated on pictures, equal golden", _add_options, _run, _section)
