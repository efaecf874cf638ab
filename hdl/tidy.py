"""Yosys's Verilog as linters want it: nothing implied, no name without a use."""

import re
from collections import Counter
from collections.abc import Callable, Collection, Mapping

from .memory_blocks import MemoryShape, blocks


__all__ = ["tidy"]


_MODULE = re.compile(r"(?m)^(?=module )")
_HEADER = re.compile(r"module (\w+)\(([^)]*)\);\n")
_PORT = re.compile(r"(?m)^  (input|output|inout) (?:\[\d+:\d+\] )?(\w+);\n")
_NET = re.compile(r"(?m)^(?:  \(\* .* \*\)\n)*  (?:wire|reg) (?:signed )?(?:\[(\d+):0\] )?(\w+);\n")
_ASSIGNMENT = re.compile(r"(?m)^  assign (\w+)(?:\[[\d:]+\])? = .*;\n")
# A name that is no port of an instance, and not in a constant.
_NAME = re.compile(r"(?<![.\w'])[A-Za-z_]\w*")
_INSTANCE = re.compile(r"(?m)^  (\w+) (\w+) \(\n((?:    \..*\n)*)  \);\n")
_PIN = re.compile(r"    \.(\w+)\((.*)\),?\n")
_INITIAL = re.compile(r"(?m)^(  reg (?:signed )?(?:\[\d+:0\] )?(\w+)) = (\d+'\w+);\n")
_PART = re.compile(r"(\w+)(?:\[(\d+)(?::(\d+))?\])?")
_NOT = re.compile(r"(?m)^(  assign .* = )! ([\w\[\]:]+|\{ [\w\[\]:, ]+ \});\n")
_MARKED = re.compile(r"(?m)^  \(\* no_rw_check = [^*]* \*\)\n(?=  reg (?:\[(\d+):0\] )?\w+ \[(\d+):0\];)")
# A condition around a statement with two branches: whose `else` it is.
_NESTED = re.compile(r"(?m)^(    if \(.*\))\n((?:      .*\n){2})")
_CASES = "// At most one bit of a casez's select is high.\n// verilator lint_off CASEOVERLAP\n{}// verilator lint_on CASEOVERLAP\n"


def _marks(found: re.Match[str]) -> str:
    """Attributes of a memory that is never read where it is written: for Yosys, and for Quartus, whose words Yosys would refuse."""
    width, words = (int(high or 0) + 1 for high in found.groups())
    block = "M9K, " if blocks(MemoryShape(words, width, written=1)) else ""
    return f'  (* no_rw_check *)\n`ifndef YOSYS\n  (* ramstyle = "{block}no_rw_check" *)\n`endif\n'


def _written_out(part: str) -> str:
    """A module that compares with zero where it negated several bits, and initialises registers apart from their declaration."""
    part = _INITIAL.sub(r"\1;\n  initial \2 = \3;\n", part)
    part = _NESTED.sub(r"\1 begin\n\2    end\n", part)
    part = _MARKED.sub(_marks, part)
    widths = {name: int(high or 0) + 1 for high, name in _NET.findall(part)}

    def compared(found: re.Match[str]) -> str:
        before, operand = found.groups()
        width = sum(1 if high and not low else int(high) - int(low) + 1 if high else widths[name]
                    for name, high, low in _PART.findall(operand))
        return found[0] if width == 1 else f"{before}{operand} == {width}'h{0:0{-(-width // 4)}x};\n"

    return _NOT.sub(compared, part)


def _pins(part: str, change: Callable[[str, str, str], str | None]) -> str:
    """A module whose instances have other pins: ``change(kind, port, signal)`` gives the new signal, ``None`` if the pin is to be left out.

    Instances with parameters are black boxes, and stay.
    """
    def instance(found: re.Match[str]) -> str:
        kind, name, pins = found.groups()
        signals = ((port, change(kind, port, signal)) for port, signal in _PIN.findall(pins))
        lines = [f"    .{port}({signal})" for port, signal in signals if signal is not None]
        return "\n".join([f"  {kind} {name} (", ",\n".join(lines), "  );\n"])

    return _INSTANCE.sub(instance, part)


