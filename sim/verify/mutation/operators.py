"""Kinds of mutants: each is a function from a place to the changes that it makes there."""

import ast
from collections.abc import Callable, Iterator

from .places import Place, Places


__all__ = ["OPERATORS"]


Change = tuple[int, int, str]


_ARITHMETIC: dict[type[ast.operator], tuple[str, str]] = {
    ast.Add: ("+", "-"), ast.Sub: ("-", "+"), ast.Mult: ("*", "+"), ast.FloorDiv: ("//", "*"), ast.Mod: ("%", "//"),
    ast.LShift: ("<<", ">>"), ast.RShift: (">>", "<<"), ast.BitAnd: ("&", "|"), ast.BitOr: ("|", "&"), ast.BitXor: ("^", "&")}
_COMPARISONS: dict[type[ast.cmpop], tuple[str, tuple[str, ...]]] = {
    ast.Eq: ("==", ("!=",)), ast.NotEq: ("!=", ("==",)), ast.Lt: ("<", ("<=", ">=")), ast.LtE: ("<=", ("<", ">")),
    ast.Gt: (">", (">=", "<=")), ast.GtE: (">=", (">", "<"))}
_DELAYS = {"CountedDelay", "Delay", "StepDelay", "sparing_delay"}
_SHAPED = {"Signal", "In", "Out", "unsigned", "signed"}


def _name(function: ast.expr) -> str:
    return function.id if isinstance(function, ast.Name) else function.attr if isinstance(function, ast.Attribute) else ""


def _called(node: ast.AST, *names: str) -> bool:
    return isinstance(node, ast.Call) and _name(node.func) in names


def _is_width(node: ast.AST, above: tuple[ast.AST, ...]) -> bool:
    """Whether a node is a width or a range that declares one; the numbers of a loop are none."""
    parent = above[-1] if above else None
    if _called(node, "range"):
        if isinstance(parent, ast.For | ast.comprehension | ast.Compare | ast.Starred):
            return False
        return not isinstance(parent, ast.Call) or _name(parent.func)[:1].isupper() or _called(parent, "fromkeys", "register", "like")
    if isinstance(parent, ast.Dict) and isinstance(node, ast.Constant):     # a member of a layout
        return any(_called(call, "StructLayout", "__init__") for call in above)
    return isinstance(parent, ast.Call) and _name(parent.func) in _SHAPED and bool(parent.args) and parent.args[0] is node


def _in_width(place: Place) -> bool:
    return any(_is_width(node, place.above[:number]) for number, node in enumerate(place.above)) or _is_width(place.node, place.above)


def _declares_circuit(place: Place) -> bool:
    """Whether a place is outside of all widths, which are narrowed only: a wider one computes the same."""
    return not _in_width(place)


def arithmetic(places: Places, place: Place) -> Iterator[Change]:
    """Another operator of arithmetic or logic."""
    node = place.node
    if isinstance(node, ast.BinOp) and type(node.op) in _ARITHMETIC and _declares_circuit(place):
        token, other = _ARITHMETIC[type(node.op)]
        yield from _replaced(places, token, other, node.left, node.right)


def _replaced(places: Places, token: str, other: str, left: ast.expr, right: ast.expr) -> Iterator[Change]:
    found = places.find(token, places.span(left)[1], places.span(right)[0])
    if found:
        yield (*found, other)


def comparison(places: Places, place: Place) -> Iterator[Change]:
    """A comparison that differs at the limit, or everywhere."""
    node = place.node
    if isinstance(node, ast.Compare):
        operands = [node.left, *node.comparators]
        for left, operator, right in zip(operands, node.ops, operands[1:]):
            token, others = _COMPARISONS.get(type(operator), ("", ()))
            for other in others:
                yield from _replaced(places, token, other, left, right)


def constant(places: Places, place: Place) -> Iterator[Change]:
    """A number that is one more or one less; the other truth value."""
    node = place.node
    if not isinstance(node, ast.Constant) or _is_reset(place) or not _declares_circuit(place):
        return
    if isinstance(node.value, bool):
        yield (*places.span(node), str(not node.value))
    elif isinstance(node.value, int | float):
        yield (*places.span(node), repr(node.value + 1))
        if node.value >= 1:
            yield (*places.span(node), repr(node.value - 1))


def _is_reset(place: Place) -> bool:
    return any(isinstance(node, ast.keyword) and node.arg == "init" for node in place.above)


def swap(places: Places, place: Place) -> Iterator[Change]:
    """Operands in the other order: of a difference, a quotient or a shift, of Mux and of Cat."""
    node = place.node
    if isinstance(node, ast.BinOp) and isinstance(node.op, ast.Sub | ast.FloorDiv | ast.Mod | ast.LShift | ast.RShift):
        of_abs = isinstance(node.op, ast.Sub) and _called(place.above[-1], "abs")
        if _declares_circuit(place) and not of_abs:
            yield _swapped(places, node.left, node.right)
    elif isinstance(node, ast.Call) and not any(isinstance(argument, ast.Starred) for argument in node.args):
        if _called(node, "Mux") and len(node.args) == 3:
            yield _swapped(places, node.args[1], node.args[2])
        elif _called(node, "Cat") and len(node.args) > 1 and not isinstance(node.args[0], ast.GeneratorExp):
            yield _swapped(places, node.args[0], node.args[1])


def _swapped(places: Places, left: ast.expr, right: ast.expr) -> Change:
    (start, left_end), (right_start, end) = places.span(left), places.span(right)
    return start, end, f"({places.text(right)}){places.source[left_end:right_start].decode()}({places.text(left)})"


