"""Readable, portable Verilog-2001 from a component, and the netlist of the same design."""

import gc
import os
import re
import tempfile
from collections.abc import Collection, Iterable, Sequence
from pathlib import Path
from typing import Any, NamedTuple

from amaranth.back import rtlil

from golden.files import atomic

from .keywords import AMS
from .modules import merge_equal_modules
from .netlist import Netlist, read_netlist
from .tidy import tidy
from .widths import pad_operands
from .yosys import Tool, run_yosys


__all__ = ["NO_RW_CHECK", "ZERO_INIT", "Emitted", "emit_rtlil", "port_name", "rtlil_text", "verilog_text", "write_verilog"]


# A light clean-up: the text simulates two to three times faster than without, and reads better. Of equal cells only such are merged that
# no part of another signal would depend on: simulators take a signal as a whole, and would see a loop.
_CLEAN_UP = """
read_rtlil design.il
proc
memory_collect
opt_expr
opt_merge t:$xor t:$not
opt_clean
opt_dff
opt_clean
hierarchy -auto-top
"""
_WRITE_NETLIST = "write_json design.json\n"
_WRITE_VERILOG = "write_verilog {options} design.v\n"

#: Attribute of a memory that is never read where it is written in the same cycle.
NO_RW_CHECK = "no_rw_check"

# The initial content of a memory that starts as zeros. Amaranth would have it printed as one assignment a word. Memories here are
# written before they are read, and a simulator that shows an unwritten word as X keeps it so; look-up tables are not all zeros.
ZERO_INIT = re.compile(r"  cell \$meminit_v2 \$\d+\n(?:    (?!connect \\DATA).*\n)*    connect \\DATA \d+'0+\n(?:    .*\n)*  end\n")


class Emitted(NamedTuple):
    """A design as Verilog, and its modules as :mod:`hdl.netlist` has them: all names in those stay as they are."""
    verilog: str
    netlist: dict[str, Netlist]


def _plain_names(text: str) -> str:
    """Names without escapes: ``\\matcher.bec `` becomes ``matcher_bec``, the keyword ``\\table `` becomes ``table_``.

    Yosys escapes what is not a plain identifier: other characters, or a keyword of Verilog or SystemVerilog. Where two names of a module
    would collide, the later one, in alphabetical order, gets underscores at its end; names of modules have priority.
    """
    def rename(text: str, names: Iterable[str], taken: set[str]) -> str:
        plain: dict[str, str] = {}
        for name in names:
            new = f"{name}_" if re.fullmatch(r"\w+", name) else re.sub(r"\W", "_", name)
            while new in taken:
                new += "_"
            taken.add(new)
            plain[name] = new
        return re.sub(r"\\(\S+) ", lambda match: plain[match[1]] if match[1] in plain else match[0], text)

    definitions = re.findall(r"(?m)^module (\\?)([^\s(]+)", text)
    modules = {name for escape, name in definitions if not escape}
    text = rename(text, sorted(name for escape, name in definitions if escape), modules)
    parts = re.split(r"(?m)^(?=module )", text)
    for index, part in enumerate(parts):
        taken = set(re.findall(r"(?<!\\)\b[A-Za-z_]\w*\b", re.sub(r"\\\S+ ", " ", part)))
        parts[index] = rename(part, sorted(set(re.findall(r"\\(\S+) ", part))), taken | modules)
    return "".join(parts)


def _without_attributes(text: str, kept: Collection[str]) -> str:
    """Verilog without attributes but those ``kept``, by name; the rest is the text that Yosys writes without any.

    Yosys writes each attribute on a line of its own, or within an expression; without attributes ``parallel_case`` is a comment.
    """
    text = re.sub(r"(?m)^ *\(\* parallel_case \*\)\n(.*)$", r"\1 // synopsys parallel_case", text)
    return re.sub(r"(?m)^ *\(\* (\w+)(?: = .*?)? \*\)\n|\(\* (\w+)(?: = .*?)? \*\) ",
                  lambda match: match[0] if (match[1] or match[2]) in kept else "", text)


def port_name(path: Iterable[str | int]) -> str:
    """Name of a port in Verilog, from its path in the component's signature: with single underscores, as VHDL wants them, and no keyword of
    Verilog-AMS.

    Examples
    --------
    >>> port_name(["i", "payload"]), port_name(["write", 0, "be"]), port_name(["timer"])
    ('i_payload', 'write_0_be', 'timer_')
    """
    return _plain("_".join(map(str, path)))


def _plain(name: str) -> str:
    name = re.sub("__+", "_", name)
    return f"{name}_" if name in AMS else name


