# amaranth: UnusedElaboratable=no
"""hdl.host.grab and its command: pictures of a kept pair, from a chip that keeps the protocol, over lines with faults."""

import contextlib

import numpy as np
import pytest

from golden.config import MatcherConfig, OnePass
from golden.errors import UserError
from golden.host.blocks import PLANES, block_answer
from golden.host.protocol import FRAME_BYTES, Operation, Reply, Status, decode_request, encode_reply
from golden.host.registers import Kind, answer, register_map
from golden.pictures.images import read_picture
from hdl.host.chip import Chip
from hdl.host.console import main
from hdl.host.grab import grab, grab_pair
from sim.kit.cases import noise
from sim.models.uart import SimulatedChip


WIDTH, HEIGHT = 40, 5
REGISTERS = register_map(MatcherConfig(labels=20, max_width=WIDTH, method=OnePass()), HEIGHT)


class KeptLine:
    """A line to a chip that keeps another pair each time; ``fault`` may change the answer, given its number among the block reads.

    Parameters
    ----------
    fault : callable
    readings : int
        Of ``kept`` until it is 1.
    """
    def __init__(self, fault=lambda number, data: data, readings=3):
        self.fault = fault
        self.readings = readings
        self.values = {}
        self.pairs = 0
        self.planes = None
        self.blocks = 0
        self.writes = []
        self._data = b""

    def write(self, data):
        request = decode_request(data)
        if request.operation == Operation.BLOCK:
            self._data += self.fault(self.blocks, block_answer(self.planes if self.values["kept"] else None, HEIGHT, data))
            self.blocks += 1
            return
        if request.address == REGISTERS["kept"].address:
            self.readings -= self.values["keep"]
            self.values["kept"] = int(self.values["keep"] and self.readings <= 0)
        reply, written = answer(REGISTERS, self.values, data)
        self.values.update({name: value for name, value in written.items() if REGISTERS[name].kind is Kind.SETTING})
        if written.get("keep"):
            self.pairs += 1
            self.planes = noise(WIDTH, HEIGHT, self.pairs, pictures=3)
        elif "keep" in written:
            self.values["kept"] = 0
        self.writes += written.items()
        self._data += encode_reply(reply)

    def read(self, count, seconds):
        data, self._data = self._data[:count], self._data[count:]
        return data

    def connect(self, port, baud):
        return contextlib.nullcontext(self)


@pytest.fixture(autouse=True)
def no_pauses(monkeypatch):
    monkeypatch.setattr("hdl.host.grab.time.sleep", lambda seconds: None)


def run(line, *arguments):
    return main(["--port", "none", "grab", *map(str, arguments)], line.connect)


@pytest.mark.parametrize("plane", PLANES)
@pytest.mark.parametrize("suffix", [".png", ".pgm", ".npy"])
def test_command(tmp_path, capsys, plane, suffix):
    line, path = KeptLine(), tmp_path / f"picture{suffix}"
    assert run(line, plane, path) == 0
    out, err = capsys.readouterr()
    assert (out, err) == (f"{path}: {plane}, 40x5 pixels\n", "")
    read = np.load(path) if suffix == ".npy" else read_picture(path)
    assert np.array_equal(read, line.planes[PLANES.index(plane)])
    assert line.blocks == HEIGHT and line.writes == [("keep", 0), ("keep", 1), ("keep", 0)]


def test_pair_is_one():
    line, told = KeptLine(), []
    left, right = grab_pair(Chip(line), lambda *counts: told.append(counts))
    assert np.array_equal(left, line.planes[0]) and np.array_equal(right, line.planes[1])
    assert left.shape == (HEIGHT, WIDTH) and left.dtype == np.uint8
    assert line.pairs == 1 and told == [(done, 10) for done in range(1, 11)]
    assert line.values["keep"] == 0


def test_next_pair_each_time():
    line = KeptLine()
    chip = Chip(line)
    first, second = grab(chip, "right"), grab(chip, "right")
    assert np.array_equal(second, line.planes[1]) and not np.array_equal(first, second)


FAULTS = {
    "no answer": lambda data: b"",
    "a bit of a pixel is wrong": lambda data: data[:20] + bytes([data[20] ^ 4]) + data[21:],
    "a bit of the CRC is wrong": lambda data: data[:-1] + bytes([data[-1] ^ 1]),
    "inverted CRC": lambda data: data[:-2] + bytes(byte ^ 255 for byte in data[-2:]),
    "a byte is lost": lambda data: data[:30] + data[31:],
    "only the reply": lambda data: data[:FRAME_BYTES],
    "another line": lambda data: block_answer([*noise(WIDTH, HEIGHT, 9, pictures=3)], HEIGHT, bytes.fromhex("a5 61 01 00 00 f9")),
    "stale bytes after it": lambda data: data + b"\x5a\0\0",
}


