"""Which class of the gateware each module of the emitted Verilog was."""

import re
from typing import Any

from amaranth.hdl import Fragment, Value


__all__ = ["origins", "room"]


# What has no gateware of its own: Amaranth's language, in which the classes are written.
_LANGUAGE = "amaranth.hdl"


def origins(component: Any, name: str) -> dict[str, str]:
    """Class, with its module, by the module's name in :func:`hdl.emit.verilog_text` of ``component`` as ``name``.

    A submodule that is no class, but part of one, counts as that.
    """
    ports = {"__".join(map(str, path)): (Value.cast(value), None) for path, _, value in component.signature.flatten(component)}
    design = Fragment.get(component, None).prepare(ports=ports, hierarchy=(name,))
    found: dict[str, str] = {}

    def walk(part: Any, above: str) -> None:
        classes = [type(origin) for origin in part.origins or () if not type(origin).__module__.startswith(_LANGUAGE)]
        kind = f"{classes[0].__module__}.{classes[0].__qualname__}" if classes else above
        found[re.sub(r"\W", "_", "_".join(design.fragments[part].name))] = kind
        for child, _, _ in part.subfragments:
            walk(child, kind)

    walk(design.fragment, "")
    return found


def room(kind: str) -> str:
    """The room of a class.

    Examples
    --------
    >>> room("hdl.matcher.streaming.cones.Cones"), room("amaranth.lib.fifo.SyncFIFO")
    ('hdl.matcher.streaming', 'amaranth.lib.fifo')
    """
    module = kind.rpartition(".")[0]
    return module.rpartition(".")[0] if module.startswith("hdl.") else module
