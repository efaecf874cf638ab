"""The DE2-115: pins, PLLs, constraints and their check, fit."""

import csv
import re
from dataclasses import replace
from importlib import resources

import pytest
from amaranth.build.res import ResourceManager

from boards.altera.bitec import quad_video_card
from boards.altera.pll import Pll, make_clock
from boards.de2_115 import platform
from boards.de2_115.platform import BALLS, CLOCK_BALLS, De2115Platform
from boards.de2_115.project import check_project
from boards.registry import find_board
from golden.errors import UserError
from hdl.resources.devices import DEVICES
from sim.models.loop_double import double_project
from tests.kit import refused_components


PROJECT, BOARD = "de2_115", find_board("de2_115")


def pins():
    """Port to ball, as the settings have them."""
    return {port: ball for ball, port in re.findall(r"(?m)^set_location_assignment PIN_(\w+) -to (\S+)$", files()["stereo.qsf"])}


def files():
    return double_project(PROJECT).files


def test_pins():
    """Typed from public projects for the board, independently of the table that the board reads."""
    found = pins()
    buses = {
        "vga_0__r__io": "E12 E11 D10 F12 G10 J12 H8 H10", "vga_0__g__io": "G8 G11 F8 H12 C8 B8 F10 C9",
        "vga_0__b__io": "B10 A10 C11 B11 A11 C12 D11 D12"}
    wanted = {f"{port}[{bit}]": ball for port, balls in buses.items() for bit, ball in enumerate(balls.split())}
    wanted |= {f"led_{bit}__io": ball for bit, ball in enumerate(["E21", "E22", "E25", "E24", "H21", "G20", "G22", "G21"])}
    wanted |= {"clk50_0__io": "Y2", "button_0__io": "M23", "uart_0__rx__io": "AB22", "uart_0__tx__io": "AC15", "vga_0__hs__io": "G13",
               "vga_0__vs__io": "C13", "dac_0__clk__io": "A12", "dac_0__blank_n__io": "F11", "dac_0__sync_n__io": "C10"}
    assert found == wanted
    assert found["clk50_0__io"] in CLOCK_BALLS


def test_table():
    """Each row is a resource's or the connector's, and no ball is there twice."""
    manager = De2115Platform()
    used = [ball for connector in De2115Platform.connectors for _, ball in connector]
    for resource in De2115Platform.resources:
        port = manager.request(resource.name, resource.number, dir="-")
        used += [pin.name for part in (vars(port).values() if hasattr(port, "__dict__") and "_io" not in vars(port) else [port])
                 for pin in part.io.metadata]
    assert sorted(used) == sorted(BALLS) and len(used) == len({*used}) == 124


def test_device():
    named = De2115Platform
    assert platform.DEVICE == BOARD.device == "".join((named.device, named.package, named.speed, named.suffix))
    # Of Altera's handbook: 432 blocks of 9,216 bits, 266 multipliers of 18x18.
    assert DEVICES[BOARD.device].capacity == (114_480, 432 * 9_216, 432, 2 * 266)


def test_quad_video_card_at_the_connector():
    """Its data and clocks are where the connector's lanes are; its I2C bus is at pins that lead to balls nobody has told."""
    manager = ResourceManager(quad_video_card(0, [1, 2], platform._V25), De2115Platform.connectors)
    cameras = [manager.request("camera", number, dir="-") for number in (0, 1)]
    assert [[pin.name for pin in camera.clk.io.metadata] for camera in cameras] == [["Y28"], ["Y27"]]
    assert [[pin.name for pin in camera.data.io.metadata] for camera in cameras] == [
        ["T22", "V22", "T21", "U22", "R23", "V28", "R22", "V27"], ["P25", "R27", "N26", "V26", "N25", "V25", "L22", "L28"]]
    with pytest.raises(NameError, match="refers to nonexistent connector pin hsmc_0:34"):
        manager.request("decoder", 0, dir="-")


def test_sound():
    assert check_project(double_project(PROJECT)) == []
    assert set(files()) == {"stereo.v", "stereo.qpf", "stereo.qsf", "stereo.sdc", "README.md"}
    for text in files().values():
        assert text.endswith("\n") and not text.endswith("\n\n") and not re.search(r"Amaranth|\{\{|\{%", text)


# File, pattern, replacement, and the problems that the check must report.
@pytest.mark.parametrize("suffix, pattern, replacement, told", [
    ("qsf", r"set_location_assignment PIN_\w+ -to vga_0__r__io\[3\]\n", "", [r"vga_0__r__io\[3\] has no pin"]),
    ("qsf", r'"3.3-V LVTTL" -to vga_0__hs__io', '"2.5 V" -to vga_0__hs__io',
     [r"vga_0__hs__io has the I/O standard '2.5 V', but its pin G13 is supplied with 3.3 V$"]),
    ("qsf", "PIN_Y2 -to", "PIN_AE28 -to", ["the clock at clk50_0__io enters at AE28, which does not reach the clock network",
                                            "clk50_0__io has the I/O standard '3.3-V LVTTL', but its pin AE28 is supplied with 2.5 V"]),
    ("qsf", "PIN_Y2 -to", "PIN_AH14 -to", ["pin AH14 of clk50_0__io is not a known pin", "enters at AH14"]),
    ("sdc", r"pixel_pll\|block", "pixel_pll|blocks", [r"no pin pixel_pll\|blocks"]),
    ("sdc", r"\{pll\|\*\}", "{pll_1|*}", [r"no clock pll_1\|\* has been created"]),
    ("sdc", "dac_0__sync_n__io", "dac_0__sync__io", ["no port dac_0__sync__io is in the design"]),
])
def test_violation(suffix, pattern, replacement, told):
    sound = double_project(PROJECT)
    text, times = re.subn(pattern, replacement, sound.files[f"stereo.{suffix}"], count=1)
    assert times == 1
    problems = check_project(replace(sound, files={**sound.files, f"stereo.{suffix}": text}))
    for expected in told:
        assert any(re.search(expected, problem) for problem in problems), (expected, problems)


