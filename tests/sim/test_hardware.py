"""sim.run --hardware: the board's result against golden, in memory and at a port, over lines with faults; and what is refused."""

import errno
import json
import os
import re

import numpy as np
import pytest

from golden.config import FUSED_1, RECURSIVE_1, RECURSIVE_2, MatcherConfig, OnePass, changed
from golden.host.camera_device import CameraDevice
from golden.host.loop_device import LoopDevice
from golden.pictures.images import write_picture
from golden.pictures.scenes import scene
from golden.rig.config import RigConfig
from sim import loop, run
from sim.models.loop_line import LoopLine, device_at_port


WIDTH, HEIGHT, LABELS = 24, 6, 8
LINEAR = changed(OnePass(), arithmetic="linear")
CONFIG = MatcherConfig(LABELS, WIDTH, method=LINEAR)


@pytest.fixture
def pair(tmp_path, monkeypatch):
    """The current folder, with a pair that a board holds, and a wider one."""
    monkeypatch.chdir(tmp_path)
    left, right, _ = scene(WIDTH, HEIGHT, LABELS, seed=3)
    for name, picture in {"left": left, "right": right, "wide": np.hstack([left, left])}.items():
        write_picture(tmp_path / f"{name}.png", picture)
    return tmp_path


def matched(line, *options, port="none"):
    """Status of the command on a board behind a line."""
    return run.main(["left.png", "right.png", "--hardware", port, *options], *([line.connect] if line else []))


def report():
    with open("build/run/report.json") as file:
        return json.load(file)


@pytest.mark.parametrize("method, options", [
    (LINEAR, []),
    (FUSED_1, ["--method", "fused", "--minimum", "1"]),
    (changed(FUSED_1, sub_pixel=True), ["--method", "fused", "--sub-pixel", "--u1", "3", "--no-fill"]),
    (RECURSIVE_1, ["--method", "recursive"]),
    (RECURSIVE_2, ["--method", "recursive", "--parameters", "recursive-2", "--soft-multipliers"]),
], ids=["thesis", "fused", "sub-pixel", "recursive-1", "recursive-2"])
def test_equals_golden(pair, capsys, method, options):
    """A board of the method with other settings than the command's, which are written to it; disparities are the board's."""
    device = LoopDevice(MatcherConfig(LABELS, WIDTH + 3, method=method), HEIGHT + 2)
    assert matched(LoopLine(device), *options) == 0
    assert re.search(r"mismatching pixels against golden +│ +0 ", capsys.readouterr().out)
    told = report()
    assert (told["mismatches"], told["disparities"], told["width"], told["height"], told["repeated"]) == (0, LABELS, WIDTH, HEIGHT, 0)
    assert device.values["pairs"] == 1
    assert {"disparity.npy", "disparity.png", "left.txt"} <= set(told["files"])


@pytest.mark.parametrize("method, options, rig", [
    (LINEAR, [], None), (LINEAR, [], RigConfig()), (changed(FUSED_1, sub_pixel=True), ["--method", "fused", "--sub-pixel"], None),
], ids=["thesis", "rig", "sub-pixel"])
def test_system_with_cameras(pair, method, options, rig):
    """Whole disparities, of the pair as it was sent; then all is as before, and the cameras are the source."""
    device = CameraDevice(MatcherConfig(LABELS, WIDTH, method=method), HEIGHT, rig)
    device.values["hold"] = 1
    assert matched(LoopLine(device, to_board=faulty(CHANGES["changed"], 40, 11)), *options, "--baud", "115200") == 0
    told = report()
    assert (told["mismatches"], told["disparities"], told["baud"], told["repeated"] > 0) == (0, LABELS, 115_200, True)
    assert told["line_frames_per_second"] == round(115_200 / (3 * HEIGHT * 10 * (14 + 32)), 3)
    settings = {name: device._value(name) for name in ("source", "keep", "hold", *(("rectify", "balance") if rig else ()))}
    assert settings == {"source": 0, "keep": 0, "hold": 1, **({"rectify": 1, "balance": 1} if rig else {})}


def test_wrong_pixel_of_a_system_with_cameras(pair):
    class Broken(CameraDevice):
        def _match(self, pair):
            super()._match(pair)
            if self.kept:
                self.kept[2][1, 5] ^= 1
    device = Broken(CONFIG, HEIGHT)
    assert matched(LoopLine(device), "--baud", "115200") == 1
    assert report()["mismatches"] == 1


def test_system_with_cameras_that_is_lost(pair, capsys):
    """In the middle of the result: the cameras are to be the source as long as the line allows it."""
    device = CameraDevice(CONFIG, HEIGHT)
    line = LoopLine(device, to_host=lambda number, data: b"" if device._value("kept") and device._value("keep") else data)
    assert "no answer in 4 attempts" in fails(capsys, line)
    assert (device._value("source"), device._value("keep")) == (0, 0)


