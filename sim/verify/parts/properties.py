"""Properties of the golden model, with more examples than the tests take: ``python -m sim.verify properties``."""

import argparse
import re
import subprocess
import sys
from collections.abc import Mapping
from typing import Any

from golden.pages import table
from golden.processes import started

from ..campaign import ROOT, Part, add_campaign_options, digest_of_sources, run_campaign, write_record


__all__ = ["PART", "properties_of", "run_property"]


#: Numbers of examples, as tests/conftest.py has them.
PROFILES = ("deep", "fixed")
_FILE = "test_properties.py"
_TEST = re.compile(r"^@given\(.*?^def (test_\w+)", re.MULTILINE | re.DOTALL)


def properties_of(folder: str) -> list[str]:
    """The tests of properties below a folder of the repository, as pytest names them."""
    return [f"{path.relative_to(ROOT)}::{name}" for path in sorted((ROOT / folder).rglob(_FILE))
            for name in _TEST.findall(path.read_text(encoding="utf-8"))]


def run_property(test: str, profile: str = "deep") -> dict[str, Any]:
    """Run a test of a property; whether it holds, the number of examples that passed, and if it does not, the end of what pytest printed.

    Parameters
    ----------
    test : str
        Of :func:`properties_of`.
    profile : str
        One of :data:`PROFILES`, which are in ``tests/conftest.py``.
    """
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "--hypothesis-show-statistics",
               "--hypothesis-profile", profile, test]
    with started(command, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, cwd=ROOT) as process:
        assert process.stdout
        told: str = process.stdout.read()
    passing = sum(map(int, re.findall(r"(\d+) passing", told)))
    return {"holds": process.returncode == 0, "examples": passing, "told": "" if process.returncode == 0 else told[-4000:]}


def _add_options(parser: argparse.ArgumentParser) -> None:
    add_campaign_options(parser)
    parser.add_argument("--profile", choices=PROFILES, default="deep", metavar="|".join(PROFILES), help=(
        "how many examples of each: a thousand, or as few as the tests take (default: %(default)s)"))


def _run(options: argparse.Namespace) -> int:
    cases = {f"{test} {options.profile}": (run_property, test, options.profile) for test in properties_of("tests/golden")}
    results = run_campaign("properties", cases, options, digest_of_sources("golden", "tests/golden"))
    failed = {key: each for key, each in results.items() if not each["holds"]}
    for key, each in failed.items():
        print(f"{key}:\n{each['told']}")
    print(f"{len(results)} properties, {sum(each['examples'] for each in results.values())} examples, {len(failed)} properties do not hold")
    if options.record:
        write_record("properties", f"python -m sim.verify properties --profile {options.profile} --record", {
            "properties": {key.partition(" ")[0]: {"examples": each["examples"], "holds": each["holds"]} for key, each in results.items()}})
    return 1 if failed else 0


def _section(record: Mapping[str, Any]) -> list[str]:
    by_file: dict[str, list[Mapping[str, Any]]] = {}
    for test, each in record["properties"].items():
        by_file.setdefault(test.partition("::")[0], []).append(each)
    rows = [[f"`{file}`", len(own), sum(each["examples"] for each in own), sum(not each["holds"] for each in own)]
            for file, own in by_file.items()]
    return [
        "Laws that hold for any picture and parameters, on examples that Hypothesis draws and reduces: fast versions equal the plain ones; "
        "the transition of a pixel is monotone",
        "and idempotent, and the rule is a chain of transitions; the smallest label wins a tie; an energy is the sum of its terms; mirror "
        "images and transposes give mirrored and transposed",
        "results; text pictures are read as they were written; the identity map rectifies to the same picture. Examples are the same in "
        "every run; `make test` takes twenty of each.", "",
        *table(["tests", "properties", "examples that passed", "properties that do not hold"], rows), "",
        "No property is stated of the methods' quality, and none of the gateware, which equals the golden model by other tests.",
    ]


PART = Part("properties", "laws of the golden model, on drawn examples", _add_options, _run, _section)
