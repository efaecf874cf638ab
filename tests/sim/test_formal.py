# amaranth: UnusedElaboratable=no
import pytest
from amaranth import *
from amaranth.hdl import Assert, Assume, Elaboratable

from sim.kit.formal import Circuit, prove, told


class Counter(Elaboratable):
    """Counts to ``top`` and stops there; asserts that the count is never ``limit``."""
    def __init__(self, top, limit):
        self.top, self.limit = top, limit
        self.up = Signal()

    def elaborate(self, platform):
        m = Module()
        count = Signal(4, init=1)
        with m.If(self.up & (count != self.top)):
            m.d.sync += count.eq(count + 1)
        m.d.comb += Assert(count != self.limit)
        return m


@pytest.mark.parametrize("top, limit, holds", [(9, 10, True), (10, 10, False), (9, 0, True), (15, 0, True)])
def test_counter(tmp_path, top, limit, holds):
    counter = Counter(top, limit)
    assert prove(counter, [counter.up], tmp_path) is holds


def test_no_assertion(tmp_path):
    counter = Counter(9, 10)
    with pytest.raises(ValueError, match=r"^Counter has no assertion about registers"):
        prove(counter, [], tmp_path)     # no input can change it


def test_time_out(tmp_path):
    counter = Counter(9, 10)
    with pytest.raises(TimeoutError, match=r"^neither proved nor refuted in 1e-05 s$"):
        prove(counter, [counter.up], tmp_path, timeout=1e-5)


def test_violation_by_cycle(tmp_path):
    counter = Counter(3, 3)
    circuit = Circuit(counter, [counter.up], tmp_path)
    assert circuit.check(2).holds and circuit.check(2).depth == 2
    for depth in (None, 3):
        verdict = circuit.check(depth)
        assert not verdict.holds and sum(cycle["up"] for cycle in verdict.trace[:-1]) == 2
    assert len(verdict.trace) == 3
    assert told(verdict.trace).split() == ["cycle", "up", "0", "1", "1", "1", "2", str(verdict.trace[2]["up"])]


class Assumed(Elaboratable):
    """Two registers: one takes an input, which is assumed not to be 3; the other holds what the first one was."""
    def __init__(self, limit):
        self.limit = limit
        self.given = Signal(2)
        self.other = Signal(2)
        self.reached, self.both = Signal(), Signal(2)

    def elaborate(self, platform):
        m = Module()
        first, second = Signal(2), Signal(2)
        m.d.sync += [first.eq(self.given), second.eq(first)]
        m.d.comb += [
            Assume(self.given != 3), Assert(second != self.limit), Assert(first != 3),
            self.reached.eq(second == 2), self.both.eq(second ^ self.other),
        ]
        return m


@pytest.mark.parametrize("limit, holds", [(3, True), (2, False)])
def test_assumption_witness_and_cone(limit, holds, tmp_path):
    """All assertions count, an assumption holds in every cycle, and a cone ends at registers."""
    dut = Assumed(limit)
    circuit = Circuit(dut, [dut.given, dut.other], tmp_path, witness=dut.reached, outputs={"both": dut.both})
    assert circuit.check().holds is circuit.check(10).holds is holds
    assert circuit.inputs_of("both") == {"other"}
    assert circuit.reaches(3) and not circuit.reaches(2)
