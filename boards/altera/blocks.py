"""Altera's blocks that Quartus has without IP folders, and how clocks pass through them."""

from hdl.netlist import BlackBox


__all__ = ["BLOCKS"]


#: Every foreign module that may occur on any board, with its clocks.
BLOCKS = {
    "altiobuf_in": BlackBox(repeats={"dataout": "datain"}),
    "altiobuf_out": BlackBox(),
    "altiobuf_bidir": BlackBox(repeats={"dataout": "dataio"}),
    "altpll": BlackBox(generates=("clk",), clocked=("inclk",)),
    "altddio_out": BlackBox(clocked=("outclock",)),
    "altddio_in": BlackBox(clocked=("inclock",)),
}
