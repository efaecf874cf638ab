# amaranth: UnusedElaboratable=no
"""Boards with an ECP5: pins, PLLs, constraints and their check."""

import re
from dataclasses import replace
from itertools import chain

import pytest
from amaranth_boards.ecpix5 import ECPIX585Platform
from amaranth_boards.ulx3s import ULX3S_85F_Platform

from boards.ecp5.check import check_project
from boards.ecp5.fit import blocks
from boards.ecp5.platform import BLOCKS
from boards.ecp5.pll import Pll, dividers, make_clock
from boards.ecp5.stores import block_or_sdram_stores
from boards.registry import Design, find_board
from golden.config import FUSED_1, MatcherConfig, OnePass, changed
from golden.errors import UserError
from golden.video.formats import VGA
from hdl.loop.sdram_store import SdramStores
from hdl.loop.store import BlockStores
from hdl.memory_blocks import MemoryShape
from sim.models.loop_double import double_project
from tests.kit import refused_components


THESIS = changed(OnePass(), arithmetic="linear")


def project(board="ulx3s"):
    return double_project(*((board,) if board == "ulx3s" else (board, None)))


def constraints(board):
    text = project(board).files["stereo.lpf"]
    return dict(re.findall(r'LOCATE COMP "(.*)" SITE "(.*)";', text)), dict(re.findall(r'IOBUF PORT "(.*?)" (.*);', text)), text


def sites(platform):
    """Port to ball, of all resources of a platform of amaranth-boards, as Amaranth names their ports."""
    def of(path, ios):
        for each in ios:
            if hasattr(each, "ios"):
                yield from of(f"{path}__{each.name}", each.ios)
            elif hasattr(each, "p"):
                yield from named(f"{path}__p", each.p.names)
            else:
                yield from named(f"{path}__io", each.names)

    def named(port, balls):
        return [(port, balls[0])] if len(balls) == 1 else [(f"{port}[{bit}]", ball) for bit, ball in enumerate(balls)]
    return dict(chain.from_iterable(of(f"{resource.name}_{resource.number}", resource.ios) for resource in platform.resources))


@pytest.mark.parametrize("board, platform, ports", [("ulx3s", ULX3S_85F_Platform, 17), ("ecpix5", ECPIX585Platform, 12)])
def test_pins_are_those_of_the_package(board, platform, ports):
    found, attributes, _ = constraints(board)
    known = sites(platform)
    assert len(found) == ports
    assert found == {port: known[port] for port in found}
    assert set(attributes) == set(found) and all("IO_TYPE=LVCMOS33" in each for each in attributes.values())


def test_pins_of_the_ulx3s():
    """By the board's schematic: oscillator, FTDI's lines, first button, LEDs, the clock pair and data of the connector."""
    found, attributes, text = constraints("ulx3s")
    assert {port: found[port] for port in (
        "clk25_0__io", "uart_0__rx__io", "uart_0__tx__io", "button_fire_0__io", "led_0__io", "led_7__io", "hdmi_0__clk__p",
        "hdmi_0__d__p[0]", "hdmi_0__d__p[2]", "esp32_0__gpio0__io")} == {
        "clk25_0__io": "G2", "uart_0__rx__io": "M1", "uart_0__tx__io": "L4", "button_fire_0__io": "R1", "led_0__io": "B2",
        "led_7__io": "H3", "hdmi_0__clk__p": "A17", "hdmi_0__d__p[0]": "A16", "hdmi_0__d__p[2]": "A12", "esp32_0__gpio0__io": "L2"}
    assert {port for port, each in attributes.items() if "LVCMOS33D" in each} == {port for port in found if "hdmi" in port}
    assert 'FREQUENCY PORT "clk25_0__io" 25000000.0 HZ;' in text


@pytest.mark.parametrize("board", ["ulx3s", "ecpix5"])
def test_sound(board):
    assert check_project(project(board)) == []
    assert project(board).files["README.md"].startswith("# Stereo matching on the")
    assert "{{" not in project(board).files["README.md"]


@pytest.mark.parametrize("pattern, text, told", [
    (r'LOCATE COMP "led_3__io".*\n', "", ["led_3__io has no site"]),
    (r'IOBUF PORT "led_3__io".*\n', "", ["led_3__io has no I/O standard"]),
    (r'SITE "B2"', 'SITE "C2"', ["C2 is the site of 2 bits"]),
    (r'"hdmi_0__d__p\[1\]" SITE', '"hdmi_0__d__n[1]" SITE',
     ["hdmi_0__d__p[1] has no site", "hdmi_0__d__n[1] is constrained, and is no port"]),
    (r'(LOCATE COMP "led_0__io".*\n)', r'\1LOCATE COMP "led_0__io" SITE "Z1";\n', ["led_0__io has 2 sites"]),
])
def test_constraints_that_are_not_sound(pattern, text, told):
    sound = project()
    changed, count = re.subn(pattern, text, sound.files["stereo.lpf"])
    assert count == 1
    assert check_project(replace(sound, files={**sound.files, "stereo.lpf": changed})) == told


def test_netlist_that_is_not_sound(monkeypatch):
    """A block that nobody knows; a clock from elsewhere."""
    monkeypatch.delitem(BLOCKS, "OFS1P3DX")
    assert check_project(project()) == ["there is no block OFS1P3DX"]
    monkeypatch.setitem(BLOCKS, "EHXPLLL", replace(BLOCKS["EHXPLLL"], generates=("CLKOP",)))
    problems = check_project(project())
    assert len(problems) == 2 and re.match(r"the clock \? .*pixel_pll.* has no frequency$", problems[1])


