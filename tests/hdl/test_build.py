import os
import re
import subprocess
import sys
from dataclasses import replace
from functools import partial
from pathlib import Path

import pytest
from amaranth.hdl import Fragment

from boards.cyclone3 import board
from boards.cyclone3.check import check_project
from golden.config import FUSED_1, Arithmetic, MatcherConfig, OnePass, changed
from golden.host.registers import register_map
from golden.rig.config import RigConfig
from golden.video.bandwidth import MemoryTiming
from golden.video.formats import DISPLAYS
from hdl.build import main
from hdl.matcher.matcher import Matcher
from sim.models.board_core import BoardCore
from tests.kit import manifest, refused_components, verilog_ports


ROOT = Path(__file__).parents[2]
BOARD_AS_IT_IS = board.BOARD
SMALL = ["--width", "24", "--height", "10", "--disparities", "6"]
FEW = ["--disparities", "6"]
BOARD = ["--board", "cyclone3", "--engine", "sequential", "--display", "1024x768", *FEW]

# The command with the stand-in for the video system, for a separate process.
WITH_STAND_IN = """
import sys, dataclasses
from boards.cyclone3 import board
from hdl.build import main
from sim.models.board_core import BoardCore
board.BOARD = dataclasses.replace(board.BOARD, system=lambda design: BoardCore(design.config))
sys.exit(main(sys.argv[1:]))
"""


@pytest.fixture(scope="module", autouse=True)
def given():
    """Replaces the board's video system by the stand-in; the displays that it was made for, and the rectification."""
    made = []

    def stand_in(design):
        assert MemoryTiming.at(design.clock_hz) == MemoryTiming()
        made.append((design.display, design.rig))
        return BoardCore(design.config)

    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(board, "BOARD", replace(board.BOARD, system=stand_in))
        yield made


@pytest.fixture(scope="module")
def folders(tmp_path_factory, given):
    """Builds of a board with the sequential engine, of a core with the streaming engine, and of that core with frame timing signals."""
    base = tmp_path_factory.mktemp("builds")
    assert main([*BOARD, "--package", "registers", "--output", str(base / "deep" / "board")]) == 0
    assert given == [(DISPLAYS["1024x768"], RigConfig())]
    core = ["--core", *SMALL, "--fraction-bits", "2", "--u1", "7"]
    assert main([*core, "--output", str(base / "core")]) == 0
    assert main([*core, "--frame-timing", "--output", str(base / "framed")]) == 0
    return {"stereo": base / "deep" / "board", "matcher": base / "core", "framed": base / "framed"}


def test_files(folders):
    names = {"stereo": {"stereo.v", "stereo.qpf", "stereo.qsf", "stereo.sdc", "check_ddr2.tcl", "README.md",
                        "stereo.rdl", "stereo.h", "stereo_registers.py"},
             "matcher": {"matcher.v", "matcher.vlt"}, "framed": {"matcher.v", "matcher.vlt"}}
    for top, folder in folders.items():
        assert {path.name for path in folder.iterdir()} == names[top] | {"manifest.json"}
        assert set(manifest(folder)["files"]) == names[top]


@pytest.mark.parametrize("folder, top", [("stereo", "stereo"), ("matcher", "matcher"), ("framed", "matcher")])
def test_ports_are_those_of_the_module(folders, folder, top):
    told = manifest(folders[folder])
    ports = {name: (port["direction"], port["width"]) for name, port in told["ports"].items()}
    assert told["top"] == top
    assert ports == verilog_ports((folders[folder] / f"{top}.v").read_text(), top)


def test_registers_of_the_board(folders):
    """Are those of its serial line, two bytes each."""
    text = (folders["stereo"] / "stereo_registers.py").read_text()
    offsets = {name: int(offset, 16) for name, offset in re.findall(r"(?m)^    '(\w+)': Register\(\n +(\w+),", text)}
    registers = register_map(MatcherConfig(6, 720, engine="sequential", method=OnePass(Arithmetic.THESIS)), 576, RigConfig())
    assert offsets == {register.name: 2 * register.address for register in registers}


