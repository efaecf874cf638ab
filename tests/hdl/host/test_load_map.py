# amaranth: UnusedElaboratable=no
"""hdl.host.load_map: maps loaded over lines with faults, into a strict model of the chip and into the gateware; what is refused."""

import contextlib

import numpy as np
import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.lib.memory import Memory

from golden.config import MatcherConfig
from golden.host.protocol import Reply, Status, encode_reply
from golden.host.registers import RegisterMap, register_map
from golden.rig.config import RigConfig
from golden.rig.files import Rig, write_rig
from golden.rig.maps import WORD_BITS, identity, pack
from hdl.host import load_map
from hdl.host.console import main
from hdl.host.registers import SerialRegisters
from hdl.rig.control import RigControl
from hdl.rig.stages import MapLoader
from sim.kit.rig_cases import camera_map, noise_map
from sim.models.uart import SimulatedChip

from .rig_chip import RigChip


@pytest.fixture(autouse=True)
def waits(monkeypatch):
    """The seconds that the console would have waited."""
    seconds = []
    monkeypatch.setattr(load_map.time, "sleep", seconds.append)
    return seconds


def rig(width=40, height=33, row_offset=0):
    return Rig(camera_map(width, height, roll=2), camera_map(width, height, lens=-0.1, gain=150), row_offset)


def rectify(chip, folder, which):
    write_rig(folder / "rig.json", which)
    return main(["--port", "none", "--timeout", "5", "rectify", str(folder)], chip.connect)


def fails(chip, folder, which, capsys):
    """The one sentence of a load that ends with status 2."""
    assert rectify(chip, folder, which) == 2
    out, err = capsys.readouterr()
    assert out == "" and err.startswith("hdl.host.console: ") and err.count("\n") == 1
    return err


def loaded(chip, which):
    """Whether the maps and the offset are in use, and nothing was done that must not be."""
    return (chip.failures == [] and chip.in_use == [pack(which.left), pack(which.right)]
            and chip.values["row_offset"] == which.row_offset and not chip.values["map_swapping"])


def test_loaded(tmp_path, capsys, waits):
    chip, which = RigChip(), rig(row_offset=-3)
    assert rectify(chip, tmp_path, which) == 0
    assert capsys.readouterr() == (
        f"{tmp_path}: 40x33 pixels, {which.lines} lines of 34, the right picture moved by -3 lines: maps loaded, map_fault no\n", "")
    assert loaded(chip, which) and chip.swaps == 1
    # The trial is after the swap, and map_fault is read after it.
    assert waits[-1] == 1.0 and chip.names[-5:] == ["map_abandoned", "map_fault", "map_abandoned", "rectify", "map"]


def test_the_file_itself(tmp_path, capsys):
    chip, which = RigChip(), rig()
    write_rig(tmp_path / "other.json", which)
    assert main(["--port", "none", "rectify", str(tmp_path / "other.json")], chip.connect) == 0
    assert loaded(chip, which)


def test_loaded_again_and_other_maps(tmp_path, capsys):
    """The maps change places at each swap."""
    chip = RigChip()
    for which in (rig(), Rig(noise_map(40, 33, 60, 1), noise_map(40, 33, 60, 2)), rig(row_offset=1)):
        assert rectify(chip, tmp_path, which) == 0
        assert loaded(chip, which)
    assert chip.swaps == 3


def test_equal_parts_are_written_once(tmp_path):
    """The identity has the same words all over but for its row bounds: parts change only there."""
    chip, which = RigChip(), Rig(identity(40, 33), identity(40, 33))
    assert rectify(chip, tmp_path, which) == 0
    assert loaded(chip, which)
    counts = {name: chip.names.count(name) for name in ("map_low", "map_middle", "map_high", "map_next")}
    # Twelve words a side; the high part changes six times.
    assert counts == {"map_low": 2, "map_middle": 2, "map_high": 12, "map_next": 24}


FAULTS = {
    "replies are lost": {"fault": lambda data: b""},
    "requests are lost": {"lost": True},
    "a bit of replies is wrong": {"fault": lambda data: bytes([*data[:4], data[4] ^ 1, data[5]])},
    "bad sums": {"fault": lambda data: encode_reply(Reply(Status.BAD_SUM, data[2]))},
    "noise before replies": {"fault": lambda data: bytes([0, 0x5A, 255]) + data},
}


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize("fault", FAULTS)
def test_faults_of_the_line(tmp_path, fault, seed):
    """A quarter of the replies, or requests: a map_next whose reply is lost has, or has not, written a word."""
    rng = np.random.default_rng(seed)
    change, lost = FAULTS[fault].get("fault"), "lost" in FAULTS[fault]

    def strikes(number):
        return rng.random() < 0.25 and number > 20      # after the constants

    chip = RigChip(pair_requests=50, fault=lambda number, data: change(data) if change and strikes(number) else data,
                   lost=lambda number, name: lost and strikes(number))
    which = rig()
    assert rectify(chip, tmp_path, which) == 0
    assert loaded(chip, which) and len(chip.names) > 150


