"""Part of the verification: the soak of the whole system."""

import argparse
import json
import sys
from collections import Counter
from collections.abc import Iterator, Mapping
from pathlib import Path
from typing import Any

from golden.errors import UserError
from golden.host.registers import RegisterMap, register_map
from golden.pages import table
from sim.benches.system_sizes import SIZES
from sim.kit.simulators import require
from sim.verify.campaign import Part, add_campaign_options, digest_of_sources, run_campaign, write_record
from sim.verify.soak.memory import GROWTH, growth
from sim.verify.soak.runs import emit, run_seed
from sim.verify.soak.schedule import Disturbance, Schedule, schedule, written


__all__ = ["PART"]


# Systems of the smallest pictures that there are: the thesis's method, and the others with all that the monitor sees.
_SIZES = {"thesis": "least", "fused": "glance", "recursive": "least recursive"}

# Rounds from which on a line through the second half of the samples means something.
_ROUNDS = 8


def _registers(size: str) -> RegisterMap:
    parameters = SIZES[size]
    return register_map(parameters.config, parameters.camera.height, parameters.rig)


def _schedules(options: argparse.Namespace) -> dict[str, tuple[Schedule, int, str]]:
    """Schedule, seed and size of each run: segments of a round each, and one of many rounds."""
    size = _SIZES[options.method]
    registers = _registers(size)
    seeds = [options.seed] if options.only else range(options.seed, options.seed + options.segments)
    runs = {f"segment {seed}": (schedule(seed, registers, 1, options.disturbances), seed, size) for seed in seeds}
    if options.rounds and not options.only:
        seed = options.seed + options.segments
        runs[f"long run {seed}"] = schedule(seed, registers, options.rounds, options.disturbances), seed, size
    return runs


def _source(options: argparse.Namespace, sources: str) -> Path:
    """The Verilog of the system, which is written once."""
    folder = options.work / "soak" / sources
    size = _SIZES[options.method]
    found = folder / f"{size.replace(' ', '-')}.v"
    return (found if found.exists() else emit(size, folder)).absolute()


def _disturbances(runs: Mapping[str, tuple[Schedule, int, str]]) -> Iterator[Disturbance]:
    for plan, _, _ in runs.values():
        for each_round in plan:
            yield from each_round


def _kinds(runs: Mapping[str, tuple[Schedule, int, str]]) -> dict[str, int]:
    """How often each fault and each other kind of disturbance is in the schedules."""
    found: Counter[str] = Counter()
    for drawn in _disturbances(runs):
        if drawn["kind"] == "faults":
            for where in ("left", "right"):
                found.update([f"camera: {drawn[where][0]}"] if where in drawn else [])
            found.update(drawn[where] for where in ("host", "memory") if where in drawn)
        elif drawn["kind"] == "reset":
            found["reset of the whole system" + (" within a request" if drawn["in_request"] else "")] += 1
            found["memory initialised late"] += drawn["init"] > 5000
        elif drawn["kind"] == "pause":
            found["picture held" if drawn["hold"] else "pause"] += 1
        else:
            found["writes"] += len(drawn["requests"])
    return dict(sorted(found.items()))


def _figures(options: argparse.Namespace, runs: Mapping[str, tuple[Schedule, int, str]], results: Mapping[str, Any]) -> dict[str, Any]:
    good = [result for result in results.values() if "failed" not in result]
    registers = _registers(_SIZES[options.method])
    reached = written([each for plan, _, _ in runs.values() for each in plan], registers)
    sampled = [result["resident"] for name, result in results.items() if name.startswith("long") and "failed" not in result]
    resident = sampled[0] if sampled else []
    return {
        "method": options.method, "runs": len(results), "failed": [name for name, result in results.items() if "failed" in result],
        "frames": sum(result["frames"] for result in good), "shown": sum(result["shown"] for result in good),
        "recovered": sum(result["recovered"] for result in good), "kinds": _kinds(runs),
        "registers": [len(reached), sum(legal for legal, _ in reached.values()), sum(illegal for _, illegal in reached.values())],
        "seconds": round(sum(result["seconds"] for result in good), 1), "resident": resident,
        "growth": growth(resident) if len(resident) >= _ROUNDS else None, "bound": GROWTH}


