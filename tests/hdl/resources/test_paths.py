"""Classes of slow paths, from a file of delays: worked by hand, and those of a small design that is placed and routed."""

import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from hdl.resources.clock import place_and_route
from hdl.resources.paths import PathClass, path_classes
from hdl.resources.report import classes_table
from hdl.resources.stand_ins import STAND_INS


def wire(begin, end, delay):
    return rf"(INTERCONNECT {begin} {end} (1:2:{delay}) (1:2:{delay}))"


def cell(name, *timings):
    return [f"(INSTANCE {name})", *timings]


def register(name):
    return cell(name, "(IOPATH CLK Q (1:2:500) (1:2:500))", "(SETUPHOLD (posedge DI) (posedge CLK) (0:0:100) (0:0:0))",
                "(SETUPHOLD (negedge DI) (posedge CLK) (0:0:100) (0:0:0))")


TABLE = "(IOPATH {} F (1:2:{}) (1:2:{}))"


def test_worked_by_hand():
    """Of two ways into a table the later one counts; paths that differ in a label are one class; a pin that no clock leads to is none."""
    lines = [
        *register("up_1.a"), *register("up_2.a"), *register(r"b\[0\]"), *register("up_1.c"), *register("up_2.c"),
        *cell("t", TABLE.format("A", 200, 200), TABLE.format("B", 300, 300)), *cell("pad"),
        wire("up_1.a/Q", "t/A", 2000), wire(r"b\[0\]/Q", "t/B", 1800), wire("t/F", "up_1.c/DI", 1000), wire("up_2.a/Q", "up_2.c/DI", 700),
        wire("up_1.a/Q", "up_2.a/DI", 600), wire("up_2.a/Q", "up_1.a/DI", 400), wire("pad/O", "b/DI", 9000),
    ]
    found = [(path.begin, path.end, round(path.logic, 3), round(path.routing, 3), path.ends) for path in path_classes(lines)]
    # 0.5 + 2 + 0.2 + 1 + 0.1 against 0.5 + 1.8 + 0.3 + 1 + 0.1.
    assert found == [("up_*.a", "up_*.c", 0.8, 3.0, 2), ("up_*.a", "up_*.a", 0.6, 0.6, 2)]
    names = list(path_classes(lines, lambda name: name.replace("up_1.a", "")))
    assert names[0].begin == "up_*.a"  # a cell without a name of ours keeps its own


class Chain(wiring.Component):
    """A sum of two registers, and a register behind it."""
    def __init__(self):
        super().__init__({"a": In(12), "y": Out(12)})

    def elaborate(self, platform):
        m = Module()
        step_1, step_2, total_3 = Signal(12), Signal(12), Signal(12)
        m.d.sync += [step_1.eq(self.a), step_2.eq(step_1), total_3.eq(total_3 + step_2), self.y.eq(total_3)]
        return m


@pytest.mark.parametrize("name", STAND_INS)
def test_placed_design(name):
    """The slowest class has the period that the tool reports, and the names are ours."""
    clock, = place_and_route(Chain(), STAND_INS[name])
    assert clock.device == STAND_INS[name].device and clock.seed == 1
    worst = clock.classes[0]
    assert worst.delay == pytest.approx(1000 / clock.mhz, rel=0.01)
    assert worst.logic == pytest.approx(clock.logic, abs=0.02) and worst.routing == pytest.approx(clock.routing, abs=0.02)
    # The sum is that of two registers; which of them begins the slowest path is the placement's.
    assert ("total_*", "y") in {(found.begin, found.end) for found in clock.classes} and "total_*" in {found.end for found in clock.classes}
    assert len(clock.path_classes) == len(clock.classes) and clock.path_classes[0]["from"] == worst.begin


def test_table():
    class Found:
        classes = (PathClass("a_*", "b", 1.25, 2.5, 1234),)
    shown = classes_table(Found)
    assert [next(iter(column.cells)) for column in shown.columns] == ["a_*", "b", "1.25", "2.50", "3.75", "1,234"]
