"""Mutants of the gateware's and of the golden matcher's sources against the tests that reach them."""

import argparse
from collections import Counter
from collections.abc import Mapping, Sequence
from itertools import islice
from typing import Any

from golden.cli import progress
from golden.errors import UserError
from golden.lab.workers import Job, workers
from golden.pages import table

from ..campaign import ROOT, Part, add_campaign_options, run_campaign, write_record
from ..mutation.equivalents import Equivalents
from ..mutation.mutants import Mutant, draw, mutants_of
from ..mutation.reach import Reach, content, files_of_tests, record
from ..mutation.runs import MOST_SECONDS, run_mutant


__all__ = ["PART"]


#: What is mutated, how many mutants are drawn by default, and where its tests are: the cheap ones first.
SCOPES = {
    "hdl": (400, ("tests/hdl", "tests/boards", "sim/benches")),
    "golden/matcher": (200, ("tests/golden/matcher", "golden/matcher")),
}
# Of the journal: whatever else changes, a result stays one.
_METHOD = "mutants, 1"
_KILLED = ("comparison", "crash", "time")
_ALIVE = ("survived", "unreached")


def _add_options(parser: argparse.ArgumentParser) -> None:
    add_campaign_options(parser)
    parser.add_argument("--seed", type=int, default=1, metavar="N", help="of the order in which mutants are drawn (default: %(default)s)")
    for scope, (count, _) in SCOPES.items():
        parser.add_argument(f"--{scope.replace('/', '-')}", type=int, default=count, metavar="N", dest=scope,
                            help=f"mutants of {scope} (default: %(default)s)")
    parser.add_argument("--only", metavar="PATH", help="mutants of this folder or file only, such as hdl/video")
    parser.add_argument("--again", choices=["survivors"], help="run those again that survived, because tests have changed")
    parser.add_argument("--seconds", type=float, default=30.0, metavar="N",
                        help="of a processor for the tests of a mutant; dearer ones are left out (default: %(default)s)")


def _mutants(scope: str) -> list[Mutant]:
    found = []
    for path in sorted((ROOT / scope).rglob("*.py")):
        found += mutants_of(str(path.relative_to(ROOT)), path.read_bytes())
    return found


def _record_reach(options: argparse.Namespace, tests: Sequence[str]) -> Reach:
    """What each file of tests reaches; recorded now where it is not known."""
    kept = options.work / "reach"
    jobs: list[Job] = [(record, ROOT, name, tuple(SCOPES), kept, 10 * MOST_SECONDS) for name in tests]
    with progress() as bar, workers(min(options.workers, len(jobs))) as run:
        task = bar.add_task("reach of tests", total=len(jobs))
        run(jobs, lambda number, result: bar.advance(task))
    return Reach(kept, tests)


def _run(options: argparse.Namespace) -> int:
    counts = {scope: getattr(options, scope) for scope in SCOPES}
    for scope, count in counts.items():
        if count < 0:
            raise UserError(f"--{scope.replace('/', '-')} must be at least 0, not {count}; choose a greater one")
    every = {scope: _mutants(scope) for scope in SCOPES}
    equivalents = Equivalents()
    equivalents.check(mutant for mutants in every.values() for mutant in mutants)
    wanted = options.only or ""
    drawn = {scope: list(islice(draw((mutant for mutant in mutants if _below(mutant.file, wanted)), options.seed), counts[scope]))
             for scope, mutants in every.items()}
    if not any(drawn.values()):
        raise UserError(f"no mutants of {wanted or 'anything'}; choose a file or a folder of {' or '.join(SCOPES)} and a count from 1 on")
    tests = [name for scope in SCOPES if drawn[scope] for name in files_of_tests(ROOT, SCOPES[scope][1])]
    reach = _record_reach(options, tests)
    contents = {mutant.file: content(ROOT / mutant.file) for mutants in drawn.values() for mutant in mutants}
    keys = {mutant.key(contents[mutant.file]): mutant for mutants in drawn.values() for mutant in mutants}
    cases: dict[str, Job] = {key: (run_mutant, str(ROOT), mutant, reach.choose(mutant, options.seconds))
                             for key, mutant in keys.items() if not equivalents.reason(mutant)}
    results = run_campaign("mutation", cases, options, _METHOD,
                           again=lambda result: options.again == "survivors" and result["verdict"] in _ALIVE)
    verdicts = {keys[key]: result for key, result in results.items()}
    scopes = [_figures(scope, len(every[scope]), drawn[scope], verdicts, equivalents) for scope in SCOPES if drawn[scope]]
    print("\n".join(line for scope in scopes for line in _told(scope)))
    if options.record:
        write_record("mutation", _command(options, counts), {"seed": options.seed, "scopes": scopes})
    return int(any(scope["survivors"] for scope in scopes))


def _below(file: str, folder: str) -> bool:
    folder = folder.rstrip("/")
    return not folder or file == folder or file.startswith(f"{folder}/")


