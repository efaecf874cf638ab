import json
import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from amaranth.hdl import Fragment

from boards import cyclone3
from golden.config import Arithmetic, MatcherConfig
from hdl.build import main
from hdl.matcher import Matcher


ROOT = Path(__file__).parent.parent
SMALL = ["--width", "24", "--height", "10", "--disparities", "6"]
BOARD = ["--board", "cyclone3", "--engine", "sequential", *SMALL]


@pytest.fixture(scope="module")
def folders(tmp_path_factory):
    """A board's build, sequential engine; a core's, streaming engine."""
    base = tmp_path_factory.mktemp("builds")
    assert main([*BOARD, "--output", str(base / "deep" / "board")]) == 0
    assert main(["--core", *SMALL, "--fraction-bits", "2", "--u1", "7", "--output", str(base / "core")]) == 0
    return {"stereo": base / "deep" / "board", "matcher": base / "core"}


def manifest(folder):
    return json.loads((folder / "manifest.json").read_text())


def header(text, module):
    """Ports of a module of the Verilog text: name to (direction, width)."""
    body = re.search(rf"(?ms)^module {module}\((.*?)\);(.*?)^endmodule", text)
    names = re.findall(r"\w+", body[1])
    found = {name: (direction, int(high or 0) + 1) for direction, high, name
             in re.findall(r"(?m)^  (input|output) (?:\[(\d+):0\] )?(\w+);$", body[2])}
    assert sorted(names) == sorted(found)
    return found


def test_files(folders):
    names = {"stereo": {"stereo.v", "stereo.qpf", "stereo.qsf", "stereo.sdc"}, "matcher": {"matcher.v"}}
    for top, folder in folders.items():
        assert {path.name for path in folder.iterdir()} == names[top] | {"manifest.json"}
        assert set(manifest(folder)["files"]) == names[top]


@pytest.mark.parametrize("top", ["stereo", "matcher"])
def test_ports_are_those_of_the_module(folders, top):
    told = manifest(folders[top])
    ports = {name: (port["direction"], port["width"]) for name, port in told["ports"].items()}
    assert told["top"] == top
    assert ports == header((folders[top] / f"{top}.v").read_text(), top)


@pytest.mark.parametrize("top, parameters, clocks", [
    ("stereo", {"arithmetic": "thesis", "u1": 15}, 5),
    ("matcher", {"arithmetic": "linear", "fraction_bits": 2, "u1": 7}, 1),
])
def test_manifest(folders, top, parameters, clocks):
    told = manifest(folders[top])
    assert told["engine"] == {"stereo": "sequential", "matcher": "streaming"}[top]
    common = {"disparities": 6, "u2": 10, "u3": 5, "max_width": 24, "height": 10}
    assert {name: told["parameters"][name] for name in {**common, **parameters}} == {**common, **parameters}
    matcher = Matcher(MatcherConfig(disparities=6, max_width=24, arithmetic=Arithmetic(parameters["arithmetic"]), engine=told["engine"]))
    Fragment.get(matcher, None)  # Amaranth complains of a component that is not used
    assert told["clocks_per_pixel"] == matcher.clocks_per_pixel == clocks
    # Short lines take as long as a disparity takes to come back to the line memory.
    assert told["latency_clocks"] == 2 * max(24, matcher.full_rate_width) * clocks + matcher.latency_clocks
    assert told["full_rate_width"] == matcher.full_rate_width
    assert told["clock_mhz_for_25_frames"] >= round(25 * 24 * 10 * clocks / 1e6, 2)


def test_manifest_tells_where_the_fields_of_a_payload_are(folders):
    payloads = manifest(folders["matcher"])["payloads"]
    assert payloads["i__payload"] == {"left": [0, 7], "right": [8, 15], "first": [16, 16], "last": [17, 17], "end": [18, 18]}
    assert list(payloads["o__payload"]) == ["disparity", "first", "last", "end"]
    assert payloads["o__payload"]["disparity"][0] == 0


def test_a_clock_that_the_board_does_not_have(tmp_path, capsys):
    """Constrained to what 25 frames/s need, and said so."""
    arguments = ["--board", "cyclone3", "--width", "4000", "--height", "4000", "--disparities", "2", "--output", str(tmp_path)]
    assert main(arguments) == 0
    needed = manifest(tmp_path)["clock_mhz"]
    assert needed > cyclone3.CLOCK_MHZ
    assert f"-period {1000 / needed:.3f} " in (tmp_path / "stereo.sdc").read_text()
    assert f"constrained to {needed} MHz, and needs a PLL" in capsys.readouterr().out


def test_manifest_names_the_board(folders):
    board, core = manifest(folders["stereo"]), manifest(folders["matcher"])
    assert (board["board"], board["device"], board["clock_mhz"]) == ("cyclone3", "EP3C120F780C7", cyclone3.CLOCK_MHZ)
    assert "board" not in core


def test_weights_and_width_reach_the_verilog(folders):
    text = (folders["matcher"] / "matcher.v").read_text()
    defaults = dict(re.findall(r"reg \[5:0\] (u[123])_(?!of_frame)\w+ = 6'h(\w+);", text))
    assert {name: int(value, 16) for name, value in defaults.items()} == {"u1": 7, "u2": 10, "u3": 5}
    assert re.search(r"reg \[15:0\] line_memory \[23:0\];", text)


