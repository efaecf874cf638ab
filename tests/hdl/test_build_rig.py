"""hdl.build with rectification: options, manifest, ports and maps of the core; what a board's system is made of."""

import re
from dataclasses import replace

import pytest
from amaranth.hdl import Fragment

from boards.cyclone3 import board
from boards.registry import Project
from golden.config import Arithmetic, MatcherConfig, OnePass, changed
from golden.rig.config import RigConfig
from golden.rig.files import Rig, write_rig
from golden.rig.maps import pack
from hdl.build import main
from hdl.netlist import Netlist
from hdl.rectified import RectifiedMatcher
from sim.kit.rig_cases import camera_map, noise_map
from sim.models.board_core import BoardCore
from tests.kit import manifest, verilog_ports


SMALL = ["--width", "24", "--height", "10", "--disparities", "6"]


def a_rig(folder, width=24, height=10, row_offset=-3, **right):
    """A folder as golden calibrate leaves it; its rig."""
    right = camera_map(width, height, **right) if right else noise_map(width, height, 90, 2)
    rig = Rig(noise_map(width, height, 90, 1), right, row_offset)
    folder.mkdir()
    write_rig(folder / "rig.json", rig)
    return rig


# Slow: the same behind frame timing signals, without a rig.
@pytest.mark.parametrize("framed", [False, pytest.param(True, marks=pytest.mark.slow)], ids=["stream", "framed"])
def test_core_with_rectification(framed, tmp_path, capsys):
    """Its ports, its maps, and what the manifest tells of them; the matcher's parameters are those of a core without."""
    rig = a_rig(tmp_path / "rig")
    more = ["--frame-timing"] if framed else ["--rig", str(tmp_path / "rig")]
    assert main(["--core", *SMALL, "--fraction-bits", "2", "--u1", "7", "--rectify", "--rectify-lines", "22", *more,
                 "--output", str(tmp_path / "core")]) == 0
    moved = "with the maps of the rig; line y + -3 of the right picture is to be sent as its line y"
    assert f"22 lines are held, {'with maps that change nothing' if framed else moved}.\n" in capsys.readouterr().out
    told = manifest(tmp_path / "core")
    assert (told["rectify_lines"], told["rig"], told["row_offset"]) == ((22, False, 0) if framed else (22, True, -3))
    assert "line by line from the top" in told["pixel_order"] and "y + row_offset" in told["pixel_order"]
    text = (tmp_path / "core" / "matcher.v").read_text()
    ports = {name: (port["direction"], port["width"]) for name, port in told["ports"].items()}
    assert ports == verilog_ports(text, "matcher")
    assert {name: ports[name] for name in ("rectify", "map_high", "width", "fault", "u1")} == {
        "rectify": ("input", 1), "map_high": ("input", 4), "width": ("input", 5), "fault": ("output", 1), "u1": ("input", 6)}
    assert ("line_valid" in ports) == framed
    # The maps that the gateware has after configuration.
    words = {f"{word:09x}" for side in (rig.left, rig.right) for word in pack(side) if word}
    assert (words <= set(re.findall(r"= 36'h(\w+);", text))) != framed
    config = MatcherConfig(6, 24, engine=told["engine"], method=changed(OnePass(Arithmetic.LINEAR, 2), u1=7))
    core = RectifiedMatcher(config, 10, RigConfig(22))
    Fragment.get(core, None)  # Amaranth complains of a component that is not used
    # The rectifier's 22 lines, two of the matcher.
    assert told["latency_clocks"] == 24 * max(24, core.full_rate_width) + core.latency_clocks
    assert told["clock_mhz_for_25_frames"] == round(25 * core.frame_clocks(24, 10) / 1e6, 2)
    assert told["full_rate_width"] == core.full_rate_width


