"""Reads constraints as TimeQuest does: a strict subset of Tcl, in order, with all filters resolved against the design.

TimeQuest ignores a filter that matches nothing, with a warning among hundreds, and the constraint with it. Here it is a problem, as is
a command or an option that this module does not know.
"""

import fnmatch
import re
from collections.abc import Callable, Collection, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple


__all__ = ["Bounds", "Constraints", "Design", "Found", "read_sdc"]


class Found(NamedTuple):
    """What a filter finds: a ``clock``, ``port``, ``pin`` or ``register`` and its name."""
    kind: str
    name: str


@dataclass(frozen=True)
class Design:
    """What filters can find.

    Parameters
    ----------
    ports, pins : collection of str
        Bits of ports; pins of blocks.
    pll_clocks : collection of str
        Clocks that exist after ``derive_pll_clocks``.
    registers : callable
        Bits of registers that a pattern matches.
    """
    ports: Collection[str]
    pins: Collection[str]
    pll_clocks: Collection[str]
    registers: Callable[[str], Collection[str]]


class Bounds(NamedTuple):
    """Between which delays the paths of a crossing must be, in nanoseconds; ``None`` without a bound."""
    least: float | None
    most: float | None


@dataclass(frozen=True)
class _Exception:
    """``set_max_delay``, ``set_min_delay`` or ``set_false_path``; an end that is not given is ``None``."""
    command: str
    ends: tuple[frozenset[Found] | None, frozenset[Found] | None]
    value: float

    def priority(self) -> tuple[bool, bool, bool, bool]:
        """Of two exceptions of one kind the greater one applies, else the later one: nodes come before clocks, ``-from`` before ``-to``."""
        nodes = [end is not None and any(found.kind != "clock" for found in end) for end in self.ends]
        return *nodes, *(end is not None for end in self.ends)     # type: ignore[return-value]


@dataclass
class Constraints:
    """What a file of constraints says; ``problems`` are sentences, none if it is sound.

    ``clocks`` maps the name of a clock to its period in nanoseconds, ``None`` if the file does not give it.
    """
    clocks: dict[str, float | None] = field(default_factory=dict)
    groups: list[list[frozenset[str]]] = field(default_factory=list)
    exceptions: list[_Exception] = field(default_factory=list)
    problems: list[str] = field(default_factory=list)

    def bounds(self, launch: Collection[str], latch: Collection[str], registers: Collection[str] = ()) -> Bounds:
        """What applies to paths from clocks ``launch`` to ``registers`` with clocks ``latch``, all of them; no bounds if they are cut.

        ``set_clock_groups`` and ``set_false_path`` have priority over ``set_max_delay`` and ``set_min_delay``.
        """
        for groups in self.groups:
            sides = [{number for number, group in enumerate(groups) if group & {*clocks}} for clocks in (launch, latch)]
            if all(sides) and not sides[0] & sides[1]:
                return Bounds(None, None)
        start = {Found("clock", clock) for clock in launch}
        ends = ({Found("clock", clock) for clock in latch}, {Found("register", register) for register in registers})

        def applies(exception: _Exception) -> bool:
            first, last = exception.ends
            return (first is None or start <= first) and (last is None or any(end and end <= last for end in ends))

        applying = sorted(filter(applies, self.exceptions), key=_Exception.priority)
        if any(exception.command == "set_false_path" for exception in applying):
            return Bounds(None, None)
        values = {exception.command: exception.value for exception in applying}
        return Bounds(values.get("set_min_delay"), values.get("set_max_delay"))


class _WrongError(ValueError):
    """A line that cannot be read; the text is the problem."""


class _Command(NamedTuple):
    """Options of a command with a value and without one, and how many other arguments it takes."""
    valued: str = ""
    flags: str = ""
    others: int = 0


_COMMANDS = {
    "set": _Command(others=2),
    "create_clock": _Command("-name -period", "", 1),
    "create_generated_clock": _Command("-name -source", "-invert", 1),
    "derive_pll_clocks": _Command(),
    "derive_clock_uncertainty": _Command(),
    "set_clock_groups": _Command("-group", "-asynchronous"),
    "set_input_delay": _Command("-clock -max -min", "-clock_fall", 1),
    "set_output_delay": _Command("-clock -max -min", "-clock_fall", 1),
    "set_false_path": _Command("-from -to"),
    "set_max_delay": _Command("-from -to", "", 1),
    "set_min_delay": _Command("-from -to", "", 1),
    **{f"get_{kind}s": _Command(others=1) for kind in ("clock", "port", "pin", "register")},
}
_CREATORS = ("create_clock", "create_generated_clock", "derive_pll_clocks")
_TOKEN = re.compile(r"\s+|\{(?P<braced>[^{}]*)\}|(?P<open>\[)|(?P<close>\])|\$(?P<variable>\w+)|(?P<bare>[^\s{}\[\]$\"\\;]+)")

_Value = str | list[Found]