@pytest.mark.parametrize("input_hz, outputs", [
    (25_000_000, (125_000_000, 25_000_000)), (25_000_000, (60_000_000,)), (100_000_000, (75_000_000,)), (25_000_000, (62_500_000,)),
    (25_000_000, (3_125_000,)), (100_000_000, (400_000_000,)),
])
def test_dividers(input_hz, outputs):
    """Frequencies without error, all within the limits of the data sheet."""
    found = dividers(input_hz, outputs)
    oscillator = input_hz / found.reference * found.feedback * found.outputs[0]
    assert 400e6 <= oscillator <= 800e6 and input_hz / found.reference >= 3.125e6
    assert tuple(oscillator / divider for divider in found.outputs) == outputs
    assert all(1 <= divider <= 128 for divider in (found.reference, found.feedback, *found.outputs))


@pytest.mark.parametrize("input_hz, outputs", [
    (25_000_000, (77_000_000,)), (25_000_000, (801_000_000,)), (25_000_000, (125_000_000, 26_000_000))])
def test_no_dividers(input_hz, outputs):
    assert dividers(input_hz, outputs) is None
    with refused_components(), pytest.raises(ValueError, match=f"^an EHXPLLL does not make {outputs[0]}"):
        Pll(input_hz, outputs)


def test_pll_of_the_project():
    text = project().files["stereo.v"]
    blocks_of = re.findall(r"(?s)((?:  \(\* \w+ = \"\w+\" \*\)\n)*)  EHXPLLL #\((.*?)\) block \((.*?)\);", text)
    settings = sorted(tuple(int(re.search(rf"\.{name}\(32'd(\d+)\)", each)[1]) for name in ("CLKI_DIV", "CLKFB_DIV", "CLKOP_DIV"))
                      for _, each, _ in blocks_of)
    assert settings == [(1, 3, 8), (1, 5, 5)]
    for attributes, _, pins in blocks_of:
        assert dict(re.findall(r'(\w+) = "(\w+)"', attributes)) == {
            "FREQUENCY_PIN_CLKI": "25", "ICP_CURRENT": "12", "LPF_RESISTOR": "8", "MFG_ENABLE_FILTEROPAMP": "1", "MFG_GMCREF_SEL": "2"}
        assert re.search(r"\.CLKFB\((\w+)\)", pins)[1] == re.search(r"\.CLKOP\((\w+)\)", pins)[1]


def test_clock_that_is_chosen():
    assert make_clock("b", 25_000_000, 62.5) == find_board("ulx3s").clock_hz(62.5) == 62_500_000
    assert find_board("ecpix5").clock_hz() == 60_000_000
    for clock, nearest in ((77, "78.125"), (0, "3.125"), (-5, "3.125"), (1000, "400")):
        with pytest.raises(UserError, match=rf"^the PLL of the board b does not make {clock} MHz of 25 MHz; choose --clock {nearest}$"):
            make_clock("b", 25_000_000, clock)


def design(width, height, clock_hz=60_000_000, method=THESIS, labels=64):
    return Design(MatcherConfig(labels, width, method=method), height, clock_hz, VGA, None, 3_000_000)


@pytest.mark.parametrize("of, kind", [
    (design(320, 240, labels=16), BlockStores), (design(320, 240, method=FUSED_1), BlockStores), (design(384, 240), BlockStores),
    (design(400, 300), SdramStores), (design(640, 480), SdramStores),
])
def test_what_pictures_are_stored_in(of, kind):
    """Memory blocks, three quarters of them at most, or an SDRAM."""
    with refused_components():
        assert type(block_or_sdram_stores(of)) is kind


def test_memory_that_is_too_slow():
    with refused_components(), pytest.raises(UserError, match=r"^--width 640 --height 480 --clock 25: a line of .* at least 28"):
        block_or_sdram_stores(design(640, 480, 25_000_000))


def test_pins_of_the_memory(monkeypatch):
    """By the board's schematic; each has a register, and the memory's clock and data are as :mod:`boards.ecp5.sdram_pins` has them."""
    monkeypatch.setattr("boards.ecp5.stores.PICTURE_BLOCKS", -1)
    small = design(8, 4, labels=2)
    board = find_board("ulx3s")
    built = board.project(board.system(small), small)
    assert check_project(built) == [] and built.stored.startswith("SDRAM, ")
    found = dict(re.findall(r'LOCATE COMP "sdram_0__(.*)" SITE "(.*)";', built.files["stereo.lpf"]))
    assert len(found) == 39
    assert {name: found[name] for name in ("clk__io", "clk_en__io", "cs__io", "we__io", "ras__io", "cas__io", "ba__io[0]", "a__io[12]",
                                           "dqm__io[1]", "dq__io[0]", "dq__io[15]")} == {
        "clk__io": "F19", "clk_en__io": "F20", "cs__io": "P20", "we__io": "T20", "ras__io": "R20", "cas__io": "T19", "ba__io[0]": "P19",
        "a__io[12]": "G19", "dqm__io[1]": "E20", "dq__io[0]": "J16", "dq__io[15]": "J17"}


@pytest.mark.parametrize("shape, number", [
    ((16_384, 1, 1), 1), ((16_385, 1, 1), 2), ((76_800, 8, 1), 38), ((512, 36, 1), 1), ((512, 37, 1), 2), ((16, 8, 1), 0), ((80, 24, 0), 0),
    ((256, 24, 0), 1), ((1024, 18, 1, 2), 2),
])
def test_blocks(shape, number):
    assert blocks(MemoryShape(*shape)) == number
