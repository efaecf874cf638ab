"""Places of a source file that a change can be made in: nodes of its syntax tree, with what is around them."""

import ast
import re
from collections.abc import Iterator
from typing import NamedTuple


__all__ = ["Place", "Places"]


#: Keyword arguments that no result depends on.
_SILENT = {"attrs", "help", "metavar", "name", "reset_less", "src_loc_at", "strict"}
_NO_PLACES = ast.Raise | ast.JoinedStr | ast.Import | ast.ImportFrom | ast.Assert


class Place(NamedTuple):
    """A node, and where it is.

    Members
    -------
    node : ast.AST
    above : tuple of ast.AST
        The nodes around it, the outermost first.
    lines : tuple of int
        First and last line of its statement, or of the head of a compound one.
    in_function : bool
        Executed when a function is called.
    """
    node: ast.AST
    above: tuple[ast.AST, ...]
    lines: tuple[int, int]
    in_function: bool


class Places:
    """The syntax tree of a source file with positions in bytes.

    Annotations, docstrings, decorators, formatted text and what is raised are no places: no test should tell their changes.
    """
    def __init__(self, source: bytes):
        self.source = source
        self.tree = ast.parse(source)
        self._starts = [0]
        for line in source.splitlines(keepends=True):
            self._starts.append(self._starts[-1] + len(line))
        #: Names that are assigned in a clock domain, by function.
        self._registers: dict[ast.AST, set[str]] = {}

    def span(self, node: ast.AST) -> tuple[int, int]:
        """First byte of a node and the one behind it, without parentheses around it."""
        assert isinstance(node, ast.expr | ast.stmt) and node.end_lineno is not None and node.end_col_offset is not None
        return self._starts[node.lineno - 1] + node.col_offset, self._starts[node.end_lineno - 1] + node.end_col_offset

    def text(self, node: ast.AST) -> str:
        start, end = self.span(node)
        return self.source[start:end].decode()

    def find(self, token: str, start: int, end: int) -> tuple[int, int] | None:
        """Where a token is between two bytes, not in a comment."""
        gap = re.sub(rb"#[^\n]*", lambda comment: b" " * len(comment[0]), self.source[start:end])
        place = gap.find(token.encode())
        return None if place < 0 else (start + place, start + place + len(token.encode()))

    def registers(self, place: Place) -> set[str]:
        """Names that the function around a place assigns in a clock domain."""
        function = next((node for node in reversed(place.above) if isinstance(node, ast.FunctionDef)), None)
        if function is None:
            return set()
        if function not in self._registers:
            self._registers[function] = {
                call.func.value.id for statement in ast.walk(function) if isinstance(statement, ast.AugAssign)
                and isinstance(statement.target, ast.Attribute) and statement.target.attr != "comb"
                for call in ast.walk(statement.value)
                if isinstance(call, ast.Call) and isinstance(call.func, ast.Attribute) and call.func.attr == "eq"
                and isinstance(call.func.value, ast.Name)}
        return self._registers[function]

    def walk(self) -> Iterator[Place]:
        """All places, the outer ones first."""
        yield from self._walk(self.tree, (), (0, 0), False)

    def _walk(self, node: ast.AST, above: tuple[ast.AST, ...], lines: tuple[int, int], in_function: bool) -> Iterator[Place]:
        if isinstance(node, _NO_PLACES) or _is_main(node) or (isinstance(node, ast.keyword) and node.arg in _SILENT):
            return
        if isinstance(node, ast.stmt):
            body = getattr(node, "body", None)
            lines = node.lineno, (_head_end(node) if body else node.end_lineno or node.lineno)
        if above:
            yield Place(node, above, lines, in_function)
        for name, child in ast.iter_fields(node):
            if name in ("annotation", "returns", "decorator_list", "type_params") or (name == "func" and isinstance(child, ast.Name)):
                continue
            called = in_function or (isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef | ast.Lambda) and name == "body")
            for each in child if isinstance(child, list) else [child]:
                if isinstance(each, ast.AST):
                    yield from self._walk(each, (*above, node), lines, called)


def _head_end(node: ast.stmt) -> int:
    """Last line of a compound statement's head."""
    return max(node.lineno, node.body[0].lineno - 1)       # type: ignore[attr-defined]


def _is_main(node: ast.AST) -> bool:
    return isinstance(node, ast.If) and isinstance(node.test, ast.Compare) and isinstance(node.test.left, ast.Name) \
        and node.test.left.id == "__name__"
