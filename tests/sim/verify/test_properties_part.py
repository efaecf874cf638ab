"""The part of the verification that runs the properties: it finds all of them, sees one that does not hold, and tells how many examples."""

from sim.verify.campaign import ROOT
from sim.verify.parts import properties


def test_all_properties_are_found():
    found = properties.properties_of("tests/golden")
    given = sum(path.read_text(encoding="utf-8").count("\n@given(") for path in (ROOT / "tests").rglob("test_*.py"))
    assert len(found) == len(set(found)) == given > 30
    assert "tests/golden/matcher/test_properties.py::test_transition_is_monotone_and_idempotent" in found


def test_property_that_holds_and_one_that_does_not():
    holds = properties.run_property("tests/sim/verify/laws.py::test_square", "fixed")
    assert holds == {"holds": True, "examples": 20, "told": ""}
    broken = properties.run_property("tests/sim/verify/laws.py::test_every_number_is_small", "fixed")
    assert not broken["holds"] and "number=101" in broken["told"]


def test_section():
    lines = properties.PART.section({"properties": {
        "a.py::test_x": {"examples": 3, "holds": True}, "a.py::test_y": {"examples": 4, "holds": False}}})
    assert "| `a.py` | 2 | 7 | 1 |" in lines