def condition(places: Places, place: Place) -> Iterator[Change]:
    """A condition that is dropped, always, never or inverted; one operand of a conjunction or a disjunction."""
    node = place.node
    if isinstance(node, ast.With):
        for item in node.items:
            call = item.context_expr
            if isinstance(call, ast.Call) and _called(call, "If", "Elif") and len(call.args) == 1:
                yield (*places.span(call.args[0]), "1")
                yield (*places.span(call.args[0]), "0")
    elif isinstance(node, ast.If | ast.IfExp):
        yield (*places.span(node.test), f"(not ({places.text(node.test)}))")
    elif isinstance(node, ast.comprehension):
        for test in node.ifs:
            yield (*places.span(test), "True")
    elif isinstance(node, ast.BinOp) and isinstance(node.op, ast.BitAnd | ast.BitOr):
        yield from ((*places.span(node), f"({places.text(side)})") for side in (node.left, node.right))
    elif isinstance(node, ast.BoolOp):
        for left, right in zip(node.values, node.values[1:]):
            start, end = places.span(left)[0], places.span(right)[1]
            yield from ((start, end, f"({places.text(side)})") for side in (left, right))
    elif isinstance(node, ast.UnaryOp) and isinstance(node.op, ast.Invert | ast.Not):
        yield (*places.span(node), f"({places.text(node.operand)})")


def reset(places: Places, place: Place) -> Iterator[Change]:
    """Another value after reset."""
    node = place.node
    if isinstance(node, ast.keyword) and node.arg == "init" and not isinstance(node.value, ast.List):
        text = places.text(node.value)
        yield (*places.span(node.value), "0" if text not in ("0", "False") else "1")
    elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Name) and _called(node.value, "Signal"):
        call = node.value
        assert isinstance(call, ast.Call)
        plain = not call.args or isinstance(call.args[0], ast.Constant) or _called(call.args[0], "range")
        if plain and not call.keywords and node.targets[0].id in places.registers(place):
            end = places.span(call)[1] - 1
            yield end, end, f"{', ' if call.args else ''}init=1"


def domain(places: Places, place: Place) -> Iterator[Change]:
    """One cycle less or more: an assignment without its register, or with one."""
    node = place.node
    if isinstance(node, ast.AugAssign) and isinstance(node.target, ast.Attribute) and node.target.attr in ("sync", "comb") \
            and isinstance(node.target.value, ast.Attribute) and node.target.value.attr == "d" and not _feeds_back(places, node):
        _, end = places.span(node.target)
        yield end - 4, end, "comb" if node.target.attr == "sync" else "sync"


def _feeds_back(places: Places, statement: ast.AugAssign) -> bool:
    """Whether a signal is computed from itself: without a register the simulation would not end."""
    return statement.target.attr == "sync" and any(     # type: ignore[union-attr]
        places.text(call.func.value) in {places.text(each) for each in ast.walk(argument) if isinstance(each, ast.expr)}
        for call in ast.walk(statement.value) if isinstance(call, ast.Call) and isinstance(call.func, ast.Attribute)
        and call.func.attr == "eq" for argument in call.args)


def delay(places: Places, place: Place) -> Iterator[Change]:
    """One cycle less or more in a delay."""
    node = place.node
    if isinstance(node, ast.Call) and _called(node, *_DELAYS) and len(node.args) > 1 and not isinstance(node.args[1], ast.Constant):
        yield from ((*places.span(node.args[1]), f"({places.text(node.args[1])}) {change}") for change in ("+ 1", "- 1"))


def width(places: Places, place: Place) -> Iterator[Change]:
    """A declared width that is one bit less, or holds one or two values less."""
    node = place.node
    if not _is_width(node, place.above):
        return
    if isinstance(node, ast.Call) and _called(node, "range"):
        if len(node.args) in (1, 2) and not any(isinstance(argument, ast.Starred) for argument in node.args):
            last = node.args[-1]
            yield from ((*places.span(last), f"({places.text(last)}) {change}") for change in ("- 1", "- 2"))
            if len(node.args) == 1:
                yield (*places.span(last), f"({places.text(last)}) + 1 >> 1")
    elif isinstance(node, ast.Constant) and type(node.value) is int and node.value > 1:
        yield (*places.span(node), str(node.value - 1))
    elif isinstance(node, ast.BinOp) or _called(node, "len"):
        yield (*places.span(node), f"({places.text(node)}) - 1")


def assignment(places: Places, place: Place) -> Iterator[Change]:
    """An assignment less."""
    node = place.node
    if isinstance(node, ast.AugAssign):
        if isinstance(node.target, ast.Attribute) and isinstance(node.target.value, ast.Attribute) and node.target.value.attr == "d":
            elements = node.value.elts if isinstance(node.value, ast.List) else [node.value]
            for element in elements:
                if isinstance(element, ast.Call) and isinstance(element.func, ast.Attribute) and element.func.attr == "eq":
                    yield (*places.span(element), "*()" if isinstance(node.value, ast.List) else "[]")
        else:
            yield (*places.span(node), "pass")
    elif isinstance(node, ast.Assign) and isinstance(node.targets[0], ast.Subscript):
        yield (*places.span(node), "pass")


#: The kinds by name; of two that make the same change the first counts.
OPERATORS: dict[str, Callable[[Places, Place], Iterator[Change]]] = {
    function.__name__: function
    for function in (arithmetic, comparison, constant, swap, condition, reset, domain, delay, width, assignment)}
