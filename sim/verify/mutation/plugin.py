"""For pytest, as ``-p sim.verify.mutation.plugin``: which lines each test executes, or whether chosen tests find a mutant.

Options: ``--reach FILE`` writes a line of JSON for each test, which lines of the files below ``--reach-of`` it executes.
``--chosen FILE`` runs the tests that the file lists, in their order, and writes what the first failure was to ``--verdict FILE``.
"""

import functools
import inspect
import json
import os
import resource
import sys
from collections.abc import Callable, Generator
from pathlib import Path
from types import CodeType, FrameType
from typing import Any

import pytest
from amaranth.sim import Simulator


# Failures of a comparison; the time-outs of simulations are among them. All else is a crash of the mutant itself.
_COMPARISONS = ("AssertionError", "DocTestFailure", "Failed", "TimeoutError")


# Lines told of a function without a new one among them. Loops over pixels would take minutes otherwise.
_PATIENCE = 2000


def pytest_addoption(parser: pytest.Parser) -> None:
    group = parser.getgroup("mutation")
    group.addoption("--reach", metavar="FILE")
    group.addoption("--reach-of", metavar="FOLDER", action="append", default=[])
    group.addoption("--chosen", metavar="FILE")
    group.addoption("--verdict", metavar="FILE")
    group.addoption("--processor-seconds", metavar="N", type=int)


def pytest_configure(config: pytest.Config) -> None:
    limit = config.getoption("--processor-seconds")
    if limit:
        resource.setrlimit(resource.RLIMIT_CPU, (limit, limit + 5))
        resource.setrlimit(resource.RLIMIT_DATA, (3 << 30, 3 << 30))    # of widths that a mutant makes huge
    if config.getoption("--reach"):
        config.pluginmanager.register(Reach(config))
    if config.getoption("--chosen"):
        config.pluginmanager.register(Chosen(config))


def _processor_seconds() -> float:
    times = os.times()
    return times.user + times.system + times.children_user + times.children_system


class _Function:
    """Lines of a function that a test has executed, and how many events are still waited for before it is told of no further ones."""
    __slots__ = ("lines", "patience")

    def __init__(self) -> None:
        self.lines: set[int] = set()
        self.patience = _PATIENCE


class Reach:
    """Records the lines of functions that each test executes, and the seconds that it takes."""
    def __init__(self, config: pytest.Config):
        self.root = config.rootpath
        self.folders = tuple(f"{self.root / folder}{os.sep}" for folder in config.getoption("--reach-of"))
        self.file = Path(config.getoption("--reach"))
        self.fixtures: dict[Any, dict[str, set[int]]] = {}  # lines that made a fixture which several tests share
        self._ours: dict[str, bool] = {}
        self._functions: dict[CodeType, _Function] = {}
        for name in ("advance", "run", "run_until"):
            setattr(Simulator, name, _untraced(getattr(Simulator, name)))

    def _call(self, frame: FrameType, event: str, argument: object) -> Any:
        code = frame.f_code
        function = self._functions.get(code)
        if function is None:
            name = code.co_filename
            ours = self._ours.get(name)
            if ours is None:
                ours = self._ours[name] = name.startswith(self.folders)
            if not ours:
                return None
            function = self._functions[code] = _Function()
        return self._line if function.patience else None

    def _line(self, frame: FrameType, event: str, argument: object) -> Any:
        function = self._functions.get(frame.f_code)
        if function is None or not function.patience:
            frame.f_trace_lines = False
        elif event == "line":
            if frame.f_lineno in function.lines:
                function.patience -= 1
            else:
                function.lines.add(frame.f_lineno)
                function.patience = _PATIENCE
        return self._line

    def _lines(self) -> dict[str, set[int]]:
        lines: dict[str, set[int]] = {}
        for code, function in self._functions.items():
            lines.setdefault(os.path.relpath(code.co_filename, self.root), set()).update(function.lines)
        return lines

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_protocol(self, item: pytest.Item) -> Generator[None, Any, Any]:
        _forget()
        self._functions = {}
        begin = _processor_seconds()
        sys.settrace(self._call)
        try:
            return (yield)
        finally:
            sys.settrace(None)
            lines = self._lines()
            shared = item._fixtureinfo.name2fixturedefs.values() if isinstance(item, pytest.Function) else ()
            for definitions in shared:
                for name, more in self.fixtures.get(definitions[-1], {}).items():
                    lines.setdefault(name, set()).update(more)
            entry = {"test": item.nodeid, "seconds": round(_processor_seconds() - begin, 3),
                     "lines": {file: sorted(these) for file, these in sorted(lines.items())}}
            with self.file.open("a", encoding="utf-8") as file:     # at once: the limit of seconds may end this process
                file.write(f"{json.dumps(entry)}\n")

    @pytest.hookimpl(wrapper=True)
    def pytest_fixture_setup(self, fixturedef: Any) -> Generator[None, Any, Any]:
        if fixturedef.scope == "function":
            return (yield)
        before, self._functions = self._functions, {}
        try:
            return (yield)
        finally:
            self.fixtures[fixturedef] = self._lines()
            self._functions = before


def _untraced(method: Callable[..., Any]) -> Callable[..., Any]:
    """A method of the simulator: no component's source is executed in it, and it is three times as fast untraced."""
    @functools.wraps(method)
    def run(*arguments: Any, **options: Any) -> Any:
        trace = sys.gettrace()
        sys.settrace(None)
        try:
            return method(*arguments, **options)
        finally:
            sys.settrace(trace)
    return run


def _forget() -> None:
    """Empty what functions of tests and benches have built for others, so that a test executes what it needs itself."""
    for name, module in list(sys.modules.items()):
        if name.startswith(("tests.", "sim.models.", "sim.system")):
            for value in vars(module).values():
                if isinstance(value, functools._lru_cache_wrapper) and inspect.signature(value).parameters:
                    value.cache_clear()


class Chosen:
    """Runs the tests that a file lists, in its order, and writes what the first failure was."""
    def __init__(self, config: pytest.Config):
        self.order = {name: number for number, name in enumerate(json.loads(Path(config.getoption("--chosen")).read_text()))}
        self.file = Path(config.getoption("--verdict"))

    def _tell(self, test: str, error: str) -> None:
        if not self.file.exists():
            kind = "comparison" if error in _COMPARISONS else "crash"
            self.file.write_text(json.dumps({"verdict": kind, "test": test, "error": error}), encoding="utf-8")

    @pytest.hookimpl(trylast=True)
    def pytest_collection_modifyitems(self, config: pytest.Config, items: list[pytest.Item]) -> None:
        kept = [item for item in items if item.nodeid in self.order]
        config.hook.pytest_deselected(items=[item for item in items if item.nodeid not in self.order])
        items[:] = sorted(kept, key=lambda item: self.order[item.nodeid])

    @pytest.hookimpl(wrapper=True)
    def pytest_make_collect_report(self, collector: pytest.Collector) -> Generator[None, Any, Any]:
        report = yield
        if report.failed:
            self._tell(collector.nodeid, "CollectError")
        return report

    @pytest.hookimpl(wrapper=True)
    def pytest_runtest_makereport(self, item: pytest.Item, call: pytest.CallInfo[None]) -> Generator[None, Any, Any]:
        report = yield
        if report.failed and call.excinfo is not None:
            self._tell(item.nodeid, call.excinfo.typename)
        return report
