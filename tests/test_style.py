"""Rules that tools can check: style, types, which module imports which, bounded dependencies, short files, no machine's paths."""

import ast
import graphlib
import pathlib
import re
import subprocess
import sys
import tomllib

import pytest


ROOT = pathlib.Path(__file__).parent.parent
PACKAGES = ["golden", "hdl", "boards", "sim", "docs", "tests"]
SOURCES = sorted(path for package in PACKAGES for path in (ROOT / package).rglob("*.py"))
PATTERNS = ("*.md", "*.toml", "Makefile", ".ci/run", ".github/**/*.yml", ".pre-commit-config.yaml", "docs/**/*.md", "sim/**/*.v")
TEXTS = [path for pattern in PATTERNS for path in ROOT.glob(pattern)]
TEXTS += SOURCES

MAX_LINES = 400

# What a package must not import: what is above it, and for the golden model the languages of gateware and benches too.
FORBIDDEN = {
    "golden": {"hdl", "boards", "sim", "tests", "amaranth", "amaranth_boards", "cocotb"},
    "boards": {"sim", "tests", "cocotb"},
    "hdl":    {"boards", "sim", "tests", "cocotb"},
    "sim":    {"tests"},
    "docs":   {"tests"},
}
# The one upward import: a command that looks a board up by its name.
EXCEPTIONS = {("hdl/build.py", "boards.registry")}

# Rooms: the packages, and the folders in them.
ROOMS = sorted(".".join(path.parent.relative_to(ROOT).parts) for package in PACKAGES[:-1] for path in (ROOT / package).rglob("__init__.py"))


def name(path):
    return str(path.relative_to(ROOT))


# Dotted name of each module to its file.
MODULES = {name(path).removesuffix(".py").removesuffix("/__init__").replace("/", "."): path for path in SOURCES}


def imported(path):
    """Dotted names of the modules that a file imports, wherever in the file; of ``from a import b`` both ``a`` and ``a.b``."""
    package = path.relative_to(ROOT).parent.parts
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            # `from ..a import b` climbs one folder less than it has dots.
            above = package[:len(package) - node.level + 1] if node.level else ()
            module = ".".join([*above, *filter(None, [node.module])])
            yield from (module, *(f"{module}.{alias.name}" for alias in node.names))


@pytest.mark.parametrize("command", [["ruff", "check", "--no-fix", *PACKAGES], ["mypy"]], ids=lambda command: command[0])
def test_tool(command):
    run = subprocess.run([sys.executable, "-m", *command], cwd=ROOT, capture_output=True, text=True, timeout=300)
    assert run.returncode == 0, f"{run.stdout}{run.stderr}"


@pytest.mark.parametrize("package", FORBIDDEN)
def test_imports_point_downward(package):
    found = {name(path): wrong for path in (ROOT / package).rglob("*.py")
             if (wrong := [module for module in imported(path) if module.partition(".")[0] in FORBIDDEN[package]
                           and not any(name(path) == file and within(module, room) for file, room in EXCEPTIONS)])}
    assert not found


def within(module, room):
    return f"{module}.".startswith(f"{room}.")


def statement(room):
    """What a room's docstring says that it may import, and what it must not; ``None`` if it says neither."""
    docstring = ast.get_docstring(ast.parse((ROOT.joinpath(*room.split(".")) / "__init__.py").read_text(encoding="utf-8"))) or ""
    told = re.search(r"May import (.*?)\.(?=\s|$)", docstring, re.DOTALL)
    if told:
        allowed, _, excepted = re.sub("never|but not", "except", told[1]).partition("except")
        return [set(re.findall(r"``([\w.]+)``", part)) for part in (allowed, excepted)]


@pytest.mark.parametrize("room", ROOMS)
def test_room_states_what_it_may_import(room):
    told = statement(room)
    assert told, f"the docstring of {room} must say what lives there, and 'May import' with the names of rooms"
    assert {other for part in told or () for other in part} <= {*MODULES}


@pytest.mark.parametrize("room", ROOMS)
def test_room_imports_what_it_states(room):
    """Besides what it holds itself, and the files that stand in its package outside of all rooms."""
    allowed, excepted = statement(room) or ({*PACKAGES}, set())
    package, *_ = room.split(".")
    allowed |= {room, *(f"{package}.{path.stem}" for path in (ROOT / package).glob("*.py"))}
    rooms_and_files = {module for module in MODULES if module not in PACKAGES}   # a package itself holds a docstring only
    found = {name(path): wrong for path in ROOT.joinpath(*room.split(".")).glob("*.py") if (wrong := sorted(
        module for module in {*imported(path)} & rooms_and_files
        if not any(within(module, other) for other in allowed) or any(within(module, other) for other in excepted)))}
    assert not found


def untyped(path):
    """Public functions and methods of a file that lack the type of a parameter or of the result."""
    tree = ast.parse(path.read_text(encoding="utf-8"))
    classes = [node for node in tree.body if isinstance(node, ast.ClassDef) and not node.name.startswith("_")]
    for node in (*tree.body, *(node for each in classes for node in each.body)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and (not node.name.startswith("_") or node.name == "__init__"):
            parameters = [node.args.vararg, *node.args.posonlyargs, *node.args.args, *node.args.kwonlyargs, node.args.kwarg]
            lacking = [each.arg for each in parameters if each and each.annotation is None and each.arg not in ("self", "cls")]
            if lacking or (node.returns is None and node.name != "__init__"):
                yield f"{name(path)}:{node.lineno} {node.name}"


@pytest.mark.parametrize("room", [room for room in ROOMS if not within(room, "golden")])
def test_public_signatures_have_types(room):
    """But not those of tests and benches. Of golden mypy asks more, but nothing of its arrays."""
    files = [path for path in ROOT.joinpath(*room.split(".")).glob("*.py") if not re.search(r"^test_|_tb\.py$", path.name)]
    assert [each for path in files for each in untyped(path)] == []


def test_no_import_circle():
    # Without packages: they import what is in them, and say nothing of which file needs which.
    files = {module: {other for other in imported(path) if other in MODULES and MODULES[other].name != "__init__.py"}
             for module, path in MODULES.items() if path.name != "__init__.py"}
    try:
        graphlib.TopologicalSorter(files).prepare()
    except graphlib.CycleError as error:
        pytest.fail(" -> ".join(reversed(error.args[1])))


def test_no_test_imports_a_test():
    found = {name(path): wrong for path in SOURCES
             if (wrong := [module for module in imported(path) if any(part.startswith("test_") for part in module.split("."))])}
    assert not found


def test_dependencies_are_bounded_and_explained():
    text = (ROOT / "pyproject.toml").read_text(encoding="utf-8")
    parsed = tomllib.loads(text)
    project = parsed["project"]
    dependencies = sum(project["optional-dependencies"].values(), parsed["build-system"]["requires"] + project["dependencies"])
    for dependency in dependencies:
        assert "~=" in dependency or (">=" in dependency and "<" in dependency), f"{dependency} lacks a bound"
        assert re.search(rf'"{re.escape(dependency)}", +# \w', text), f"{dependency} lacks its reason"


def test_files_are_short():
    lines = {name(path): len(path.read_text(encoding="utf-8").splitlines()) for path in SOURCES}
    assert {path: count for path, count in lines.items() if count > MAX_LINES} == {}


def test_no_machine_paths():
    machine = re.compile(r"(?<![\w./<>])/(?:work|root|home|tmp/venv)\b")
    found = [f"{name(path)}:{number}" for path in TEXTS
             for number, line in enumerate(path.read_text(encoding="utf-8").splitlines(), 1) if machine.search(line)]
    assert not found
