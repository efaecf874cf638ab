"""Altera's blocks on this board: the only modules that its project takes from elsewhere, and how clocks pass through them."""

from hdl.netlist import BlackBox

from ..altera import blocks


__all__ = ["BLOCKS", "MEMORY_CONTROLLER"]


#: Variation of Altera's DDR2 controller that the user generates: name of the module and of its files.
MEMORY_CONTROLLER = "stereo_ddr2"

#: Every foreign module that may occur, with its clocks. Quartus has all of them without IP folders, but for the controller.
BLOCKS = {**blocks.BLOCKS, MEMORY_CONTROLLER: BlackBox(generates=("phy_clk",), clocked=("pll_ref_clk",))}
