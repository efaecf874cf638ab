"""hdl.build --core --interface: ports, manifest, and what is refused."""

import re

import pytest

from golden.config import FUSED_1, MatcherConfig
from golden.host.core_registers import core_register_map
from hdl.build import fields_of, main, ports_of
from hdl.interfaces.cores import INTERFACES, AvalonMatcher, AxiMatcher, OutputData
from tests.kit import manifest, refused_components, verilog_ports


SIZE = ["--width", "12", "--height", "6", "--disparities", "4"]
CONFIG = MatcherConfig(20, 300, -16, method=FUSED_1)

# Name, direction and width of the ports, as the specifications of AXI and Avalon have them.
STREAMS = {
    "axi": {"aclk": ("input", 1), "aresetn": ("input", 1),
            "s_axis_tdata": ("input", 16), "s_axis_tuser": ("input", 1), "s_axis_tlast": ("input", 1), "s_axis_tvalid": ("input", 1),
            "s_axis_tready": ("output", 1), "m_axis_tdata": ("output", 8), "m_axis_tuser": ("output", 1), "m_axis_tlast": ("output", 1),
            "m_axis_tvalid": ("output", 1), "m_axis_tready": ("input", 1)},
    "avalon": {"clk": ("input", 1), "reset": ("input", 1),
               "asi_data": ("input", 16), "asi_startofpacket": ("input", 1), "asi_endofpacket": ("input", 1), "asi_valid": ("input", 1),
               "asi_ready": ("output", 1), "aso_data": ("output", 8), "aso_startofpacket": ("output", 1), "aso_endofpacket": ("output", 1),
               "aso_valid": ("output", 1), "aso_ready": ("input", 1)},
}
REGISTERS = {
    "axi": "s_axi_awaddr 10, s_axi_awvalid, s_axi_awready -1, s_axi_wdata 32, s_axi_wstrb 4, s_axi_wvalid, s_axi_wready -1, "
           "s_axi_bresp -2, s_axi_bvalid -1, s_axi_bready, s_axi_araddr 10, s_axi_arvalid, s_axi_arready -1, s_axi_rdata -32, "
           "s_axi_rresp -2, s_axi_rvalid -1, s_axi_rready",
    "avalon": "avs_address 8, avs_read, avs_write, avs_writedata 32, avs_byteenable 4, avs_waitrequest -1, avs_readdata -32, "
              "avs_readdatavalid -1, avs_response -2, avs_writeresponsevalid -1",
}


@pytest.mark.parametrize("interface", INTERFACES)
def test_build(interface, tmp_path):
    assert main(["--core", "--interface", interface, *SIZE, "--output", str(tmp_path)]) == 0
    told = manifest(tmp_path)
    ports = {name: (port["direction"], port["width"]) for name, port in told["ports"].items()}
    assert ports == verilog_ports((tmp_path / "matcher.v").read_text(), "matcher")
    widths = {name: int(width or 1) for name, width in (each.partition(" ")[::2] for each in REGISTERS[interface].split(", "))}
    assert ports == STREAMS[interface] | {name: ("input" if width > 0 else "output", abs(width)) for name, width in widths.items()}
    assert told["interface"] == interface and set(told["marks"]) <= set(ports)
    name = {"axi": "s_axis_tdata", "avalon": "asi_data"}[interface]
    assert told["payloads"].pop(name) == {"left": [0, 7], "right": [8, 15]}
    assert [*told["payloads"].values()] == [{"disparity": [0, 1]}]
    registers = {register["name"]: register for register in told["registers"]}
    assert registers["height"]["offset"] == 0x24 and registers["height"]["reset"] == 6 and registers["width"]["maximum"] == 12
    assert len(registers) == len(core_register_map(MatcherConfig(4, 12)))


def test_output_is_whole_bytes():
    layout = OutputData(CONFIG)
    assert {name: (field.offset, field.width) for name, field in layout} == {"disparity": (0, 10), "passed": (10, 1), "confidence": (11, 4)}
    assert layout.size == 16
    with refused_components():      # they are not elaborated
        for data, core in {"m_axis_tdata": AxiMatcher, "aso_data": AvalonMatcher}.items():
            check_fields(core(CONFIG, 10), data)


def check_fields(core, data):
    assert ports_of(core)[data] == ("output", 16)
    assert fields_of(core)[data] == {"disparity": (0, 9), "passed": (10, 10), "confidence": (11, 14)}
    minimum = next(register for register in core.about["registers"] if register["name"] == "minimum")
    assert (minimum["signed"], minimum["minimum"], minimum["reset"]) == (True, -16, -16)


def test_bare_streams_tell_their_interface(tmp_path):
    for more, interface in (([], "stream"), (["--frame-timing"], "frame timing")):
        assert main(["--core", *more, *SIZE, "--output", str(tmp_path)]) == 0
        assert manifest(tmp_path)["interface"] == interface and "registers" not in manifest(tmp_path)


@pytest.mark.parametrize("arguments, told", [
    (["--core", "--interface", "wishbone"], "no interface 'wishbone'; choose one of: stream, axi, avalon$"),
    (["--core", "--interface", "axi", "--frame-timing"], "--interface axi and --frame-timing .*leave one of the two out$"),
    (["--core", "--interface", "avalon", "--rectify"], "--rectify .* --interface avalon .*choose --interface stream$"),
    (["--board", "cyclone3", "--interface", "axi"], "--interface axi is for the bare matcher.*choose --core, or leave --interface out$"),
])
def test_bad_input(arguments, told, tmp_path, capsys):
    assert main([*arguments, "--output", str(tmp_path / "out")]) == 2
    out, err = capsys.readouterr()
    assert re.match(f"hdl.build: .*{told}", err) and err.count("\n") == 1 and out == ""
    assert list(tmp_path.iterdir()) == []
