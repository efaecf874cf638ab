"""Mutants: what is changed, which tests are chosen, and that a run finds what a test can find and nothing else."""

import argparse
import ast

import pytest

from golden.errors import UserError
from sim.verify.campaign import ROOT
from sim.verify.mutation import runs
from sim.verify.mutation.equivalents import Equivalents
from sim.verify.mutation.mutants import draw, mutants_of
from sim.verify.mutation.operators import OPERATORS
from sim.verify.mutation.reach import Chosen, Reach, content, files_of_tests, record
from sim.verify.parts.mutation import PART, SCOPES


def changed(source, operator):
    """New texts of a source by the mutants of an operator."""
    return [mutant.apply(source.encode()).decode() for mutant in mutants_of("a.py", source.encode()) if mutant.operator == operator]


@pytest.mark.parametrize("operator, source, expected", [
    ("arithmetic", "y = (é + b) * c  # +", ["y = (é - b) * c  # +", "y = (é + b) + c  # +"]),
    ("comparison", "y = a < b == c", ["y = a <= b == c", "y = a >= b == c", "y = a < b != c"]),
    ("constant", "y = f(2, True, 0)", ["y = f(1, True, 0)", "y = f(3, True, 0)", "y = f(2, False, 0)", "y = f(2, True, 1)"]),
    ("swap", "y = (a + b) - c", ["y = ((c)) - (a + b)"]),
    ("swap", "y = np.abs(a - b)", []),
    ("swap", "y = Mux(s, a, b)", ["y = Mux(s, (b), (a))"]),
    ("condition", "with m.If(a & b):\n    pass", ["with m.If((a)):\n    pass", "with m.If((b)):\n    pass", "with m.If(0):\n    pass",
                                                  "with m.If(1):\n    pass"]),
    ("condition", "if a or b:\n    pass", ["if (a):\n    pass", "if (b):\n    pass", "if (not (a or b)):\n    pass"]),
    ("condition", "y = ~x", ["y = (x)"]),
    ("reset", "def f(m):\n    x = Signal()\n    y = Signal()\n    m.d.sync += x.eq(y)",
     ["def f(m):\n    x = Signal(init=1)\n    y = Signal()\n    m.d.sync += x.eq(y)"]),
    ("reset", "x = Signal(4, init=7)", ["x = Signal(4, init=0)"]),
    ("domain", "m.d.sync += x.eq(y)", ["m.d.comb += x.eq(y)"]),
    ("domain", "m.d.sync += x.eq(x + 1)", []),      # a loop
    ("delay", "x = Delay(8, n)", ["x = Delay(8, (n) + 1)", "x = Delay(8, (n) - 1)"]),
    ("width", "x = Signal(range(n + 1))", ["x = Signal(range((n + 1) + 1 >> 1))", "x = Signal(range((n + 1) - 1))",
                                           "x = Signal(range((n + 1) - 2))"]),
    ("width", "x = Signal(8)", ["x = Signal(7)"]),
    ("width", "super().__init__({'a': 1, 'b': 4})", ["super().__init__({'a': 1, 'b': 3})"]),
    ("constant", "super().__init__({'a': 1, 'b': 4})", []),
    ("width", "for x in range(n):\n    pass", []),
    ("assignment", "m.d.comb += [a.eq(b), c.eq(d)]", ["m.d.comb += [*(), c.eq(d)]", "m.d.comb += [a.eq(b), *()]"]),
    ("assignment", "m.d.sync += a.eq(b)", ["m.d.sync += []"]),
    ("assignment", "x >>= y\na[0] = b", ["pass\na[0] = b", "x >>= y\npass"]),
])
def test_operators(operator, source, expected):
    assert changed(source, operator) == expected


def test_what_no_test_should_tell_is_no_place():
    source = '''"""1 + 1"""
import a

@cache(1)
def f(x: 2 + 2) -> 3:
    """4"""
    assert x > 5, f"{x + 6}"
    raise ValueError(f"{x - 7}", 8)

m = Memory(attrs={"a": 9}, name="b" + "c")
if __name__ == "__main__":
    f(10)
'''
    assert mutants_of("a.py", source.encode()) == []


def test_each_mutant_of_the_project_is_another_file_and_python():
    """Of a sample, which has each operator."""
    mutants = []
    for scope in SCOPES:
        for path in sorted((ROOT / scope).rglob("*.py"))[::12]:
            mutants += mutants_of(str(path.relative_to(ROOT)), path.read_bytes())
    sample = list(draw(mutants, 5))[:100]
    assert {mutant.operator for mutant in mutants} == set(OPERATORS)
    for mutant in sample:
        source = (ROOT / mutant.file).read_bytes()
        new = mutant.apply(source)
        assert ast.dump(ast.parse(new)) != ast.dump(ast.parse(source))
        assert mutant.lines[0] <= mutant.line <= mutant.lines[1] or mutant.operator == "swap"
    keys = {mutant.key("digest") for mutant in mutants}
    assert len(keys) == len(mutants)