def test_two_cores_in_one_design(tmp_path):
    """Top module, its file and all sub-modules have the name that was given."""
    names = {}
    for name in ("left_eye", "right_eye"):
        assert main(["--core", *SMALL, "--name", name, "--output", str(tmp_path / name)]) == 0
        assert manifest(tmp_path / name)["top"] == name
        names[name] = re.findall(r"(?m)^module (\w+)", (tmp_path / name / f"{name}.v").read_text())
        assert len(names[name]) > 5 and all(module == name or module.startswith(f"{name}_") for module in names[name])
    assert not set(names["left_eye"]) & set(names["right_eye"])


def test_header(folders):
    """Version, command without the folder, licence, parameters, timing."""
    lines = (folders["matcher"] / "matcher.v").read_text().partition("\n\n")[0].splitlines()
    assert all(line.startswith("//") for line in lines)
    text = "\n".join(lines)
    told = manifest(folders["matcher"])
    assert f"python -m hdl.build --core {' '.join(SMALL)} --fraction-bits 2 --u1 7\n" in text
    assert "SPDX-License-Identifier: BSD-2-Clause" in text and "disparities = 6" in text and "max_width = 24" in text
    assert f"Clocks a pixel: {told['clocks_per_pixel']}. A line of fewer than {told['full_rate_width']} " in text
    assert re.search(r"stereo-graph-cut \d+\.\d+\.\d+; made by:", text) and re.search(r"Latency: at most 2 lines and \d+ clocks", text)
    assert (folders["stereo"] / "stereo.v").read_text().startswith("// stereo.v: ")


def test_ways_into_the_core(folders):
    """A stream, or frame timing signals; the matcher is the same."""
    stream, framed = manifest(folders["matcher"]), manifest(folders["framed"])
    assert {"i_payload", "i_valid", "i_ready"} <= set(stream["ports"])
    assert {"frame_valid", "line_valid", "pixel_valid", "left", "right", "reset_n"} <= set(framed["ports"])
    assert framed["payloads"] == {}
    assert (framed["parameters"], framed["latency_clocks"]) == (stream["parameters"], stream["latency_clocks"])


@pytest.mark.parametrize("top, method, clocks", [
    ("stereo", OnePass(Arithmetic.THESIS), 5),
    ("matcher", changed(OnePass(Arithmetic.LINEAR, 2), u1=7), 1),
])
def test_manifest(folders, top, method, clocks):
    told = manifest(folders[top])
    assert told["engine"] == {"stereo": "sequential", "matcher": "streaming"}[top]
    width, height = {"stereo": (720, 576), "matcher": (24, 10)}[top]
    assert told["parameters"] == {
        "disparities": 6, "method": "thesis", "arithmetic": method.arithmetic, "minimum": 0, "max_width": width, "height": height,
        "disparity_scale": 1, "method_parameters": method.about()}
    matcher = Matcher(MatcherConfig(6, width, engine=told["engine"], method=method))
    Fragment.get(matcher, None)  # Amaranth complains of a component that is not used
    assert told["clocks_per_pixel"] == matcher.clocks_per_pixel == clocks
    # A short line takes the latency from the line memory to a disparity and back.
    assert told["latency_clocks"] == 2 * max(width, matcher.full_rate_width) * clocks + matcher.latency_clocks
    assert told["full_rate_width"] == matcher.full_rate_width
    assert told["clock_mhz_for_25_frames"] >= round(25 * width * height * clocks / 1e6, 2)


def test_manifest_tells_where_the_fields_of_a_payload_are(folders):
    payloads = manifest(folders["matcher"])["payloads"]
    assert payloads["i_payload"] == {"left": [0, 7], "right": [8, 15], "first": [16, 16], "last": [17, 17], "end": [18, 18]}
    assert list(payloads["o_payload"]) == ["disparity", "first", "last", "end"]
    assert payloads["o_payload"]["disparity"][0] == 0


@pytest.mark.parametrize("clock_mhz, told", [
    (50, r"the matcher takes 42\.\d ms to read a pair, and with 3 buffers it has 40\.0 ms: choose a matcher of fewer clocks a pixel"),
    (10, r"need \d+\.\d million words a second of memory, and it serves \d+\.\d at 10 MHz: choose"),
])
def test_what_the_memory_cannot_serve_is_refused(clock_mhz, told, tmp_path, capsys, monkeypatch):
    monkeypatch.setattr(board, "BOARD", replace(BOARD_AS_IT_IS, clock_mhz=clock_mhz))
    with refused_components():
        assert main(["--board", "cyclone3", "--engine", "sequential", *FEW, "--output", str(tmp_path / "out")]) == 2
    assert re.fullmatch(rf"hdl\.build: .*{told}.*\n", capsys.readouterr().err)
    assert list(tmp_path.iterdir()) == []