@pytest.mark.parametrize("times", [1, 2, 3])
def test_lost_replies_to_map_next(tmp_path, times):
    """The replies to one map_next are lost, once to three times, wherever it is, also those to the last one of a side."""
    which = rig()
    for place in (0, 5, 11, 12, 23):
        state = {"next": 0, "lost": 0}

        def fault(number, data, place=place, state=state):
            if data[2] != 0x6B:
                return data
            if state["next"] == place and state["lost"] < times:
                state["lost"] += 1
                return b""
            state["next"] += 1
            return data

        chip = RigChip(fault=fault)
        assert rectify(chip, tmp_path, which) == 0
        assert state["lost"] == times and loaded(chip, which)
        assert chip.names.count("map_next") == 24 + times   # no side is loaded twice


def test_lost_reply_to_the_last_word_of_a_full_memory(tmp_path):
    """Eight words fill the memory: the word that was written again is over the first one, so the side is loaded once more."""
    which = rig(40, 20)
    state = {"next": 0, "lost": False}

    def fault(number, data):
        if data[2] == 0x6B:
            state["next"] += 1
            if state["next"] == 8:
                return b""
        return data

    chip = RigChip(40, 20, fault=fault)
    assert rectify(chip, tmp_path, which) == 0
    assert loaded(chip, which) and chip.names.count("map_next") == 9 + 8 + 8


def test_lost_reply_to_map_swap(tmp_path):
    """The pair is received before the second map_swap: the old maps are in use again, and all is loaded once more."""
    chip, which = RigChip(pair_requests=1), rig()
    state = {"swaps": 0}

    def fault(number, data):
        state["swaps"] += data[2] == 0x6C
        return b"" if data[2] == 0x6C and state["swaps"] == 1 else data

    chip.fault = fault
    assert rectify(chip, tmp_path, which) == 0
    assert loaded(chip, which) and chip.swaps == 3


def test_replies_to_map_swap_are_always_lost(tmp_path, capsys):
    state = {"swaps": 0}

    def fault(number, data):
        state["swaps"] += data[2] == 0x6C
        return b"" if data[2] == 0x6C and state["swaps"] % 2 else data

    assert "the reply to map_swap was lost 3 times" in fails(RigChip(fault=fault), tmp_path, rig(), capsys)


def test_wrong_sum(tmp_path, capsys):
    """Once: that side is loaded again. Twice: nothing is put in use."""
    which = rig()
    chip = RigChip(flip=[15])
    assert rectify(chip, tmp_path, which) == 0
    assert loaded(chip, which) and chip.names.count("map_next") == 12 + 2 * 12
    capsys.readouterr()
    for flip, side in (([3, 12 + 11], "left"), ([15, 30], "right")):
        chip = RigChip(flip=flip)
        assert f"the {side} map was loaded 2 times, and its sum was wrong each time" in fails(chip, tmp_path, which, capsys)
        assert chip.swaps == 0 and "map_swap" not in chip.names and "row_offset" not in chip.names
        assert chip.in_use == [pack(identity(40, 33))] * 2


@pytest.mark.parametrize("chip, which, message", [
    (lambda: RigChip(lines=0), rig, "the chip has no rectifiers: rectify_lines is 0"),
    (lambda: RigChip(44, 33), rig, "the rig is for pictures of 40x33 pixels, and the chip's have 44x33; calibrate at this size"),
    (lambda: RigChip(40, 34), rig, "pictures of 40x33 pixels, and the chip's have 40x34"),
    (lambda: RigChip(320, 64, 22), lambda: Rig(camera_map(320, 64, roll=8), identity(320, 64)), "lines and the gateware holds 22"),
])
def test_refused_before_anything_is_written(tmp_path, capsys, chip, which, message):
    chip = chip()
    assert message in fails(chip, tmp_path, which(), capsys)
    assert not {*chip.names} & chip.LOADING


def test_no_pair_is_received(tmp_path, capsys, waits):
    """The maps wait in the chip; as long as they do, nothing is written."""
    chip, which = RigChip(pair_requests=0), rig()
    assert "no pair of pictures was received in 5 s" in fails(chip, tmp_path, which, capsys)
    assert chip.values["map_swapping"] and chip.names[-1] == "map_swapping" and sum(waits) == pytest.approx(5)
    chip.names.clear()
    assert "check the cameras" in fails(chip, tmp_path, which, capsys)
    assert not {*chip.names} & chip.LOADING and chip.failures == []
    chip.pair_requests = 20
    assert rectify(chip, tmp_path, which) == 0
    assert loaded(chip, which)


def test_maps_that_the_chip_cannot_run(tmp_path, capsys, waits, monkeypatch):
    chip = RigChip()
    chip.faulty = True
    assert "the maps are in use, but the chip does not rectify pairs to their end: they need more than its 34 lines" in fails(
        chip, tmp_path, rig(), capsys)
    # Of other maps, before: a note.
    chip.faulty = False
    assert rectify(chip, tmp_path, rig()) == 0
    out, err = capsys.readouterr()
    assert out.endswith("map_fault yes\n") and err.startswith("note: map_fault is 1")


