import re
from dataclasses import replace

import pytest

from boards.cyclone3.check import check_project
from golden.video.formats import DISPLAYS
from hdl.netlist import Cell, Port
from sim.models.board_core import board_project


@pytest.mark.parametrize("display", DISPLAYS)
def test_sound(display):
    assert check_project(board_project(display)) == []


# File, pattern, replacement, and the problems that the check must report.
VIOLATIONS = {
    "bit without a pin": ("qsf", r"set_location_assignment PIN_\w+ -to dvi_0__red__io\[3\]\n", "", [r"dvi_0__red__io\[3\] has no pin"]),
    "bit without a standard": ("qsf", r'set_instance_assignment -name IO_STANDARD "2.5 V" -to camera_1__data__io\[0\]\n', "",
                               [r"camera_1__data__io\[0\] has no I/O standard"]),
    "two pins": ("qsf", r"(set_location_assignment PIN_)AE23( -to uart_0__tx__io\n)", r"\g<0>\g<1>AC14\2",
                 ["uart_0__tx__io has 2 pins", "pin AC14 is used by uart_0__tx__io and switch_0__io|"
                  "pin AC14 is used by switch_0__io and uart_0__tx__io"]),
    "two standards": ("qsf", r'set_instance_assignment -name IO_STANDARD "1.8 V" -to led_3__io\n', r"\g<0>\g<0>",
                      ["led_3__io has 2 I/O standards"]),
    "pin used twice": ("qsf", r"PIN_AE15 -to led_4__io", "PIN_AD15 -to led_4__io", ["pin AD15 is used by led_0__io and led_4__io"]),
    "no such pin": ("qsf", r"PIN_AE15 -to led_4__io", "PIN_AZ99 -to led_4__io", ["pin AZ99 of led_4__io is not a known pin"]),
    "assignment to no port": ("qsf", r"\Z", "set_location_assignment PIN_AD18 -to switch_1__io\n",
                              ["switch_1__io has an assignment but is no port"]),
    "bit that is none": ("qsf", r"\Z", 'set_instance_assignment -name FAST_OUTPUT_REGISTER ON -to dvi_0__red__io[8]\n',
                         [r"dvi_0__red__io\[8\] has an assignment but is no port"]),
    "pair with no port": ("qsf", r"-from ddr2_0__clk_n__io", "-from ddr2_0__ck_n__io", ["ddr2_0__ck_n__io has an assignment but is no"]),
    "standard of another supply": ("qsf", r'"2.5 V" -to dvi_0__de__io', '"1.8 V" -to dvi_0__de__io',
                                   ["dvi_0__de__io .*'1.8 V', but its pin K3 is in bank 1, which is supplied with 2.5 V"]),
    "standard that is none": ("qsf", r'"2.5 V" -to dvi_0__de__io', '"LVDS" -to dvi_0__de__io', ["dvi_0__de__io .*'LVDS', which is not"]),
    # Nine filters find nothing, and two Gray pointers have no clock.
    "clock without constraint": ("sdc", r"create_clock -name camera_1.*\n", "", [
        "^the clock at camera_1__clk__io is not constrained$", *[r"line \d+: no clock camera_1__clk__io has been created by"] * 9,
        *["^the skew of the Gray pointer at core.right_camera_queue.* is not bounded"] * 2]),
    "oscillator without constraint": ("sdc", r"create_clock -name clk50.*\n", "", ["the clock at clk50_0__io is not constrained"]),
    "clock twice": ("sdc", r"create_clock -name camera_1.*\n", r"\g<0>\g<0>", ["camera_1__clk__io has 2 clocks"]),
    "clock that clocks nothing": ("sdc", r"\A", "create_clock -name u -period 9 [get_ports {uart_0__rx__io}]\n",
                                  ["a clock is created at uart_0__rx__io, which clocks nothing"]),
    "clock off the clock network": ("qsf", r"(PIN_)(Y28)( -to camera_0__clk__io\n[^\0]*?PIN_)(AC28)( -to camera_0__data__io\[0\])",
                                    r"\1\4\3\2\5", ["the clock at camera_0__clk__io enters at AC28, which does not reach"]),
    "constraint on no port": ("sdc", r"\[get_ports \{dvi_0__red__io\[\*\] ", "[get_ports {dvi_0__reds__io[*] ",
                              [r"^stereo.sdc, line \d+: no port dvi_0__reds__io\[\*\] is in the design$"]),
    "generated clock too late": ("sdc", r"(create_generated_clock .*\n)([^\0]*)(?=# DVI)", r"\2\1",
                                 ["^stereo.sdc, line 1[0-9]: no clock dvi_clock has been created by then$"]),
    "clock of another name": ("sdc", r"(set_clock_groups[^#]*?)camera_1__clk__io", r"\1camera_1__clock",
                              ["^stereo.sdc, line 1[0-9]: no clock camera_1__clock has been created by then$"]),
    "register that is none": ("sdc", r"(set_max_delay .*)right_camera_queue\|", r"\1right_queue|",
                              [r"no register core\|right_queue\|.*stage0\[\*\] is in the design$",
                               # What is left is the bound of the clocks.
                               r"Gray pointer at core\|right_camera_queue\|.*consume_cdc may have a skew of 104.444 ns, and "
                               r"the faster of its clocks has a period of 13.333 ns"]),
    "pointer without a bound": ("sdc", r"set_min_delay .*left_camera_queue\|.*produce.*\n", "",
                                [r"Gray pointer at core\|left_camera_queue\|fifo\|unbuffered\|produce_cdc may have a skew of 108.888 ns"]),
    "pointer with a wide bound": ("sdc", r"8\.888\n\Z|8\.888(?=\nset_min_delay [^\n]*\n\Z)", "8.890",
                                  [r"right_camera_queue\|.*produce_cdc may have a skew of 13.334 ns, and .* period of 13.333 ns"]),
    "pointers cut by a false path": ("sdc", r"\Z", "set_false_path -from [get_clocks {camera_0__clk__io}] -to [get_clocks {ddr2|*}]\n",
                                     [r"Gray pointer at core\|left_camera_queue\|.*produce_cdc is not bounded: give it set_max"]),
    "pointers cut by clock groups": ("sdc", r"set_clock_groups -asynchronous", r"\g<0> -group [get_clocks {ddr2|*}]",
                                     [r"Gray pointer at core\|(left|right)_camera_queue.*(consume|produce)_cdc is not bounded"] * 4 +
                                     [r"skew of the Gray pointer at core\|display_queue.*(consume|produce)_cdc is not bounded"] * 2),
    "command that is not known": ("sdc", r"\Z", "set_max_skew -to [get_clocks {ddr2|*}] 1\n",
                                  ["the command 'set_max_skew' is not one that is checked"]),
    "attribute of a synchroniser": ("v", r" -name PRESERVE_REGISTER ON(?=\")", "",
                                    [r"the synchroniser \S+ lacks the altera_attribute of its registers in stereo.v"]),
    "instance of another name": ("v", r" display_queue \(", " display_queue_ (",
                                 [r"stereo.v has no instance display_queue, which leads to the synchroniser core\|display_queue"] * 3),
    "module": ("v", r"\Amodule stereo\(", "module mono(", ["stereo.v has no module stereo"]),
    "port of the text alone": ("v", r"(\Amodule stereo\()", r"\1spare, ", ["stereo.v has the port spare, which is not in the design"]),
    "port that the text lacks": ("v", r"(\Amodule stereo\([^;]*)rst_0__io, ", r"\1", ["stereo.v lacks the port rst_0__io"]),
    "top level": ("qsf", "TOP_LEVEL_ENTITY stereo", "TOP_LEVEL_ENTITY mono", ["top-level module is stereo, but stereo.qsf has mono"]),
    "source": ("qsf", "VERILOG_FILE stereo.v", "VERILOG_FILE mono.v", ["stereo.qsf names the file mono.v, which does not exist"]),
    "constraints": ("qsf", ".*SDC_FILE.*\n", "", ["stereo.qsf has no SDC_FILE"]),
    "device": ("qsf", ".*DEVICE EP3.*\n", "", ["stereo.qsf has no DEVICE"]),
}


