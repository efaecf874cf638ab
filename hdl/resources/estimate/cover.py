"""Tables of four inputs that cover the logic of a graph, as ABC finds them: few, by the flow of area."""

from collections.abc import Iterable

from .cells import register_inputs
from .graph import ADD, CARRY, LOGIC, MULTIPLIER, PRODUCT, RAM, READ, REGISTER, TRUE
from .resolve import Resolved, memory_inputs


__all__ = ["Cover"]


#: Inputs of a table, and the cost of one in tables: a table with fewer inputs is more easily part of another.
_INPUTS, _INPUT = 4, 0.15


class Cover:
    """Which nodes of a design are used, and which are outputs of tables.

    Parameters
    ----------
    resolved : Resolved

    Attributes
    ----------
    uses : list of int
        How many operands of used nodes and outputs each node is; 0 of a node that is not used.
    tables : list of int
        Nodes that are outputs of tables.
    """
    def __init__(self, resolved: Resolved):
        self.resolved = resolved
        self.nodes = resolved.graph.nodes
        self.uses = [0] * len(self.nodes)
        self._needed = bytearray(len(self.nodes))   # as a signal, not only within a table
        self._mark()
        self._cuts: list[frozenset[int] | None] = [None] * len(self.nodes)
        self._find_cuts()
        self.tables = self._choose()

    def _operands(self, node: int) -> tuple[Iterable[int], Iterable[int]]:
        """Literals that a node takes: those that a table may include, and those that must be signals."""
        kind, *rest = self.nodes[node]
        literal = self.resolved.literal
        if kind <= LOGIC:
            return rest, ()
        if kind in (ADD, CARRY):
            return rest[2:], rest[:2]
        if kind == REGISTER:
            return (), [literal(net) for net in register_inputs(*rest)]
        if kind == RAM:
            return (), [literal(net) for net in memory_inputs(*rest)]
        if kind == MULTIPLIER:
            return (), rest[1]
        return (rest, ()) if kind in (READ, PRODUCT) else ((), ())

    def _mark(self) -> None:
        """Follow the operands from the outputs back."""
        uses, needed = self.uses, self._needed
        left: list[int] = []

        def use(literals: Iterable[int], signal: bool) -> None:
            for literal in literals:
                if literal > TRUE:
                    node = literal >> 1
                    if not uses[node]:
                        left.append(node)
                    uses[node] += 1
                    if signal:
                        needed[node] = 1
        use([self.resolved.literal(net) for net in self.resolved.flat.outputs], signal=True)
        while left:
            inside, signals = self._operands(left.pop())
            use(inside, signal=False)
            use(signals, signal=True)

    def _find_cuts(self) -> None:
        """The best inputs of a table at each node: an operand, or instead of it the inputs of its table.

        The flow of a node is the number of tables up to it; a node that several use counts for each of them with its share.
        """
        cuts, uses = self._cuts, self.uses
        flow = [0.0] * len(uses)
        share = [0.0] * len(uses)
        for node, entry in enumerate(self.nodes):
            if entry[0] > LOGIC or not uses[node]:
                continue
            found: list[frozenset[int]] = [frozenset()]
            for literal in entry[1:]:
                if literal <= TRUE:
                    continue
                operand = literal >> 1
                inputs, inner = frozenset((operand,)), cuts[operand]
                if inner is None:
                    found = [cut | inputs for cut in found]
                else:
                    found = [cut | inputs for cut in found] + [joined for cut in found if len(joined := cut | inner) <= _INPUTS]
            best = min((cut for cut in found if len(cut) <= _INPUTS), key=lambda cut: sum(share[each] for each in cut) + _INPUT * len(cut))
            cuts[node] = best
            flow[node] = 1 + sum(share[each] for each in best)
            share[node] = flow[node] / uses[node]

    def _choose(self) -> list[int]:
        needed = self._needed
        tables = []
        for node in range(len(self.nodes) - 1, 0, -1):
            cut = self._cuts[node]
            if cut is not None and needed[node]:
                tables.append(node)
                for each in cut:
                    needed[each] = 1
        return tables
