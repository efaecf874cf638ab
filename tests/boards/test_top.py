# amaranth: UnusedElaboratable=no
import re
from fractions import Fraction

import pytest
from amaranth.lib import wiring
from amaranth.lib.wiring import In, Out

from boards.cyclone3.blocks import BLOCKS
from boards.cyclone3.platform import LOCAL_CLOCKS_MHZ, MEMORY_CLOCK_MHZ
from boards.cyclone3.top import BoardTop, pll_ratio
from golden.video.formats import DISPLAYS
from hdl.video.ports import DOMAINS, SystemPorts
from hdl.video.words import LocalBus
from sim.kit.simulators import STUBS
from sim.models.board_core import board_project


def cells(display="720x576"):
    return board_project(display).netlist["stereo"].cells


def stub_ports():
    """Ports of the stand-ins: module to port to (direction, text of its range)."""
    text = "".join(path.read_text() for path in STUBS)
    return {module: {name: (direction, bits) for direction, bits, name in
                     re.findall(r"(?m)^  (input|output|inout)(?: reg)?((?: \[[^\]]+\])?) (\w+)(?: = [^;]+)?;$", body)}
            for module, body in re.findall(r"(?ms)^module (\w+) (.*?)^endmodule", text)}


@pytest.mark.parametrize("display, ratio", [("720x576", Fraction(27, 50)), ("1024x768", Fraction(13, 10))])
def test_pll(display, ratio):
    assert pll_ratio(DISPLAYS[display].pixel_clock_hz) == ratio
    text = re.search(r"(?s)altpll #\(.*?\) display_pll", board_project(display).files["stereo.v"])[0]
    told = dict(re.findall(r"\.(\w+)\((?:32'd)?\"?([^\"]*?)\"?\)", text))
    assert (told["clk0_multiply_by"], told["clk0_divide_by"]) == (str(ratio.numerator), str(ratio.denominator))
    assert told["inclk0_input_frequency"] == "20000"  # ps
    assert told["intended_device_family"] == "Cyclone III"


@pytest.mark.parametrize("display", DISPLAYS)
def test_pll_can_be_set(display):
    """A multiplier and a divider set the PLL's oscillator, which runs at 600 to 1300 MHz; another divider follows it."""
    ratio = pll_ratio(DISPLAYS[display].pixel_clock_hz)
    settings = [(m, n, c) for n in range(1, 11) for m in range(1, 513) if 600 <= 50 * m / n <= 1300
                for c in range(1, 513) if Fraction(m, n * c) == ratio]
    assert settings


def test_memory_controller_has_the_ports_of_its_stand_in():
    """They are those of the module that Altera's generator made for this board."""
    connections = cells()["ddr2"].connections
    assert cells()["ddr2"].kind == "stereo_ddr2"
    ports = stub_ports()["stereo_ddr2"]
    assert set(connections) == set(ports)
    assert {name for name, (direction, _) in ports.items() if direction == "input"} == {
        "local_address", "local_write_req", "local_read_req", "local_burstbegin", "local_wdata", "local_be", "local_size",
        "global_reset_n", "pll_ref_clk", "soft_reset_n"}
    assert {name: bits for name, (direction, bits) in ports.items() if direction == "inout"} == {
        "mem_clk": " [0:0]", "mem_clk_n": " [0:0]", "mem_dq": " [31:0]", "mem_dqs": " [3:0]"}
    assert {name for name, (direction, _) in ports.items() if direction == "output"} == {
        "local_ready", "local_rdata", "local_rdata_valid", "local_refresh_ack", "local_wdata_req", "local_init_done", "reset_request_n",
        "reset_phy_clk_n", "phy_clk", "aux_full_rate_clk", "aux_half_rate_clk", "mem_odt", "mem_cs_n", "mem_cke", "mem_addr", "mem_ba",
        "mem_ras_n", "mem_cas_n", "mem_we_n", "mem_dm"}
    widths = {name: int(bits[2:].split(":")[0]) + 1 if bits else 1 for name, (_, bits) in ports.items()}
    for name in ("address", "wdata", "be", "size", "rdata"):
        assert widths[f"local_{name}"] == len(getattr(LocalBus().create(), name))
    of_top = board_project("720x576").netlist["stereo"].ports
    for name, bits in connections.items():
        if name.startswith("mem_"):
            port = of_top[f"ddr2_0__{name.removeprefix('mem_')}__io"]
            assert (port.direction, port.bits, len(bits)) == (ports[name][0], bits, widths[name])
    assert LOCAL_CLOCKS_MHZ == {125: 62.5, 150: 75}
    assert MEMORY_CLOCK_MHZ == 150


