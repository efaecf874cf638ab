"""What a platform of amaranth-boards writes for a project here, and the project itself."""

from importlib import resources
from typing import Any, ClassVar

from amaranth.build.run import BuildPlan
from amaranth.hdl import Fragment
from amaranth.vendor import LatticeECP5Platform

from hdl.netlist import BlackBox

from ..emission import NAME, emitted_files
from ..environment import no_overrides
from ..loop.system import LoopBoard
from ..loop.top import Wiring
from ..registry import Design, Project
from .pll import ATTRIBUTES
from .top import DviTop


__all__ = ["BLOCKS", "LoopPlatform", "loop_project"]


#: Lattice's blocks, the only modules that a project takes from elsewhere: Yosys knows all of them.
BLOCKS = {
    "EHXPLLL": BlackBox(generates=("CLKOP", "CLKOS"), clocked=("CLKI",)),
    "BB": BlackBox(),
    "IB": BlackBox(repeats={"O": "I"}),
    "OBZ": BlackBox(),
    "ODDRX1F": BlackBox(clocked=("SCLK",)),
    "OFS1P3DX": BlackBox(clocked=("SCLK",)),
    "FD1S3AX": BlackBox(clocked=("CK",)),
}


class LoopPlatform(LatticeECP5Platform):
    """For a subclass of it and of a board's platform: the files are RTLIL for :mod:`boards.emission`, Amaranth's constraints, instructions.

    ``WIRING`` says which of the board's resources are taken; ``README`` is the package whose ``readme.md`` has the instructions.
    """
    WIRING: ClassVar[Wiring]
    README: ClassVar[str]

    def __init__(self, design: Design):
        super().__init__(toolchain="Trellis")
        self.design = design

    @property
    def file_templates(self) -> dict[str, str]:
        constraints = "{{name}}.lpf"
        return {"{{name}}.il": "{{emit_rtlil()}}", constraints: super().file_templates[constraints],
                "README.md": resources.files(self.README).joinpath("readme.md").read_text(encoding="utf-8")}

    @property
    def command_templates(self) -> tuple[str, ...]:
        return ()   # the tools are started by `boards.ecp5.bitstream`

    def toolchain_prepare(self, fragment: Fragment, name: str, **kwargs: Any) -> BuildPlan:
        with no_overrides():
            return super().toolchain_prepare(fragment, name, **kwargs)


def loop_project(platform: LoopPlatform, system: LoopBoard) -> Project:
    """Verilog, constraints and README of a board with a system on it.

    Parameters
    ----------
    platform : LoopPlatform
    system : LoopBoard
    """
    design = platform.design
    top = DviTop(system.core, design.clock_hz, platform.WIRING, design.display)
    files, netlist = emitted_files(platform, top, ["FREQUENCY_PIN_CLKI", *ATTRIBUTES])
    return Project(NAME, files, netlist, stored=system.core.stores.about)
