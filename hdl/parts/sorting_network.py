"""Networks of compare-exchange elements: sorting, merging and selection by rank, pruned to what reaches an output."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from amaranth import *
from amaranth.hdl import ShapeLike
from amaranth.lib import data, wiring
from amaranth.lib.wiring import In, Out


__all__ = ["Exchange", "Selection", "levels", "merge", "prune", "select", "sort"]


class Exchange(NamedTuple):
    """A compare-exchange element: the smaller value leaves on the wire ``low``, the greater on ``high``; one that is not kept is unused."""
    low: int
    high: int
    keeps_low: bool = True
    keeps_high: bool = True


def merge(a: Sequence[int], b: Sequence[int]) -> tuple[list[Exchange], list[int]]:
    """Batcher's odd-even merge of two lists of wires whose values are sorted.

    Returns
    -------
    exchanges : list of Exchange
    order : list of int
        All wires, the least value first.

    Examples
    --------
    >>> merge([0, 1], [2])
    ([Exchange(low=0, high=2, keeps_low=True, keeps_high=True), Exchange(low=1, high=2, keeps_low=True, keeps_high=True)], [0, 1, 2])
    """
    if not a or not b:
        return [], [*a, *b]
    if len(a) == len(b) == 1:
        return [Exchange(a[0], b[0])], [a[0], b[0]]
    even, ranks = merge(a[::2], b[::2])
    odd, between = merge(a[1::2], b[1::2])
    exchanges, order = even + odd, ranks[:1]
    ranks = ranks[1:]
    for low, high in zip(between, ranks):
        exchanges.append(Exchange(low, high))
        order += [low, high]
    shared = min(len(between), len(ranks))
    return exchanges, order + between[shared:] + ranks[shared:]


def sort(wires: Sequence[int]) -> tuple[list[Exchange], list[int]]:
    """Sorts by merging halves; returns as :func:`merge`."""
    if len(wires) < 2:
        return [], list(wires)
    half = len(wires) // 2
    (first, a), (second, b) = sort(wires[:half]), sort(wires[half:])
    merged, order = merge(a, b)
    return first + second + merged, order


def select(a: Sequence[int], b: Sequence[int], rank: int) -> tuple[list[Exchange], int]:
    """Selects from two lists of wires whose values are sorted the ``rank``-th smallest value of both, from 1.

    The smaller of ``a[i]`` and ``b[rank - 1 - i]``, for all ``i``, are the ``rank`` smallest values; the greatest of them is sought.

    Returns
    -------
    exchanges : list of Exchange
    wire : int
    """
    exchanges: list[Exchange] = []
    left: list[int] = []
    for i in range(rank):
        pair = [side[place] for side, place in ((a, i), (b, rank - 1 - i)) if place < len(side)]
        if len(pair) == 2:
            exchanges.append(Exchange(pair[0], pair[1]))
        left += pair[:1]
    while len(left) > 1:
        pairs = list(zip(left[::2], left[1::2]))
        exchanges += [Exchange(*pair) for pair in pairs]
        left = [high for _, high in pairs] + left[2 * len(pairs):]
    return exchanges, left[0]


def prune(exchanges: Sequence[Exchange], outputs: Iterable[int]) -> list[Exchange]:
    """The exchanges that reach one of the wires ``outputs`` at the end, and which of their two wires do."""
    needed = set(outputs)
    kept = []
    for low, high, *_ in reversed(exchanges):
        if needed & {low, high}:
            kept.append(Exchange(low, high, low in needed, high in needed))
            needed |= {low, high}
    return kept[::-1]


def levels(exchanges: Sequence[Exchange]) -> list[list[Exchange]]:
    """The exchanges by levels: each as early as its wires allow, no two of a level on the same wire."""
    depth: dict[int, int] = {}
    result: list[list[Exchange]] = []
    for exchange in exchanges:
        level = max(depth.get(exchange.low, 0), depth.get(exchange.high, 0))
        depth[exchange.low] = depth[exchange.high] = level + 1
        if level == len(result):
            result.append([])
        result[level].append(exchange)
    return result


class Selection(wiring.Component):
    """A network of compare-exchange elements, pruned to its outputs, with registers behind every level.

    Golden: :func:`sorted`; each output is the value of one rank.

    Timing: latency :attr:`latency` cycles, one set of values a cycle; it cannot be stalled.

    Parameters
    ----------
    shape : shape-like
        Shape of a value.
    wires : int
        Number of inputs.
    exchanges : list of Exchange
    outputs : list of int
        Wires that are outputs, in this order.

    Members
    -------
    i : In(data.ArrayLayout(shape, wires))
    o : Out(data.ArrayLayout(shape, len(outputs)))
    """
    def __init__(self, shape: ShapeLike, wires: int, exchanges: Sequence[Exchange], outputs: Sequence[int]):
        self.shape = shape
        self.levels = levels(prune(exchanges, outputs))
        self.outputs = outputs
        super().__init__({"i": In(data.ArrayLayout(shape, wires)), "o": Out(data.ArrayLayout(shape, len(outputs)))})

    @property
    def latency(self) -> int:
        """Cycles, one a level."""
        return len(self.levels)

    def elaborate(self, platform: object) -> Module:
        m = Module()
        # Wires that a later level or an output still needs.
        alive = [set(self.outputs)]
        for level in reversed(self.levels):
            alive.insert(0, alive[0] | {wire for exchange in level for wire in exchange[:2]})
        values = {wire: self.i[wire] for wire in alive[0]}
        for number, level in enumerate(self.levels):
            later = {wire: Signal(self.shape, name=f"level_{number}_wire_{wire}", reset_less=True) for wire in sorted(alive[number + 1])}
            following = dict(values)
            for low, high, *_ in level:
                swap = Signal(name=f"swap_{number}_{low}_{high}")
                m.d.comb += swap.eq(values[high] < values[low])
                following[low], following[high] = Mux(swap, values[high], values[low]), Mux(swap, values[low], values[high])
            m.d.sync += [register.eq(following[wire]) for wire, register in later.items()]
            values = later
        m.d.comb += [port.eq(values[wire]) for port, wire in zip(self.o, self.outputs)]
        return m