def test_quartus_project(folders):
    folder = folders["stereo"]
    settings = (folder / "stereo.qsf").read_text()
    assert 'set_global_assignment -name FAMILY "Cyclone III"\n' in settings
    assert "set_global_assignment -name DEVICE EP3C120F780C7\n" in settings
    assert "set_global_assignment -name TOP_LEVEL_ENTITY stereo\n" in settings
    assert "set_global_assignment -name VERILOG_FILE stereo.v\n" in settings
    assert "set_global_assignment -name SDC_FILE stereo.sdc\n" in settings
    assert 'PROJECT_REVISION = "stereo"\n' in (folder / "stereo.qpf").read_text()
    assert f"create_clock -name clk -period {1000 / cyclone3.CLOCK_MHZ:.3f} [get_ports clk]\n" in (folder / "stereo.sdc").read_text()
    # Every bit of every port has one place: a ball, or a virtual pin.
    assigned = re.findall(r"(?m)^set_(?:location_assignment PIN_\w+|instance_assignment -name VIRTUAL_PIN ON) -to (\S+)$", settings)
    bits = [name if port["width"] == 1 else f"{name}[{bit}]"
            for name, port in manifest(folder)["ports"].items() for bit in range(port["width"])]
    assert sorted(assigned) == sorted(bits)
    assert {"clk", "reset_n"} == set(re.findall(r"(?m)^set_location_assignment PIN_\w+ -to (\w+)$", settings))


def test_same_bytes_in_another_process(folders, tmp_path):
    environment = {**os.environ, "PYTHONHASHSEED": "123", "AMARANTH_USE_YOSYS": "builtin"}
    subprocess.run([sys.executable, "-m", "hdl.build", *BOARD, "--output", tmp_path / "again"], cwd=ROOT,
                   env=environment, check=True, capture_output=True)
    first = {path.name: path.read_bytes() for path in folders["stereo"].iterdir()}
    assert {path.name: path.read_bytes() for path in (tmp_path / "again").iterdir()} == first


def test_a_build_takes_the_place_of_another(tmp_path, capsys):
    for labels in ("3", "2"):
        assert main(["--core", "--width", "4", "--disparities", labels, "--output", str(tmp_path)]) == 0
    assert manifest(tmp_path)["parameters"]["disparities"] == 2
    assert sorted(path.name for path in tmp_path.iterdir()) == ["manifest.json", "matcher.v"]
    told = capsys.readouterr().out
    assert "Clocks a pixel: 1;" in told and "MHz" in told


BAD = {
    "unknown board": (["--board", "de2"], "'de2'.*cyclone3"),
    "neither board nor core": ([], "--board.*--core"),
    "board and core": (["--board", "cyclone3", "--core"], "not allowed"),
    "too few disparities": (["--core", "--disparities", "1"], "disparities.*from 2 to.*not 1;"),
    "too many disparities": (["--core", "--disparities", "257"], "disparities.*from 2 to 256.*not 257;"),
    "too many for the sequential engine": (["--core", "--engine", "sequential", "--disparities", "129"], "disparities.*to 128.*129;"),
    "thesis on the streaming engine": (["--core", "--engine", "streaming", "--arithmetic", "thesis"], "thesis.*--engine sequential"),
    "unknown engine": (["--core", "--engine", "graph"], "'graph'"),
    "disparities not a number": (["--core", "--disparities", "many"], "'many'"),
    "width 0": (["--core", "--width", "0"], "--width.*from 1 to 4096.*not 0"),
    "width too great": (["--core", "--width", "4097"], "--width.*4097"),
    "height 0": (["--board", "cyclone3", "--height", "0"], "--height.*not 0"),
    "float": (["--core", "--arithmetic", "float"], "float.*thesis or linear.*golden"),
    "unknown arithmetic": (["--core", "--arithmetic", "exact"], "'exact'"),
    "fraction bits": (["--core", "--arithmetic", "linear", "--fraction-bits", "5"], "--fraction-bits.*from 0 to 4.*not 5"),
    "weight": (["--core", "--u2", "64"], "--u2.*from 0 to 63.*not 64"),
    "negative weight": (["--core", "--u3", "-1"], "--u3.*not -1"),
    "abbreviated option": (["--core", "--disp", "4"], "--disp"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input(case, tmp_path, capsys):
    arguments, told = BAD[case]
    assert main([*arguments, "--output", str(tmp_path / "out")]) == 2
    out, err = capsys.readouterr()
    assert re.match(f"hdl.build: .*{told}", err), err
    assert err.count("\n") == 1
    assert out == ""
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("place", ["file", "file/below", "not/writable"])
def test_bad_output(place, tmp_path, capsys):
    (tmp_path / "file").write_text("mine")
    if place == "not/writable":
        folder = Path("/proc/version_of_nothing")  # not even root makes folders there
        if not Path("/proc").is_dir():
            pytest.skip("no /proc on this machine")
    else:
        folder = tmp_path / place
    assert main(["--core", *SMALL, "--output", str(folder)]) == 2
    out, err = capsys.readouterr()
    assert re.match(r"hdl\.build: .*choose another --output\n$", err), err
    assert out == ""
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
    assert (tmp_path / "file").read_text() == "mine"
