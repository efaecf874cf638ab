"""Sums, products, choices and minima against the direct expression."""

from collections.abc import Callable, Sequence
from functools import reduce
from typing import Any

from amaranth import *

from golden.config import Arithmetic, MatcherConfig, OnePass
from hdl.matcher.sequential.argmin import ComparatorTree
from hdl.matcher.stream import Least
from hdl.matcher.streaming.label_array import LabelArray, vertex_rise
from hdl.matcher.streaming.labels import least_of, tree_of
from hdl.parts import arithmetic, sorting_network

from .claim import Claim
from .proof import Proof


__all__ = ["Equals", "PROOFS", "label_passes"]


class Equals(Claim):
    """A value, ``latency`` cycles after its inputs, equals the direct expression of these.

    Parameters
    ----------
    values : function
        Given the module and the claim: the value, the direct expression of the inputs in the same cycle, and the latency.
    """
    def __init__(self, values: Callable[[Module, Claim], tuple[Value, Value, int]]):
        super().__init__()
        self.values = values

    def build(self, m: Module) -> None:
        given, expected, latency = self.values(m, self)
        age = Signal(range(latency + 2))
        for stage in range(latency):
            later = Signal(len(expected), name=f"expected_{stage}")
            m.d.sync += later.eq(expected)
            expected = later
        m.d.sync += age.eq(Mux(age > latency, age, age + 1))
        with m.If(age >= latency):
            self.promise(m, given == expected, "the direct expression")
        m.d.comb += self.witness.eq((age > latency) & given.any())


def later(m: Module, value: Value, cycles: int, name: str) -> Value:
    """A value some cycles later."""
    for stage in range(cycles):
        register = Signal(len(value), name=f"{name}_{stage}")
        m.d.sync += register.eq(value)
        value = register
    return value


def least(values: Sequence[Value]) -> tuple[Value, Value]:
    """The least value and its index; the smaller index wins a tie."""
    best: tuple[Value, Value] = (values[0], C(0, 8))
    for index, value in enumerate(values[1:], 1):
        here = value < best[0]
        best = Mux(here, value, best[0]), Mux(here, index, best[1])
    return best


def _inputs(claim: Claim, number: int, bits: int) -> list[Signal]:
    return [claim.free(bits, f"value_{n}") for n in range(number)]


def _tree(m: Module, claim: Claim) -> tuple[Value, Value, int]:
    m.submodules.tree = tree = ComparatorTree(3, 6)
    values = _inputs(claim, 6, 3)
    m.d.comb += [tree.enable.eq(1), *(port.eq(value) for port, value in zip(tree.i, values))]
    value, index = least(values)
    return Cat(tree.o.value, tree.o.index), Cat(value[:3], index[:len(tree.o.index)]), tree.latency


def _least_of(first: int) -> Callable[[Module, Claim], tuple[Value, Value, int]]:
    """The greatest of three labels from ``first`` on, and of those below."""
    def values(m: Module, claim: Claim) -> tuple[Value, Value, int]:
        own, shape = _inputs(claim, 3, 3), Least(3, 8)
        before, below, found = Signal(shape), Signal(shape), Signal(shape)
        m.d.comb += Value.cast(before).eq(claim.free(6, "below"))
        m.d.comb += Value.cast(below).eq(later(m, Value.cast(before), tree_of(3), "below"))
        least_of(m, own, first, below, found, 3)
        rivals = [*([~before.value] if first else []), *(~value for value in own)]
        value, index = least([rival[:3] for rival in rivals])
        label = Mux(index == 0, before.index, first + index - 1) if first else index
        return Value.cast(found), Cat(~value[:3], label[:3]), tree_of(3) + 1
    return values


def label_passes(m: Module, claim: Claim) -> tuple[Value, Value, int]:
    """The passes of the array of labels; data terms below 4, slopes below 4."""
    config = MatcherConfig(3, 3, method=OnePass(Arithmetic.LINEAR))
    labels, shift = range(3), config.rule.energy_shift
    m.submodules.array = array = LabelArray(config)
    w1, w2, w3 = (claim.free(2, f"w{n}") for n in (1, 2, 3))
    f, b = Signal(2), Signal(2)
    for name, vertex in (("f", f), ("b", b)):
        given = claim.free(2, name)
        m.d.comb += vertex.eq(Mux(given == 3, 0, given))
    costs = [claim.free(2, f"cost_{d}") for d in labels]
    up, down = array.up, array.down
    f_first, same = f < b, f == b
    m.d.comb += [
        up.cone.eq(w2 * f + w3 * b + config.smooth_max),
        up.step.eq(Mux(f == 0, w2, -w2) + Mux(b == 0, w3, -w3) - w1),
        up.low.eq(Mux(f_first, f, b)), up.high.eq(Mux(f_first, b, f)),
        up.low_rise.eq(Mux(same, w2 + w3, Mux(f_first, w2, w3))), up.high_rise.eq(Mux(f_first, w3, w2)),
        up.rise.eq(vertex_rise(up, up.low == 1, up.high == 1)), up.at_low.eq(up.low == 2), up.at_high.eq(up.high == 2),
        down.ramp.eq(2 * w1 * labels[-1]), down.step.eq(2 * w1),
        *(port.eq(~later(m, cost, d, f"cost_{d}").as_unsigned() | ~C(3, len(port)))
          for d, (port, cost) in enumerate(zip(array.cost, costs))),
    ]

    def far(label: int, from_label: Value) -> Value:
        return Mux(from_label > label, from_label - label, label - from_label)[:2]

    energies = [(cost << shift) + w2 * far(d, f) + w3 * far(d, b) for d, cost in enumerate(costs)]
    found = [least([energy + w1 * abs(d - p) for d, energy in enumerate(energies)])[1][:2] for p in labels]
    return Value.cast(array.transition), Cat(found), array.latency