def _without(part: str, dead: Collection[str]) -> str:
    """A module without declarations of nets and ports."""
    header = _HEADER.match(part)
    if not dead or header is None:
        return part
    ports = ", ".join(port for port in header[2].split(", ") if port not in dead)
    part = f"module {header[1]}({ports});\n{part[header.end():]}"
    for declaration in (_PORT, _NET):
        part = declaration.sub(lambda found: "" if found[2] in dead else found[0], part)
    return part


def _used_nets(part: str, outputs: Mapping[str, Collection[str]]) -> str:
    """A module without nets that nothing reads; an output of an instance that leads to such a net is left open.

    ``outputs`` has those of each kind of instance.
    """
    ports = {name for _, name in _PORT.findall(part)}
    while True:
        uses = Counter(_NAME.findall(part))
        written = Counter(_ASSIGNMENT.findall(part))
        nets = {name for _, name in _NET.findall(part)} - ports
        unread = {name for name in nets if uses[name] == 1 + written[name]}
        alone = {name for name in nets if uses[name] == 2}
        # An output may lead to several nets.
        signals = {signal: _NAME.findall(signal) for kind, _, pins in _INSTANCE.findall(part) for port, signal in _PIN.findall(pins)
                   if port in outputs.get(kind, ())}
        open_pins = {signal for signal, names in signals.items() if names and alone.issuperset(names)}
        if not unread and not open_pins:
            return part
        part = _ASSIGNMENT.sub(lambda found: "" if found[1] in unread else found[0], part)
        part = _pins(part, lambda kind, port, signal: "" if signal in open_pins else signal)
        part = _without(part, unread.union(*(signals[signal] for signal in open_pins)))


def _used_ports(modules: Mapping[str, str]) -> dict[str, str]:
    """Modules without nets that nothing reads, and without inputs that nothing inside them reads, but those of the top level.

    Amaranth gives every module with a register the reset of its clock domain, and those that it does not reset have no use for it.
    """
    outputs = {name: {port for direction, port in _PORT.findall(part) if direction == "output"} for name, part in modules.items()}
    modules = {name: _used_nets(part, outputs) for name, part in modules.items()}
    inside = {kind for part in modules.values() for kind, _, _ in _INSTANCE.findall(part)}
    changed = set(modules) & inside
    while changed:
        removed: dict[str, set[str]] = {}
        for name in changed:
            part = modules[name]
            uses = Counter(_NAME.findall(part))
            # In the header, and in two declarations.
            dead = {port for direction, port in _PORT.findall(part) if direction == "input" and uses[port] == 3}
            if dead:
                removed[name] = dead
                modules[name] = _without(part, dead)
        changed = set()
        for name, part in modules.items():
            if any(kind in removed for kind, _, _ in _INSTANCE.findall(part)):
                part = _pins(part, lambda kind, port, signal: None if port in removed.get(kind, ()) else signal)
                modules[name] = _used_nets(part, outputs)
                changed |= {name} & inside
    return modules


def tidy(text: str) -> str:
    """Verilog with the same behaviour that passes linters.

    * Registers are initialised by a statement of their own, ``! x`` of several bits is ``x == 0``, and each ``else`` stands in a block.
    * Modules have no inputs without a use, and nets without a use are not there; an instance's output may be open.
    * The selects of ``casez`` overlap only where two would be high at once; a comment tells Verilator so.

    Parameters
    ----------
    text : str
        Of Yosys, with plain names.
    """
    head, *parts = _MODULE.split(text)
    modules = {part.split("(", 1)[0].removeprefix("module "): _written_out(part) for part in parts}
    text = head + "".join(_used_ports(modules).values())
    return _CASES.format(text) if "casez" in text else text
