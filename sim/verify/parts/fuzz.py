"""Command lines with hostile arguments and files: ``python -m sim.verify fuzz``."""

import argparse
from collections import Counter
from collections.abc import Mapping, Sequence
from typing import Any

from golden.errors import UserError
from golden.pages import table

from ..campaign import Part, add_campaign_options, digest_of_sources, run_campaign, write_record
from ..fuzz.arguments import options_of
from ..fuzz.cases import WAYS, run_case
from ..fuzz.commands import LEFT_OUT, commands, parser_of


__all__ = ["PART"]


_CASES = 2000

#: Faults that the campaign has found, and the test that holds each now.
FOUND = (
    ("a file of JSON, YAML or TOML whose brackets are nested thousands deep ended in a traceback: rig, calibration, parameters, meta.json, "
     "clock, and the manifest in a folder that is written to",
     "tests/golden/rig/test_files.py::test_no_file, tests/golden/pictures/test_calibration_yaml.py::test_refused, "
     "tests/golden/matcher/test_parameters.py::test_bad_files, tests/golden/pictures/test_sets.py::test_refused, "
     "tests/hdl/resources/test_tables.py::test_clock_file_is_refused_before_the_count, "
     "tests/golden/test_files.py::test_no_stale_files_of_a_hostile_manifest, tests/boards/test_ecp5_build.py::test_placed_before"),
    ("disp_range of meta.json may be infinite: a traceback", "tests/golden/pictures/test_sets.py::test_refused"),
    ("a date in YAML that is none: a traceback", "tests/golden/pictures/test_calibration_yaml.py::test_refused"),
    ("what is wrong with the file of --clock was told, as a traceback, after a quarter of an hour of counting",
     "tests/hdl/resources/test_tables.py::test_clock_file_is_refused_before_the_count"),
    ("a signal within the microseconds before a command's body or after it: a traceback",
     "tests/golden/test_endings.py::test_signal_before_and_after_the_body"),
    ("golden thesis repeated the sentence of the command that counts for it",
     "tests/golden/lab/thesis/test_tables.py::test_a_count_that_fails"),
    ("the sentence of a damaged rig named no remedy", "tests/golden/rig/test_files.py::test_refused"),
    ("a signal whose exception a library swallows, such as tifffile as it is imported, was obeyed half a minute late or never",
     "tests/golden/test_endings.py::test_signal_that_is_swallowed"),
    ("compilers that Verilator had started were killed before they removed their temporary files",
     "tests/golden/test_processes.py::test_what_a_program_has_started_may_clean_up"),
)

#: Faults that the campaign has found and that are not mended.
OPEN: tuple[str, ...] = ()

# How a case ended, as the page names it; what has another status is a fault.
_ENDS = {"0": "status 0", "1": "status 1", "2": "status 2", "signal": "ended by the signal", "limit": "ended at the limit of time",
         "pipe": "nobody read stdout"}


def _add_options(parser: argparse.ArgumentParser) -> None:
    add_campaign_options(parser)
    parser.add_argument("--cases", type=int, default=_CASES, metavar="N", help="number of cases (default: %(default)s)")
    parser.add_argument("--seed", type=int, default=1, metavar="S", help="of the cases (default: %(default)s)")
    parser.add_argument("--only", choices=[each.name for each in commands()], metavar="NAME", help=(
        "cases of this command only, such as 'golden match'"))
    parser.add_argument("--case", type=int, metavar="K", help="run this case alone, show it, and leave its files in --work")


def _end(result: Mapping[str, Any]) -> str:
    """How a case ended, one of the keys of :data:`_ENDS`."""
    status = str(result["status"])
    if result["ended"] == "signal" and status not in ("0", "2"):
        return "signal"
    return status if status in _ENDS else "pipe" if result["way"] == "pipe" and status == "141" else str(result["ended"])


def figures(results: Sequence[Mapping[str, Any]], seed: int) -> dict[str, Any]:
    """What the report is made from."""
    by_command: dict[str, Any] = {}
    for command in commands():
        own = [each for each in results if each["command"] == command.name]
        options = options_of(parser_of(command))
        by_command[command.name] = {
            "cases": len(own), "ends": dict(Counter(map(_end, own))), "faults": sum(map(bool, (each["faults"] for each in own))),
            "options": len(options), "given": len({name for each in own for name in each["given"]} & {*options}),
            "accepted": len({name for each in own if each["status"] == 0 for name in each["given"]} & {*options}),
        }
    return {"cases": len(results), "seed": seed, "minutes": round(sum(each["processor"] for each in results) / 60, 1),
            "ways": {way: sum(each["way"] == way for each in results) for way in WAYS}, "commands": by_command}