@pytest.mark.parametrize("case", VIOLATIONS)
def test_violation(case):
    suffix, pattern, replacement, told = VIOLATIONS[case]
    project = board_project("720x576")
    text, times = re.subn(pattern, replacement, project.files[f"stereo.{suffix}"], count=1)
    assert times == 1
    problems = check_project(replace(project, files={**project.files, f"stereo.{suffix}": text}))
    assert len(problems) == len(told), problems
    for expected in told:
        assert any(re.search(expected, problem) for problem in problems), (expected, problems)


def with_top(project, **changes):
    """The project with another netlist of its top level."""
    return replace(project, netlist={**project.netlist, "stereo": replace(project.netlist["stereo"], **changes)})


def test_gated_clock():
    project = board_project("720x576")
    cells = project.netlist["stereo"].cells
    ddr2 = replace(cells["ddr2"], connections={**cells["ddr2"].connections, "pll_ref_clk": [10_000]})
    gate = Cell("$and", {"Y": [10_000]}, {"Y": "output"})
    gated = with_top(project, cells={**cells, "ddr2": ddr2, "gate": gate}, nets={**project.netlist["stereo"].nets, "gated": [10_000]})
    assert check_project(gated) == ["the clock gated is driven neither by a pin nor by a PLL"]


def test_port_that_nobody_expected():
    project = board_project("720x576")
    ports = {**project.netlist["stereo"].ports, "spare": Port("output", [10_000, 10_001])}
    assert check_project(with_top(project, ports=ports)) == [
        "stereo.v lacks the port spare", *(f"spare[{bit}] has no {what}" for what in ("pin", "I/O standard") for bit in (0, 1))]


