"""docs/architecture.md states latencies and rates: they are those of the components at the size that it names."""

import gc
import pathlib
import re

import pytest

from golden.config import FUSED_1, RECURSIVE_1, RECURSIVE_2, Arithmetic, Engine, MatcherConfig, OnePass
from hdl.matcher.census import CensusStage
from hdl.matcher.matcher import Matcher
from hdl.matcher.methods import METHODS
from hdl.matcher.refine.border_fill import BorderFill
from hdl.matcher.refine.fill import Fill
from hdl.matcher.refine.median import Median
from hdl.matcher.refine.weighted_median import WeightedMedian
from hdl.matcher.sequential.bec import Bec
from hdl.matcher.shift import RightShift
from hdl.matcher.streaming.bec_array import BecArray
from hdl.matcher.streaming.cones import Cones
from hdl.matcher.streaming.fused_array import FusedArray
from hdl.matcher.streaming.label_array import LabelArray
from hdl.matcher.streaming.right_view import LeftRightCheck


# Figures of components are read here; nothing is elaborated.
pytestmark = pytest.mark.filterwarnings("ignore::amaranth.hdl.UnusedElaboratable")

PAGE = (pathlib.Path(__file__).parents[3] / "docs" / "architecture.md").read_text(encoding="utf-8")
SEQUENTIAL, STREAMING = (MatcherConfig(80, 720, method=OnePass(arithmetic), engine=engine)
                         for arithmetic, engine in ((Arithmetic.THESIS, Engine.SEQUENTIAL), (Arithmetic.LINEAR, Engine.STREAMING)))
FUSED = MatcherConfig(80, 720, method=FUSED_1)
RECURSIVE, RECURSIVE_BELOW = (MatcherConfig(80, 720, method=method) for method in (RECURSIVE_1, RECURSIVE_2))


@pytest.fixture(autouse=True)
def no_component_is_left():
    """A component that was collected later would warn in another test, which does not ignore it."""
    yield
    gc.collect()


def row(part):
    """Latency and rate in the table of latencies."""
    name, _, which = part.partition(", ")
    which = re.escape(f", {which}" if which else "")
    found, = re.findall(rf"^\| `{name}`{which} \| (.*) \| (.*) \|$", PAGE.partition("| part | latency |")[2], re.MULTILINE)
    return found


def stage(built):
    lines = f"{built.lines} line{'s' * (built.lines > 1)} and " if built.lines else ""
    return f"{lines}{built.latency} clocks", f", and {built.line_clocks} clocks a line" if built.line_clocks else ""


@pytest.mark.parametrize("part", [RightShift, CensusStage, Fill, Median, BorderFill, WeightedMedian], ids=lambda part: part.__name__)
def test_stages(part):
    latency, rate = row(part.__name__)
    expected, line_clocks = stage(part(RECURSIVE if part in (BorderFill, WeightedMedian) else FUSED))
    assert latency.partition(":")[0] == expected and rate.partition("a clock")[2].startswith(line_clocks)
    assert line_clocks or rate == "a pixel a clock"


def test_weighted_median():
    for labels in (2, 5, 80, 256):
        built = WeightedMedian(MatcherConfig(labels, 720, method=RECURSIVE_1))
        assert built.latency == 19 + 9 * (((labels - 1).bit_length() + 1) // 2)
    assert row("WeightedMedian")[0].endswith(": 19 and 9 for two bits of a label")


def test_arrays():
    assert row("BecArray")[0].startswith(f"{BecArray.latency_of(STREAMING)} clocks: 6 + D/4") and BecArray.lag_of(STREAMING) == 0
    lag, latency = FusedArray.lag_of(FUSED), FusedArray.latency_of(FUSED)
    assert row("FusedArray, *fused-1*")[0].startswith(f"{lag} pixels and {latency} clocks: 12 + D/4")
    for labels in (2, 5, 80, 256):
        assert BecArray.latency_of(MatcherConfig(labels, method=OnePass(Arithmetic.LINEAR), engine=Engine.STREAMING)) == 6 - -labels // 4
        assert FusedArray.latency_of(MatcherConfig(labels, method=FUSED_1)) == 12 - -labels // 4
        assert LabelArray(MatcherConfig(labels, method=FUSED_1)).latency == 2 * labels + 6
    assert row("LabelArray")[0] == f"{LabelArray(FUSED).latency} clocks: 2 D + 6"
    with_supports = Cones.latency_of(FUSED, FusedArray.size_max_of(FUSED))
    assert row("Cones")[0] == f"{Cones.latency_of(STREAMING)} clocks, with supports {with_supports}"
    assert row("LeftRightCheck")[0] == f"{LeftRightCheck.LATENCY} clocks"


def test_sequential_engine():
    matcher = Matcher(SEQUENTIAL)
    assert row("Bec") == (f"{Bec(SEQUENTIAL).latency} clocks", f"a pixel each {Bec(SEQUENTIAL).clocks_per_pixel} clocks")
    assert row("SequentialEngine")[1] == f"a pixel each {matcher.clocks_per_pixel} clocks"


@pytest.mark.parametrize("part, config", [("sequential engine", SEQUENTIAL), ("streaming engine", STREAMING), ("*fused-1*", FUSED),
                                          ("*recursive-1*", RECURSIVE), ("*recursive-2*", RECURSIVE_BELOW)])
def test_matcher(part, config):
    matcher = Matcher(config)
    latency, rate = row(f"Matcher, {part}")
    assert latency == f"{matcher.latency_lines} lines and {matcher.latency_clocks} clocks"
    assert rate == (f"a pixel each {matcher.clocks_per_pixel} clocks" if config is SEQUENTIAL else
                    f"a pixel a clock on lines of {matcher.full_rate_width} pixels or more")
    # They are in the README too.
    readme = (pathlib.Path(__file__).parents[3] / "README.md").read_text(encoding="utf-8")
    assert f"| {matcher.latency_lines} lines, {matcher.latency_clocks} clocks |" in readme


def test_table_of_methods():
    for method, parts in METHODS.items():
        groups = [parts.pixels, parts.columns, [parts.costs or parts.engine], [parts.label_output] if parts.costs else [], parts.labels]
        cells = " | ".join(", ".join(f"`{part.__name__}`" for part in group) for group in groups)
        found, = re.findall(rf"^\| `{method.__name__}`[^|]*\| (.*) \|$", PAGE.partition("| method | pixels |")[2], re.MULTILINE)
        assert re.sub(r" +", " ", f" {found} ") == re.sub(r" +", " ", f" {cells} ")
