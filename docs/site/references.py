"""What the docstrings say, as Sphinx reads it: numpydoc's sections with those of this project, and names of this project as links."""

import builtins
import importlib
from collections.abc import Iterator
from types import ModuleType
from typing import Any

from docutils import nodes
from sphinx.addnodes import pending_xref
from sphinx.application import Sphinx
from sphinx.environment import BuildEnvironment
from sphinx.ext.napoleon import Config
from sphinx.ext.napoleon.docstring import NumpyDocstring
from sphinx.util.nodes import make_refnode


__all__ = ["ELSEWHERE", "resolve", "sections"]


#: Names that are not of this project: those of other packages and of Python itself. All others must be known.
ELSEWHERE = [r"(?!(?:golden|hdl|boards|sim)\.)\w+\..*", rf"(?:{'|'.join(dir(builtins))})(?:\[.*)?"]

# `Members` are a component's ports. Types are words, such as "(H, W) uint8 ndarray", and no names to link to.
_CONFIG = Config(napoleon_use_param=False, napoleon_use_rtype=False,
                 napoleon_custom_sections=[("Attributes", "params_style"), ("Members", "params_style"), "Resources"])


def sections(app: Sphinx, what: str, name: str, obj: object, options: object, lines: list[str]) -> None:
    """Turn the sections of a docstring into reStructuredText. The text of an attribute has none: its colons are those of a sentence."""
    if what not in ("attribute", "data", "property"):
        lines[:] = NumpyDocstring(lines, _CONFIG, app, what, name, obj, options).lines()


def resolve(app: Sphinx, env: BuildEnvironment, node: pending_xref, content: nodes.TextElement) -> nodes.reference | None:
    """A link for a name that Sphinx does not know, but Python does: one that a room passes on, a module imports, or a constant.

    What has no entry of its own links to its class or module. ``None``, and so a warning, for what does not exist.
    """
    if node.get("refdomain") != "py":
        return None
    objects = env.domains.python_domain.objects
    scopes = [node.get("py:module"), node.get("py:class")]
    for scope in (scopes, scopes[:1], []):
        for name in _owners(".".join(filter(None, [*scope, node["reftarget"]]))):
            if name in objects:
                return make_refnode(app.builder, node["refdoc"], objects[name].docname, objects[name].node_id, content)
    return None


def _owners(name: str) -> Iterator[str]:
    """Where what has this name is defined, and what it is defined in, from the inside; nothing if Python does not know the name."""
    module, _, attribute = name.rpartition(".")
    path = [attribute]
    while module and not isinstance(found := _imported(module), ModuleType):
        module, _, attribute = module.rpartition(".")
        path.insert(0, attribute)
    if not module:
        return
    owners = [module]
    for each in path:
        if not hasattr(found, each) and each not in getattr(found, "__annotations__", {}):    # a dataclass has fields without a default
            return
        found = getattr(found, each, None)
        owners.append(_definition(found) or f"{owners[-1]}.{each}")
    yield from reversed(owners)


def _imported(name: str) -> ModuleType | None:
    try:
        return importlib.import_module(name)
    except ModuleNotFoundError:
        return None


def _definition(found: Any) -> str | None:
    """Full name of a class or a function where it is defined."""
    named = isinstance(found, type) or callable(found)
    return f"{found.__module__}.{found.__qualname__}" if named and hasattr(found, "__qualname__") else None