def test_draw_is_a_fair_sample_from_its_beginning():
    """Each room has its share of the first ones, and an edit of one line moves no other mutant."""
    many, few = "\n".join(f"y = a{n} + b" for n in range(90)), "\n".join(f"y = a{n} + b" for n in range(10))
    mutants = [*mutants_of("hdl/a/x.py", many.encode()), *mutants_of("hdl/b/x.py", few.encode())]
    order = list(draw(mutants, 1))
    assert sorted(order) == sorted(mutants)
    assert {mutant.file for mutant in order[:2]} == {"hdl/a/x.py", "hdl/b/x.py"}
    assert 4 <= sum(mutant.file == "hdl/b/x.py" for mutant in order[:50]) <= 6
    assert [mutant.shown for mutant in draw(mutants, 2)] != [mutant.shown for mutant in order]
    edited = mutants_of("hdl/a/x.py", many.replace("a40 ", "c40 ").encode())
    before, after = ([mutant.shown for mutant in draw(each, 1)] for each in (mutants[:90], edited))
    assert [shown for shown in before if "40" not in shown] == [shown for shown in after if "40" not in shown]


ADDER = '''"""An adder."""

LIMIT = 3


def add(a, b):
    return a + b


def limited(x):
    if x > LIMIT:
        return LIMIT
    return x


def untested(x):
    return x + 1


def countdown(x):
    while x:
        x -= 1
    return x
'''

TESTS = '''
import pytest
from hdl.adder import add, countdown, limited


@pytest.fixture(scope="module")
def three():
    return limited(5)


def test_add():
    assert add(2, 1) == 3


def test_first(three):
    pass


def test_second(three):
    assert three == 3


def test_countdown():
    assert countdown(4) == 0
'''


@pytest.fixture(scope="module")
def toy(tmp_path_factory):
    """A project of one file, and what its tests reach."""
    root = tmp_path_factory.mktemp("toy")
    for folder in ("hdl", "tests", "tests/hdl"):
        (root / folder).mkdir()
        (root / folder / "__init__.py").touch()
    for package in ("sim", "golden"):
        (root / package).symlink_to(ROOT / package)
    (root / "pytest.ini").write_text("[pytest]\npythonpath = .\n")
    (root / "hdl" / "adder.py").write_text(ADDER)
    (root / "tests" / "hdl" / "test_adder.py").write_text(TESTS)
    assert record(root, "tests/hdl/test_adder.py", ["hdl"], root / "reach", 60)
    return root


def mutant_of(new, source=ADDER, was=""):
    found = [mutant for mutant in mutants_of("hdl/adder.py", source.encode()) if mutant.shown == new and was in mutant.was]
    assert found, new
    return found[0]


def names(tests):
    return sorted(test.rpartition("::")[2] for test in tests)


def test_reach(toy):
    """By the line that a test executes, also in a fixture that others have made; recorded again when a file has changed."""
    assert files_of_tests(toy, ["tests/hdl", "hdl"]) == ["tests/hdl/test_adder.py"]
    reach = Reach(toy / "reach", ["tests/hdl/test_adder.py"])
    assert names(reach.of(mutant_of("return a - b"))) == ["test_add"]
    assert names(reach.of(mutant_of("if x >= LIMIT:"))) == ["test_first", "test_second"]
    assert names(reach.of(mutant_of("return x - 1"))) == []
    assert names(reach.of(mutant_of("LIMIT = 4"))) == ["test_add", "test_countdown", "test_first", "test_second"]
    assert not record(toy, "tests/hdl/test_adder.py", ["hdl"], toy / "reach", 60)
    with pytest.raises(UserError, match="has not been recorded"):
        Reach(toy / "reach", ["tests/hdl/test_other.py"])


def test_choice_is_cheap(toy):
    """The cheapest first, and no more than the seconds that there are, but one test at least."""
    reach = Reach(toy / "reach", ["tests/hdl/test_adder.py"])
    every = sorted(reach.seconds)
    reach.seconds = {test: 1.0 + number for number, test in enumerate(every)}
    mutant = mutant_of("LIMIT = 4")
    assert reach.choose(mutant, 3.5) == Chosen(every[:2], 3.0, 2)
    assert reach.choose(mutant, 0.1) == Chosen(every[:1], 1.0, 3)