def test_without_the_clocks_of_the_plls():
    """All that names one of them is told, once for each filter."""
    project = board_project("720x576")
    constraints = project.files["stereo.sdc"].replace("\nderive_pll_clocks\n", "\n# derive_pll_clocks_no\n")
    problems = check_project(replace(project, files={**project.files, "stereo.sdc": constraints}))
    assert problems[:2] == [f"the clock {clock} is not constrained: derive_pll_clocks is missing"
                            for clock in ("altpll.clk", "stereo_ddr2.phy_clk")]
    assert sum("no clock display_pll|* has been created by then" in problem for problem in problems) == 7


@pytest.mark.parametrize("kind", ["altera_std_synchronizer_bundle", "lpm_mult"])
def test_foreign_module(kind):
    project = board_project("720x576")
    cells = {**project.netlist["stereo"].cells, "foreign": Cell(kind, {})}
    assert check_project(with_top(project, cells=cells)) == [
        f"the module {kind} is neither in the design nor one of Altera's blocks altiobuf_in, altiobuf_out, altiobuf_bidir, altpll, "
        "altddio_out, altddio_in, stereo_ddr2"]


def test_wide_synchroniser_without_a_gray_pointer():
    """Bits that change together, by the name of their net; the constraints do not know of them either."""
    project = board_project("720x576")
    name = "stereo.core.display_queue.fifo.unbuffered"
    module = project.netlist[name]
    nets = {net.replace("consume_r_gry", "consume_r_bits"): bits for net, bits in module.nets.items()}
    problem, = check_project(replace(project, netlist={**project.netlist, name: replace(module, nets=nets)}))
    assert problem.startswith("the synchroniser core|display_queue|fifo|unbuffered|consume_cdc takes 4 bits, and consume_r_bits is not a ")


def test_bits_that_need_not_arrive_together(monkeypatch):
    monkeypatch.setattr("boards.altera.crossings.GRAY", "_none")
    assert all("takes 4 bits" in problem for problem in check_project(board_project("720x576")))
    monkeypatch.setattr("boards.altera.check.LOOSE", ("consume_cdc", "produce_cdc"))
    assert check_project(board_project("720x576")) == []
