import re
from functools import reduce

import pytest

from boards.cyclone3.check import check_project
from golden.video.formats import DISPLAYS
from sim.models.board_core import board_project


@pytest.fixture(params=DISPLAYS)
def display(request):
    return request.param


@pytest.fixture
def files(display):
    return board_project(display).files


@pytest.fixture
def top(display):
    return board_project(display).netlist["stereo"]


def of_port(settings, name):
    """Values of an instance assignment by port."""
    return {port: value.strip('"') for value, port in
            re.findall(rf'(?m)^set_instance_assignment -name {name} ("[^"]+"|\w+) -to (\S+)$', settings)}


def test_files(files):
    assert set(files) == {"stereo.v", "stereo.qpf", "stereo.qsf", "stereo.sdc", "check_ddr2.tcl", "README.md"}
    for text in files.values():
        assert text.endswith("\n") and not text.endswith("\n\n")
        assert not re.search(r"Amaranth|\{\{|\{%|placeholder|@[A-Z]+@", text)
    assert set(re.findall(r"\(\* *(\w+)", files["stereo.v"])) == {"altera_attribute"}
    assert not re.search(r"\.py", files["stereo.v"])


def test_settings(files):
    lines = files["stereo.qsf"].splitlines()
    for line in ('set_global_assignment -name FAMILY "Cyclone III"',
                 'set_global_assignment -name STRATIX_DEVICE_IO_STANDARD "2.5 V"',
                 'set_global_assignment -name RESERVE_ALL_UNUSED_PINS_WEAK_PULLUP "AS INPUT TRI-STATED WITH WEAK PULL-UP"',
                 "set_global_assignment -name DEVICE EP3C120F780C7", "set_global_assignment -name TOP_LEVEL_ENTITY stereo",
                 "set_global_assignment -name CYCLONEII_OPTIMIZATION_TECHNIQUE SPEED",
                 "set_global_assignment -name AUTO_SHIFT_REGISTER_RECOGNITION OFF",
                 "set_global_assignment -name VERILOG_FILE stereo.v", "set_global_assignment -name QIP_FILE stereo_ddr2.qip"):
        assert lines.count(line) == 1
    # The controller's own constraints need the clocks of the pins.
    order = [line.split()[3] for line in lines if "_FILE " in line]
    assert order == ["stereo.v", "stereo.sdc", "stereo_ddr2.qip"]


def test_registers_in_the_pins(files):
    """The emitted text has none of their attributes: Amaranth's attributes are settings."""
    settings = files["stereo.qsf"]
    assert set(of_port(settings, "FAST_INPUT_REGISTER")) == {f"camera_{n}__data__io[{bit}]" for n in (0, 1) for bit in range(8)}
    assert set(of_port(settings, "FAST_OUTPUT_REGISTER")) == {
        *(f"dvi_0__{colour}__io[{bit}]" for colour in ("red", "green", "blue") for bit in range(8)),
        "dvi_0__de__io", "dvi_0__hsync__io", "dvi_0__vsync__io"}
    assert set(of_port(settings, "WEAK_PULL_UP_RESISTOR")) == {
        "decoder_0__scl__io", "decoder_0__sda__io", "dvi_0__scl__io", "dvi_0__sda__io"}


def test_memory_pins(files):
    """As in the script that Altera generates for this controller on this board."""
    settings = files["stereo.qsf"]
    strength, group = of_port(settings, "CURRENT_STRENGTH_NEW"), of_port(settings, "OUTPUT_ENABLE_GROUP")
    names = {port: re.match(r"ddr2_0__(\w+)__io", port)[1] for port in strength}
    assert {names[port] for port, value in strength.items() if value == "MAXIMUM CURRENT"} == {
        "odt", "cs_n", "cke", "addr", "ba", "ras_n", "cas_n", "we_n"}
    assert {names[port] for port, value in strength.items() if value == "12MA"} == {"clk", "clk_n", "dq", "dqs", "dm"}
    assert set(group) == {f"ddr2_0__{name}__io[{bit}]" for name, width in (("dq", 32), ("dqs", 4), ("dm", 4)) for bit in range(width)}
    assert len(set(group.values())) == 1
    assert of_port(settings, "PAD_TO_CORE_DELAY") == {"ddr2_0__clk__io": "0"}
    assert "set_instance_assignment -name CKN_CK_PAIR ON -from ddr2_0__clk_n__io -to ddr2_0__clk__io\n" in settings


def test_clocks(files):
    constraints = files["stereo.sdc"]
    clocks = dict(re.findall(r"(?m)^create_clock -name (\S+) -period (\S+) ", constraints))
    assert clocks == {"clk50_0__io": "20.000", "camera_0__clk__io": "37.037", "camera_1__clk__io": "37.037"}
    # All clocks are created before the first constraint that names one.
    commands = [line.split()[0] for line in constraints.splitlines() if line and line[0] not in "# "]
    assert [command for command in dict.fromkeys(commands)][:5] == [
        "create_clock", "derive_pll_clocks", "derive_clock_uncertainty", "create_generated_clock", "set_clock_groups"]
    assert not {"create_clock", "create_generated_clock"} & set(commands[commands.index("set_clock_groups"):])
    groups = re.findall(r"-group \[get_clocks \{([^}]+)\}\]", constraints)
    assert groups == ["display_pll|* dvi_clock", "camera_0__clk__io", "camera_1__clk__io"]