@pytest.mark.parametrize("new, verdict, test", [
    ("return a - b", "comparison", "test_add"),
    ("LIMIT = 4", "comparison", "test_second"),
    ("if (not (x > LIMIT)):", "comparison", "test_second"),
    ("if x >= LIMIT:", "survived", None),       # 3 is 3
    ("return x - 1", "unreached", None),
    ("x -= 2", "survived", None),               # 4 is even
    ("pass", "time", ""),
])
def test_verdicts(toy, monkeypatch, new, verdict, test):
    monkeypatch.setattr(runs, "MARGIN", 3)
    mutant = mutant_of(new)
    before = content(toy / "hdl/adder.py")
    result = runs.run_mutant(str(toy), mutant, Reach(toy / "reach", ["tests/hdl/test_adder.py"]).choose(mutant, 30))
    assert result["verdict"] == verdict
    assert test is None or result["test"].endswith(test)
    assert content(toy / "hdl/adder.py") == before


def test_crash_is_told_apart(toy):
    """A file that cannot be imported, and an exception within a test."""
    chosen = Chosen(["tests/hdl/test_adder.py::test_add"], 1.0, 0)
    for new, error in (("return a + c", "NameError"), ("return a + (", "CollectError")):
        mutant = mutant_of("return a - b")
        start = ADDER.index("a + b")
        result = runs.run_mutant(str(toy), mutant._replace(start=start, end=start + 5, new=new.removeprefix("return ")), chosen)
        assert (result["verdict"], result["error"]) == ("crash", error)


ENTRY = '''[[mutant]]
file = "hdl/adder.py"
operator = "comparison"
was = "if x > LIMIT:"
now = "if x >= LIMIT:"
reason = "the limit itself is returned either way"
'''


def test_equivalents(tmp_path):
    path = tmp_path / "list.toml"
    path.write_text(ENTRY)
    equivalents = Equivalents(path)
    mutants = mutants_of("hdl/adder.py", ADDER.encode())
    assert [mutant.shown for mutant in mutants if equivalents.reason(mutant)] == ["if x >= LIMIT:"]
    equivalents.check(mutants)
    with pytest.raises(UserError, match=r"has 1 entries of no mutant, the first 'if x >= LIMIT:' of hdl/adder\.py"):
        equivalents.check(mutants_of("hdl/adder.py", ADDER.replace("x > LIMIT", "x > 9").encode()))


@pytest.mark.parametrize("text, sentence", [
    (ENTRY * 2, "needs one entry with a reason of one line"), (ENTRY.replace("the limit itself is returned either way", " "), "a reason"),
    (ENTRY.replace("operator", "kind"), "is no list of equivalent mutants"), ("junk", "is no list of equivalent mutants")])
def test_bad_lists_are_refused(tmp_path, text, sentence):
    (tmp_path / "list.toml").write_text(text)
    with pytest.raises(UserError, match=sentence):
        Equivalents(tmp_path / "list.toml")


def test_list_of_the_project_is_of_its_mutants():
    equivalents = Equivalents()
    equivalents.check(mutant for file in equivalents.files for mutant in mutants_of(file, (ROOT / file).read_bytes()))


CALLS: list[str] = []     # mutants that were run
UNREACHED = ["return x + 0", "return x + 2", "return x - 1"]


def test_command(toy, monkeypatch, tmp_path, capsys):
    """Survivors are told and run again when asked for; the score leaves equivalents out."""
    from sim.verify.parts import mutation

    (tmp_path / "list.toml").write_text(ENTRY)
    monkeypatch.setattr(mutation, "ROOT", toy)
    monkeypatch.setattr(mutation, "SCOPES", {"hdl": (400, ("tests/hdl",))})
    monkeypatch.setattr(mutation, "Equivalents", lambda: Equivalents(tmp_path / "list.toml"))
    monkeypatch.setattr(mutation, "run_mutant", fake_run)
    parser = argparse.ArgumentParser()
    PART.add_options(parser)
    options = ["--workers", "1", "--work", str(tmp_path)]
    assert PART.run(parser.parse_args(options)) == 1
    told = capsys.readouterr().out
    every = len(mutants_of("hdl/adder.py", ADDER.encode()))
    assert told.startswith(f"hdl: {every - 1 - len(UNREACHED)} of {every - 1}, ")
    assert told.count("[[mutant]]") == len(UNREACHED) and "now = '''return x - 1'''" in told
    CALLS.clear()
    PART.run(parser.parse_args(options))
    assert CALLS == []
    PART.run(parser.parse_args([*options, "--again", "survivors"]))
    assert sorted(CALLS) == UNREACHED
    with pytest.raises(UserError, match="no mutants of hdl/nothing"):
        PART.run(parser.parse_args([*options, "--only", "hdl/nothing"]))
    with pytest.raises(UserError, match="--hdl must be at least 0, not -1"):
        PART.run(parser.parse_args([*options, "--hdl", "-1"]))


def fake_run(root, mutant, chosen):
    CALLS.append(mutant.shown)
    return {"verdict": "comparison" if chosen.tests else "unreached", "seconds": 1.0, "left_out": 0}