@pytest.mark.parametrize("fault", FAULTS)
def test_retries(fault):
    """Every second answer has the fault."""
    line = KeptLine(lambda number, data: FAULTS[fault](data) if number % 2 == 0 else data)
    assert np.array_equal(grab(Chip(line), "disparity"), line.planes[2])


def test_reply_of_another_line():
    """Whatever the CRC is: the request is repeated."""
    line = KeptLine(lambda number, data: encode_reply(Reply(Status.OK, 0, 3)) + data[FRAME_BYTES:] if number == 1 else data)
    assert np.array_equal(grab(Chip(line), "left"), line.planes[0]) and line.blocks == HEIGHT + 1


@pytest.mark.parametrize("fault, told", [(FAULTS["inverted CRC"], "garbled block, garbled block"), (FAULTS["no answer"], "no answer in 4")])
def test_gives_up(tmp_path, capsys, fault, told):
    """The pair is let go, and no file is left."""
    line = KeptLine(lambda number, data: fault(data) if number >= 2 else data)
    assert run(line, "left", tmp_path / "left.png") == 2
    err = capsys.readouterr().err
    assert told in err and err.count("\n") == 1 and [*tmp_path.iterdir()] == []
    assert line.values["keep"] == 0 and line.blocks == 2 + Chip.ATTEMPTS


def test_pair_that_is_lost(capsys, tmp_path):
    def fault(number, data):
        if number == 3:
            line.values["kept"] = 0     # as by another host
        return data
    line = KeptLine(fault)
    assert run(line, "right", tmp_path / "right.png") == 2
    err = capsys.readouterr().err
    assert "refuses to send line 4 of the right picture: not kept; set keep=1" in err and err.count("\n") == 1
    assert line.values["keep"] == 0


def test_no_pair(capsys, tmp_path):
    line = KeptLine(readings=10**9)
    assert run(line, "left", tmp_path / "left.png") == 2
    err = capsys.readouterr().err
    assert "no pair of pictures was received in 2 s; check the cameras" in err and err.count("\n") == 1
    assert line.values["keep"] == 0 and line.blocks == 0 and [*tmp_path.iterdir()] == []


def test_interrupted():
    def report(done, total):
        if done == 2:
            raise KeyboardInterrupt
    line = KeptLine()
    with pytest.raises(KeyboardInterrupt):
        grab(Chip(line), "left", report)
    assert line.values["keep"] == 0


def test_line_that_is_lost():
    """What is told is the first error, not that the pair could not be let go."""
    class Lost(KeptLine):
        losses = 0

        def write(self, data):
            if self.blocks == 2:
                self.losses += 1
                raise UserError(f"the serial port is lost, {self.losses}")
            super().write(data)
    with pytest.raises(UserError, match="serial port is lost, 1"):
        grab(Chip(Lost()), "left")


@pytest.mark.parametrize("arguments, told", [
    (["left", "none/left.png"], "the folder none of left.png does not exist"), (["left", "left.jpg"], "not one of .png, .pgm, .npy"),
    (["both", "both.png"], "both"), (["left"], "FILE"), (["left", "."], "suffix"),
])
def test_bad_arguments(tmp_path, monkeypatch, capsys, arguments, told):
    """Before the port is opened."""
    monkeypatch.chdir(tmp_path)

    def connect(port, baud):
        raise AssertionError
    assert main(["--port", "none", "grab", *arguments], connect) == 2
    err = capsys.readouterr().err
    assert told in err and err.count("\n") == 1


def test_chip(tmp_path, capsys):
    """The gateware as a chip, with pictures of 16x2 pixels."""
    registers = register_map(MatcherConfig(labels=20, max_width=16, method=OnePass()), 2)
    chip = SimulatedChip(registers, mismatch=0.01)
    chip.planes = noise(16, 2, 1, pictures=3)
    chip.connect = lambda port, baud: contextlib.nullcontext(chip)
    assert run(chip, "disparity", tmp_path / "out.pgm") == 0
    assert np.array_equal(read_picture(tmp_path / "out.pgm"), chip.planes[2])
    assert chip.settings["keep"] == 0