def test_every_block_of_altera_has_a_stand_in():
    netlist = board_project("720x576").netlist
    stubs = stub_ports()
    boxes = [cell for module in netlist.values() for cell in module.cells.values() if cell.kind not in netlist and cell.kind[0] != "$"]
    assert {box.kind for box in boxes} == {
        "altpll", "stereo_ddr2", "altiobuf_in", "altiobuf_out", "altiobuf_bidir", "altddio_out"}
    assert {box.kind for box in boxes} <= set(BLOCKS)
    for box in boxes:
        assert set(box.connections) == set(stubs[box.kind]), box.kind


def test_clocks_of_the_blocks_are_checked():
    """Those of all blocks, which all have a stand-in."""
    stubs = stub_ports()
    assert set(BLOCKS) == set(stubs)
    for kind, box in BLOCKS.items():
        assert {*box.repeats, *box.repeats.values(), *box.generates, *box.clocked} <= set(stubs[kind])
        inputs = {name for name, (direction, _) in stubs[kind].items() if direction == "input" and re.search("cl(oc)?k", name)}
        assert inputs - {"outclocken", "inclocken"} == set(box.clocked)


def test_domains():
    assert DOMAINS == ("sync", "display", "left_camera", "right_camera")


def test_registers_in_the_pins_have_the_clock_of_what_they_carry():
    """Simulation cannot tell: there, all clocks of Altera's blocks are the same."""
    children = cells()
    clock = children["core"].connections["display_clk"]
    assert clock != children["core"].connections["clk"] == children["ddr2"].connections["phy_clk"]
    for name in ("dvi_clock", "dvi_red", "dvi_green", "dvi_blue", "dvi_de", "dvi_hsync", "dvi_vsync"):
        assert children[name].connections["display_clk"] == clock
    for camera in ("left_camera", "right_camera"):
        for part, port in (("core", f"{camera}_clk"), (f"{camera}_data", f"{camera}_clk"), (f"{camera}_reset", "cleared_clk")):
            assert children[part].connections[port] == children[f"{camera}_clock_pin"].connections["i"]


def test_dvi_clock_is_inverted():
    """Low in the first half of a pixel: it rises in the pixel's middle."""
    netlist = board_project("720x576").netlist
    clock = netlist["stereo"].cells["dvi_clock"]
    levels = dict(zip(netlist[clock.kind].ports["o$5"].bits, clock.connections["o$5"]))
    register = netlist[clock.kind].cells["o_ddr"].connections
    assert ([levels[bit] for bit in register["datain_h"]], [levels[bit] for bit in register["datain_l"]]) == (["0"], ["1"])


@pytest.mark.parametrize("line", ["dvi_scl", "dvi_sda", "decoder_scl", "decoder_sda"])
def test_i2c_lines_of_the_transmitter_are_released_without_isel(line):
    """Switch 0 closed: then they are two of the levels that set it up. Those of the decoder are always driven."""
    top = board_project("720x576").netlist["stereo"]
    low, = top.cells["core"].connections[f"{line}_low"]
    enable, = top.cells[f"{line}_pin"].connections["oe"]
    if line.startswith("decoder"):
        assert enable == low
    else:
        isel, = (bits[0] for name, bits in top.cells["dvi_isel_pin"].connections.items() if name.startswith("o$"))
        gate = top.cells[top.drivers[enable].cell]
        assert (gate.kind, {*gate.connections["A"], *gate.connections["B"]}) == ("$and", {low, isel})


class Other(wiring.Component):
    def __init__(self, changes):
        super().__init__({name: member for name, member in {**SystemPorts().members, **changes}.items() if member is not None})


@pytest.mark.parametrize("changes, told", [
    ({"leds": None}, "leds"),
    ({"more": In(1)}, "more"),
    ({"red": Out(7)}, "red"),
    ({"buttons": Out(4)}, "buttons"),
    ({"memory": Out(LocalBus(size_bits=3))}, "memory__size"),
])
def test_core_with_other_ports(changes, told):
    with pytest.raises(ValueError, match=rf"SystemPorts\(\); these differ: {told}$"):
        BoardTop(Other(changes), DISPLAYS["720x576"])


def test_core_with_the_ports():
    BoardTop(Other({}), DISPLAYS["720x576"])