def _plain_ports(text: str) -> str:
    """Verilog whose ports have no two underscores in a row, and no name that is a keyword of Verilog-AMS.

    A net that has the new name of a port gets an underscore at its end.
    """
    parts = re.split(r"(?m)^(?=module )", text)
    headers = [re.match(r"module (\w+)\(([^)]*)\)", part) for part in parts]
    ports_of = {header[1]: re.findall(r"\w+", header[2]) for header in headers if header}
    renamed = {name for ports in ports_of.values() for name in ports if _plain(name) != name}
    for index, (part, header) in enumerate(zip(parts, headers)):
        if not header:
            continue
        ports = ports_of[header[1]]
        if len(set(map(_plain, ports))) < len(ports):
            raise ValueError(f"two ports have the same name with single underscores: {', '.join(ports)}; name one of them otherwise")
        names = set(re.findall(r"(?<![.\w'])[A-Za-z_]\w*", part))
        new = {name: _plain(name) for name in (*ports, *sorted(names & AMS - set(ports))) if _plain(name) != name}
        for name in sorted(set(new.values()) & names):
            moved = f"{name}_"
            while moved in names or moved in new.values():
                moved += "_"
            new[name] = moved
        part = re.sub(r"(?<![.\w'])[A-Za-z_]\w*", lambda match: new.get(match[0], match[0]), part)
        parts[index] = re.sub(r"(?<=\.)\w+(?=\()", lambda match: _plain(match[0]) if match[0] in renamed else match[0], part)
    return "".join(parts)


def _with_ports(text: str, name: str, ports: Sequence[str]) -> str:
    """Verilog whose module ``name`` has its ports in the order of ``ports``; others first."""
    def ordered(found: re.Match[str]) -> str:
        return f"{found[1]}{', '.join(sorted(found[2].split(', '), key=lambda port: ports.index(port) if port in ports else -1))})"

    return re.sub(rf"(?m)^(module {name}\()([^)]*)\)", ordered, text, count=1)


def _run(source: str, folder: Path, *, netlist: bool, attributes: Collection[str] = ()) -> str:
    (folder / "design.il").write_text(pad_operands(merge_equal_modules(ZERO_INIT.sub("", source))))
    # The netlist first: writing Verilog changes the design.
    write = _WRITE_VERILOG.format(options="" if attributes else "-noattr")
    run_yosys(Tool.AMARANTH, _CLEAN_UP + (_WRITE_NETLIST if netlist else "") + write, folder)
    text = re.sub(r"/\* Generated by.*?\*/\n+", "", (folder / "design.v").read_text())
    return tidy(_plain_names(_without_attributes(text, attributes) if attributes else text))


def emit_rtlil(source: str, *, attributes: Collection[str] = ()) -> Emitted:
    """Verilog and netlist of RTLIL text, which Amaranth has written without source locations; sub-modules are named ``top_path_to_it``.

    The same source gives the same bytes: no banner of the tool, and no attributes but those whose names are in ``attributes``.
    """
    with tempfile.TemporaryDirectory(prefix="emit-") as temporary:
        verilog = _run(source, Path(temporary), netlist=True, attributes=attributes)
        return Emitted(verilog, read_netlist(Path(temporary) / "design.json"))


def rtlil_text(component: Any, *, name: str) -> str:
    """RTLIL of ``component`` as module ``name``, without source locations; ports follow its signature."""
    # A netlist is millions of live objects: the garbage collector would walk through them again and again, in half of the time, and
    # free nothing.
    collects = gc.isenabled()
    gc.disable()
    try:
        return rtlil.convert(component, name=name, emit_src=False)
    finally:
        if collects:
            gc.enable()


def verilog_text(component: Any, *, name: str) -> str:
    """Verilog of ``component`` as module ``name``; ports follow its signature, see :func:`port_name`. Sub-modules are named after it.

    Clock and reset are the first ports. Memories that are marked, :data:`hdl.parts.delay.NO_COLLISION`, are marked in the Verilog.
    """
    with tempfile.TemporaryDirectory(prefix="emit-") as temporary:
        text = _run(rtlil_text(component, name=name), Path(temporary), netlist=False, attributes=(NO_RW_CHECK,))
    ports = ["clk", "rst", *(port_name(path) for path, _, _ in component.signature.flatten(component))]
    return _with_ports(_plain_ports(text), name, ports)


def write_verilog(component: Any, path: str | os.PathLike[str], *, name: str) -> Path:
    """Write :func:`verilog_text` to ``path``, whole or not at all; return the path."""
    path = Path(path)
    text = verilog_text(component, name=name)
    path.parent.mkdir(parents=True, exist_ok=True)
    with atomic(path) as file:
        file.write(text.encode())
    return path
