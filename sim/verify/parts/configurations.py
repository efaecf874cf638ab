"""Matchers of drawn configurations on their emitted Verilog, bit-exact with the golden model; what fails is made smaller."""

import argparse
import resource
import tempfile
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import Any

from golden.errors import UserError
from golden.lab.workers import Job

from ...kit.simulators import require
from ...kit.store import Store
from ..campaign import Part, add_campaign_options, digest_of_sources, run_campaign, write_record
from ..configurations import ICARUS, Case, draw, failure, literal, smallest, unreachable


__all__ = ["PART", "run_case"]


# A model runs once: what is worth keeping is Verilator's runtime library.
_STORE_LIMIT = 1 << 25


def _processor_seconds() -> float:
    """Of this process and of the programs that it has waited for."""
    used = [resource.getrusage(who) for who in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)]
    return sum(each.ru_utime + each.ru_stime for each in used)


def _about(case: Case) -> dict[str, Any]:
    """What the report counts."""
    stalls = [(frame.stall_i, frame.burst_i, frame.stall_o, frame.burst_o) for frame in case.frames]
    return {
        "kind": f"{case.method}, {case.config.engine}, {case.config.method.arithmetic}", "labels": case.labels, "max_width": case.max_width,
        "frames": len(case.frames), "pixels": sum(frame.width * frame.height for frame in case.frames),
        "changes": sum(frame.settings is not None for frame in case.frames),
        "stalled": sum(any(each) for each in stalls), "bursts": sum(bool(burst_i or burst_o) for _, burst_i, _, burst_o in stalls),
        "unreachable": len(unreachable(case)),
    }


def run_case(number: int, simulator: str, work: str) -> dict[str, Any]:
    """Result of a case, for the journal: what it is, ``failure`` and, if there is one, ``smallest``: a case as Python text."""
    start = _processor_seconds()
    case = draw(number)
    store = Store(Path(work) / "models", _STORE_LIMIT)

    def told(candidate: Case) -> str | None:
        with tempfile.TemporaryDirectory(prefix="case-") as folder:
            return failure(candidate, simulator, folder, store=store)

    wrong = told(case)
    result = {"number": number, "simulator": simulator, **_about(case), "failure": wrong}
    if wrong is not None:
        result["smallest"] = literal(smallest(case, lambda candidate: told(candidate) is not None))
    return {**result, "seconds": round(_processor_seconds() - start, 2)}


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--cases", type=int, default=500, metavar="N", help="configurations on Verilator (default: %(default)s)")
    parser.add_argument("--icarus", type=int, default=ICARUS, metavar="N",
                        help=f"of the first {ICARUS}, which are small, those that run on Icarus too (default: %(default)s)")
    add_campaign_options(parser)


def _jobs(options: argparse.Namespace) -> dict[str, Job]:
    if options.cases < 1:
        raise UserError(f"--cases must be at least 1, not {options.cases}; choose a greater one")
    if options.icarus not in range(ICARUS + 1):
        raise UserError(f"--icarus must be from 0 to {ICARUS}, not {options.icarus}; the cases that are small enough are those")
    counts = {"verilator": options.cases, "icarus": options.icarus}
    work = str(Path(options.work).absolute())
    return {f"{simulator} {number}": (run_case, number, simulator, work) for simulator, count in counts.items() for number in range(count)}


def _figures(results: list[dict[str, Any]]) -> dict[str, Any]:
    """Of all runs, by method, engine and arithmetic."""
    rows = []
    for kind in sorted({result["kind"] for result in results}):
        of_kind = [result for result in results if result["kind"] == kind]
        runs = Counter(result["simulator"] for result in of_kind)
        cases = {result["number"]: result for result in of_kind}.values()
        labels, widths = ([case[name] for case in cases] for name in ("labels", "max_width"))
        rows.append({
            "kind": kind, "verilator": runs["verilator"], "icarus": runs["icarus"], "labels": [min(labels), max(labels)],
            "max_width": [min(widths), max(widths)],
            **{name: sum(case[name] for case in cases) for name in ("frames", "pixels", "changes", "stalled", "bursts")},
            "narrow": sum(bool(case["unreachable"]) for case in cases),
            "failures": sum(result["failure"] is not None for result in of_kind),
        })
    faults = [{name: result[name] for name in ("number", "simulator", "failure", "smallest")}
              for result in results if result["failure"] is not None]
    return {"kinds": rows, "faults": faults, "seconds": round(sum(result["seconds"] for result in results) / len(results), 1)}


def _run(options: argparse.Namespace) -> int:
    jobs = _jobs(options)
    for simulator in {simulator for _, _, simulator, _ in jobs.values()}:
        require(simulator)
    results = list(run_campaign("configurations", jobs, options, digest_of_sources("golden", "hdl", "sim/kit", "sim/verify")).values())
    figures = _figures(results)
    for fault in figures["faults"]:
        print(f"Case {fault['number']} on {fault['simulator']}: {fault['failure']}. The smallest that fails:\n{fault['smallest']}")
    runs = {simulator: sum(row[simulator] for row in figures["kinds"]) for simulator in ("verilator", "icarus")}
    print(f"{runs['verilator']} configurations on Verilator, {runs['icarus']} on Icarus; {len(figures['faults'])} not bit-exact; "
          f"{figures['seconds']} seconds of a processor each.")
    if options.record:
        write_record("configurations", f"python -m sim.verify configurations --cases {options.cases} --icarus {options.icarus}", figures)
    return 1 if figures["faults"] else 0


def _section(record: Mapping[str, Any]) -> list[str]:
    rows = record["kinds"]
    total = {name: sum(row[name] for row in rows) for name in
             ("verilator", "icarus", "frames", "pixels", "changes", "stalled", "bursts", "narrow", "failures")}
    lines = [
        f"{total['verilator']} matchers drawn by a seeded generator on Verilator, {total['icarus']} of them on Icarus too: "
        f"{total['frames']} frames, {total['pixels']:,} pixels, every field of every pixel compared; {total['failures']} runs were not "
        f"bit-exact. Frames follow one another without a pause, or, before {total['changes']} of them, only until the settings could "
        f"change. {total['stalled']} frames had stalls, of a probability of 0.1, 0.5 or 0.9 a clock, or, in {total['bursts']}, bursts of "
        "up to 60 clocks, independently at both ends.",
        "",
        "| method, engine, arithmetic | Verilator | Icarus | labels | longest line | frames | settings changed | narrow | not bit-exact |",
        "|---|---:|---:|---:|---:|---:|---:|---:|---:|",
        *(f"| {row['kind']} | {row['verilator']} | {row['icarus']} | {row['labels'][0]} to {row['labels'][1]} | "
          f"{row['max_width'][0]} to {row['max_width'][1]} | {row['frames']} | {row['changes']} | {row['narrow']} | {row['failures']} |"
          for row in rows),
        "",
        "In the frames of each case every label wins at every minimum tree, so that a comparator that loses or swaps an input is seen, but "
        "for the labels that no frame of the case can show: those of disparities as long as its lines, or out of use. The cases that have "
        "such labels are counted as narrow.",
    ]
    for fault in record["faults"]:
        lines += ["", f"- Case {fault['number']} on {fault['simulator']}: {fault['failure']}. Smallest: `{fault['smallest']}`."]
    return lines


PART = Part("configurations", "whole matchers of drawn configurations, bit-exact", _add_options, _run, _section)