def _run(options: argparse.Namespace) -> int:
    if options.cases < 1:
        raise UserError(f"--cases must be at least 1, not {options.cases}; choose a greater one")
    if options.only and options.record:
        raise UserError(f"--record is of all commands, and --only {options.only} of one; leave one of the two out")
    if options.case is not None:
        result = run_case(options.seed, options.case, options.only, str(options.work))
        print(f"{result['line']}\nstatus {result['status']}, {result['ended']}; its files are in {options.work}")
        print("\n".join(result["faults"]) or "no fault")
        return 1 if result["faults"] else 0
    cases = {f"{options.seed}/{number} {options.only or ''}".strip(): (run_case, options.seed, number, options.only)
             for number in range(options.cases)}
    results = run_campaign("fuzz", cases, options, digest_of_sources("golden", "hdl", "boards", "sim"))
    for key, result in results.items():
        for fault in result["faults"]:
            print(f"case {key}, {result['way']}: {fault}\n    {result['line']}")
    failed = sum(bool(each["faults"]) for each in results.values())
    print(f"{len(results)} cases, {failed} with faults")
    if options.record:
        write_record("fuzz", f"python -m sim.verify fuzz --cases {options.cases} --seed {options.seed} --record",
                     figures([*results.values()], options.seed))
    return 1 if failed else 0


def _section(record: Mapping[str, Any]) -> list[str]:
    by_command, ways = record["commands"], record["ways"]
    total: Counter[str] = Counter()
    for each in by_command.values():
        total.update(each["ends"])
    rows = [[f"`{name}`", each["cases"], *(each["ends"].get(end, 0) for end in _ENDS), each["faults"],
             f"{each['given']} of {each['options']}", f"{each['accepted']} of {each['options']}"] for name, each in by_command.items()]
    counted = {key: sum(each[key] for each in by_command.values()) for key in ("options", "given", "accepted", "faults")}
    rows.append(["all", record["cases"], *(total[end] for end in _ENDS), counted["faults"], f"{counted['given']} of {counted['options']}",
                 f"{counted['accepted']} of {counted['options']}"])
    found = [f"| {fault} | {', '.join(f'`{test}`' for test in tests.split(', '))} |" for fault, tests in FOUND]
    left_out = "; ".join(f"`{name}`, because {why}" for name, why in LEFT_OUT.items())
    return [
        f"{record['cases']} command lines, seed {record['seed']}, {record['minutes']:g} minutes of a processor in the commands. These are",
        "found by what they are, and their arguments are made from their own parsers, so that a new option is fuzzed without a change.",
        "Files are damaged (cut, bits and words changed, headers that claim 2³¹ pixels, NaN, alpha, 16 bits, empty, deep brackets) or are",
        "none (links that loop, folders, named pipes, devices, no rights, names of 255 bytes, with line breaks, not UTF-8).",
        f"{ways['signal'] + ways['anew']} cases were sent SIGINT, SIGTERM or SIGHUP within two seconds, {ways['anew']} of them from",
        f"Python's start on; {ways['full']} wrote to a full device, {ways['pipe']} to a pipe that nobody reads, {ways['closed']} to no "
        "stdout at all.",
        "",
        "Each must end in its time, with status 0, 2, one that its help documents, or 128 and the signal's number; with one sentence on",
        "stderr that begins with the command's name and has a remedy, or with none; without a traceback or a warning; with each output "
        "whole or as it was before, inputs unchanged, no temporary file and no process left.", "",
        *table(["command", "cases", *_ENDS.values(), "faults", "options given", "of them at success"], rows), "",
        f"Not fuzzed: {left_out}; SIGKILL, which no command can see; what lies behind an open serial port. Commands that count, place or",
        "simulate for minutes are ended after a few seconds: their last steps are seen by their own tests.", "",
        *(["| fault that was found | test that holds it now |", "| --- | --- |", *found] if found else ["No fault was found."]),
        *(["", f"Found and not mended: {'; '.join(OPEN)}."] if OPEN else []),
    ]


PART = Part("fuzz", "command lines with hostile arguments and files", _add_options, _run, _section)
