"""Where signals cross between clocks: the synchronisers of a netlist, and constraints for Gray pointers.

The bits of a Gray pointer must arrive within a period of the faster clock, so that the receiver samples the value before or the one after,
and none that never was. ``set_max_delay`` and ``set_min_delay`` make all of them arrive in one window, relative to the clock that
receives them; the window is as wide as the period. All versions of Quartus know these commands, and nothing overrides them as long as
the path is not cut: ``set_max_skew`` says the same, but it obeys clock groups and false paths, as they do, and adds nothing.
"""

import math
import re
from collections.abc import Collection, Mapping
from typing import NamedTuple

from hdl.netlist import Hierarchy, InstancePath, Netlist

from .sdc import Design, matching
from .synchronizers import STAGE


__all__ = ["GRAY", "LOOSE", "Synchronizer", "design_of", "gray_constraints", "synchronizers", "window"]


#: End of the names of Gray pointers, which are Amaranth's.
GRAY = "_gry"
#: Ends of the paths of synchronisers whose bits need not arrive together: settings are steady while they are used, and each event toggles
#: a bit of its own.
LOOSE = ("settings_crossing", "events|synchronizer")

# Clocks of the PLL in the memory controller: what Altera's generator calls them, below the controller's instance.
_CONTROLLER_CLOCKS = [f"{{controller}}_controller_phy_inst|{{controller}}_phy_inst|{{controller}}_phy_alt_mem_phy_inst|clk|half_rate.pll|"
                      f"altpll_component|auto_generated|pll1|clk[{output}]" for output in range(5)]


class Synchronizer(NamedTuple):
    """A chain of registers that receives a signal of another clock.

    ``path`` and ``module`` are names as in the Verilog; ``source`` is the net that it takes, in the module around it. ``launch`` and
    ``latch`` are sources of clocks as :func:`hdl.netlist.clock_sources` has them; ``launch`` is empty unless the net is a register of that
    module, or if the chain is for a reset.
    """
    path: str
    module: str
    width: int
    source: str
    launch: str
    latch: str

    @property
    def is_gray(self) -> bool:
        """Whether it receives a Gray pointer: by its name."""
        return self.width > 1 and self.source.endswith(GRAY)

    @property
    def registers(self) -> list[str]:
        """The bits of the first register."""
        return _bits(f"{self.path}|{STAGE}0", self.width)


def _bits(name: str, width: int) -> list[str]:
    return [name] if width == 1 else [f"{name}[{bit}]" for bit in range(width)]


def _plain(name: str) -> str:
    """A name as the emitted Verilog has it, if it is no keyword."""
    return re.sub(r"\W", "_", name)


def _path(path: InstancePath) -> str:
    return "|".join(_plain(instance) for _, instance in path[1:])


def _source(design: Hierarchy, path: InstancePath) -> tuple[str, str]:
    """What a synchroniser takes: the net of the module around it, and the source of its clock if it is a register there."""
    module, around = design.modules[path[-1][0]], design.modules[path[-2][0]]
    register = module.cells[module.drivers[module.nets[f"{STAGE}0"][0]].cell]
    pin = module.inputs.get(register.connections["D"][0])
    if not pin:
        return "", ""
    bits = around.cells[path[-1][1]].connections[pin.port]
    names = sorted((name for name, net in around.nets.items() if net == bits), key=lambda name: (not name.endswith(GRAY), name))
    driver = around.drivers.get(bits[0])
    clock = around.cells[driver.cell].connections.get("CLK") if driver else None
    return names[0] if names else pin.port, design.source(path[:-1], clock[0]) if clock else ""


def synchronizers(design: Hierarchy) -> list[Synchronizer]:
    """All synchronisers, found by the names of their registers."""
    found = []
    for path in design.instances[1:]:
        name = path[-1][0]
        module = design.modules[name]
        bits = module.nets.get(f"{STAGE}0", [])
        # A chain without a driver has a constant at its input, and was removed.
        if f"{STAGE}1" in module.nets and bits[:1] and bits[0] in module.drivers:
            source, launch = _source(design, path)
            clock, = module.cells[module.drivers[bits[0]].cell].connections["CLK"]
            found.append(Synchronizer(_path(path), _plain(name), len(bits), source, launch, design.source(path, clock)))
    return found


def window(periods: Collection[float]) -> tuple[float, float]:
    """Least and most delay of a Gray pointer between clocks of these periods, all in nanoseconds: a window as wide as the shorter one.

    A third of it lies below 0, since the receiver's clock may take longer to its registers than the sender's clock and the data.

    Examples
    --------
    >>> window([37.037, 13.333])
    (-4.444, 8.888)
    """
    picoseconds = min(periods) * 1000
    return -math.floor(picoseconds / 3) / 1000, math.floor(picoseconds * 2 / 3) / 1000


def gray_constraints(design: Hierarchy, names: Mapping[str, str], periods: Mapping[str, float]) -> str:
    """Commands that bound the skew of every Gray pointer, a line each.

    Parameters
    ----------
    design : Hierarchy
    names, periods : mapping
        Source of a clock to the filter that finds it, and to its period in nanoseconds.
    """
    lines = []
    for crossing in synchronizers(design):
        if crossing.is_gray:
            least, most = window([periods[crossing.launch], periods[crossing.latch]])
            lines += [f"set_{which}_delay -from [get_clocks {{{names[crossing.launch]}}}] "
                      f"-to [get_registers {{{crossing.path}|{STAGE}0[*]}}] {value:.3f}"
                      for which, value in (("max", most), ("min", least))]
    return "".join(f"{line}\n" for line in lines)


def _registers(module: Netlist) -> list[str]:
    """Bits of the registers of a module that have plain names."""
    held = {bit for cell in module.cells.values() if "dff" in cell.kind for bit in cell.connections["Q"]}
    return [bit for name, bits in module.nets.items() if re.fullmatch(r"\w+", name) and held.issuperset(bits)
            for bit in _bits(name, len(bits))]


def design_of(design: Hierarchy, ports: Collection[str], controller: str) -> Design:
    """What the filters of the constraints can find in a netlist.

    Parameters
    ----------
    design : Hierarchy
    ports : collection of str
        Bits of the ports of the top level.
    controller : str
        Kind of the memory controller, whose clocks have the names that Altera's generator gives them; empty without one.
    """
    pins = []
    clocks = []
    for path in design.instances:
        for name, cell in design.modules[path[-1][0]].cells.items():
            place = "|".join(filter(None, (_path(path), _plain(name))))
            if cell.kind == "altpll":
                outputs = re.findall(r"\bclk(\d)_multiply_by\b", " ".join(cell.parameters))
                pins += [f"{place}|auto_generated|pll1|clk[{output}]" for output in outputs]
            elif cell.kind == controller:
                clocks += [f"{place}|{clock.format(controller=controller)}" for clock in _CONTROLLER_CLOCKS]

    def registers(pattern: str) -> list[str]:
        # Each level of a path is matched by itself.
        *levels, last = pattern.split("|")
        found = []
        for path in design.instances:
            names = [_plain(instance) for _, instance in path[1:]]
            if len(names) == len(levels) and all(matching([name], level) for name, level in zip(names, levels, strict=True)):
                found += ["|".join([*names, register]) for register in matching(_registers(design.modules[path[-1][0]]), last)]
        return found

    return Design(ports, pins, [*pins, *clocks], registers)
