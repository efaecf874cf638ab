"""A board with an ECP5 as :mod:`boards.registry` lists it, from what differs between boards."""

from collections.abc import Mapping
from functools import partial

from golden.video.formats import DisplayFormat

from ..loader import Loader
from ..loop.system import CLOCK_MHZ, PICTURES, LoopBoard, block_stores, loop_registers, loop_system
from ..registry import Board, Design, Project
from .bitstream import NEEDS, Target, make_bitstream
from .check import check_project
from .fit import ecp5_fit
from .platform import LoopPlatform, loop_project
from .pll import make_clock
from .stores import block_or_sdram_stores


__all__ = ["Target", "loop_board"]


def loop_board(name: str, platform: type[LoopPlatform], target: Target, displays: Mapping[str, DisplayFormat] | None = None) -> Board:
    """A board to which a host sends pairs over a serial line.

    Parameters
    ----------
    name : str
        Of its folder, and in openFPGALoader's list.
    platform : type
        With the board's resources.
    target : Target
    displays : mapping
        Formats of its monitor by name; none without one.
    """
    def project(system: LoopBoard, design: Design) -> Project:
        return loop_project(platform(design), system)

    return Board(
        name=name, device=target.name, clock_mhz=CLOCK_MHZ, toolchain="Yosys and nextpnr", project=project, check=check_project,
        system=partial(loop_system, stores_of=block_or_sdram_stores if platform.WIRING.sdram else block_stores), registers=loop_registers,
        pictures=PICTURES, displays=displays or {},
        make_clock=partial(make_clock, name, platform.WIRING.clock_hz), fit=partial(ecp5_fit, target.name),
        bitstream=partial(make_bitstream, target), needs=NEEDS, loader=Loader(name))
