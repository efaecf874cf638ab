"""The Cyclone III development board as :mod:`boards.registry` lists it."""

from hdl.fit import Fit, cyclone3_fit
from hdl.resources.devices import CONTROLLER, DEVICES
from hdl.resources.estimate import estimate

from ..registry import Board, Design, Project, System
from .blocks import MEMORY_CONTROLLER
from .check import check_project
from .platform import DEVICE, LOCAL_CLOCKS_MHZ, MEMORY_CLOCK_MHZ
from .project import quartus_project


__all__ = ["BOARD"]


def _project(system: System, design: Design) -> Project:
    assert design.display
    return quartus_project(system, design.display, design.config)


def _fit(project: Project) -> Fit:
    estimated = estimate(project.netlist, project.name).total
    return cyclone3_fit(estimated, CONTROLLER, "Altera's DDR2 controller", DEVICES[DEVICE])


BOARD = Board(
    name="cyclone3", device=DEVICE, clock_mhz=LOCAL_CLOCKS_MHZ[MEMORY_CLOCK_MHZ], toolchain="Quartus",
    project=_project, check=check_project, about={"memory_controller": MEMORY_CONTROLLER}, memory_clocks_mhz=LOCAL_CLOCKS_MHZ, fit=_fit)
