# amaranth: UnusedElaboratable=no

import itertools

import numpy as np
import pytest
from amaranth import *
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out

from hdl.emit import rtlil_text
from hdl.parts.arithmetic import add_all, add_with_carry, choose, maximum, multiply, times
from sim.kit.clocked import run_clocked


class Product(wiring.Component):
    def __init__(self, a_bits, b_bits):
        super().__init__({"a": In(a_bits), "b": In(b_bits), "o": Out(a_bits + b_bits)})

    def elaborate(self, platform):
        m = Module()
        product, self.latency = multiply(m, "product", self.a, self.b)
        m.d.comb += self.o.eq(product)
        return m


@pytest.mark.parametrize("a_bits, b_bits, latency", [(9, 6, 3), (11, 7, 3), (11, 8, 3), (4, 1, 1), (3, 2, 1), (5, 9, 4)])
def test_multiply(a_bits, b_bits, latency):
    rng = np.random.default_rng(2)
    pairs = [(2**a_bits - 1, 2**b_bits - 1), (0, 2**b_bits - 1), (2**a_bits - 1, 0),
             *zip(rng.integers(0, 2**a_bits, 50).tolist(), rng.integers(0, 2**b_bits, 50).tolist())]
    dut = Product(a_bits, b_bits)
    out = run_clocked(dut, [{"a": a, "b": b} for a, b in pairs], ["o"], drain=latency)
    assert dut.latency == latency
    assert [cycle["o"] for cycle in out[latency:]] == [a * b for a, b in pairs]


class Total(wiring.Component):
    def __init__(self, limits):
        self.limits = limits
        super().__init__({**{f"i{n}": In(range(limit + 1)) for n, limit in enumerate(limits)}, "o": Out(range(sum(limits) + 1))})

    def elaborate(self, platform):
        m = Module()
        total, self.latency = add_all(m, [(getattr(self, f"i{n}"), limit) for n, limit in enumerate(self.limits)])
        assert total.shape() == Shape.cast(range(sum(self.limits) + 1))
        m.d.comb += self.o.eq(total)
        return m


@pytest.mark.parametrize("limits, latency", [((3, 1), 1), ((2, 2, 12), 2), ((8,) * 7, 3), ((1, 5, 8, 8, 3, 0, 200, 7, 9), 4)])
def test_add_all(limits, latency):
    """The least, the greatest and random values, a sum a cycle; a term without a partner takes as long as the others."""
    rng = np.random.default_rng(1)
    cases = [limits, [0] * len(limits), *(rng.integers(0, np.add(limits, 1)).tolist() for _ in range(50))]
    dut = Total(limits)
    out = run_clocked(dut, [{f"i{n}": value for n, value in enumerate(case)} for case in cases], ["o"], drain=latency)
    assert dut.latency == latency
    assert [cycle["o"] for cycle in out[latency:]] == [sum(case) for case in cases]


class Sum(wiring.Component):
    def __init__(self, a_bits, b_bits):
        super().__init__({"a": In(a_bits), "b": In(b_bits), "carry": In(1), "o": Out(max(a_bits, b_bits) + 1)})

    def elaborate(self, platform):
        m = Module()
        m.d.comb += self.o.eq(add_with_carry(self.a, self.b, self.carry))
        return m


@pytest.mark.parametrize("a_bits, b_bits", [(3, 3), (1, 4), (4, 2)])
def test_add_with_carry(a_bits, b_bits):
    """All operands, the greatest among them: the sum is exact."""
    cases = list(itertools.product(range(2**a_bits), range(2**b_bits), range(2)))
    out = run_clocked(Sum(a_bits, b_bits), [{"a": a, "b": b, "carry": carry} for a, b, carry in cases], ["o"])
    assert [cycle["o"] for cycle in out] == [a + b + carry for a, b, carry in cases]


class Maximum(wiring.Component):
    def __init__(self):
        super().__init__({"a": In(4), "b": In(3), "o": Out(4)})

    def elaborate(self, platform):
        m = Module()
        m.d.comb += self.o.eq(maximum(self.a, self.b))
        return m


def test_maximum():
    cases = list(itertools.product(range(16), range(8)))
    assert [cycle["o"] for cycle in run_clocked(Maximum(), [{"a": a, "b": b} for a, b in cases], ["o"])] == [max(case) for case in cases]


class Multiples(wiring.Component):
    FACTORS = range(11)

    def __init__(self):
        super().__init__({"i": In(5), **{f"o{factor}": Out(9) for factor in self.FACTORS}})

    def elaborate(self, platform):
        m = Module()
        m.d.comb += [getattr(self, f"o{factor}").eq(times(self.i, factor)) for factor in self.FACTORS]
        return m


def test_times():
    """By adders: no product is left for synthesis."""
    ports = [f"o{factor}" for factor in Multiples.FACTORS]
    out = run_clocked(Multiples(), [{"i": value} for value in range(32)], ports)
    assert [[cycle[port] for port in ports] for cycle in out] == [[value * factor for factor in Multiples.FACTORS] for value in range(32)]
    assert "$mul" not in rtlil_text(Multiples(), name="top")


class Choice(wiring.Component):
    def __init__(self, count):
        super().__init__({"values": In(data.ArrayLayout(8, count)), "index": In(range(count)), "o": Out(8)})

    def elaborate(self, platform):
        m = Module()
        m.d.comb += self.o.eq(choose(list(self.values), self.index))
        return m


@pytest.mark.parametrize("count", [1, 2, 3, 4, 5, 7, 8, 9, 20])
def test_choose(count):
    """Each value by its index, also where the tree has branches of unlike depth."""
    values = np.random.default_rng(3).permutation(256)[:count].tolist()
    out = run_clocked(Choice(count), [{"values": values, "index": index} for index in range(count)], ["o"])
    assert [cycle["o"] for cycle in out] == values
