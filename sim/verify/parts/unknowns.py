"""Matchers that start without any initial value: no unknown bit leaves them, and no result depends on what a register held at first."""

import argparse
import tempfile
from collections import Counter
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from golden.errors import UserError
from golden.lab.workers import Job

from ...kit.simulators import SIMULATORS, require
from ...kit.store import Store
from ..campaign import Part, add_campaign_options, digest_of_sources, run_campaign, write_record
from ..configurations import Case, CaseFrame, draw, failure, literal
from ..initial_values import KEPT, without_initial_values


__all__ = ["PART", "STANDING", "unknown"]


_FRAMES = (CaseFrame(14, 4, stall_o=0.5), CaseFrame(1, 1), CaseFrame(9, 3, "noise", stall_i=0.1, settings={}))
_SMALL = {"reach": 2, "census_rows": 3, "census_columns": 3}
_GATES = {"gate_numerator": 90, "gate_offset": 7, "gate_floor": 3, "minimum": -2}
#: Each method and engine, with all stages.
STANDING: Mapping[str, Case] = {
    "thesis": Case("thesis", 5, 15, _FRAMES, engine="sequential"),
    "linear": Case("thesis", 5, 15, _FRAMES, engine="sequential", parameters={"arithmetic": "linear"}),
    "streaming": Case("thesis", 5, 15, _FRAMES, engine="streaming", parameters={"arithmetic": "linear"}),
    "fused": Case("fused", 5, 15, _FRAMES, minimum=-3, parameters={**_SMALL, "sub_pixel": True}),
    "recursive": Case("recursive", 5, 15, (*_FRAMES, CaseFrame(15, 5, settings=_GATES)), minimum=-3, parameters={
        **_SMALL, "fan": 3, "from_below": True, "sub_pixel": True}),
}

# A model runs a few times; what is worth keeping for long is Verilator's runtime library.
_STORE_LIMIT = 1 << 25


def unknown(case: Case, simulator: str, folder: str, store: Store | None = None, kept: bool = True) -> str | None:
    """What is wrong with a matcher whose registers start as X in Icarus, or as noise by the case's seed in Verilator.

    ``kept``: those of :data:`sim.verify.initial_values.KEPT` keep their values in Icarus.
    """
    rules = KEPT if simulator == "icarus" and kept else ()
    return failure(case, simulator, folder, change=lambda text: without_initial_values(text, rules), store=store)


def _run_case(name: str, simulator: str, seeds: int, work: str) -> dict[str, Any]:
    """Result of a case by name, or by number, on a simulator: on Verilator with noise of so many seeds."""
    case = STANDING[name] if name in STANDING else draw(int(name))
    wrong = None
    for seed in range(1, 1 + (seeds if simulator == "verilator" else 1)):
        with tempfile.TemporaryDirectory(prefix="case-") as folder:
            wrong = wrong or unknown(replace(case, seed=seed), simulator, folder, Store(Path(work) / "models", _STORE_LIMIT))
    return {"case": name, "kind": f"{case.method}, {case.config.engine}, {case.config.method.arithmetic}", "simulator": simulator,
            "failure": wrong, "literal": literal(case)}


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--cases", type=int, default=40, metavar="N",
                        help="drawn configurations beside one of each method and engine (default: %(default)s)")
    parser.add_argument("--seeds", type=int, default=3, metavar="N", help="kinds of noise on Verilator (default: %(default)s)")
    add_campaign_options(parser)


def _jobs(options: argparse.Namespace) -> dict[str, Job]:
    for name, least in (("cases", 0), ("seeds", 1)):
        if getattr(options, name) < least:
            raise UserError(f"--{name} must be at least {least}, not {getattr(options, name)}; choose a greater one")
    work, names = str(Path(options.work).absolute()), [*STANDING, *map(str, range(options.cases))]
    return {f"{simulator} {name}" + f" {options.seeds}" * (simulator == "verilator"): (_run_case, name, simulator, options.seeds, work)
            for simulator in SIMULATORS for name in names}


def _run(options: argparse.Namespace) -> int:
    jobs = _jobs(options)
    for simulator in SIMULATORS:
        require(simulator)
    results = list(run_campaign("unknowns", jobs, options, digest_of_sources("golden", "hdl", "sim/kit", "sim/verify")).values())
    faults = [result for result in results if result["failure"] is not None]
    for fault in faults:
        print(f"Case {fault['case']} on {fault['simulator']}: {fault['failure']}.\n{fault['literal']}")
    kinds = Counter(result["kind"] for result in results if result["simulator"] == "icarus")
    print(f"{kinds.total()} matchers without initial values; {len(faults)} runs with unknown bits, or not bit-exact.")
    if options.record:
        write_record("unknowns", f"python -m sim.verify unknowns --cases {options.cases} --seeds {options.seeds}",
                     {"kinds": dict(sorted(kinds.items())), "seeds": options.seeds, "faults": faults})
    return 1 if faults else 0


def _section(record: Mapping[str, Any]) -> list[str]:
    kinds = record["kinds"]
    lines = [
        f"{sum(kinds.values())} matchers run from Verilog without a single initial value of a register, whether it has a reset or not, and "
        "with memories that nothing has written; only look-up tables have their contents. They are reset once, for four clocks. In Icarus "
        "all this is X: no output word that is valid may have an unknown bit, nor `valid` or `ready` in any clock after the reset, and the "
        f"results must be bit-exact. In Verilator all this is noise, of {record['seeds']} seeds a matcher, and the results must be "
        f"bit-exact. {len(record['faults'])} runs failed.", "",
        "| method, engine, arithmetic | matchers |", "|---|---:|", *(f"| {kind} | {count} |" for kind, count in kinds.items()), "",
        "Holes: a branch on X in Verilog takes the other way, and does not tell; the noise in Verilator is for these. These registers keep "
        "their initial values in Icarus, not in Verilator:", "",
        *(f"- `{each.register}` of `{each.module}`: {each.reason}." for each in KEPT),
    ]
    lines += [f"- Case {fault['case']} on {fault['simulator']}: {fault['failure']}: `{fault['literal']}`." for fault in record["faults"]]
    return lines


PART = Part("unknowns", "matchers whose registers and memories start unknown", _add_options, _run, _section)
