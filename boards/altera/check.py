"""Checks of an emitted Quartus project: pins, I/O standards, clocks, files."""

import re
from collections import Counter
from collections.abc import Collection, Mapping
from dataclasses import dataclass, field
from typing import NamedTuple

from hdl.netlist import BlackBox, Hierarchy, Netlist, clock_sources

from ..registry import Project
from .blocks import BLOCKS
from .crossings import LOOSE, Synchronizer, design_of, synchronizers
from .sdc import Constraints, read_sdc
from .synchronizers import ATTRIBUTE, FIRST_STAGE, LATER_STAGE, STAGE


__all__ = ["Ball", "Chip", "check_project"]


_LOCATION = re.compile(r"(?m)^set_location_assignment PIN_(\w+) -to (\S+)$")
_STANDARD = re.compile(r'(?m)^set_instance_assignment -name IO_STANDARD "([^"]+)" -to (\S+)$')
_INSTANCE = re.compile(r"(?m)^set_instance_assignment .*-to (\S+)$")
_FROM = re.compile(r"(?m)^set_instance_assignment .*-from (\S+) -to ")
_GLOBAL = re.compile(r"(?m)^set_global_assignment -name (\w+) (.+)$")
_CLOCK = re.compile(r"(?m)^create_clock .*-period ([\d.]+) \[get_ports \{(\S+)\}\]$")

_HEADER = re.compile(r"(?m)^module (\w+)\(([^)]*)\);")

_INSTANCE_OF = re.compile(r"(?m)^  (\w+) (?:#\((?:.|\n  )*?\n  \) )?(\w+) \($")
_MODULE = re.compile(r"(?ms)^module (\w+)\(.*?^endmodule")
_STAGE = re.compile(rf'(?m)^  \(\* {ATTRIBUTE} = "([^"]*)" \*\)\n  reg (?:\[\d+:0\] )?({STAGE}\d+);')

#: I/O standard to the supply that it needs in its bank, in volts.
_STANDARD_VOLTS = {"3.3-V LVTTL": 3.3, "2.5 V": 2.5, "1.8 V": 1.8, "SSTL-18 CLASS I": 1.8}


class Ball(NamedTuple):
    """Supply of a ball, in volts, and its I/O bank, if that is known."""
    volts: float
    bank: int | None = None

    def __str__(self) -> str:
        supplied = f"supplied with {self.volts} V"
        return supplied if self.bank is None else f"in bank {self.bank}, which is {supplied}"


@dataclass(frozen=True)
class Chip:
    """What is known of the FPGA on a board.

    Parameters
    ----------
    balls : mapping
        Known balls by name.
    clock_balls : collection of str
        Balls that reach the clock network.
    blocks : mapping
        The modules that a project takes from elsewhere.
    instances : mapping
        Clock that a block generates, of those that Gray pointers cross between, to the block's instance.
    controller : str
        Module of the memory controller; empty without one.
    """
    balls: Mapping[str, Ball]
    clock_balls: Collection[str]
    blocks: Mapping[str, BlackBox] = field(default_factory=lambda: BLOCKS)
    instances: Mapping[str, str] = field(default_factory=dict)
    controller: str = ""


def _bits(ports: Mapping[str, tuple[str, int]]) -> list[str]:
    """All bits of all ports, as Quartus names them."""
    return [port if width == 1 else f"{port}[{bit}]" for port, (_, width) in ports.items() for bit in range(width)]


