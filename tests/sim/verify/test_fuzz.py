"""The campaign of command lines: it sees each of many faults, and finds all commands and options."""

import argparse
import random
from pathlib import Path

import pytest

from golden.cli import Parser
from sim.verify.campaign import ROOT
from sim.verify.fuzz import hostile, judge
from sim.verify.fuzz.arguments import Arguments, options_of
from sim.verify.fuzz.cases import WAYS, run_case
from sim.verify.fuzz.commands import BASES, LEFT_OUT, Command, commands, documents_status_1, parser_of
from sim.verify.fuzz.samples import samples
from sim.verify.parts.fuzz import FOUND, PART, figures

from .planted import FAULTS


PLANTED = {kind: Command(f"planted {kind}", "tests.sim.verify.planted", (kind,), seconds=0.5, long=kind in ("deaf", "half_when_ended"))
           for kind in FAULTS}
SEEN = {
    "crash": "KeyError", "two_sentences": "2 sentences on stderr", "no_remedy": "names no remedy",
    "other_name": "does not begin with planted", "silent": "0 sentences on stderr", "other_status": "status 3",
    "undocumented": "status 1", "warns": "DeprecationWarning", "half": "not whole", "written": "though it failed",
    "removed": "removed: old.json", "temporary": "temporary left: .0123", "temporary_folder": "left in TMPDIR",
    "changes_input": "changed, and no output", "leaves_process": "process left: sleep",
    "slow": "took", "deaf": "did not end", "half_when_ended": "not whole",
}


def found(kind, cases, **options):
    """Faults of some cases of a planted command."""
    return [fault for number in range(cases)
            for fault in run_case(3, number, among=[PLANTED[kind]], grace=0.5, **options)["faults"]]


def until(kind, text, cases, **options):
    """Whether one of some cases of a planted command has a fault with the text."""
    return any(text in fault for number in range(cases)
               for fault in run_case(3, number, among=[PLANTED[kind]], grace=0.5, **options)["faults"])


def test_every_planted_fault_has_a_test():
    assert SEEN.keys() | {"sound"} == FAULTS.keys()


@pytest.mark.parametrize("way", [way for way in WAYS if way != "anew"])     # what runs anew does not import the project first
def test_sound_command_has_no_fault(way):
    assert found("sound", 12, way=way) == []


@pytest.mark.parametrize("kind", SEEN)
def test_planted_fault_is_seen(kind):
    assert until(kind, SEEN[kind], 30, way="plain")


def test_half_written_when_ended_by_a_signal():
    assert until("half_when_ended", "not whole", 30, way="signal")


def test_case_is_the_same_every_time():
    first, again = (run_case(5, 8, among=[PLANTED["crash"]], way="plain") for _ in range(2))
    assert {**first, "processor": 0} == {**again, "processor": 0} and first["line"]


def test_every_command_is_fuzzed_or_left_out():
    """Whatever calls ``run_cli``."""
    calling = {path for package in ("golden", "hdl", "boards", "sim") for path in (ROOT / package).rglob("*.py")
               if " run_cli(" in path.read_text(encoding="utf-8") and path.name != "errors.py"}
    fuzzed = {each.module for each in commands()} | LEFT_OUT.keys()
    modules = {".".join(path.relative_to(ROOT).with_suffix("").parts).removesuffix(".__main__") for path in calling}
    within = {module for module in modules if module not in fuzzed}
    names = {each.name.partition(" ")[2] for each in commands() if each.module == "golden"}
    assert len(within) == len(names - {""}) and "match" in names and BASES.keys() == {each.name for each in commands()}


@pytest.mark.parametrize("command", commands(), ids=lambda command: command.name)
def test_parser_is_that_of_the_command(command):
    parser = parser_of(command)
    assert command.name.rpartition(".")[2] in parser.prog and "-h" not in options_of(parser)
    assert documents_status_1(parser) == (command.name in ("sim.demo", "sim.evaluate", "sim.run", "sim.system"))


def test_every_option_is_given(tmp_path):
    parser = Parser()
    parser.add_argument("left", type=Path)
    parser.add_argument("--new", type=int, choices=range(3))
    parser.add_argument("--switch", action=argparse.BooleanOptionalAction)
    below = parser.add_subparsers().add_parser("show")
    below.add_argument("--all", action="store_true")
    given = set()
    for number in range(60):
        place = tmp_path / str(number)
        place.mkdir()
        arguments = Arguments(random.Random(number), place, 0.9)
        arguments.line(parser)
        arguments.close()
        given |= {*arguments.given}
    assert {*options_of(parser)} == given | {"show --all"} == given


def test_every_kind_of_odd_file_can_be_made(tmp_path):
    for kind in {*hostile.ODD_INPUTS, *hostile.ODD_OUTPUTS}:
        folder = tmp_path / kind
        folder.mkdir()
        name = hostile.odd_name(kind, ".png")
        if kind != "too_long":
            hostile.make_odd(kind, folder / name, b"x")
        assert not name.startswith("/")


def test_damaged_files_differ_and_are_seeded():
    for name, data in samples().items():
        versions = [hostile.damaged(name, data, random.Random(f"{name}{number}")) for number in range(30)]
        assert len(set(versions)) > 8 and versions[3] == hostile.damaged(name, data, random.Random(f"{name}3"))


@pytest.mark.parametrize("name", ["left.png", "left.npy", "left.pfm", "left.pgm", "calibrated/rig.json", "camchain.yaml"])
def test_cut_file_is_not_whole(tmp_path, name):
    path = tmp_path / name.replace("/", "_")
    path.write_bytes(samples()[name])
    assert judge.look(tmp_path) and judge._whole(path) == ""
    path.write_bytes(samples()[name][:-2])
    assert judge._whole(path)


def test_page_of_the_figures():
    results = [{"command": "golden match", "way": "plain", "status": 0, "ended": "itself", "processor": 60, "given": ["LEFT", "--output"],
                "faults": []},
               {"command": "sim.run", "way": "signal", "status": 143, "ended": "signal", "processor": 60, "given": ["--simulator"],
                "faults": ["status 143"]}]
    text = "\n".join(PART.section(figures(results, 7)))
    assert "2 command lines, seed 7, 2 minutes" in text
    match, run = (len(options_of(parser_of(each))) for name in ("golden match", "sim.run") for each in commands() if each.name == name)
    assert f"| `golden match` | 1 | 1 | 0 | 0 | 0 | 0 | 0 | 0 | 2 of {match} | 2 of {match} |" in text
    assert f"| `sim.run` | 1 | 0 | 0 | 0 | 1 | 0 | 0 | 1 | 1 of {run} | 0 of {run} |" in text


@pytest.mark.parametrize("fault, tests", FOUND)
def test_faults_that_were_found_are_held(fault, tests):
    for test in tests.split(", "):
        file, _, name = test.partition("::")
        assert f"\ndef {name}(" in (ROOT / file).read_text(encoding="utf-8")


def test_sample_of_the_campaign():
    """Cases of the cheaper commands; the whole campaign is ``python -m sim.verify fuzz``."""
    cheap = [each for each in commands() if not each.name.startswith(("sim.", "hdl.resources", "hdl.build"))]
    results = [run_case(2, number, only=cheap[number % len(cheap)].name) for number in range(2 * len(cheap))]
    assert [(each["faults"], each["line"]) for each in results if each["faults"]] == []
