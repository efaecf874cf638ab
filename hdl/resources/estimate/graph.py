"""Logic as a graph of small nodes: what is constant, or there already, is not entered again."""

from typing import Any


__all__ = ["ADD", "AND", "ANY", "CARRY", "FALSE", "LAST", "LOGIC", "MULTIPLIER", "MUX", "OTHER", "PRODUCT", "RAM", "READ", "REGISTER",
           "TRUE", "XOR", "Graph"]


#: Kinds of nodes. Logic: ``AND``, ``XOR``, ``MUX`` with selection first, and ``LAST``, the end of a comparison's carry chain. ``ADD`` and
#: ``CARRY`` are the outputs of an element of a chain. A ``READ`` is a bit of what is read from a ``RAM``, a ``PRODUCT`` one of a product.
AND, XOR, MUX, LAST, ADD, CARRY, REGISTER, RAM, READ, MULTIPLIER, PRODUCT, OTHER = range(12)
#: The kinds that tables compute are those up to this one.
LOGIC = LAST

#: Constants as literals. A literal is twice the number of a node, plus 1 if it is inverted; node 0 is the constant.
FALSE, TRUE = 0, 1
#: Not a literal: what a multiplexer may choose instead of an undefined value.
ANY = -1


class Graph:
    """Nodes in an order in which logic follows its operands.

    Attributes
    ----------
    nodes : list of tuple
        A kind and what it needs: literals of logic, cells of registers and memories.
    blocks : list of int
        The block of each node, an index of ``paths`` of :class:`hdl.resources.estimate.flat.Flat`.
    block : int
        That of nodes to be added.
    """
    def __init__(self) -> None:
        self.nodes: list[tuple[Any, ...]] = [(OTHER,)]
        self.blocks = [0]
        self.block = 0
        self.known: dict[tuple[Any, ...], int] = {}

    def new(self, *node: Any) -> int:
        """Literal of a new node."""
        self.nodes.append(node)
        self.blocks.append(self.block)
        return 2 * len(self.nodes) - 2

    def shared(self, *node: Any) -> int:
        """Literal of the node, new or not."""
        literal = self.known.get(node)
        if literal is None:
            literal = self.known[node] = self.new(*node)
        return literal

    def both(self, a: int, b: int) -> int:
        """``a & b``."""
        if a > b:
            a, b = b, a
        if a == FALSE or a ^ 1 == b:
            return FALSE
        if a in (TRUE, b):
            return b
        return self.shared(AND, a, b)

    def either(self, a: int, b: int) -> int:
        """``a | b``."""
        return self.both(a ^ 1, b ^ 1) ^ 1

    def differ(self, a: int, b: int) -> int:
        """``a ^ b``."""
        inverted = (a ^ b) & 1
        a &= ~1
        b &= ~1
        if a > b:
            a, b = b, a
        if a == FALSE:
            return b ^ inverted
        if a == b:
            return inverted
        return self.shared(XOR, a, b) ^ inverted

    def choose(self, selection: int, a: int, b: int) -> int:
        """``b`` if the selection is 1, else ``a``."""
        if selection & 1:
            selection, a, b = selection ^ 1, b, a
        if selection == FALSE or a == b:
            return a
        if a ^ 1 == b:
            return self.differ(selection, a)
        if a in (FALSE, selection):
            return self.both(selection, b)
        if a in (TRUE, selection ^ 1):
            return self.either(selection ^ 1, b)
        if b in (FALSE, selection ^ 1):
            return self.both(selection ^ 1, a)
        if b in (TRUE, selection):
            return self.either(selection, a)
        inverted = a & 1
        return self.shared(MUX, selection, a ^ inverted, b ^ inverted) ^ inverted

    def any(self, literals: list[int]) -> int:
        """Whether one of them is 1: a tree, whose inner nodes fill a table with two products of two literals each."""
        while len(literals) > 1:
            literals = [self.either(*literals[place:place + 2]) if place + 1 < len(literals) else literals[place]
                        for place in range(0, len(literals), 2)]
        return literals[0] if literals else FALSE

    def all(self, literals: list[int]) -> int:
        """Whether each of them is 1."""
        return self.any([literal ^ 1 for literal in literals]) ^ 1
