"""Bitec's cards for an HSMC connector, as functions of the connector: resources by pins of the connector, whatever board it is on.

A board gives ``Connector("hsmc", NUMBER, ...)`` from pins of the connector to balls, and the I/O standard. The other attributes are
settings of Quartus.
"""

from collections.abc import Sequence
from functools import partial

from amaranth.build import Attrs, Clock, Pins, Resource, Subsignal

from golden.video.formats import PAL


__all__ = ["dvi_card", "quad_video_card"]


# The Quad Video card: channel of the decoder to the pins of its clock and of its data, the lowest bit first.
_CHANNELS = {
    1: ("158", "152 151 150 149 146 145 144 143"),
    2: ("156", "132 131 128 127 126 125 122 121"),
    3: ("98", "110 109 108 107 104 103 102 101"),
    4: ("96", "84 83 80 79 78 77 74 73"),
}

_INPUT_REGISTER  = Attrs(fast_input_register="ON")
_OUTPUT_REGISTER = Attrs(fast_output_register="ON")
_PULL_UP = Attrs(weak_pull_up_resistor="ON")


def quad_video_card(connector: int, channels: Sequence[int], standard: Attrs) -> list[Resource]:
    """The Quad Video card, with the video decoder TVP5154.

    Parameters
    ----------
    connector : int
        Number of the HSMC connector that it is on.
    channels : sequence of int
        Of the decoder, 1 to 4: the first one is ``camera`` 0, and so on.
    standard : Attrs
        I/O standard of the connector's pins.

    Returns
    -------
    list of Resource
        ``camera`` for each channel: eight bits of ``data`` at each rising edge of its ``clk``; ``decoder``: ``reset_n`` and
        ``powerdown_n``, both active low, and its I2C bus ``scl``, ``sda``.
    """
    pins = partial(Pins, conn=("hsmc", connector))
    cameras = [
        Resource("camera", number,
            Subsignal("clk", pins(clock, dir="i"), Clock(PAL.byte_clock_hz)),
            Subsignal("data", pins(data, dir="i"), _INPUT_REGISTER),
            standard)
        for number, (clock, data) in enumerate(_CHANNELS[channel] for channel in channels)
    ]
    return [*cameras, Resource("decoder", 0,
        Subsignal("reset_n", pins("155", dir="o")),
        Subsignal("powerdown_n", pins("157", dir="o")),
        Subsignal("scl", pins("34", dir="io"), _PULL_UP),
        Subsignal("sda", pins("33", dir="io"), _PULL_UP),
        standard)]


def dvi_card(connector: int, standard: Attrs) -> Resource:
    """The output of the DVI card, the transmitter TFP410; parameters as of :func:`quad_video_card`.

    Returns
    -------
    Resource
        ``dvi``: pixels ``red``, ``green``, ``blue``, ``de``, ``hsync``, ``vsync`` with their clock ``clk``, ``clk_n``; ``power_up``,
        ``isel``, ``dken``, ``ctl``, levels that configure the transmitter; its I2C bus ``scl``, ``sda``.
    """
    pins = partial(Pins, conn=("hsmc", connector))
    return Resource("dvi", 0,
        Subsignal("clk", pins("95", dir="o")),
        Subsignal("clk_n", pins("97", dir="o")),
        Subsignal("blue", pins("151 149 152 150 146 144 140 138", dir="o"), _OUTPUT_REGISTER),
        Subsignal("green", pins("134 132 128 126 122 120 116 114", dir="o"), _OUTPUT_REGISTER),
        Subsignal("red", pins("110 108 104 102 103 101 91 89", dir="o"), _OUTPUT_REGISTER),
        Subsignal("de", pins("115", dir="o"), _OUTPUT_REGISTER),
        Subsignal("hsync", pins("119", dir="o"), _OUTPUT_REGISTER),
        Subsignal("vsync", pins("121", dir="o"), _OUTPUT_REGISTER),
        Subsignal("power_up", pins("133", dir="o")),
        Subsignal("isel", pins("139", dir="o")),
        Subsignal("dken", pins("85", dir="o")),
        Subsignal("ctl", pins("131 127 125", dir="o")),
        Subsignal("scl", pins("145", dir="io"), _PULL_UP),
        Subsignal("sda", pins("143", dir="io"), _PULL_UP),
        standard)
