"""hdl.host.put and its command: a pair into a chip with cameras, over lines with faults; and that the cameras are the source again."""

import numpy as np
import pytest

from golden.config import MatcherConfig, OnePass, changed
from golden.host.camera_device import CameraDevice
from golden.host.loop_device import LoopDevice
from golden.matcher.matcher import disparities
from golden.pictures.images import read_picture, write_picture
from golden.pictures.scenes import scene
from hdl.host.chip import Chip
from hdl.host.console import main
from hdl.host.put import put
from sim.kit.cases import noise
from sim.models.loop_line import LoopLine


WIDTH, HEIGHT, LABELS = 20, 4, 4
CONFIG = MatcherConfig(LABELS, WIDTH, method=changed(OnePass(), arithmetic="linear"))


@pytest.fixture(autouse=True)
def pair(tmp_path, monkeypatch):
    """The current folder, with a pair of the cameras' size, and one of another."""
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr("hdl.host.grab.time.sleep", lambda seconds: None)
    left, right, _ = scene(WIDTH, HEIGHT, LABELS, seed=3)
    for name, picture in {"left": left, "right": right, "wide": np.hstack([left, left])}.items():
        write_picture(tmp_path / f"{name}.png", picture)
    return left, right


def chip():
    device = CameraDevice(CONFIG, HEIGHT)
    device.cameras = list(noise(WIDTH, HEIGHT, 7).astype(np.uint8))
    return device


def run(line, *arguments):
    return main(["--port", "none", *arguments], line.connect)


def grabbed(line, plane):
    assert run(line, "grab", plane, f"{plane}.pgm") == 0
    return read_picture(f"{plane}.pgm")


def test_command(pair, capsys):
    """The pair and its disparities are grabbed, more than once, until the cameras have their turn."""
    device = chip()
    line = LoopLine(device)
    assert run(line, "put", "left.png", "right.png") == 0
    assert capsys.readouterr().out == (
        "left.png and right.png are matched and shown; grab disparity reads the result, set source=cameras ends it\n")
    assert device.values["pairs"] == 1 and device.values["source"] == 1
    expected = (*pair, disparities(*pair, CONFIG).astype(int))
    for name, picture in zip(("left", "right", "disparity", "left"), (*expected, pair[0])):
        assert np.array_equal(grabbed(line, name), picture)
    assert run(line, "set", "source=cameras") == 0
    assert np.array_equal(grabbed(line, "right"), device.cameras[1])


def spoiled(number, data):
    return data[:len(data) // 2] + bytes([data[len(data) // 2] ^ 0x10]) + data[len(data) // 2 + 1:] if number % 5 == 4 else data


@pytest.mark.parametrize("faults", [{"to_board": spoiled}, {"to_host": lambda number, data: b"" if number % 97 == 60 else data}])
def test_faults_are_repeated(pair, faults):
    device = chip()
    line = LoopLine(device, **faults)
    assert run(line, "put", "left.png", "right.png") == 0
    assert np.array_equal(device.pictures, pair) and device.values["pairs"] >= 1


def fails(capsys, line, *arguments):
    assert run(line, *arguments) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.startswith("hdl.host.console: ") and err.count("\n") == 1
    return err


def test_interrupted(pair):
    """Nothing is matched, and the cameras are the source; a part of a pair is not grabbed."""
    device = chip()

    def report(done, total):
        if done == total - 1:
            raise KeyboardInterrupt
    with pytest.raises(KeyboardInterrupt):
        put(Chip(LoopLine(device)), *pair, 115_200, report)
    assert (device.values["source"], device.values.get("pairs", 0), device.values.get("pair_whole")) == (0, 0, 0)
    assert np.array_equal(grabbed(LoopLine(device), "left"), device.cameras[0])


def test_part_of_a_pair_is_not_grabbed(capsys):
    """After a command that was killed, which could not make the cameras the source."""
    device = chip()
    device.values["source"] = 1
    assert "its pair is not whole in the chip's memory; put it again, or set source=cameras" in fails(
        capsys, LoopLine(device), "grab", "left", "left.pgm")
    assert device.values["keep"] == 0 and "pairs" not in device.values


def test_another_program_takes_the_pair_away(capsys):
    class Shared(CameraDevice):
        def _value(self, name):
            return 0 if name == "pair_whole" else super()._value(name)

        def receive(self, data):
            self.values.pop("pair_whole", None)
            return super().receive(data)
    device = Shared(CONFIG, HEIGHT)
    assert "the chip does not hold the whole pair; another program may be using it" in fails(
        capsys, LoopLine(device), "put", "left.png", "right.png")
    assert device.values["source"] == 0


@pytest.mark.parametrize("arguments, settings, told", [
    (["wide.png", "wide.png"], {}, "the pictures have 40x4 pixels, and the chip's cameras send 20x4; choose pictures of that size"),
    (["left.png", "wide.png"], {}, "the pictures differ in size"), (["left.png", "none.png"], {}, "none.png"), (["left.png"], {}, "RIGHT"),
    (["left.png", "right.png"], {"hold": 1}, "the picture on the monitor is frozen, and no pair is matched; set hold=live first"),
])
def test_refused(capsys, arguments, settings, told):
    device = chip()
    device.values |= settings
    assert told in fails(capsys, LoopLine(device), "put", *arguments)
    assert not device.values.get("source")


def test_board_without_cameras(capsys):
    assert "put is for a system with cameras, and this is a matcher behind a serial line; use python -m sim.run LEFT RIGHT" in fails(
        capsys, LoopLine(LoopDevice(CONFIG, HEIGHT)), "put", "left.png", "right.png")