def test_a_wrong_pixel_is_status_1(pair, capsys):
    class Broken(LoopDevice):
        def _match(self):
            super()._match()
            self._words[2, 3] ^= 1
    assert matched(LoopLine(Broken(CONFIG, HEIGHT))) == 1
    assert report()["mismatches"] == 1
    assert "against golden" in capsys.readouterr().out


def faulty(change, first, every):
    """Of a line: ``change`` is applied to each ``every``-th piece from ``first`` on."""
    return lambda number, data: change(data) if number >= first and (number - first) % every == 0 else data


def spoiled(data):
    return data[:len(data) // 2] + bytes([data[len(data) // 2] ^ 0x10]) + data[len(data) // 2 + 1:]


CHANGES = {
    "changed": spoiled,
    "lost": lambda data: data[:len(data) // 2] + data[len(data) // 2 + 1:],
    "doubled": lambda data: data[:len(data) // 2] + data[len(data) // 2:len(data) // 2 + 1] + data[len(data) // 2:],
    "first lost": lambda data: data[1:],
    "nothing": lambda data: b"",
    "noise before": lambda data: b"\x00\xa5" + data,
}


@pytest.mark.parametrize("change", CHANGES)
def test_faults_towards_the_board_are_repeated(pair, change):
    """Requests of registers and blocks alike: every seventh of what the host sends is spoiled."""
    device = LoopDevice(CONFIG, HEIGHT)
    assert matched(LoopLine(device, to_board=faulty(CHANGES[change], 3, 7))) == 0
    assert report()["repeated"] > 5 and device.values.get("uart_errors", 0) > 3 * (change != "nothing") - 1


@pytest.mark.parametrize("change", ["changed", "nothing", "noise before"])
def test_faults_towards_the_host_are_repeated(pair, change):
    """Bytes of replies and of blocks."""
    change = {"changed": lambda data: bytes([data[0] ^ 8])}.get(change, CHANGES[change])
    assert matched(LoopLine(LoopDevice(CONFIG, HEIGHT), to_host=faulty(change, 50, 149))) == 0
    assert report()["repeated"] > 3


def fails(capsys, line, *options, port="none"):
    """The one sentence of a command that ends with status 2 and leaves no results."""
    assert matched(line, *options, port=port) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.startswith("sim.run: ") and err.count("\n") == 1
    assert not os.path.exists("build/run/report.json")
    return err


class Other(LoopDevice):
    """A board with another value of a constant."""
    def __init__(self, name, value):
        super().__init__(CONFIG, HEIGHT)
        self.values[name] = value


@pytest.mark.parametrize("device, options, message", [
    (Other("identity", 0x1234), [], "its identity is 4660, not 21319 or 21324; choose another --hardware"),
    (Other("version", 9), [], "version 9 of the register map, this program version 1"),
    (Other("release", 0x1002), [], "from release 1.0.2 of this project, and this is "),
    (CameraDevice(CONFIG, HEIGHT + 1), [], "the pictures have 24x6 pixels, and the chip's cameras send 24x7; choose pictures of that size"),
    (CameraDevice(CONFIG, HEIGHT), ["--fraction-bits", "2"], "other parameters of the method thesis than this command's"),
    (LoopDevice(CONFIG, HEIGHT), ["--disparities", "64"], "holds 8 disparities, the command says 64; say --disparities 8, or build again"),
    (LoopDevice(CONFIG, HEIGHT), ["--method", "fused"], "holds the method thesis, the command says fused; say --method thesis, or build"),
    (LoopDevice(CONFIG, HEIGHT), ["--fraction-bits", "2"], "other parameters of the method thesis than this command's"),
    (LoopDevice(CONFIG, HEIGHT - 1), [], "the pictures have 24x6 pixels, and the board holds 24x5 at most"),
    (LoopDevice(MatcherConfig(LABELS, WIDTH, method=FUSED_1), HEIGHT), ["--method", "fused", "--minimum", "-4"],
     "holds disparities from 0 on, the command says -4; say --minimum 0, or build again with --minimum -4"),
    (LoopDevice(CONFIG, HEIGHT), ["--baud", "0"], "--baud must be from 1 to 4000000, not 0"),
    (LoopDevice(CONFIG, HEIGHT), ["--timeout", "nan"], "--timeout must be from 0.001 to 60, not nan"),
    (LoopDevice(CONFIG, HEIGHT), ["--waves"], "--waves is of a simulation"),
    (LoopDevice(CONFIG, HEIGHT), ["--simulator", "icarus"], "--simulator icarus and --hardware exclude each other"),
])
def test_refused(pair, capsys, device, options, message):
    assert message in fails(capsys, LoopLine(device), *options)


def test_options_of_a_line_need_one(pair, capsys):
    assert run.main(["left.png", "right.png", "--baud", "9600"]) == 2
    assert "--baud is of a board's line; name its port with --hardware" in capsys.readouterr().err


@pytest.mark.parametrize("options, message", [
    (["--width", "0"], "--width must be a whole number from 1 to 4096, not 0"),
    (["--height", "2000"], "--height must be a whole number from 1 to 1024, not 2000"),
    (["--disparities", "1"], "--disparities must be a whole number from 2 to 256, not 1"),
    (["--arithmetic", "float"], "--arithmetic float has no gateware"),
])
def test_simulated_board_is_refused(capsys, options, message):
    assert loop.main(options) == 2
    assert message in capsys.readouterr().err


def test_no_answer(pair, capsys):
    line = LoopLine(LoopDevice(CONFIG, HEIGHT), to_host=lambda number, data: b"")
    assert "no answer in 4 attempts of 0.3 s; check the wires" in fails(capsys, line, "--timeout", "0.3")


def test_a_line_that_dies(pair, capsys):
    """In the middle of the blocks."""
    line = LoopLine(LoopDevice(CONFIG, HEIGHT), to_board=lambda number, data: b"" if number > 40 else data)
    assert "no answer in 4 attempts" in fails(capsys, line)
    assert line.writes < 70


def test_only_garbage(pair, capsys):
    line = LoopLine(LoopDevice(CONFIG, HEIGHT), to_host=lambda number, data: bytes([data[0] ^ 1]) if number > 300 else data)
    assert "no good answer in 4 attempts" in fails(capsys, line)


def test_a_board_that_forgets(pair, capsys):
    class Forgets(LoopDevice):
        def _value(self, name):
            return 9 if name == "u1" else super()._value(name)

        def receive(self, data):
            self.values["u1"] = 9
            return super().receive(data)
    assert "the board does not hold what was written to u1; check the wires" in fails(capsys, LoopLine(Forgets(CONFIG, HEIGHT)))


def test_rate_of_the_port(pair):
    """As the option says, or 3 Mbaud."""
    line, opened = LoopLine(LoopDevice(CONFIG, HEIGHT)), []

    def connect(port, baud):
        opened.append((port, baud))
        return line.connect(port, baud)
    for options in ([], ["--baud", "921600"]):
        assert run.main(["left.png", "right.png", "--hardware", "COM3", *options], connect) == 0
        assert report()["baud"] == opened[-1][1]
    assert opened == [("COM3", 3_000_000), ("COM3", 921_600)]


def test_a_board_that_refuses(pair, capsys):
    class Kept(LoopDevice):
        def _value(self, name):
            return int(name == "keep") or super()._value(name)
    assert "the board refuses line 0 of the left picture: busy" in fails(capsys, LoopLine(Kept(CONFIG, HEIGHT)))


def test_a_board_that_never_ends(pair, capsys, monkeypatch):
    class Slow(LoopDevice):
        def _match(self):
            self.values["busy"] = 1
    monkeypatch.setattr("hdl.host.loop._MATCH_SECONDS", 0.01)
    assert "has not matched the pair in 0.01 s: busy is 1, matcher_error 0" in fails(capsys, LoopLine(Slow(CONFIG, HEIGHT)))


def test_at_a_port(pair, capsys):
    """The command as it is run, with pyserial; then without a device, and in another program's hands."""
    with device_at_port(LoopDevice(CONFIG, HEIGHT)) as port:
        assert matched(None, "--timeout", "5", port=port) == 0     # on a machine that is busy, too
        assert report()["mismatches"] == 0
    os.remove("build/run/report.json")
    capsys.readouterr()
    assert f"the serial port {port} cannot be opened: there is no such port; --hardware names the one" in fails(capsys, None, port=port)


def test_port_that_is_open_already(pair, capsys):
    serial = pytest.importorskip("serial", reason="pyserial, of the extra console, is not installed")
    with device_at_port(LoopDevice(CONFIG, HEIGHT)) as port, serial.Serial(port, exclusive=True):
        assert f"the serial port {port} cannot be opened: another program has it open; end that program" in fails(capsys, None, port=port)


def test_port_without_rights(pair, capsys, monkeypatch):
    serial = pytest.importorskip("serial", reason="pyserial, of the extra console, is not installed")

    def refuse(*args, **kwargs):
        raise serial.SerialException(errno.EACCES, "could not open port")
    monkeypatch.setattr(serial, "Serial", refuse)
    assert "cannot be opened: permission denied; ask for the rights of its group" in fails(capsys, None, port="/dev/ttyUSB7")


@pytest.mark.parametrize("received", [100, 500])
def test_unplugged(pair, capsys, received):
    """Between registers, and between blocks."""
    with device_at_port(LoopDevice(CONFIG, HEIGHT), unplugged=received) as port:
        assert re.search(rf"the serial port {port} is lost: .*; plug it in again\n", fails(capsys, None, port=port))
