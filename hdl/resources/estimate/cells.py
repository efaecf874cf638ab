"""Yosys's cells as nodes of a graph, a bit of their output at a time, as :mod:`hdl.resources.mapping` maps them."""

from collections.abc import Callable, Sequence

from .flat import FlatCell
from .graph import ADD, ANY, CARRY, FALSE, LAST, MULTIPLIER, PRODUCT, TRUE, Graph


__all__ = ["REGISTER_CONTROLS", "combinational", "operands", "register_inputs"]


#: Ports of a register, beside its data.
REGISTER_CONTROLS = ("EN", "SRST", "ARST")

#: Sums and comparisons of more bits are carry chains.
_IN_TABLES = 2
#: Least widths, the greater one and the smaller one, of the operands of multipliers, which count as one and as two of 9x9 bits.
_SINGLE, _DOUBLE = (4, 4), (10, 4)

_BITWISE = {"$and": Graph.both, "$or": Graph.either, "$xor": Graph.differ}
_SUMS = ("$add", "$sub", "$neg")
_COMPARISONS = ("$lt", "$le", "$gt", "$ge")
_SHIFTS = {"$shl": True, "$sshl": True, "$shr": False, "$sshr": False, "$shift": False, "$shiftx": False}     # to the left?


def _bit(word: Sequence[int], place: int, signed: bool) -> int:
    """A bit of a word that is extended; zero is 0 for nets and for literals."""
    if place < len(word):
        return word[place]
    return word[-1] if signed and word else 0


def register_inputs(cell: FlatCell, place: int) -> list[int]:
    """Nets that bit ``place`` of a register takes: data, and then what of :data:`REGISTER_CONTROLS` it has."""
    return [cell.nets["D"][place], *(cell.nets[port][0] for port in REGISTER_CONTROLS if port in cell.nets)]


def operands(cell: FlatCell, place: int) -> list[int]:
    """Nets that bit ``place`` of the output of a combinational cell depends on."""
    kind, nets = cell.kind, cell.nets
    if kind == "$mux":
        return [nets["A"][place], nets["B"][place], nets["S"][0]]
    if kind == "$pmux":
        return [nets["A"][place], *nets["B"][place::len(nets["Y"])], *nets["S"]]
    if kind in _BITWISE or kind in ("$xnor", "$not", "$pos"):
        return [_bit(nets[port], place, bool(cell.number(f"{port}_SIGNED"))) for port in "AB" if port in nets]
    if kind in _SUMS:
        return [net for port in "AB" if port in nets for net in nets[port][:place + 1]]
    return [net for port in "AB" if port in nets for net in nets[port]]


def combinational(graph: Graph, cell: FlatCell, place: int, literal: Callable[[int], int], value: Callable[[int], int]) -> int:
    """Literal of bit ``place`` of the output of a combinational cell; :data:`ANY` of a multiplexer of nothing else.

    Parameters
    ----------
    literal : callable
        Literal of a net; those of :func:`operands` are known.
    value : callable
        The same, but :data:`ANY` where a net is undefined.
    """
    kind, nets = cell.kind, cell.nets
    if kind == "$mux":
        a, b = value(nets["A"][place]), value(nets["B"][place])
        return max(a, b) if ANY in (a, b) else graph.choose(literal(nets["S"][0]), a, b)
    if kind in _SUMS:
        return _sum(graph, cell, place, literal)
    if kind in _BITWISE or kind in ("$xnor", "$not", "$pos"):
        bits = [literal(net) for net in operands(cell, place)]
        if kind in _BITWISE:
            return _BITWISE[kind](graph, *bits)
        return graph.differ(*bits) ^ 1 if kind == "$xnor" else bits[0] ^ (kind == "$not")
    if kind == "$pmux":
        return _priority(graph, cell, place, literal, value)
    words = [[literal(net) for net in nets[port]] for port in "AB" if port in nets]
    if kind in _SHIFTS:
        return _together(cell, place, lambda: _shift(graph, cell, *words))
    if kind == "$mul":
        return _together(cell, place, lambda: _product(graph, cell, *words))
    if place:
        return FALSE        # what follows has one bit
    if kind in ("$reduce_or", "$reduce_bool", "$logic_not"):
        return graph.any(words[0]) ^ (kind == "$logic_not")
    if kind == "$reduce_and":
        return graph.all(words[0])
    if kind in ("$reduce_xor", "$reduce_xnor"):
        result = int(kind == "$reduce_xnor")
        for bit in words[0]:
            result = graph.differ(result, bit)
        return result
    if kind in ("$logic_and", "$logic_or"):
        join = graph.both if kind == "$logic_and" else graph.either
        return join(graph.any(words[0]), graph.any(words[1]))
    if kind in ("$eq", "$ne", "$eqx", "$nex"):
        left, right = _extended(words[0], words[1], cell.signed)
        return graph.any([graph.differ(*bits) for bits in zip(left, right)]) ^ (kind in ("$eq", "$eqx"))
    if kind in _COMPARISONS:
        left, right = _extended(words[0], words[1], cell.signed)
        return _comparison(graph, kind, left, right, cell.signed)
    return graph.any([bit for word in words for bit in word])       # of any other kind: some function of all


def _extended(left: list[int], right: list[int], signed: bool) -> tuple[list[int], list[int]]:
    """The words, both as wide as the wider one."""
    places = range(max(len(left), len(right)))
    return [_bit(left, place, signed) for place in places], [_bit(right, place, signed) for place in places]


def _together(cell: FlatCell, place: int, compute: Callable[[], list[int]]) -> int:
    """A bit of an output whose bits are computed at once."""
    if cell.state is None:
        cell.state = compute()
    return cell.state[place]