def _run(options: argparse.Namespace) -> int:
    for name, least in (("segments", 1), ("disturbances", 1), ("rounds", 0), ("seed", 0)):
        if getattr(options, name) < least:
            raise UserError(f"--{name} must be at least {least}, not {getattr(options, name)}; choose a greater one")
    if 0 < options.rounds < _ROUNDS:
        raise UserError(f"--rounds must be 0 or at least {_ROUNDS}, not {options.rounds}: fewer do not tell whether memory grows")
    if options.only and options.record:
        raise UserError("--only repeats one segment, and --record is for a whole run; choose one of them")
    require("verilator")
    sources = digest_of_sources("golden", "hdl", "sim")
    source = _source(options, sources)
    runs = _schedules(options)
    cases = {f"{size}, {name}, {len(plan)}x{options.disturbances}": (run_seed, plan, seed, size, source)
             for name, (plan, seed, size) in runs.items()}
    results = dict(zip(runs, run_campaign("soak", cases, options, sources).values(), strict=True))
    for name, result in results.items():
        if "failed" in result:
            print(f"{name}: {result['failed']}\n  smallest schedule: {json.dumps(result['schedule'])}")
    figures = _figures(options, runs, results)
    print("\n".join(_section(figures)))
    if options.record:
        asked = " ".join(f"--{name} {getattr(options, name)}" for name in ("method", "segments", "disturbances", "rounds", "seed"))
        write_record("soak", f"python -m sim.verify soak {asked}", figures)
    grown = figures["growth"] is not None and figures["growth"] > GROWTH
    if grown:
        print(f"sim.verify soak: the simulator's process grows by {figures['growth']:,.0f} bytes in 100 frames", file=sys.stderr)
    return int(grown or bool(figures["failed"]))


def _section(record: Mapping[str, Any]) -> list[str]:
    total, legal, illegal = record["registers"]
    lines = [
        f"{record['frames']:,} frames of each camera, {record['shown']:,} of the monitor, in {record['runs']} runs of the system with the "
        f"method {record['method']} at its smallest pictures; {record['recovered']} disturbances. After each, within 24 frames of the "
        "monitor two in a row were bit-exact for the scene and the settings that were read back; each fault's counter had counted, and the "
        "LED of a camera's signal had been off; every wait is bounded. After each round the cameras stop, and each frame that they have "
        "sent is a pair or in one of the counters of dropped, skipped and unpaired frames; counts of corrected and rejected codes are "
        "golden's.",
        "", f"Of {total} registers that can be written {legal} were written with legal values and {illegal} with others; each reply was "
        f"golden's. A frame took {record['seconds'] / max(record['frames'], 1):.2f} s of a processor."]
    if record["growth"] is not None:
        (frames, first), (_, last) = record["resident"][0], record["resident"][-1]
        lines += ["", f"Memory of a run of {record['resident'][-1][0]:,} frames: {first / 1e6:.1f} MB after {frames} of them, "
                  f"{last / 1e6:.1f} MB at its end; its slope over the second half is "
                  f"{round(record['growth'] / 1e3, 1) + 0:.1f} kB in 100 frames, and "
                  f"{record['bound'] / 1e3:.0f} kB is the bound."]
    failed = ", ".join(record["failed"]) or "none"
    return [*lines, "", f"Runs that failed: {failed}.", "", *table(["disturbance", "times"], [*record["kinds"].items()]), "",
            "Not among them: maps that the host loads and swaps (`map_swap` is written, and pictures then compared without rectification), "
            "scenes that change under the automatic balance, faults of the memory at the same time as others."]


def _add_options(parser: argparse.ArgumentParser) -> None:
    parser.add_argument("--method", choices=_SIZES, default="thesis", help="default: %(default)s")
    parser.add_argument("--segments", type=int, default=40, metavar="N", help="runs, each from its own seed (default: %(default)s)")
    parser.add_argument("--disturbances", type=int, default=4, metavar="N", help="of a segment, and of a round (default: %(default)s)")
    parser.add_argument("--rounds", type=int, default=20, metavar="N",
                        help="of one run more, whose memory is sampled; 0: without it (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the first segment (default: %(default)s)")
    parser.add_argument("--only", action="store_true", help="the segment of --seed alone")
    add_campaign_options(parser)


PART = Part("soak", "the whole system for long, with faults, resets, writes and pauses drawn from a seed", _add_options, _run, _section)
