"""The DE2-115 as :mod:`boards.registry` lists it."""

from functools import partial

from golden.video.formats import VGA
from hdl.fit import Fit, cyclone3_fit
from hdl.resources.count import Resources
from hdl.resources.devices import DEVICES
from hdl.resources.estimate import estimate
from hdl.resources.report import ESTIMATED

from ..altera.pll import make_clock
from ..loop.system import CLOCK_MHZ, PICTURES, loop_registers, loop_system
from ..registry import Board, Project
from .platform import DEVICE, OSCILLATOR_HZ
from .project import check_project, loop_project


__all__ = ["BOARD"]


_NAME = "de2_115"


def _fit(project: Project) -> Fit:
    return cyclone3_fit(estimate(project.netlist, project.name).total, Resources(), "", DEVICES[DEVICE], (ESTIMATED,))


BOARD = Board(
    name=_NAME, device=DEVICE, clock_mhz=CLOCK_MHZ, toolchain="Quartus", project=loop_project, check=check_project, system=loop_system,
    registers=loop_registers, pictures=PICTURES, displays={"640x480": VGA}, make_clock=partial(make_clock, _NAME, OSCILLATOR_HZ), fit=_fit)
