"""Netlists of whole matchers as Verilog of cells, on pictures, and faults of single cells, which the same pictures show."""

import copy
import re

import pytest

from golden.config import Arithmetic, Engine, MatcherConfig, OnePass
from sim.benches.gates import FAMILIES, MATCHERS, GateBench, check_pictures
from sim.benches.matcher_bench import pictures
from sim.kit.simulators import SimulationError


pytest.importorskip("pyosys", reason="pyosys, of the extra resources, is not installed")

SMALL = MatcherConfig(3, 12, engine=Engine.STREAMING, method=OnePass(Arithmetic.LINEAR))


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    """Of the smallest matcher with carry chains and memory blocks, in the elements of a Cyclone III."""
    return GateBench(SMALL, "Cyclone III", tmp_path_factory.mktemp("gates"))


def check(bench):
    lefts, rights = pictures([(12, 5), (5, 2)], bench.case.labels)
    bench.check(lefts, rights, "icarus", stall_i=0.2, stall_o=0.2, timeout=500)


def test_small(small):
    check(small)


def inverted(found):
    """A table with all of its entries inverted."""
    bits, mask = int(found[1]), int(found[2], 16)
    return f".LUT({bits}'h{mask ^ (1 << bits) - 1:x})"


# What is changed, and where among the cells that it could be. So small a picture shows half of all such faults: others are in high bits, in
# settings that are not changed, behind stalls that do not occur.
FAULTS = {
    "table": (r"\.LUT\((\d+)'h(\w+)\)", inverted, 0.7),
    "operand of a carry": (r"\.INVERT\(1'h0\)", ".INVERT(1'h1)", 0.1),
    "register without data": (r"(C3_FF \w+ \((?:\n *\.\w+\(.*\),)*?\n *\.D\()[^()]+\)", r"\g<1>1'h0)", 0.3),
    "memory without data": (r"(?s)(C3_M9K #\(.*?\.WE\()[^()]+\)", r"\g<1>1'h0)", 0.5),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_fault_is_seen(small, fault, tmp_path):
    """One cell is not what it was."""
    pattern, change, part = FAULTS[fault]
    text = small.verilog.read_text()
    places = list(re.finditer(pattern, text))
    place = places[int(len(places) * part)]
    wrong = copy.copy(small)
    wrong.verilog, wrong.folder = tmp_path / "gates.v", tmp_path
    wrong.verilog.write_text(text[:place.start()] + re.sub(pattern, change, place[0], count=1) + text[place.end():])
    assert wrong.verilog.read_text() != text
    # The bench's assertion, that no pixel differs, has no message.
    with pytest.raises((SimulationError, AssertionError), match=r"the harness saw faults|^$"):
        check(wrong)


# Slow: ten seconds of synthesis and of a simulator each.
@pytest.mark.slow
@pytest.mark.parametrize("family", FAMILIES)
@pytest.mark.parametrize("matcher", MATCHERS)
def test_matches_golden(matcher, family, tmp_path):
    check_pictures(GateBench(MATCHERS[matcher], family, tmp_path), "icarus")
