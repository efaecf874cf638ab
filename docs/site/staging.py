"""Sources of the site, laid out as in the repository, so that links between its documents are right both there and on the site.

Nothing is written into the repository: what is made at each build, the pages of the API, the pictures of the methods and the timing
diagrams, is written beside copies of the documents.
"""

import ast
import pkgutil
import tomllib
from collections.abc import Iterator, Mapping
from pathlib import Path


__all__ = ["ROOT", "api_pages", "documents", "rooms", "stage", "version"]


ROOT = Path(__file__).parents[2]

#: Documents of the repository, and the pictures that they show.
DOCUMENTS = ("README.md", "CONTRIBUTING.md", "CHANGELOG.md", "docs/*.md", "docs/*.png", "docs/thesis/*.png", "docs/site/*.md")

#: Packages with an API, in the order of the site.
PACKAGES = ("golden", "hdl", "boards", "sim")

API = "docs/site/api"


def version() -> str:
    """The project's version."""
    return tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]["version"]


def documents() -> dict[str, bytes]:
    """Documents that are pages of the site, and their pictures, by their paths in the repository."""
    paths = (path for pattern in DOCUMENTS for path in sorted(ROOT.glob(pattern)))
    return {path.relative_to(ROOT).as_posix(): path.read_bytes() for path in paths}


def rooms() -> Iterator[tuple[str, list[str]]]:
    """Dotted name of each room, and those of its modules but commands' entries, tests and benches."""
    for package in PACKAGES:
        for path in sorted((ROOT / package).rglob("__init__.py")):
            room = ".".join(path.parent.relative_to(ROOT).parts)
            modules = sorted(module.name for module in pkgutil.iter_modules([str(path.parent)]) if not module.ispkg)
            yield room, [f"{room}.{module}" for module in modules
                         if module != "__main__" and not module.startswith("test_") and not module.endswith("_tb")]


def api_pages() -> dict[str, bytes]:
    """A page for each room, by its path: the room's docstring, then its modules with their members; and the page that lists them."""
    pages = {f"{API}/{room}.rst": "\n".join([_module(room, "="), *(_module(module, "-") for module in modules)])
             for room, modules in rooms()}
    listed = "\n".join(f"api/{Path(page).stem}" for page in pages)
    index = (ROOT / f"{API}.md").read_text(encoding="utf-8")
    pages[f"{API}.md"] = f"{index}\n```{{toctree}}\n:maxdepth: 1\n\n{listed}\n```\n"
    return {page: text.encode("utf-8") for page, text in pages.items()}


def _module(name: str, underline: str) -> str:
    members = "   :members:\n" if _defines(name) else ""
    return f"{name}\n{underline * len(name)}\n\n.. automodule:: {name}\n{members}"


def _defines(name: str) -> bool:
    """Whether a module defines anything. One that is a further name of another's members would list them twice."""
    path = ROOT.joinpath(*name.split("."))
    tree = ast.parse((path / "__init__.py" if path.is_dir() else path.with_suffix(".py")).read_text(encoding="utf-8"))
    return any(isinstance(node, ast.ClassDef | ast.FunctionDef | ast.AsyncFunctionDef)
               or (isinstance(node, ast.Assign | ast.AnnAssign) and not ast.unparse(node).startswith("__all__")) for node in tree.body)


def stage(folder: Path, made: Mapping[str, bytes]) -> None:
    """Make ``folder`` hold the documents and what is ``made``, by paths, and nothing else; what has not changed is left alone.

    :class:`ValueError` if it is a folder of the repository that others use.
    """
    if ROOT.is_relative_to(folder) or (folder.is_relative_to(ROOT) and not folder.is_relative_to(ROOT / "build")):
        raise ValueError(f"the sources of the site would replace all in {folder}; choose a folder in build, or run make site")
    wanted = {**documents(), **made}
    for path in folder.rglob("*"):
        if path.is_file() and path.relative_to(folder).as_posix() not in wanted:
            path.unlink()
    for name, content in wanted.items():
        path = folder / name
        if not path.is_file() or path.read_bytes() != content:
            path.parent.mkdir(parents=True, exist_ok=True)
            path.write_bytes(content)