def test_rectification_is_off(tmp_path, capsys):
    chip = RigChip()
    chip.values["rectify"] = 0
    assert rectify(chip, tmp_path, rig()) == 0
    assert capsys.readouterr().out.endswith("; rectification is off: set rectify=1\n")


def test_no_rig(tmp_path, capsys):
    """Before the port is opened."""
    def connect(port, baud):
        raise AssertionError
    assert main(["--port", "none", "rectify", str(tmp_path)], connect) == 2
    err = capsys.readouterr().err
    assert "rig.json" in err and err.count("\n") == 1


class LoadedRegisters(wiring.Component):
    """Registers, their line, loader and control, and a memory of all maps; a pair begins every ``PAIR`` clocks."""
    PAIR = 5000
    WORDS = 8

    def __init__(self, *args, **kwargs):
        self.serial = SerialRegisters(*args, **kwargs)
        self.memory = Memory(shape=WORD_BITS, depth=4 * self.WORDS, init=[])
        members = self.serial.signature.members
        super().__init__({name: members[name] for name in ("rx", "tx", "settings", "actions", "status", "line", "byte")})

    def elaborate(self, platform):
        m = Module()
        m.submodules.serial = serial = self.serial
        m.submodules.loader = loader = MapLoader(self.WORDS)
        m.submodules.memory = self.memory
        port = self.memory.write_port()
        m.submodules.control = control = RigControl()
        bank, swapping, clock = Signal(), Signal(), Signal(range(self.PAIR))
        settings, actions = serial.settings, serial.actions
        wiring.connect(m, serial.line, wiring.flipped(self.line))
        wiring.connect(m, wiring.flipped(self.byte), serial.byte)
        m.d.sync += clock.eq(Mux(clock == self.PAIR - 1, 0, clock + 1))
        # As the rectifier does: the first pixel is some clocks after the pair's start.
        with m.If(control.stages_swap):
            m.d.sync += swapping.eq(1)
        with m.Elif(clock == 100):
            m.d.sync += [swapping.eq(0), bank.eq(bank ^ swapping)]
        m.d.comb += [
            serial.rx.eq(self.rx), self.tx.eq(serial.tx), self.settings.eq(settings), self.actions.eq(actions),
            control.swap.eq(actions.map_swap), control.start.eq(clock == 0), control.swapping.eq(swapping),
            control.wanted_row_offset.eq(settings.row_offset), control.settings.rectify.eq(settings.rectify),
            serial.status.map_swapping.eq(control.waits), serial.status.map.eq(control.maps), serial.status.map_sum.eq(loader.sum),
            *(getattr(loader, name).eq(settings[f"map_{name}"]) for name in ("address", "low", "middle", "high")),
            *(getattr(loader, name).eq(actions[f"map_{name}"]) for name in ("start", "next")),
            port.en.eq(loader.write), port.data.eq(loader.write_data),
            port.addr.eq(Cat(loader.write_address, settings.map_side, ~bank)),
        ]
        return m


class SimulatedRig(SimulatedChip):
    """The gateware as a chip for :func:`rectify`, with its memory and the number of requests."""
    BIT = 16

    def __init__(self):
        registers = register_map(MatcherConfig(labels=20, max_width=16), 16, RigConfig())
        # Without those that are of no use here, for the time of the simulation.
        used = [each for each in registers if each.address < 0x10 or "map" in each.name or each.name in (
            "rectify", "row_offset", "clear_counters", "uart_errors", "keep", "kept", "source", "start_pair", "pair_whole")]
        super().__init__(RegisterMap(tuple(used)), bit_cycles=self.BIT, system=LoadedRegisters)
        self.requests = 0

    async def _run(self, ctx):
        self.context = ctx
        await super()._run(ctx)

    def write(self, data):
        self.requests += 1
        super().write(data)

    def connect(self, port, baud):
        return contextlib.nullcontext(self)

    def maps(self, bank):
        words = [self.context.get(self.dut.memory.data[place]) for place in range(4 * LoadedRegisters.WORDS)]
        return [words[8 * (2 * bank + side):][:6] for side in (0, 1)]


@pytest.mark.slow   # 136,000 clocks; the strict model above covers the console, tests of hdl.host.registers and hdl.rig.stages the gateware
def test_gateware(tmp_path, capsys):
    """Registers, loader and control as they are: the memory has the maps, and the time is that of so many requests on the line."""
    chip, which = SimulatedRig(), rig(16, 16, row_offset=-2)
    assert rectify(chip, tmp_path, which) == 0
    assert capsys.readouterr().out.endswith(" lines of 34, the right picture moved by -2 lines: maps loaded, map_fault no\n")
    assert chip.maps(1) == [pack(which.left), pack(which.right)] and chip.settings["row_offset"] == -2
    assert chip.line.cycle == pytest.approx(120 * chip.BIT * chip.requests, rel=0.01)