def _sorted(m: Module, claim: Claim) -> tuple[Value, Value, int]:
    exchanges, order = sorting_network.sort(range(5))
    m.submodules.network = network = sorting_network.Selection(2, 5, exchanges, order)
    values = _inputs(claim, 5, 2)
    m.d.comb += [port.eq(value) for port, value in zip(network.i, values)]
    # The value of a rank has at most so many smaller ones.
    ranked = [reduce(lambda best, value: Mux(sum(other < value for other in values) <= rank, arithmetic.maximum(best, value), best),
                     values, C(0, 2)) for rank in range(5)]
    return Value.cast(network.o), Cat(value[:2] for value in ranked), network.latency


def _sum(m: Module, claim: Claim) -> tuple[Value, Value, int]:
    values = _inputs(claim, 5, 3)
    total, latency = arithmetic.add_all(m, [(value, 7) for value in values])
    return total, Value.cast(sum(values, C(0)))[:len(total)], latency


def _product(m: Module, claim: Claim) -> tuple[Value, Value, int]:
    a, b = claim.free(5, "a"), claim.free(4, "b")
    product, latency = arithmetic.multiply(m, "product", a, b)
    return product, (a * b)[:len(product)], latency


def _combinational(m: Module, claim: Claim) -> tuple[Value, Value, int]:
    a, b, carry, index = claim.free(4, "a"), claim.free(4, "b"), claim.free(1, "carry"), claim.free(3, "index")
    values = [claim.free(2, f"value_{n}") for n in range(5)]
    chosen, low = Signal(2), Mux(index < 5, index, 0)
    with m.Switch(low):
        for n, value in enumerate(values):
            with m.Case(n):
                m.d.comb += chosen.eq(value)
    length = Value.cast(sum((a >= 1 << place for place in range(4)), C(0)))[:3]
    given = [arithmetic.add_with_carry(a, b, carry)[:5], Value.cast(arithmetic.choose(values, low)), arithmetic.maximum(a, b),
             arithmetic.bit_length(a)[:3], *(arithmetic.times(a, factor)[:8] for factor in (0, 1, 6, 11))]
    expected = [(a + b + carry)[:5], chosen, Mux(a < b, b, a), length, *(Value.cast(a * factor + C(0, 8))[:8] for factor in (0, 1, 6, 11))]
    held = [Signal(len(other), name=f"given_{n}") for n, other in enumerate(expected)]     # the prover wants a register
    m.d.sync += [register.eq(value) for register, value in zip(held, given)]
    return Cat(held), Cat(expected), 1


def _proof(name: str, size: str, claim: str, values: Callable[[Module, Claim], Any], *, depth: int | None = None,
           quick: bool = True) -> Proof:
    return Proof("minimum", name, claim, size, lambda: Equals(values), depth=depth, quick=quick)


PROOFS = [
    _proof("matcher.sequential.argmin.ComparatorTree", "6 values of 3 bits", "least value and its index, ties to the smaller one", _tree),
    _proof("matcher.streaming.labels.least_of", "3 labels of 3 bits", "the first labels", _least_of(0)),
    _proof("matcher.streaming.labels.least_of, further labels", "3 labels of 3 bits", "with those of the labels below", _least_of(3)),
    _proof("matcher.streaming.label_array.LabelArray", "3 labels, data terms and slopes of 2 bits",
           "both passes: `argmin_d A(d) + w1*abs(d - p)` for each `p`, ties to the smaller label", label_passes, depth=14, quick=False),
    _proof("parts.sorting_network.Selection", "5 values of 2 bits", "the value of each rank", _sorted),
    _proof("parts.arithmetic.add_all", "5 values of 3 bits", "", _sum),
    _proof("parts.arithmetic.multiply", "5 by 4 bits", "", _product),
    _proof("parts.arithmetic, combinational", "4 bits, 5 values to choose from",
           "`add_with_carry`, `choose`, `maximum`, `bit_length`, `times`", _combinational),
]
