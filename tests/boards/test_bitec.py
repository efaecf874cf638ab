"""Bitec's cards on connectors of any board."""

import pytest
from amaranth.build import Attrs, Connector
from amaranth.build.res import ResourceManager

from boards.altera.bitec import dvi_card, quad_video_card


STANDARD = Attrs(io_standard="3 V")

# Signals of the cards' schematics in the order of the connector's pins, by the project files that ran with them.
QUAD_VIDEO = """
    33 SDA  34 SCL  73 D4[7]  74 D4[6]  77 D4[5]  78 D4[4]  79 D4[3]  80 D4[2]  83 D4[1]  84 D4[0]  96 CLK4  98 CLK3
    101 D3[7]  102 D3[6]  103 D3[5]  104 D3[4]  107 D3[3]  108 D3[2]  109 D3[1]  110 D3[0]
    121 D2[7]  122 D2[6]  125 D2[5]  126 D2[4]  127 D2[3]  128 D2[2]  131 D2[1]  132 D2[0]
    143 D1[7]  144 D1[6]  145 D1[5]  146 D1[4]  149 D1[3]  150 D1[2]  151 D1[1]  152 D1[0]
    155 RESETB  156 CLK2  157 PDN  158 CLK1"""
DVI = """
    85 DKEN  89 OUT[23]  91 OUT[22]  95 IDCKp  97 IDCKn  101 OUT[21]  102 OUT[19]  103 OUT[20]  104 OUT[18]  108 OUT[17]  110 OUT[16]
    114 OUT[15]  115 DE  116 OUT[14]  119 HSYNC  120 OUT[13]  121 VSYNC  122 OUT[12]  125 CTL3  126 OUT[11]  127 CTL2  128 OUT[10]
    131 CTL1  132 OUT[9]  133 PD  134 OUT[8]  138 OUT[7]  139 ISEL  140 OUT[6]  143 DVI_DAT  144 OUT[5]  145 DVI_CLK  146 OUT[4]
    149 OUT[1]  150 OUT[3]  151 OUT[0]  152 OUT[2]"""


def on(connector, card, text):
    """A card's resources on a connector whose pins lead to balls with the names of its signals, and to no others."""
    words = text.split()
    pins = Connector("hsmc", connector, dict(zip(words[::2], words[1::2])))
    return ResourceManager(card, [pins])


def bits(signal, first, width=8):
    return [f"{signal}[{bit}]" for bit in range(first, first + width)]


@pytest.mark.parametrize("channels", [(1, 2), (4, 3, 2, 1), (3,)])
def test_cameras(channels):
    """In the order that is asked for."""
    card = quad_video_card(7, channels, STANDARD)
    assert [(each.name, each.number) for each in card] == [*(("camera", number) for number in range(len(channels))), ("decoder", 0)]
    manager = on(7, card, QUAD_VIDEO)
    for number, channel in enumerate(channels):
        camera = manager.request("camera", number, dir="-")
        assert [pin.name for pin in camera.clk.io.metadata] == [f"CLK{channel}"]
        assert [pin.name for pin in camera.data.io.metadata] == bits(f"D{channel}", 0)
        assert [pin.attrs for pin in camera.data.io.metadata] == [{"io_standard": "3 V", "fast_input_register": "ON"}] * 8
    assert [frequency for _, frequency in manager.iter_port_clock_constraints()] == [27e6] * len(channels)


def test_decoder():
    manager = on(0, quad_video_card(0, [1], STANDARD), QUAD_VIDEO)
    decoder = manager.request("decoder", 0, dir="-")
    for part, signal in (("reset_n", "RESETB"), ("powerdown_n", "PDN"), ("scl", "SCL"), ("sda", "SDA")):
        pin, = getattr(decoder, part).io.metadata
        pulled = {"weak_pull_up_resistor": "ON"} if part.startswith("s") else {}
        assert (pin.name, pin.attrs) == (signal, {"io_standard": "3 V", **pulled})


def test_dvi():
    manager = on(3, [dvi_card(3, STANDARD)], DVI)
    dvi = manager.request("dvi", 0, dir="-")
    found = {part: [pin.name for pin in port.io.metadata] for part, port in vars(dvi).items()}
    assert found == {
        "clk": ["IDCKp"], "clk_n": ["IDCKn"], "blue": bits("OUT", 0), "green": bits("OUT", 8), "red": bits("OUT", 16),
        "de": ["DE"], "hsync": ["HSYNC"], "vsync": ["VSYNC"], "power_up": ["PD"], "isel": ["ISEL"], "dken": ["DKEN"],
        "ctl": ["CTL1", "CTL2", "CTL3"], "scl": ["DVI_CLK"], "sda": ["DVI_DAT"]}
    registers = {part for part, port in vars(dvi).items() if port.io.metadata[0].attrs.get("fast_output_register") == "ON"}
    assert registers == {"red", "green", "blue", "de", "hsync", "vsync"}
    assert {part for part, port in vars(dvi).items() if "weak_pull_up_resistor" in port.io.metadata[0].attrs} == {"scl", "sda"}
    assert {pin.attrs["io_standard"] for port in vars(dvi).values() for pin in port.io.metadata} == {"3 V"}
