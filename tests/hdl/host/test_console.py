# amaranth: UnusedElaboratable=no
"""hdl.host.console: the command line against the simulated chip, in memory and over a pseudo terminal, and against lines with faults."""

import contextlib
import os
import pty
import select
import threading
import tty

import numpy as np
import pytest

from golden.config import FUSED_1, MatcherConfig
from golden.errors import UserError
from golden.host.loop_device import LoopDevice
from golden.host.protocol import FRAME_BYTES, REPLY_SYNC, Operation, Reply, Request, Status, decode_request, encode_reply
from golden.host.registers import IDENTITY, Kind, RegisterMap, answer, register_map
from golden.pictures.images import read_picture
from golden.rig.config import RigConfig
from hdl.host.chip import Chip, SerialPort
from hdl.host.console import main
from sim.models.loop_line import LoopLine
from sim.models.uart import SimulatedChip


REGISTERS = register_map(MatcherConfig(labels=20), height=200)

# Registers that a console reads first, to know which chip it is.
CONSTANTS = 8


class FakeLine:
    """A line to a chip that replies as :func:`golden.host.registers.answer` does; ``fault`` may change the reply.

    ``fault`` takes the number of the request, counted from 0, and the reply's bytes, and returns bytes.
    """
    def __init__(self, fault=lambda number, data: data, values=None, registers=REGISTERS):
        self.fault = fault
        self.values = dict(values or {})
        self.registers = registers
        self.requests: list = []
        self.waits: list = []
        self._data = b""

    def write(self, data):
        reply, written = answer(self.registers, self.values, data)
        self.values.update({name: value for name, value in written.items() if self.registers[name].kind is Kind.SETTING})
        self._data += self.fault(len(self.requests), encode_reply(reply))
        self.requests.append(decode_request(data))

    def read(self, count, seconds):
        data, self._data = self._data[:count], self._data[count:]
        if len(data) < count:
            self.waits.append(seconds)
        return data

    def connect(self, port, baud):
        return contextlib.nullcontext(self)


def run(capsys, arguments, line=None):
    """Status, stdout and stderr of the command."""
    status = main(["--port", "none", *arguments.split()], (line or FakeLine()).connect)
    return status, *capsys.readouterr()


def fails(capsys, arguments, line=None):
    """The one sentence of a command that ends with status 2."""
    status, out, err = run(capsys, arguments, line)
    assert status == 2
    assert out == ""
    assert err.startswith("hdl.host.console: ") and err.count("\n") == 1 and err.endswith("\n")
    return err


def rows(out, name):
    """Cells of the rows of a printed table that are about a register."""
    cells = [[cell.strip() for cell in line.split("│")[1:-1]] for line in out.splitlines()]
    return [row for row in cells if row and row[0] == name]


@pytest.fixture(scope="module")
def simulated():
    """The gateware behind a line that is 2 % slow."""
    chip = SimulatedChip(REGISTERS, mismatch=-0.02)
    chip.connect = lambda port, baud: contextlib.nullcontext(chip)
    return chip


def test_get_and_set_on_the_chip(simulated, capsys):
    simulated.status |= {"pairs": 65535, "left_locked": 1, "decoder_step": 7}
    assert main(["--port", "none", "set", "u1=0x2A", "show=both", "in_use=20", "restart_setup=1"], simulated.connect) == 0
    assert capsys.readouterr().out == "u1 = 42 grey levels a pixel\nshow = both\nin_use = 20 labels\nrestart_setup = 1\n"
    assert simulated.settings == {"u1": 42, "u2": 10, "u3": 5, "in_use": 20, "show": 2, "colour": 0, "hold": 0, "keep": 0, "source": 0}
    assert simulated.actions == ["restart_setup"]
    assert main(["--port", "none", "get", "pairs", "left_locked", "decoder_step", "u1", "width"], simulated.connect) == 0
    assert capsys.readouterr().out == (
        "pairs = 65535 pairs\nleft_locked = yes\ndecoder_step = decoder 2: write FE = 02\n"
        "u1 = 42 grey levels a pixel\nwidth = 720 pixels\n")


def test_refused_by_the_chip_itself(simulated):
    """A request that the console itself would not send: the chip refuses it."""
    chip = Chip(simulated)
    assert chip.transact(Request(Operation.WRITE, REGISTERS["u2"].address, 64)) == Reply(Status.OUT_OF_RANGE, REGISTERS["u2"].address)
    assert simulated.settings["u2"] == 10
    with pytest.raises(UserError, match="refuses to write pairs: read only"):
        chip.write("pairs", 1)