def test_rectification_of_the_board(tmp_path, monkeypatch):
    """What its system is made of: by default, with a rig, without."""
    made = []

    def stand_in(design):
        made.append(design.rig)
        core = BoardCore(design.config)
        Fragment.get(core, None)  # Amaranth complains of a component that is not used
        return core

    empty = Project("stereo", {}, {"stereo": Netlist({}, {}, {})})
    monkeypatch.setattr(board, "BOARD", replace(board.BOARD, system=stand_in, project=lambda *_: empty, check=lambda project: []))
    rig = a_rig(tmp_path / "rig", 720, 576, 5)
    base = ["--board", "cyclone3", "--disparities", "6", "--output", str(tmp_path / "out")]
    assert main(base) == 0
    told = manifest(tmp_path / "out")
    assert made == [RigConfig()]
    assert (told["rectify_lines"], told["rig"], told["row_offset"]) == (34, False, 0)
    assert main([*base, "--rectify-lines", "56", "--rig", str(tmp_path / "rig" / "rig.json")]) == 0
    assert (made[-1].lines, made[-1].row_offset, made[-1].maps) == (56, 5, {"left": pack(rig.left), "right": pack(rig.right)})
    told = manifest(tmp_path / "out")
    assert (told["rectify_lines"], told["rig"], told["row_offset"]) == (56, True, 5)
    assert main([*base, "--no-rectify"]) == 0
    told = manifest(tmp_path / "out")
    assert made[-1] is None and told["rectify_lines"] == 0 and not {"rig", "row_offset"} & set(told)


BAD_RIG = {
    "rig without": (["--board", "cyclone3", "--no-rectify", "--rig", "{rig}"], "--rig .*, and --no-rectify builds none; leave one"),
    "lines without": (["--board", "cyclone3", "--no-rectify", "--rectify-lines", "34"], "--rectify-lines 34 .*builds none; leave one"),
    "lines": (["--board", "cyclone3", "--rectify-lines", "35"], "--rectify-lines must be one of 22, 34, 44, 56, 68, not 35; choose"),
    "no lines": (["--core", "--rectify", "--rectify-lines", "0"], "--rectify-lines must be one of .*, not 0; choose"),
    "rig of the core": (["--core", "--rig", "{rig}"], "--rig .*, and --core builds none; add --rectify, or leave --rig out"),
    "lines of the core": (["--core", "--rectify-lines", "34"], "--rectify-lines 34 .*; add --rectify, or leave --rectify-lines out"),
    "default of the board": (["--board", "cyclone3", "--rectify"], "--rectify is what --board does by default; leave it out"),
    "default of the core": (["--core", "--no-rectify"], "--no-rectify is what --core does by default; leave it out"),
    "size of the board": (["--board", "cyclone3", "--rig", "{rig}"],
                          ".*rig is a rig .*of 24x10 pixels.* send 720x576; calibrate at this size$"),
    "size of the core": (["--core", "--rectify", "--rig", "{rig}"],
                         ".*rig is a rig .*of 24x10 pixels.* send 720x576; calibrate at this size, or choose --width 24 --height 10$"),
    "width": (["--core", "--rectify", "--width", "1"], "--width must be from 2 to 4096 with --rectify, not 1; choose"),
    "height": (["--core", "--rectify", "--height", "1"], "--height must be from 2 to 4096 with --rectify, not 1; choose"),
    "more lines": (["--core", "--rectify", "--width", "80", "--height", "80", "--rig", "{rolled}"],
                   ".*rolled: this map needs (3[5-9]|4[0-4]) lines .* holds 34: level the cameras, or build with --rectify-lines 44$"),
    "no rig": (["--core", "--rectify", "--rig", "none"], "cannot read none: .*give the rig.json of golden calibrate"),
    "no rig in it": (["--core", "--rectify", "--rig", "{manifest}"], ".* is not a rig; give"),
}


@pytest.mark.parametrize("case", BAD_RIG)
def test_bad_rectification(case, tmp_path, capsys):
    a_rig(tmp_path / "rig")
    a_rig(tmp_path / "rolled", 80, 80, 0, roll=24)
    places = {"rig": tmp_path / "rig", "rolled": tmp_path / "rolled", "manifest": tmp_path / "manifest.json"}
    places["manifest"].write_text("{}")
    arguments, told = BAD_RIG[case]
    assert main([*(each.format(**places) for each in arguments), "--output", str(tmp_path / "out")]) == 2
    out, err = capsys.readouterr()
    assert re.match(f"hdl.build: {told}", err), err
    assert (err.count("\n"), out) == (1, "")
    assert not (tmp_path / "out").exists()
