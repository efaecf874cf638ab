"""The Cyclone III development board as :mod:`boards.registry` lists it."""

from hdl.resources.devices import CONTROLLER, DEVICES
from hdl.resources.estimate import estimate

from ..registry import Board
from .blocks import MEMORY_CONTROLLER
from .check import check_project
from .platform import DEVICE, LOCAL_CLOCKS_MHZ, MEMORY_CLOCK_MHZ
from .project import quartus_project


__all__ = ["BOARD"]


BOARD = Board(
    name="cyclone3", device=DEVICES[DEVICE], memory_clock_mhz=LOCAL_CLOCKS_MHZ[MEMORY_CLOCK_MHZ], toolchain="Quartus",
    project=quartus_project, check=check_project, about={"memory_controller": MEMORY_CONTROLLER},
    memory_clocks_mhz=LOCAL_CLOCKS_MHZ, estimate=estimate, allowance=CONTROLLER, allowed_for="Altera's DDR2 controller")