def test_noise_on_the_line_of_the_chip(simulated):
    """Bytes of noise spoil a request; the console repeats it after a pause, and gets a reply."""
    chip = Chip(simulated)
    errors = chip.read("uart_errors")
    simulated.line.send([0xA5, 0x10, 0x20])
    assert chip.read("height") == 200
    assert chip.read("uart_errors") > errors


def test_over_a_pseudo_terminal(capsys):
    """The command as it is run, with pyserial on one end and the chip on the other."""
    chip = SimulatedChip(REGISTERS)
    master, slave = pty.openpty()
    tty.setraw(slave)
    stop = threading.Event()

    def wire():
        while not stop.is_set():
            if select.select([master], [], [], 0.01)[0]:
                chip.write(os.read(master, 64))
                os.write(master, chip.read(FRAME_BYTES, 2e-3))

    thread = threading.Thread(target=wire)
    thread.start()
    try:
        port = os.ttyname(slave)
        assert main(["--port", port, "--timeout", "5", "set", "u3=9"]) == 0
        assert capsys.readouterr().out == "u3 = 9 grey levels a pixel\n"
        assert chip.settings["u3"] == 9
    finally:
        stop.set()
        thread.join()
        os.close(master)
        os.close(slave)


def test_watch(simulated, capsys, monkeypatch):
    """All status and counters of the chip, twice, with the change between the readings."""
    monkeypatch.setenv("COLUMNS", "200")
    simulated.status |= {"left_dropped": 4, "memory_ready": 1}
    Chip(simulated).write("clear_counters", 1)
    assert main(["--port", "none", "watch", "--count", "1"], simulated.connect) == 0
    out = capsys.readouterr().out
    for register in REGISTERS.of(Kind.STATUS, Kind.COUNTER):
        (row,) = rows(out, register.name)
        assert row[1:3] == [register.text(simulated.status.get(register.name, 0)), ""]
    assert not rows(out, "u1")


def test_watch_shows_changes(capsys):
    line = FakeLine(values={"pairs": 100, "decoder_step": 3})

    def count(number, data):
        line.values["pairs"] += 1
        line.values["decoder_step"] += 1
        return data

    line.fault = count
    status, out, _ = run(capsys, "watch --count 3 --interval 0", line)
    assert status == 0
    looks = len(REGISTERS.of(Kind.STATUS, Kind.COUNTER))
    assert len(line.requests) == CONSTANTS + 3 * looks
    *_, last = rows(out, "pairs")
    assert last[2] == f"+{looks}"
    *_, last = rows(out, "decoder_step")
    assert last[2] == "" and int(last[1]) > looks


def test_watch_ends_when_interrupted(capsys, monkeypatch):
    def interrupt(seconds):
        assert seconds == 2.5
        raise KeyboardInterrupt
    monkeypatch.setattr("hdl.host.console.time.sleep", interrupt)
    status, out, err = run(capsys, "watch --interval 2.5")
    assert (status, err) == (0, "")
    assert len(rows(out, "pairs")) == 1


def test_list_needs_no_chip(capsys, monkeypatch):
    monkeypatch.setenv("COLUMNS", "200")
    assert main(["list"]) == 0
    out = capsys.readouterr().out
    for register in register_map(rig=RigConfig()):
        assert rows(out, register.name) == [[register.name, register.access, register.limits, register.unit, register.description]]


FAULTS = {
    "no answer": lambda number, data: b"" if number % 2 == 0 else data,
    "a bit is wrong": lambda number, data: data[:4] + bytes([data[4] ^ 1]) + data[5:] if number % 2 == 0 else data,
    "half of it is lost": lambda number, data: data[:3] if number % 3 else data,
    "the chip found a bad sum": lambda number, data: encode_reply(Reply(Status.BAD_SUM, data[2])) if number % 3 else data,
    "another address": lambda number, data: encode_reply(Reply(Status.OK, data[2] ^ 1, 5)) if number % 2 == 0 else data,
    "noise before it": lambda number, data: bytes([0, REPLY_SYNC, 255, 7]) + data,
    "stale bytes after it": lambda number, data: data + data[:4],
}