def _check_pins(bits: Collection[str], settings: str, balls: Mapping[str, Ball]) -> list[str]:
    problems = []
    places = [(bit, ball) for ball, bit in _LOCATION.findall(settings)]
    standards = [(bit, standard) for standard, bit in _STANDARD.findall(settings)]
    for what, assignments in (("pin", places), ("I/O standard", standards)):
        times = Counter(bit for bit, _ in assignments)
        problems += [f"{bit} has no {what}" for bit in bits if not times[bit]]
        problems += [f"{bit} has {times[bit]} {what}s" for bit in bits if times[bit] > 1]
    named = {*_INSTANCE.findall(settings), *_FROM.findall(settings), *(bit for bit, _ in places)}
    problems += [f"{name} has an assignment but is no port" for name in sorted(named - set(bits))]

    users: dict[str, list[str]] = {}
    for bit, ball in places:
        users.setdefault(ball, []).append(bit)
    problems += [f"pin {ball} is used by {' and '.join(names)}" for ball, names in users.items() if len(names) > 1]
    problems += [f"pin {ball} of {names[0]} is not a known pin of this board" for ball, names in users.items() if ball not in balls]
    of_bit = dict(places)
    for bit, standard in standards:
        ball = balls.get(of_bit.get(bit, ""))
        if standard not in _STANDARD_VOLTS:
            problems.append(f"{bit} has the I/O standard {standard!r}, which is not one of {', '.join(_STANDARD_VOLTS)}")
        elif ball is not None and _STANDARD_VOLTS[standard] != ball.volts:
            problems.append(f"{bit} has the I/O standard {standard!r}, but its pin {of_bit[bit]} is {ball}")
    return problems


def _check_clocks(sources: Collection[str], settings: str, constraints: str, clock_balls: Collection[str]) -> list[str]:
    problems = []
    clocks = [port for _, port in _CLOCK.findall(constraints)]
    of_bit = {bit: ball for ball, bit in _LOCATION.findall(settings)}
    for source in sorted(sources):
        if source.startswith("? "):
            problems.append(f"the clock {source[2:]} is driven neither by a pin nor by a PLL")
        elif "." in source:
            if "derive_pll_clocks" not in constraints.split():
                problems.append(f"the clock {source} is not constrained: derive_pll_clocks is missing")
        elif source not in clocks:
            problems.append(f"the clock at {source} is not constrained")
        elif of_bit.get(source) not in clock_balls:
            problems.append(f"the clock at {source} enters at {of_bit.get(source)}, which does not reach the clock network")
    problems += [f"a clock is created at {port}, which clocks nothing" for port in clocks if port not in sources]
    return problems + [f"{port} has {times} clocks" for port, times in Counter(clocks).items() if times > 1]


def _check_header(name: str, verilog: str, ports: Collection[str]) -> list[str]:
    """Whether the Verilog has the ports of the netlist, which the other checks are about."""
    headers = dict(_HEADER.findall(verilog))
    if name not in headers:
        return [f"{name}.v has no module {name}"]
    written = set(re.findall(r"\w+", headers[name]))
    problems = [f"{name}.v lacks the port {port}" for port in sorted(set(ports) - written)]
    return problems + [f"{name}.v has the port {port}, which is not in the design" for port in sorted(written - set(ports))]


def _check_crossings(chains: Collection[Synchronizer], said: Constraints, clocks_mhz: Mapping[str, float],
                     instances: Mapping[str, str]) -> list[str]:
    """Whether the paths of Gray pointers are bounded, within a period of the faster of their two clocks."""
    problems = []
    for chain in chains:
        if chain.width > 1 and not chain.is_gray and not chain.path.endswith(LOOSE):
            problems.append(f"the synchroniser {chain.path} takes {chain.width} bits, and {chain.source} is not a Gray pointer by its "
                            "name: make it one, or if its bits need not arrive together, call it as one of those that "
                            f"end in {', '.join(LOOSE)}")
        if not chain.is_gray:
            continue
        if not chain.launch:
            problems.append(f"the Gray pointer {chain.source} at {chain.path} is not a register of the module around it")
            continue
        # A source is a port, whose clock has its name, or an output of a block, whose clocks have names below its instance.
        sides = [{clock for clock in said.clocks if clock == source or clock.startswith(f"{instances.get(source)}|")}
                 for source in (chain.launch, chain.latch)]
        least, most = said.bounds(sides[0], sides[1], chain.registers)
        periods = [1000 / clocks_mhz[source] if source in clocks_mhz else said.clocks.get(source)
                   for source in (chain.launch, chain.latch)]
        period = min(period or 0 for period in periods)
        if least is None or most is None:
            problems.append(f"the skew of the Gray pointer at {chain.path} is not bounded: give it set_max_delay and set_min_delay, and do "
                            "not cut its clocks")
        elif most - least > period:
            problems.append(f"the Gray pointer at {chain.path} may have a skew of {most - least:.3f} ns, and the faster of its clocks has "
                            f"a period of {period:.3f} ns")
    return problems