def _priority(graph: Graph, cell: FlatCell, place: int, literal: Callable[[int], int], value: Callable[[int], int]) -> int:
    """At most one selection of a ``$pmux`` is 1."""
    nets = cell.nets
    cases = [(literal(selection), value(net)) for selection, net in zip(nets["S"], nets["B"][place::len(nets["Y"])])]
    cases = [case for case in cases if case[1] != ANY]
    otherwise = value(nets["A"][place])
    if not cases or (len(cases) == 1 and otherwise == ANY):
        return cases[0][1] if cases else otherwise
    chosen = [graph.both(*case) for case in cases]
    if otherwise in (FALSE, ANY):
        return graph.any(chosen)
    return graph.any([*chosen, graph.both(graph.any([selection for selection, _ in cases]) ^ 1, otherwise)])


def _shift(graph: Graph, cell: FlatCell, word: list[int], amount: list[int]) -> list[int]:
    """A row of multiplexers for each bit of the amount."""
    left, width = _SHIFTS[cell.kind], len(cell.nets["Y"])
    signed = bool(cell.number("A_SIGNED")) and cell.kind in ("$sshr", "$shift")
    word = [_bit(word, place, signed) for place in range(max(len(word), width))]
    filling = word[-1] if signed else FALSE
    size = len(word)
    for place, bit in enumerate(amount):
        step = 1 << place
        moved = [FALSE] * step + word if left else word[step:] + [filling] * step
        word = [graph.choose(bit, *pair) for pair in zip(word, moved[:size])] if step < size else [
            graph.choose(bit, each, filling) for each in word]
    return word


def _effective(word: list[int], signed: bool) -> list[int]:
    """The word without bits that only extend it."""
    word = list(word)
    while word and (len(word) > 1 and word[-1] == word[-2] if signed else word[-1] == FALSE):
        word.pop()
    return word


def _product(graph: Graph, cell: FlatCell, a: list[int], b: list[int]) -> list[int]:
    """Bits of the product; a multiplier is a node ``(MULTIPLIER, number of 9x9 multipliers, operands, widths)``."""
    width, signed = len(cell.nets["Y"]), cell.signed
    a, b = sorted((_effective(a, signed), _effective(b, signed)), key=len)
    if len(a) <= 1:
        return [graph.both(a[0], _bit(b, place, signed)) if a else FALSE for place in range(width)]
    widths = len(b), len(a)
    multipliers = 2 if all(map(int.__ge__, widths, _DOUBLE)) else int(all(map(int.__ge__, widths, _SINGLE)))
    node = graph.new(MULTIPLIER, multipliers, (*a, *b), widths)
    return [graph.new(PRODUCT, node) for _ in range(width)]


def _comparison(graph: Graph, kind: str, a: list[int], b: list[int], signed: bool) -> int:
    """``a > b``, or another comparison, by exchange of the operands and inversion of the result."""
    while len(a) > 1 and (a[-1] == a[-2] and b[-1] == b[-2] if signed else a[-1] == b[-1] == FALSE):
        a, b = a[:-1], b[:-1]
    tables = len(a) <= _IN_TABLES or any(all(bit <= TRUE for bit in word) for word in (a, b))
    if kind in ("$lt", "$ge"):
        a, b = b, a
    if signed:
        a, b = [*a[:-1], b[-1]], [*b[:-1], a[-1]]
    inverted = kind in ("$le", "$ge")
    carry = FALSE
    if tables:
        for p, q in zip(a, b):
            constant = p <= TRUE or q <= TRUE
            carry = graph.either(graph.both(p, q ^ 1), graph.both(graph.either(p, q ^ 1), carry)) if constant else graph.choose(
                graph.differ(p, q), carry, p)
        return carry ^ inverted
    for p, q in zip(a[:-1], b[:-1]):
        carry = graph.shared(CARRY, p, q ^ 1, carry)
    return graph.shared(LAST, a[-1], b[-1] ^ 1, carry) ^ inverted


class _Chain(list[int]):
    """The sums so far, with the carry and the operands' bits."""
    def __init__(self, carry: int):
        super().__init__()
        self.carry = carry
        self.pairs: list[tuple[int, int]] = []


def _sum(graph: Graph, cell: FlatCell, place: int, literal: Callable[[int], int]) -> int:
    """Bit ``place`` of a sum or difference: only operands up to there are known."""
    subtracts = cell.kind != "$add"
    if not isinstance(cell.state, _Chain):
        cell.state = _Chain(int(subtracts))
    chain = cell.state
    a, b = ([], cell.nets["A"]) if cell.kind == "$neg" else (cell.nets["A"], cell.nets["B"])
    signed, in_tables = cell.signed, len(cell.nets["Y"]) <= _IN_TABLES
    while len(chain) <= place:
        p = literal(_bit(a, len(chain), signed))
        q = literal(_bit(b, len(chain), signed)) ^ subtracts
        carry = chain.carry
        before = chain.pairs[-2:]
        chain.pairs.append((p, q))
        if carry <= TRUE and q == carry:
            chain.append(p)                             # nothing is added to the low bits
        elif carry <= TRUE and p == carry and not subtracts:
            chain.append(q)
        elif before == [(p, q)] * 2 or (before[-1:] == [(p, q)] and p ^ 1 == q and p <= TRUE):
            chain.append(chain[-1])                     # the sign again
        elif before[-1:] == [(p, q)] and p == q and p <= TRUE:
            chain.append(p)
            chain.carry = p
        elif in_tables:
            chain.append(graph.differ(graph.differ(p, q), carry))
            chain.carry = graph.either(graph.both(p, q), graph.both(carry, graph.either(p, q)))
        else:
            chain.append(graph.shared(ADD, p, q, carry))
            chain.carry = graph.shared(CARRY, p, q, carry)
    return chain[place]
