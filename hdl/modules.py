"""Modules of RTLIL text whose bodies are equal become one module."""

import re
from collections.abc import Mapping
from functools import partial


__all__ = ["merge_equal_modules"]


_END = re.compile(r"(?<=\nend\n)")      # of a module
_NAME = re.compile(r"(?m)^module \\(\S+)$")
_INSTANCE = re.compile(r"(?m)^  cell \\(\S+) .*\n(?:    .*\n)*")
# A port's declaration, with its attributes: what is in front of its number, and behind it.
_PORT = re.compile(r"(?m)^((?:  attribute .*\n)*  wire .*(?:input|output|inout) )\d+( .*\n\n)")
# A port that Amaranth has no name for: it takes that of the net's driver, a number among all cells of the design.
_NUMBERED = re.compile(r"\\port\$\d+\$\d+")
_NUMBERED_PORT = re.compile(r"(?m)^  wire .*(?:input|output|inout) \d+ .*(\\port\$\d+\$\d+)$")
_PIN = re.compile(r"(?m)^    connect (\S+) (.*)\n")


def _new_names(part: str) -> dict[str, str]:
    """Names for the numbered ports of a module: ``\\port_0`` and so on, in their order."""
    names: dict[str, str] = {}
    number = 0
    for port in _NUMBERED_PORT.findall(part):
        while f"\\port_{number}" in part:
            number += 1
        names[port] = f"\\port_{number}"
        number += 1
    return names


def _ordered(part: str) -> str:
    """A module whose ports are in the order of their names, since Amaranth's order depends on what is around it."""
    ports = sorted(_PORT.findall(part), key=lambda port: port[1])
    head, end, body = part.partition("\n\n")
    return head + end + "".join(f"{before}{number}{name}" for number, (before, name) in enumerate(ports)) + _PORT.sub("", body)


def _with_pins(names: Mapping[str, Mapping[str, str]], found: re.Match[str]) -> str:
    """An instance whose pins have the new names of the ports of its module, and are in the order of their names."""
    of_kind = names.get(found[1], {})
    pins = [f"    connect {of_kind.get(port, port)} {signal}\n" for port, signal in _PIN.findall(found[0])]
    return _PIN.sub("", found[0]) + "".join(sorted(pins))


def _renamed(kept: Mapping[str, str], found: re.Match[str]) -> str:
    """An instance of the module that is kept."""
    return found[0].replace(f"\\{found[1]} ", f"\\{kept[found[1]]} ", 1) if found[1] in kept else found[0]


def merge_equal_modules(text: str) -> str:
    r"""RTLIL in which no two modules have the same body; a module that several places share has the name of the first of them in ``text``.

    Names of instances stay, so a path through the design is what it was. Modules that differ only in what is inside them are merged as
    well, if that is equal. The order of ports does not matter, but for the top level, and ports that had a number for a name have a small
    one afterwards.

    Parameters
    ----------
    text : str
        Of Amaranth, the top level with its attribute.

    Examples
    --------
    >>> leaf, top = "module \\{}\n\n  wire \\x\nend\n", "module \\t\n\n  cell \\t.a \\a\n  end\n  cell \\t.b \\b\n  end\nend\n"
    >>> print(merge_equal_modules(leaf.format("t.a") + leaf.format("t.b") + top).strip())
    module \t.a
    <BLANKLINE>
      wire \x
    end
    module \t
    <BLANKLINE>
      cell \t.a \a
      end
      cell \t.a \b
      end
    end
    """
    *parts, tail = _END.split(text)
    modules = {}
    for part in parts:
        found = _NAME.search(part)
        if found is None:
            raise ValueError(f"no module begins with {part[:40]!r}")
        modules[found[1]] = part
    inner = {name for name, part in modules.items() if "attribute \\top 1\n" not in part}
    new = {name: names for name in inner if (names := _new_names(modules[name]))}
    for name, part in modules.items():
        part = _INSTANCE.sub(partial(_with_pins, new), part)
        if name in new:
            # Pins of instances have their new names already: what is left of the old ones are nets.
            part = _NUMBERED.sub(lambda found: new[name].get(found[0], found[0]), part)
        modules[name] = _ordered(part) if name in inner else part
    while True:
        first: dict[str, str] = {}      # body, without the name, to the name of the first module that has it
        kept = {name: first.setdefault(_NAME.sub("", part, count=1), name) for name, part in modules.items()}
        if len(first) == len(modules):
            return "".join(modules.values()) + tail
        modules = {name: _INSTANCE.sub(partial(_renamed, kept), modules[name]) for name in first.values()}