def _check_synchronizers(name: str, chains: Collection[Synchronizer], verilog: str) -> list[str]:
    """Whether the text has the synchronisers under the names that the constraints use, with the settings that keep their registers."""
    texts = {match[1]: match[0] for match in _MODULE.finditer(verilog)}
    instances = {match[2] for match in _INSTANCE_OF.finditer(verilog)}
    problems = []
    for chain in chains:
        stages = {stage: value for value, stage in _STAGE.findall(texts.get(chain.module, ""))}
        if missing := [part for part in chain.path.split("|") if part not in instances]:
            problems.append(f"{name}.v has no instance {missing[0]}, which leads to the synchroniser {chain.path}")
        elif stages.pop(f"{STAGE}0", "") != FIRST_STAGE or not stages or {*stages.values()} != {LATER_STAGE}:
            problems.append(f"the synchroniser {chain.path} lacks the {ATTRIBUTE} of its registers in {name}.v")
    return problems


def _check_blocks(netlist: Mapping[str, Netlist], blocks: Collection[str]) -> list[str]:
    """Whether all foreign modules are among those that Quartus has."""
    kinds = {cell.kind for module in netlist.values() for cell in module.cells.values()}
    return [f"the module {kind} is neither in the design nor one of Altera's blocks {', '.join(blocks)}"
            for kind in sorted(kinds) if kind[0] != "$" and kind not in netlist and kind not in blocks]


def check_project(chip: Chip, project: Project) -> list[str]:
    """Problems of a Quartus project.

    - Every bit of every port has one pin and one I/O standard, and nothing else has an assignment.
    - No pin is used twice; each is known, and its supply suits the standard.
    - Every clock is that of a pin that reaches the clock network and has a ``create_clock``, or of a PLL, with ``derive_pll_clocks``.
    - Every filter of the constraints finds something at the place where it stands, and every Gray pointer has bounds within a period.
    - The text has the settings of the synchronisers, and no module is foreign but Altera's blocks.
    - The files that the settings name exist, except the ``.qip``, which the user generates.

    Parameters
    ----------
    chip : Chip
    project : Project
        With the files ``NAME.v``, ``NAME.qsf`` and ``NAME.sdc``.

    Returns
    -------
    list of str
        A sentence for each problem; empty if there is none.
    """
    name, files, ports = project.name, project.files, project.ports
    settings, constraints = files[f"{name}.qsf"], files[f"{name}.sdc"]
    problems = _check_header(name, files[f"{name}.v"], ports)
    problems += _check_pins(_bits(ports), settings, chip.balls)
    problems += _check_clocks(clock_sources(project.netlist, name, chip.blocks), settings, constraints, chip.clock_balls)

    design = Hierarchy(project.netlist, name, chip.blocks)
    said = read_sdc(constraints, design_of(design, _bits(ports), chip.controller))
    problems += [f"{name}.sdc, {problem}" for problem in said.problems]
    chains = synchronizers(design)
    problems += _check_crossings(chains, said, project.clocks_mhz, chip.instances)
    problems += _check_synchronizers(name, chains, files[f"{name}.v"])
    problems += _check_blocks(project.netlist, chip.blocks)
    assigned = _GLOBAL.findall(settings)
    named = {key: value for key, value in assigned}
    problems += [f"{name}.qsf names the file {value}, which does not exist" for key, value in assigned
                 if key in ("VERILOG_FILE", "SDC_FILE") and value not in files]
    problems += [f"{name}.qsf has no {key}" for key in ("DEVICE", "TOP_LEVEL_ENTITY", "VERILOG_FILE", "SDC_FILE") if key not in named]
    if named.get("TOP_LEVEL_ENTITY", name) != name:
        problems.append(f"the top-level module is {name}, but {name}.qsf has {named['TOP_LEVEL_ENTITY']}")
    return problems
