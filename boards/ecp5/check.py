"""Whether the constraints of a project are those of its netlist: a pin for each bit, known clocks."""

import re
from collections import Counter

from hdl.netlist import clock_sources

from ..registry import Project
from .platform import BLOCKS


__all__ = ["check_project"]


_LOCATE = re.compile(r'(?m)^LOCATE COMP "([^"]+)" SITE "([^"]+)";$')
_IOBUF = re.compile(r'(?m)^IOBUF PORT "([^"]+)" (.*);$')
_FREQUENCY = re.compile(r'(?m)^FREQUENCY PORT "([^"]+)" ([\d.]+) HZ;$')


def check_project(project: Project) -> list[str]:
    """Problems of a project, a sentence each.

    Each bit of each port has one site and an I/O standard, no site has two bits, nothing else is constrained; each clock is an output of a
    PLL or a port with a frequency, and no block is unknown.
    """
    constraints = project.files[f"{project.name}.lpf"]
    ports = project.ports
    bits = {name if width == 1 else f"{name}[{bit}]" for name, (_, width) in ports.items() for bit in range(width)}
    problems = []
    located, sites = (Counter(names) for names in zip(*_LOCATE.findall(constraints)))
    standards = {port for port, attributes in _IOBUF.findall(constraints) if "IO_TYPE=" in attributes}
    problems += [f"{bit} has no site" for bit in sorted(bits - located.keys())]
    problems += [f"{bit} has no I/O standard" for bit in sorted(bits - standards)]
    problems += [f"{bit} is constrained, and is no port" for bit in sorted((located.keys() | standards) - bits)]
    problems += [f"{bit} has {count} sites" for bit, count in sorted(located.items()) if count > 1]
    problems += [f"{site} is the site of {count} bits" for site, count in sorted(sites.items()) if count > 1]
    unknown = {cell.kind for module in project.netlist.values() for cell in module.cells.values()
               if not cell.kind.startswith("$") and cell.kind not in project.netlist and cell.kind not in BLOCKS}
    problems += [f"there is no block {kind}" for kind in sorted(unknown)]
    known = {port for port, _ in _FREQUENCY.findall(constraints)}
    known |= {f"{kind}.{port}" for kind, box in BLOCKS.items() for port in box.generates}
    problems += [f"the clock {clock} has no frequency" for clock in sorted(clock_sources(project.netlist, project.name, BLOCKS) - known)]
    return problems
