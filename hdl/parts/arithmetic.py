"""Arithmetic shaped for four-input tables and carry chains: sums, products, maximum, selection by an index."""

from collections.abc import Sequence

from amaranth import *
from amaranth.hdl import ValueLike


__all__ = ["add_all", "add_with_carry", "bit_length", "choose", "maximum", "multiply", "times"]


def add_all(m: Module, terms: Sequence[tuple[Value, int]], name: str = "sum") -> tuple[Signal, int]:
    """Sum of unsigned values by a tree of pairs, with registers behind every level.

    A term without a partner passes through a register, so that all take as long.

    Parameters
    ----------
    m : Module
    terms : sequence of (Value, int)
        Two or more values and the largest of each.
    name : str
        Prefix of the signals.

    Returns
    -------
    total : Signal
        Exact.
    latency : int
        Cycles; one sum a cycle.
    """
    level = 0
    while len(terms) > 1:
        sums = []
        for n in range(0, len(terms), 2):
            values, limits = zip(*terms[n:n + 2])
            total = Signal(range(sum(limits) + 1), name=f"{name}_{level}_{n // 2}", reset_less=True)
            m.d.sync += total.eq(sum(values[1:], values[0]))
            sums.append((total, sum(limits)))
        terms, level = sums, level + 1
    return terms[0][0], level


def add_with_carry(a: Value, b: Value, carry: Value) -> Value:
    """``a + b + carry`` in one carry chain: an extra bit below the lowest one generates the carry.

    All are unsigned; the sum is exact: one bit more than the wider of ``a`` and ``b`` holds it. Combinational.
    """
    return (Cat(Const(1, 1), a) + Cat(carry, b)) >> 1


def choose(values: Sequence[ValueLike], index: Value) -> ValueLike:
    """``values[index]`` as a tree of two-input multiplexers, the lowest bit of the index first; combinational.

    ``index`` must be below ``len(values)``; for a greater one the result is one of the values, undefined which.
    """
    for bit in index:
        values = [Mux(bit, values[n + 1], values[n]) if n + 1 < len(values) else values[n] for n in range(0, len(values), 2)]
    return values[0]


def maximum(a: Value, b: Value) -> Value:
    """The greater of two values; combinational."""
    return Mux(a > b, a, b)


def multiply(m: Module, name: str, a: Value, b: Value) -> tuple[Signal, int]:
    """Product of two unsigned values by shifted additions, in pipelined pairs: no multiplier is used.

    Parameters
    ----------
    m : Module
    name : str
        Prefix of the signals.
    a, b : Value
        Factors; each bit of ``b`` is a row of the addition.

    Returns
    -------
    product : Signal
        Exact, ``len(a) + len(b)`` bits.
    latency : int
        Cycles; one product a cycle.
    """
    bits = len(a) + len(b)
    rows = [Mux(bit, a << place, 0) for place, bit in enumerate(b)]
    latency = 0
    while len(rows) > 1 or latency == 0:
        sums = []
        for n in range(0, len(rows), 2):
            total = Signal(bits, name=f"{name}_{latency}_{n // 2}", reset_less=True)
            m.d.sync += total.eq(rows[n] + rows[n + 1] if n + 1 < len(rows) else rows[n])
            sums.append(total)
        rows = sums
        latency += 1
    return rows[0], latency


def bit_length(value: Value) -> Value:
    """Bits of a number without leading zeros."""
    bits = len(value)
    length: Value = Const(0, bits.bit_length())
    for place in range(bits):
        length = Mux(value[place], place + 1, length)
    return length


def times(value: Value, factor: int) -> Value:
    """``value * factor`` as a sum of shifted values; combinational, and exact for any ``value`` and a ``factor`` from 0.

    Synthesis may spend a multiplier on a product with a constant, and then have too few for others.
    """
    terms = [value << bit for bit in range(factor.bit_length()) if factor >> bit & 1]
    return Value.cast(sum(terms[1:], terms[0])) if terms else Const(0)