def test_manifest_of_the_board(folders):
    whole, core = manifest(folders["stereo"]), manifest(folders["matcher"])
    about = {"board": "cyclone3", "device": "EP3C120F780C7", "display": "1024x768", "clock_mhz": 75,
             "pixel_clock_mhz": 65.0, "camera_clock_mhz": 27.0, "memory_controller": "stereo_ddr2", "buffers": 2,
             "memory_words_per_second": {"used": 13_943_250, "available": 37_201_592}}
    assert {name: whole[name] for name in about} == about
    assert not set(about) & set(core)


def test_default_display(tmp_path, given, capsys):
    assert main(["--board", "cyclone3", *FEW, "--output", str(tmp_path)]) == 0
    assert given[-1] == (DISPLAYS["720x576"], RigConfig())
    assert manifest(tmp_path)["display"] == "720x576"
    assert ".clk0_multiply_by(32'd27)" in (tmp_path / "stereo.v").read_text()
    told = capsys.readouterr().out
    assert f"What to do in Quartus: {tmp_path / 'README.md'}" in told
    assert "gives the matcher 75 MHz; frames wait in 2 buffers" in told
    assert re.search(r"all +│ +223\.1 │ +13,943,250 │ +37\.5%", told)


def test_memory_clock(tmp_path, capsys, monkeypatch):
    """Budget, table, manifest, constraints and instructions follow."""
    made = []

    def stand_in(design):
        made.append(MemoryTiming.at(design.clock_hz))
        return BoardCore(design.config, made[-1])

    monkeypatch.setattr(board, "BOARD", replace(BOARD_AS_IT_IS, system=stand_in))
    assert main([*BOARD, "--memory-clock", "125", "--output", str(tmp_path)]) == 0
    assert made == [MemoryTiming.at(62_500_000)]
    told = manifest(tmp_path)
    assert told["clock_mhz"] == 62.5
    assert told["memory_words_per_second"]["available"] < 37_201_592 * 62.5 / 75
    printed = capsys.readouterr().out
    assert "gives the matcher 62.5 MHz; frames" in printed and "a second at 62.5 MHz" in printed
    assert "| memory clock | 125 MHz |" in (tmp_path / "README.md").read_text().replace("| | ", "| ")
    assert "10.256" in (tmp_path / "stereo.sdc").read_text()


def test_a_project_that_is_not_sound_is_not_written(tmp_path, monkeypatch):
    chip, = check_project.args
    unclocked = partial(check_project.func, replace(chip, clock_balls=frozenset()))
    monkeypatch.setattr(board, "BOARD", replace(board.BOARD, check=unclocked))
    with pytest.raises(RuntimeError, match="not sound: the clock at camera_0__clk__io enters at Y28"):
        main([*BOARD, "--output", str(tmp_path / "out")])
    assert list(tmp_path.iterdir()) == []


