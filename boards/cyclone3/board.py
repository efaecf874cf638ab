"""The Cyclone III development board as :mod:`boards.registry` lists it."""

from hdl.resources.devices import DEVICES

from ..registry import Board
from .check import check_project
from .platform import DEVICE, MEMORY_CLOCK_MHZ
from .project import MEMORY_CONTROLLER, quartus_project


__all__ = ["BOARD"]


BOARD = Board(
    name="cyclone3", device=DEVICES[DEVICE], memory_clock_mhz=MEMORY_CLOCK_MHZ, toolchain="Quartus",
    project=quartus_project, check=check_project, about={"memory_controller": MEMORY_CONTROLLER})