@pytest.mark.parametrize("fault", FAULTS)
def test_retries(capsys, fault):
    line = FakeLine(FAULTS[fault], {"u1": 33})
    status, out, _ = run(capsys, "get u1 height", line)
    assert (status, out) == (0, "u1 = 33 grey levels a pixel\nheight = 200 lines\n")
    status, out, _ = run(capsys, "set u1=34", line)
    assert (status, out) == (0, "u1 = 34 grey levels a pixel\n")
    assert line.values["u1"] == 34


def test_write_that_came_as_another_value(capsys):
    """The sum was right by chance: the reply tells, and the write is sent again."""
    def fault(number, data):
        return encode_reply(Reply(Status.OK, data[2], 35)) if number == CONSTANTS else data
    line = FakeLine(fault)
    assert run(capsys, "set u1=34", line)[:2] == (0, "u1 = 34 grey levels a pixel\n")
    assert line.requests[CONSTANTS] == line.requests[CONSTANTS + 1] == Request(Operation.WRITE, REGISTERS["u1"].address, 34)


def test_silence_before_a_retry():
    """The chip drops half a request only after its time-out."""
    line = FakeLine(lambda number, data: b"" if number == CONSTANTS else data)
    Chip(line, answer_seconds=0.5).read("u1")
    # No wait before the first attempts; then the time-out of the reply, and the pause.
    assert line.waits == [*[0] * (CONSTANTS + 1), 0.5, 0.011]


def test_no_answer(capsys):
    line = FakeLine(lambda number, data: b"")
    assert "no answer in 4 attempts of 0.25 s; check the wires" in fails(capsys, "--timeout 0.25 get u1", line)
    assert len(line.requests) == 4


def test_only_garbage(capsys):
    rng = np.random.default_rng(1)
    line = FakeLine(lambda number, data: bytes(rng.integers(0, 90, 100).tolist()))
    assert "no good answer in 4 attempts (garbled, garbled, garbled, garbled)" in fails(capsys, "get u1", line)
    line = FakeLine(lambda number, data: encode_reply(Reply(Status.BAD_SUM, 0)) if number else b"")
    assert "(nothing, bad sum, bad sum, bad sum)" in fails(capsys, "get u1", line)


def test_line_that_never_falls_silent():
    """Babble does not keep the console for ever."""
    class Babble(FakeLine):
        def read(self, count, seconds):
            return bytes(count)
    with pytest.raises(UserError, match="no good answer"):
        Chip(Babble())


def test_other_chips(capsys):
    def with_constant(name, value):
        changed = [register if register.name != name else type(register)(
            name, register.address, Kind.CONSTANT, value, "changed", reset=value) for register in REGISTERS]
        return FakeLine(registers=RegisterMap(tuple(changed)))
    assert f"its identity is 4660, not {IDENTITY}" in fails(capsys, "get u1", with_constant("identity", 0x1234))
    assert "the chip has the method 3, this program knows those from 0 to 2" in fails(capsys, "get u1", with_constant("method", 3))
    assert "version 9 of the register map, this program version 6" in fails(capsys, "get u1", with_constant("version", 9))
    assert run(capsys, "set in_use=200", with_constant("disparities", 256))[0] == 2   # the fake itself still has 20
    assert "choose one of: 1 .. 20 labels" in fails(capsys, "set in_use=21")


@pytest.mark.parametrize("arguments, message", [
    ("get u4", "no register 'u4'"),
    ("get u1 U2", "no register 'U2'"),
    ("set u4=1", "no register 'u4'"),
    ("set u1", "'u1' is no assignment"),
    ("set u1=64", "u1 cannot be set to '64'; choose one of: 0 .. 63 grey levels a pixel"),
    ("set u1=-1", "choose one of: 0 .. 63"),
    ("set u1=two", "u1 cannot be set to 'two'"),
    ("set u1=", "u1 cannot be set to ''"),
    ("set u1=1.5", "u1 cannot be set to '1.5'"),
    ("set in_use=0", "choose one of: 1 .. 20 labels"),
    ("set show=none", "choose one of: 0 disparity, 1 left, 2 both"),
    ("set show=3", "choose one of: 0 disparity"),
    ("set clear_counters=0", "choose one of: 1"),
    ("set pairs=0", "pairs cannot be set, it is read-only"),
    ("set identity=1", "identity cannot be set, it is read-only"),
    ("get", "NAME"),
    ("set", "NAME=VALUE"),
    ("put u1=1", "put"),
    ("--baud 0 get u1", "--baud must be from 1 to 4000000, not 0"),
    ("--baud 9999999 get u1", "--baud must be from 1 to 4000000, not 9999999"),
    ("--baud fast get u1", "--baud"),
    ("--timeout 0 get u1", "--timeout must be from 0.001 to 60, not 0.0"),
    ("--timeout nan get u1", "--timeout"),
    ("watch --interval -1", "--interval must be from 0 to 3600, not -1.0"),
    ("watch --count 0", "--count must be from 1 to 1000000000, not 0"),
])
def test_bad_arguments(capsys, arguments, message):
    line = FakeLine()
    assert message in fails(capsys, arguments, line)
    assert not any(request.operation == Operation.WRITE for request in line.requests)