def test_core_of_the_method_fused(tmp_path):
    """The method is in the manifest, its settings have ports, and its words have fields."""
    (tmp_path / "mine.toml").write_text("[fused]\nreach = 3\nu2 = 9\ncensus_rows = 3\ncensus_columns = 3\n")
    assert main(["--core", *SMALL, "--method", "fused", "--parameters", str(tmp_path / "mine.toml"), "--minimum", "5", "--no-fill",
                 "--sub-pixel", "--u1", "7", "--output", str(tmp_path / "core")]) == 0
    told = manifest(tmp_path / "core")
    config = MatcherConfig(6, 24, 5, engine=told["engine"], method=changed(
        FUSED_1, reach=3, census_rows=3, census_columns=3, u1=7, u2=9, fill=False, sub_pixel=True))
    assert told["parameters"] == {
        "disparities": 6, "method": "fused", "arithmetic": "linear", "minimum": 5, "max_width": 24, "height": 10, "disparity_scale": 8,
        "method_parameters": config.method.about()}
    assert told["parameters"]["method_parameters"]["weights"] == {"u1": 7, "u2": 9, "u3": 22}
    assert told["parameters"]["method_parameters"]["refinement"] == {
        "check": True, "fill": False, "median": True, "sub_pixel": True, "tolerance": 1, "median_size": 5}
    matcher = Matcher(config)
    Fragment.get(matcher, None)  # Amaranth complains of a component that is not used
    # Two lines of the window of three, one of the fill, two of the median.
    assert told["latency_clocks"] == 5 * max(24, matcher.full_rate_width) + matcher.latency_clocks
    ports = {name: (port["direction"], port["width"]) for name, port in told["ports"].items()}
    text = (tmp_path / "core" / "matcher.v").read_text()
    assert ports == verilog_ports(text, "matcher")
    assert {name: ports[name] for name in ("minimum", "check", "fill", "median", "in_use")} == {
        "minimum": ("input", 8), "check": ("input", 1), "fill": ("input", 1), "median": ("input", 1), "in_use": ("input", 9)}
    # Up to 255 + 5 pixels in eighths, for the least disparity can be set; a confidence of 0 to 15.
    assert told["payloads"]["o_payload"] == {
        "disparity": [0, 11], "passed": [12, 12], "confidence": [13, 16], "first": [17, 17], "last": [18, 18], "end": [19, 19]}
    built_in = re.findall(r"if \(rst\) \w+ <= \d+'h(\w+);\n +else if \(apply_settings\) \w+ <= (\w+);", text)
    assert {name: int(value, 16) for value, name in built_in} == {
        "u1": 7, "u2": 9, "u3": 22, "in_use": 6, "minimum": 5, "check": 1, "fill": 0, "median": 1}


@pytest.mark.slow
def test_board_of_the_method_fused(tmp_path, monkeypatch):
    """With the video system itself: a project that is not sound would not be written."""
    monkeypatch.setattr(board, "BOARD", BOARD_AS_IT_IS)
    assert main(["--board", "cyclone3", "--method", "fused", "--sub-pixel", *FEW, "--output", str(tmp_path)]) == 0
    told = manifest(tmp_path)
    assert (told["parameters"]["method"], told["parameters"]["disparity_scale"], told["board"]) == ("fused", 8, "cyclone3")
    assert set(told["files"]) == {"stereo.v", "stereo.qpf", "stereo.qsf", "stereo.sdc", "README.md", "check_ddr2.tcl"}


def test_weights_and_width_reach_the_verilog(folders):
    text = (folders["matcher"] / "matcher.v").read_text()
    defaults = dict(re.findall(r"initial (u[123])_(?!of_frame)\w+ = 6'h(\w+);", text))
    assert {name: int(value, 16) for name, value in defaults.items()} == {"u1": 7, "u2": 10, "u3": 5}
    assert re.search(r"reg \[15:0\] line_memory \[23:0\];", text)


def test_same_bytes_in_another_process(folders, tmp_path):
    """Whatever that one's environment has for other boards."""
    foreign = {f"AMARANTH_{name}": "mine" for name in ("add_settings", "add_constraints", "nproc", "quartus_map_opts", "verbose")}
    environment = {**os.environ, **foreign, "PYTHONHASHSEED": "123", "AMARANTH_USE_YOSYS": "builtin"}
    subprocess.run([sys.executable, "-c", WITH_STAND_IN, *BOARD, "--package", "registers", "--output", tmp_path / "again"], cwd=ROOT,
                   env=environment, check=True, capture_output=True)
    first = {path.name: path.read_bytes() for path in folders["stereo"].iterdir()}
    assert {path.name: path.read_bytes() for path in (tmp_path / "again").iterdir()} == first


def test_a_build_takes_the_place_of_another(tmp_path, capsys):
    for labels in ("3", "2"):
        assert main(["--core", "--width", "4", "--disparities", labels, "--output", str(tmp_path)]) == 0
    assert manifest(tmp_path)["parameters"]["disparities"] == 2
    assert sorted(path.name for path in tmp_path.iterdir()) == ["manifest.json", "matcher.v", "matcher.vlt"]
    told = capsys.readouterr().out
    assert "Clocks a pixel: 1;" in told and "MHz" in told