def _command(options: argparse.Namespace, counts: Mapping[str, int]) -> str:
    chosen = [f"--{scope.replace('/', '-')} {count}" for scope, count in counts.items()]
    return " ".join(["python -m sim.verify mutation", f"--seed {options.seed}", *chosen,
                     *([f"--only {options.only}"] if options.only else []), f"--seconds {options.seconds:g}"])


def _figures(scope: str, total: int, drawn: Sequence[Mutant], verdicts: Mapping[Mutant, Mapping[str, Any]],
             equivalents: Equivalents) -> dict[str, Any]:
    """What the record has of a scope."""
    files: dict[str, Counter[str]] = {}
    survivors, equal = [], []
    for mutant in drawn:
        reason = equivalents.reason(mutant)
        verdict = "equivalent" if reason else verdicts[mutant]["verdict"]
        files.setdefault(mutant.file, Counter())[verdict] += 1
        told = {"file": mutant.file, "operator": mutant.operator, "was": mutant.was, "now": mutant.shown}
        if reason:
            equal.append({**told, "reason": reason})
        elif verdict in _ALIVE:
            survivors.append({**told, "line": mutant.line, "verdict": verdict, "left_out": verdicts[mutant]["left_out"]})
    return {"scope": scope, "mutants": total, "drawn": len(drawn), "files": dict(sorted(files.items())),
            "survivors": survivors, "equivalent": equal}


def _score(counts: Mapping[str, int]) -> str:
    killed, alive = (sum(counts.get(verdict, 0) for verdict in verdicts) for verdicts in (_KILLED, _ALIVE))
    return f"{killed} of {killed + alive}, {100 * killed / (killed + alive):.1f} %" if killed + alive else "-"


def _total(scope: Mapping[str, Any]) -> Counter[str]:
    return sum((Counter(counts) for counts in scope["files"].values()), Counter())


def _told(scope: Mapping[str, Any]) -> list[str]:
    """For the terminal: the score, and each survivor as an entry of the list of equivalents."""
    lines = [f"{scope['scope']}: {_score(_total(scope))} found"]
    for each in scope["survivors"]:
        lines += [f"# {each['file']}:{each['line']}, {each['verdict']}, {each['left_out']} tests left out", "[[mutant]]",
                  *(f"{name} = '''{each[name]}'''" for name in ("file", "operator", "was", "now")), "reason = ''"]
    return lines


def _common(one: str, other: str) -> int:
    """Length of the common beginning of two texts."""
    return next((place for place, (a, b) in enumerate(zip(one, other)) if a != b), min(len(one), len(other)))


def _change(was: str, now: str) -> str:
    """A change of a line, without what is far from it."""
    first = _common(was, now)
    same = _common(was[first:][::-1], now[first:][::-1])
    start = max(first - 30, 0)
    parts = [("... " if start else "") + text[start:len(text) - same + 30] + (" ..." if same > 30 else "") for text in (was, now)]
    return f"`{parts[0]}` became `{parts[1]}`"


def _section(record: Mapping[str, Any]) -> list[str]:
    lines = ["A mutant is a source file with one small change: another operator, comparison, number, reset value, width or delay,",
             "operands swapped, a condition or an assignment dropped, a register more or less. It is found if a test that reaches it",
             "fails: by a comparison, by a crash (the mutant is no circuit, or no Python), or because it takes too long. Mutants are",
             f"drawn at random, seed {record['seed']}, of each room its share; the score leaves out those that compute the same, listed",
             "as such. What an earlier run of that seed did not find has tests since then; another seed measures afresh."]
    for scope in record["scopes"]:
        rooms: dict[str, Counter[str]] = {}
        for file, counts in scope["files"].items():
            rooms.setdefault(file.rpartition("/")[0], Counter()).update(counts)
        columns = (*_KILLED, *_ALIVE, "equivalent")
        lines += ["", f"### Of `{scope['scope']}/`: {_score(_total(scope))} found", "",
                  f"{scope['drawn']} of {scope['mutants']} mutants were drawn.", ""]
        rows = [(f"`{room}/`", *(counts[column] for column in columns), _score(counts)) for room, counts in sorted(rooms.items())]
        lines += table(("room", *columns, "found"), rows)
        lines += ["", "By file: " + "; ".join(f"`{file}` {_score(counts).partition(',')[0]}" for file, counts in scope["files"].items()
                                              if _score(counts) != "-") + "."]
        for name, told in (("survivors", "Not found, a hole each:"), ("equivalent", "The same as the file itself:")):
            if scope[name]:
                lines += ["", told, ""]
                lines += [f"- `{each['file']}`, {each['operator']}: {_change(each['was'], each['now'])}{_why(each)}"
                          for each in scope[name]]
    return lines


def _why(told: Mapping[str, Any]) -> str:
    if "reason" in told:
        return f": {told['reason']}"
    if told["verdict"] == "unreached":
        return "; no test executes it"
    return f"; {told['left_out']} dear tests were left out" if told["left_out"] else ""


PART = Part("mutation", "mutants of the sources against the tests that reach them", _add_options, _run, _section)
