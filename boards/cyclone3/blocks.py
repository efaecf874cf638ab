"""Altera's blocks: the only modules that a project of this board takes from elsewhere, and how clocks pass through them."""

from hdl.netlist import BlackBox


__all__ = ["BLOCKS", "MEMORY_CONTROLLER"]


#: Variation of Altera's DDR2 controller that the user generates: name of the module and of its files.
MEMORY_CONTROLLER = "stereo_ddr2"

#: Every foreign module that may occur, with its clocks. Quartus has all of them without IP folders, but for the controller.
BLOCKS = {
    "altiobuf_in": BlackBox(repeats={"dataout": "datain"}),
    "altiobuf_out": BlackBox(),
    "altiobuf_bidir": BlackBox(repeats={"dataout": "dataio"}),
    "altpll": BlackBox(generates=("clk",), clocked=("inclk",)),
    MEMORY_CONTROLLER: BlackBox(generates=("phy_clk",), clocked=("pll_ref_clk",)),
    "altddio_out": BlackBox(clocked=("outclock",)),
    "altddio_in": BlackBox(clocked=("inclock",)),
}