def test_what_another_build_left_is_gone(tmp_path, folders):
    """The project of the board; what is the user's stays, though it has a name of the project's in a folder."""
    written = {path.name for path in folders["stereo"].iterdir()}
    for name in written:
        (tmp_path / name).write_bytes((folders["stereo"] / name).read_bytes())
    (tmp_path / "mine").mkdir()
    for name in ("mine.v", "stereo_ddr2.v", "mine/stereo.v"):
        (tmp_path / name).touch()
    assert main(["--core", "--width", "4", "--disparities", "2", "--output", str(tmp_path)]) == 0
    assert {path.name for path in tmp_path.iterdir()} == {"manifest.json", "matcher.v", "matcher.vlt", "mine", "mine.v", "stereo_ddr2.v"}
    assert (tmp_path / "mine" / "stereo.v").exists() and "stereo_ddr2.v" not in written


BAD = {
    "unknown board": (["--board", "de2"], "'de2'.*cyclone3"),
    "neither board nor core": ([], "--board.*--core"),
    "board and core": (["--board", "cyclone3", "--core"], "not allowed"),
    "unknown display": (["--board", "cyclone3", "--display", "800x600"], "'800x600'.*720x576, 1024x768$"),
    "display in capitals": (["--board", "cyclone3", "--display", "720X576"], "'720X576'"),
    "display of the core": (["--core", "--display", "720x576"], "--display.*--core has no monitor; choose --board"),
    "memory clock of the core": (["--core", "--memory-clock", "125"], "--memory-clock.*--core has none; choose --board, or leave"),
    "memory clock that is none": (["--board", "cyclone3", "--memory-clock", "133"], "memory at 133 MHz; choose --memory-clock 125 or 150$"),
    "memory clock in words": (["--board", "cyclone3", "--memory-clock", "fast"], "--memory-clock.*'fast'"),
    "width on the board": (["--board", "cyclone3", "--width", "640"], "720x576 pixels, not 640x576; leave --width and --height out"),
    "height on the board": (["--board", "cyclone3", "--height", "480"], "720x576 pixels, not 720x480; .*choose --core"),
    "frame timing on the board": (["--board", "cyclone3", "--frame-timing"], "--frame-timing.*--board makes a whole system; choose --core"),
    "name on the board": (["--board", "cyclone3", "--name", "left"], "--name is for the bare matcher.*choose --core"),
    "name that is none": (["--core", "--name", "left eye"], "'left eye' cannot name a module: it is no identifier; choose another one"),
    "keyword as a name": (["--core", "--name", "Buffer"], "'Buffer' cannot name a module: it is a keyword of VHDL; choose"),
    "underscores in a name": (["--core", "--name", "left__eye"], "VHDL allows neither two underscores in a row nor one at the end"),
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
    "method fused, sequential": (["--core", "--method", "fused", "--engine", "sequential"], "sequential has no method fused; choose"),
    "method fused, thesis": (["--board", "cyclone3", "--method", "fused", "--arithmetic", "thesis"], "cannot compute the method fused"),
    "cost": (["--core", "--cost", "fused"], "--cost is now --method; write --method fused"),
    "minimum": (["--core", "--method", "fused", "--minimum", "256"], "--minimum.*from -64 to 255, not 256; choose"),
    "minimum of the thesis": (["--core", "--minimum", "3"], "--minimum 3 belongs to the method fused"),
    "refinement of the thesis": (["--board", "cyclone3", "--refine"], "--refine belongs to the method fused"),
    "parameters of the thesis": (["--core", "--parameters", "none.toml"], "--parameters none.toml belongs to the method fused"),
    "no parameters": (["--core", "--method", "fused", "--parameters", "none.toml"], "cannot read none.toml"),
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


@pytest.mark.parametrize("what", [["--core"], ["--board", "cyclone3"]], ids=lambda what: what[0])
@pytest.mark.parametrize("place", ["file", "file/below", "not/writable"])
def test_bad_output(place, what, tmp_path, capsys):
    (tmp_path / "file").write_text("mine")
    if place == "not/writable":
        folder = Path("/proc/version_of_nothing")  # not even root makes folders there
        if not Path("/proc").is_dir():
            pytest.skip("no /proc on this machine")
    else:
        folder = tmp_path / place
    assert main([*what, *FEW, "--output", str(folder)]) == 2
    out, err = capsys.readouterr()
    assert re.match(r"hdl\.build: .*choose another --output\n$", err), err
    assert out == ""
    assert [path.name for path in tmp_path.iterdir()] == ["file"]
    assert (tmp_path / "file").read_text() == "mine"
