"""Project files for Quartus around :class:`boards.de2_115.top.VgaTop`, through Amaranth's templates."""

from fractions import Fraction
from functools import partial
from typing import ClassVar

from ..altera import check
from ..altera.check import Chip
from ..altera.platform import OUTSIDE_CLOCKS, file_templates
from ..altera.synchronizers import ATTRIBUTE
from ..emission import NAME, emitted_files
from ..loop.system import LoopBoard
from ..registry import Design, Project
from .platform import BALLS, CLOCK_BALLS, FAMILY, OSCILLATOR_HZ, De2115Platform
from .top import VgaTop


__all__ = ["check_project", "loop_project"]


_CONSTRAINTS = OUTSIDE_CLOCKS + """
    # Clocks of both PLLs.
    derive_pll_clocks
    derive_clock_uncertainty

    # The clock that is sent with the pixels of the monitor, inverted.
    create_generated_clock -name dac_clock -source [get_pins {pixel_pll|block|auto_generated|pll1|clk[0]}] -invert \\
        [get_ports {dac_0__clk__io}]

    # The picture memory has a port in either domain, and nothing else is between them. The oscillator clocks nothing but the PLLs.
    set_clock_groups -asynchronous -group [get_clocks {pll|*}] -group [get_clocks {pixel_pll|* dac_clock}]

    # VGA: the converter latches at the rising edge of its clock, which is the inverted pixel clock. Half a pixel is
    # {{"%.1f"|format(5e8 / platform.design.display.pixel_clock_hz)}} ns; 5 ns are for set-up, 5 ns for hold, for want of a data sheet.
    set vga_ports [get_ports {vga_0__r__io[*] vga_0__g__io[*] vga_0__b__io[*] dac_0__blank_n__io}]
    set_output_delay -clock dac_clock -max 5 $vga_ports
    set_output_delay -clock dac_clock -min -5 $vga_ports

    # Levels that change slowly or never, and lines without a clock. The sync signals go to the connector itself.
    set_false_path -from [get_ports {button_0__io uart_0__rx__io}]
    set_false_path -to [get_ports {led_*__io uart_0__tx__io dac_0__sync_n__io vga_0__hs__io vga_0__vs__io}]
"""


class _ProjectPlatform(De2115Platform):
    """The board with the files of this project."""
    FAMILY = FAMILY

    quartus_file_templates: ClassVar = file_templates(__package__, _CONSTRAINTS)

    def __init__(self, design: Design):
        super().__init__()
        self.design = design

    def ratio(self, clock_hz: int) -> Fraction:
        """A clock as a multiple of the oscillator's."""
        return Fraction(clock_hz, OSCILLATOR_HZ)


def loop_project(system: LoopBoard, design: Design) -> Project:
    """Verilog, project, settings, constraints and README of the board with ``system`` on it."""
    assert design.display
    files, netlist = emitted_files(_ProjectPlatform(design), VgaTop(system.core, design.clock_hz, design.display), [ATTRIBUTE])
    return Project(NAME, files, netlist, stored=system.core.stores.about)


#: Lists the problems of a project, as :func:`boards.altera.check.check_project` does.
check_project = partial(check.check_project, Chip(BALLS, CLOCK_BALLS))