class _Reader:
    def __init__(self, design: Design):
        self.design = design
        self.said = Constraints()
        self.variables: dict[str, _Value] = {}

    def run(self, text: str, position: int = 0) -> tuple[_Value, int]:
        """Run one command, to the end of the text or to the bracket that closes it; its result, and the position behind it."""
        words: list[_Value] = []
        while position < len(text):
            match = _TOKEN.match(text, position)
            if not match:
                raise _WrongError(f"{text[position:].split()[0]!r} is beyond the subset of Tcl that is checked")
            position = match.end()
            if match["open"]:
                word, position = self.run(text, position)
                words.append(word)
            elif match["close"]:
                break
            elif match["variable"]:
                if match["variable"] not in self.variables:
                    raise _WrongError(f"the variable {match['variable']} has no value yet")
                words.append(self.variables[match["variable"]])
            elif match["braced"] is not None or match["bare"]:
                words.append(match["braced"] if match["braced"] is not None else match["bare"])
        return self.command(words), position

    def command(self, words: list[_Value]) -> _Value:
        name = words[0] if words else ""
        if not isinstance(name, str) or name not in _COMMANDS:
            raise _WrongError(f"the command {name!r} is not one that is checked")
        spec, options, others = _COMMANDS[name], dict[str, list[_Value]](), list[_Value]()
        rest = iter(words[1:])
        for word in rest:
            if not isinstance(word, str) or not re.match("-[a-z]", word):
                others.append(word)
            elif word in spec.valued.split():
                options.setdefault(word, []).append(next(rest, ""))
            elif word in spec.flags.split():
                options.setdefault(word, []).append("")
            else:
                raise _WrongError(f"{name} has the option {word}, which is not one that is checked")
        if len(others) != spec.others:
            raise _WrongError(f"{name} has {len(others)} arguments without an option, not {spec.others}")
        if name == "set":
            self.variables[str(others[0])] = others[1]
        elif name.startswith("get_"):
            return self.find(name.removeprefix("get_").removesuffix("s"), str(others[0]))
        elif name in _CREATORS:
            self.create(name, options)
        elif name == "set_clock_groups":
            groups = [self.collection(name, group) for group in options.get("-group", [])]
            self.said.groups.append([frozenset(found.name for found in group) for group in groups])
        elif name in ("set_input_delay", "set_output_delay"):
            self.find("clock", str(options.get("-clock", [""])[0]))
            self.collection(name, others[0])
        elif name.startswith("set_"):
            ends = [frozenset(self.collection(name, options[end][0])) if end in options else None for end in ("-from", "-to")]
            self.said.exceptions.append(_Exception(name, (ends[0], ends[1]), self.number(name, others[0]) if others else 0))
        return ""

    def collection(self, name: str, value: _Value) -> list[Found]:
        if isinstance(value, str):
            raise _WrongError(f"{name} has {value!r} where a filter such as [get_ports ...] belongs")
        return value

    def number(self, name: str, value: _Value) -> float:
        try:
            return float(value)     # type: ignore[arg-type]
        except (TypeError, ValueError):
            raise _WrongError(f"{name} has {value!r} where a number of nanoseconds belongs") from None

    def create(self, name: str, options: Mapping[str, list[_Value]]) -> None:
        if name == "derive_pll_clocks":
            self.said.clocks.update(dict.fromkeys(self.design.pll_clocks))
            return
        if "-name" not in options:
            raise _WrongError(f"{name} has no -name")
        if name == "create_generated_clock":
            self.collection(name, options.get("-source", [""])[0])
        period = self.number(name, options["-period"][0]) if "-period" in options else None
        self.said.clocks[str(options["-name"][0])] = period

    def find(self, kind: str, patterns: str) -> list[Found]:
        found: list[Found] = []
        for pattern in patterns.split():
            if kind == "register":
                names = self.design.registers(pattern)
            else:
                all_of_kind = {"clock": self.said.clocks, "port": self.design.ports, "pin": self.design.pins}[kind]
                names = matching(all_of_kind, pattern)
            if not names:
                told = "has been created by then" if kind == "clock" else "is in the design"
                self.said.problems.append(f"no {kind} {pattern} {told}")
            found += [Found(kind, name) for name in names]
        return found


def matching(names: Collection[str], pattern: str) -> list[str]:
    """Names that a pattern matches, as filters do: brackets are literal, only the asterisk and the question mark are wildcards."""
    return [name for name in names if fnmatch.fnmatchcase(name, pattern.replace("[", "[[]"))]


def read_sdc(text: str, design: Design) -> Constraints:
    """What the constraints in ``text`` say of ``design``; each problem names its line."""
    reader = _Reader(design)
    # A line that ends in a backslash goes on; its number is that of its beginning.
    number = 1
    for line in re.findall(r"(?:[^\n]*\\\n)*[^\n]*(?:\n|\Z)", text):
        command = line.replace("\\\n", " ").strip()
        known = len(reader.said.problems)
        if command and not command.startswith("#"):
            try:
                reader.run(command)
            except _WrongError as wrong:
                reader.said.problems.append(str(wrong))
        reader.said.problems[known:] = [f"line {number}: {problem}" for problem in reader.said.problems[known:]]
        number += line.count("\n")
    return reader.said