def test_settings():
    settings = files()["stereo.qsf"]
    for line in ('FAMILY "Cyclone IV E"', "DEVICE EP4CE115F29C7", "SDC_FILE stereo.sdc", 'STRATIX_DEVICE_IO_STANDARD "2.5 V"'):
        assert settings.count(f"set_global_assignment -name {line}\n") == 1
    assert "QIP_FILE" not in settings
    registers = set(re.findall(r'FAST_OUTPUT_REGISTER "ON" -to (\S+)', settings))
    assert registers == {port for port in pins() if re.match("vga_0|dac_0__blank", port)}


def test_constraints():
    """Every bit of a port has a delay, a clock or none that matters, by name."""
    text = files()["stereo.sdc"]
    assert "create_clock -name clk50_0__io -period 20.000 [get_ports {clk50_0__io}]" in text
    patterns = [re.escape(name).replace(r"\*", ".*") for names in re.findall(r"\[get_ports \{([^}]+)\}\]", text) for name in names.split()]
    for port in pins():
        assert any(re.fullmatch(pattern, port) for pattern in patterns), port
    # The converter's clock is inverted, belongs to the monitor's, and has a quarter of a pixel on either side of its edge.
    commands = re.sub(r"\\\n *", "", text)
    assert re.search(r"(?m)^create_generated_clock -name dac_clock .* -invert \[get_ports \{dac_0__clk__io\}\]$", commands)
    assert "-group [get_clocks {pll|*}] -group [get_clocks {pixel_pll|* dac_clock}]\n" in commands
    assert re.findall(r"set_output_delay -clock dac_clock (.*) \$vga_ports\n", commands) == ["-max 5", "-min -5"]


def test_plls():
    blocks = re.findall(r"altpll #\(.*?\) block", files()["stereo.v"], re.DOTALL)
    found = [dict(re.findall(r"\.(\w+)\((?:32'd)?\"?([^\"]*?)\"?\)", block)) for block in blocks]
    assert sorted((block["clk0_multiply_by"], block["clk0_divide_by"]) for block in found) == [("1", "2"), ("3", "2")]
    assert {(block["inclk0_input_frequency"], block["intended_device_family"]) for block in found} == {("20000", "Cyclone IV E")}
    assert {(block["operation_mode"], block["compensate_clock"], block["clk0_duty_cycle"]) for block in found} == {("NORMAL", "CLK0", "50")}


def test_polarity():
    """Buttons are active low, LEDs active high."""
    manager = De2115Platform()
    assert manager.request("button", 0, dir="-").invert == (True,)
    assert manager.request("led", 0, dir="-").invert == (False,)


def test_clock_that_is_chosen():
    assert BOARD.clock_hz() == 60_000_000 and BOARD.clock_hz(62.5) == 62_500_000
    for clock, nearest in ((77, "78.125"), (0, "1.2"), (2000, "1300")):
        with pytest.raises(UserError, match=rf"^the PLL of the board b does not make {clock} MHz of 50 MHz; choose --clock {nearest}$"):
            make_clock("b", 50_000_000, clock)
    with refused_components(), pytest.raises(ValueError, match=r"^an altpll does not make 77000000 Hz of 50000000 Hz; choose another"):
        Pll("Cyclone IV E", 50_000_000, 77_000_000)


def test_fit():
    fit = BOARD.fit(double_project(PROJECT))
    assert (fit.device, fit.told(), [figure.capacity for figure in fit.figures]) == (BOARD.device, [*fit.about], [114_480, 432, 532])
    assert all(figure.allowance == 0 for figure in fit.figures)


def test_readme():
    text = files()["README.md"]
    assert "75 MHz at `pll` (50 MHz x 3 / 2)" in text and "25 MHz at `pixel_pll` (50 MHz x 1 / 2)" in text
    assert "640x480 at 60 Hz" in text and "3,000,000 bits a second" in text
    for name in re.findall(r"`(stereo\.\w+)`", text):
        assert name in files()


def test_supplies_are_those_of_the_standards():
    """As public projects have them: 3.3 V for clock, header and VGA."""
    with resources.files("boards.de2_115").joinpath("pins.csv").open(encoding="utf-8") as file:
        rows = list(csv.DictReader(line for line in file if not line.startswith("#")))
    high = {row["signal"].partition("[")[0] for row in rows if row["volts"] == "3.3"}
    assert high == {"CLOCK_50", "GPIO", *(f"VGA_{name}" for name in ("CLK", "BLANK_N", "SYNC_N", "HS", "VS", "R", "G", "B"))}
    assert {row["volts"] for row in rows} == {"3.3", "2.5"}
