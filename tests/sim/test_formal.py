# amaranth: UnusedElaboratable=no
import pytest
from amaranth import *
from amaranth.hdl import Assert, Elaboratable

from sim.kit.formal import prove


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