def test_nothing_is_written_unless_all_is_good(capsys):
    line = FakeLine()
    fails(capsys, "set u1=1 u2=64", line)
    assert not any(request.operation == Operation.WRITE for request in line.requests)


def test_port_is_missing(capsys):
    assert main(["get", "u1"]) == 2
    assert "--port is missing; name the serial port" in capsys.readouterr().err


@pytest.mark.parametrize("port", ["none/ttyS0", "."])
def test_port_that_is_none(capsys, tmp_path, monkeypatch, port):
    monkeypatch.chdir(tmp_path)
    assert main(["--port", port, "get", "u1"]) == 2
    err = capsys.readouterr().err
    assert f"the serial port {port} cannot be opened: " in err and err.count("\n") == 1


def test_port_that_is_a_file(capsys, tmp_path):
    (tmp_path / "file").write_text("")
    assert main(["--port", str(tmp_path / "file"), "get", "u1"]) == 2
    assert "cannot be opened" in capsys.readouterr().err


def test_port_that_goes_away():
    master, slave = pty.openpty()
    with SerialPort(os.ttyname(slave), 115_200) as port:
        os.close(slave)
        os.close(master)
        with pytest.raises(UserError, match=r"is lost: .*plug it in again"):
            port.read(1, 1.0)
        with pytest.raises(UserError, match="is lost"):
            port.write(b"a")


def test_without_pyserial(capsys, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "serial", None)
    assert main(["--port", "none", "get", "u1"]) == 2
    assert "pip install 'pyserial" in capsys.readouterr().err


def test_negative_setting(capsys):
    """The console learns from the chip how far below 0 the least disparity may be."""
    line = FakeLine(registers=register_map(MatcherConfig(labels=20, minimum=-16, method=FUSED_1)))
    assert run(capsys, "set minimum=-16", line)[:2] == (0, "minimum = -16 pixels\n")
    assert line.values == {"minimum": -16}
    assert run(capsys, "get minimum lead", line)[:2] == (0, "minimum = -16 pixels\nlead = 16 columns\n")
    assert "minimum cannot be set to '-17'; choose one of: -16 .. 255 pixels" in fails(capsys, "set minimum=-17", line)
    assert "minimum cannot be set to 'no'" in fails(capsys, "set minimum=no", line)
    plain = FakeLine(registers=register_map(MatcherConfig(labels=20, method=FUSED_1)))
    assert "minimum cannot be set to '-1'; choose one of: 0 .. 255 pixels" in fails(capsys, "set minimum=-1", plain)


def test_list_of_the_board_at_a_port(capsys, monkeypatch):
    """Registers of that build, and of a system without cameras."""
    monkeypatch.setenv("COLUMNS", "200")
    device = LoopDevice(MatcherConfig(labels=9, max_width=33), 7)
    assert main(["--port", "none", "list"], LoopLine(device).connect) == 0
    out = capsys.readouterr().out
    for register in device.registers:
        assert rows(out, register.name) == [[register.name, register.access, register.limits, register.unit, register.description]]
    assert not rows(out, "show")


def test_console_of_a_board_without_cameras(capsys, tmp_path):
    """Its pictures have the size of the last pair; and it has no rectifiers."""
    device = LoopDevice(MatcherConfig(labels=9, max_width=33), 7)
    device.values |= {"picture_width": 20, "picture_height": 5, "kept": 1}
    device.pictures[0][:] = np.arange(33)
    assert main(["--port", "none", "grab", "left", str(tmp_path / "left.pgm")], LoopLine(device).connect) == 0
    assert (read_picture(tmp_path / "left.pgm") == np.tile(np.arange(20), (5, 1))).all()
    assert device.values["keep"] == 0
    assert main(["--port", "none", "set", "start=1", "u1=3"], LoopLine(device).connect) == 0
    assert device.values["pairs"] == 1 and capsys.readouterr().out.endswith("start = 1\nu1 = 3 grey levels a pixel\n")