def test_delays_at_the_pins(files):
    """Pixels relative to the clock sent with them, camera bytes relative to the falling edge of theirs."""
    constraints = files["stereo.sdc"]
    delays = re.findall(r"(?m)^set_(input|output)_delay -clock (\S+) (-clock_fall )?-(max|min) (\S+) (.*)$", constraints)
    camera = [("input", f"camera_{n}__clk__io", "-clock_fall ", *limit, f"[get_ports {{camera_{n}__data__io[*]}}]")
              for n in (0, 1) for limit in (("max", "10.0"), ("min", "0.0"))]
    assert delays == [("output", "dvi_clock", "", "max", "1.2", "$dvi_ports"), ("output", "dvi_clock", "", "min", "-1.3", "$dvi_ports"),
                      *camera]
    assert re.search(r"(?m)^create_generated_clock -name dvi_clock .* -invert \[get_ports \{dvi_0__clk__io\}\]$", constraints)


def test_names_of_the_blocks_that_constraints_name(files, top):
    """The PLL and the memory controller are at the top, with these names; in the text too."""
    for name, kind in (("display_pll", "altpll"), ("ddr2", "stereo_ddr2")):
        assert top.cells[name].kind == kind
        assert re.search(rf"(?m)^  {kind} (#\([^;]*?\n  \) )?{name} \($", files["stereo.v"])


def test_registers_that_the_readme_names(files):
    """The first registers of the Gray pointers: all that the constraints bound, and no other but single bits."""
    level, register = re.search(r"get_registers -compatibility_mode \{\*(\w+)\|(\w+)\[\*\]\}", files["README.md"]).groups()
    bounded = re.findall(r"get_registers \{(.*)\|(\w+)\[\*\]\}", files["stereo.sdc"])
    assert len(bounded) == 2 * 6
    assert all(path.endswith(level) and name == register for path, name in bounded)
    wide = re.findall(rf"(?ms)^module (\w+{level})\((?:(?!endmodule).)*reg \[\d+:0\] {register};", files["stereo.v"])
    modules = {name: {instance: kind for kind, instance in re.findall(r"(?m)^  (\w+) (?:#\([^;]*?\n  \) )?(\w+) \($", body)}
               for name, body in re.findall(r"(?ms)^module (\w+)(.*?)^endmodule", files["stereo.v"])}
    kinds = [reduce(lambda module, instance: modules[module][instance], path.split("|"), "stereo") for path, _ in bounded]
    assert sorted(wide) == sorted(set(kinds))


def test_memory_clock_of_125_mhz():
    """All that names a frequency follows; the FIFOs' windows are those of the pixel clock of 65 MHz, now the faster one."""
    slow, fast = (board_project("1024x768", hertz).files for hertz in (62_500_000, 75_000_000))
    assert "| memory clock | 125 MHz |" in re.sub(r"(?m)^\| \| ", "| ", slow["README.md"])
    assert "62.5 MHz at `ddr2`" in slow["README.md"]
    assert "75 MHz" not in slow["README.md"] and "150 MHz" not in slow["README.md"]
    bounds = [{float(value) for value in re.findall(r"stage0\[\*\]\}\] (\S+)", files["stereo.sdc"])} for files in (slow, fast)]
    # Thirds of 15.385 ns and of 16 ns; of 13.333 ns.
    assert bounds == [{10.256, -5.128, 10.666, -5.333}, {8.888, -4.444}]
    assert check_project(board_project("1024x768", 62_500_000)) == []


def test_every_port_is_constrained(files, display):
    """By a delay, as a false path, as a clock, or by the memory controller's own constraints."""
    named = re.findall(r"\[get_ports \{([^}]+)\}\]", files["stereo.sdc"])
    patterns = [re.escape(pattern).replace(r"\*", ".*") for pattern in " ".join(named).split()]
    for port, (_, width) in board_project(display).ports.items():
        bits = [port] if width == 1 else [f"{port}[{bit}]" for bit in range(width)]
        for bit in bits:
            assert port.startswith("ddr2_") or any(re.fullmatch(pattern, bit) for pattern in patterns), bit


def test_readme(files, display, top):
    """Names the files that exist, with the numbers of this build."""
    text = files["README.md"]
    shown = DISPLAYS[display]
    assert f"{shown.width}x{shown.height} at {round(shown.frames_per_second)} Hz" in text
    assert f"{shown.pixel_clock_hz / 1e6} MHz at `display_pll` (50 MHz x {'27 / 50' if display == '720x576' else '13 / 10'})" in text
    assert "| memory clock | 150 MHz |" in re.sub(r"(?m)^\| \| ", "| ", text)
    assert "4 disparities, sequential engine, thesis arithmetic" in text
    for name in re.findall(r"`(stereo\.\w+)`", text):
        assert name in files
    listed = text[text.index("The module must have"):text.index("Of the scripts")]
    assert set(top.cells["ddr2"].connections) == set(re.findall(r"\b(?:local|mem|aux|pll|global|soft|phy|reset)_\w+", listed))
