"""The cocotb half of ``test_system.py``: the whole system, from two cameras to the monitor."""

import argparse
import dataclasses
import json
import os
from pathlib import Path

import cocotb
import numpy as np
from cocotb.triggers import ClockCycles

from golden.host.protocol import Status
from golden.host.registers import IDENTITY
from golden.rig.balance import GAIN_ONE
from golden.rig.config import MapsInUse
from golden.rig.maps import map_sum, pack
from golden.video.display import DisplayMode
from sim.benches.system_faults import FAULTS
from sim.benches.system_rig import SIDES, Rig
from sim.benches.system_sizes import noise_rig
from sim.models.ddr2 import Ddr2Timing


HOSTILE = Ddr2Timing(busy=0.4, refresh=(300, 24))

# A hundred clocks shorter than the monitor's blanking: a stall that begins with the display's fetch ends before the first word is due.
STALLS = tuple((clock, 500) for clock in range(20_000, 2_000_000, 3_777))

#: Counters that stay 0 with any timing of the memory within its bounds.
NEVER = ("matcher_error", "display_underflows", "pictures_abandoned",
         *(f"{side}_{what}" for side in SIDES for what in ("dropped", "overflow", "skipped", "rejected")))


#: Lines that are read of each picture of a kept pair: all of the left one.
LINES = range(24), (0, 11, 23), (0, 1, 12, 23)


async def start(dut, stalls=()):
    """A rig whose monitor shows the first pair."""
    rig = Rig(dut, timing=dataclasses.replace(HOSTILE, stalls=stalls))
    await rig.start()
    if rig.rig:     # the first two pairs are as they are, then gain and offset stay
        rig.change(scene=False, balance=rig.auto())
    await rig.shows(frames=20)
    rig.cut = 0     # black until the first picture
    if rig.rig:     # scenes that change would have a balance that depends on what was seen when
        await fix_balance(rig, 300, -1500)
    return rig


async def fix_balance(rig, gain, offset):
    """Another fixed balance; the one before is not fixed."""
    await rig.write("fixed_gain", gain)
    await rig.write("fixed_offset", offset)
    rig.change(scene=False, balance=(gain, offset))
    await rig.write("balance", 2)
    await rig.shows()


async def look(dut, changes, held):
    """The monitor is bit-exact after each of ``changes``, a register's name, its value and the setting, which takes effect between
    pictures; while the picture is held, for ``held`` of its frames; status and counters are read, and a button clears these."""
    rig = await start(dut)
    assert await rig.read("identity") == IDENTITY
    assert await rig.read("in_use") == rig.config.labels
    for name, value, setting in changes(rig.config.settings):
        rig.change(scene=name in ("show", "u3", "above_share", "minimum"), **setting)
        await rig.write(name, value)
        await rig.shows()
    assert rig.cut == 0

    # Hold: the picture is repeated.
    await rig.write("hold", 1)
    await rig.shows()
    still = rig.golden(rig.pair, rig.settings)
    rig.change()
    for _ in range(held):
        await rig.frame()
        assert np.array_equal(rig.monitor.pictures[-1], still)
    assert await rig.read("left_unpaired") > 0
    await rig.write("hold", 0)
    await rig.shows()

    for name in ("memory_ready", "left_signal", "right_signal"):
        assert await rig.read(name) == 1, name
    for name in (*NEVER, "uart_errors"):
        assert await rig.read(name) == 0, name
    for name in ("display_frames", "pairs", "left_camera_fill", "right_camera_fill", "pair_fill", "picture_fill", "display_fill"):
        assert await rig.read(name) > 0, name
    frames, pairs = await rig.read("display_frames"), await rig.read("pairs")
    assert abs(frames - rig.monitor.frames) <= 3 and 0 <= rig.films["left"].frames - pairs < 12
    assert int(dut.leds.value) & 0b11010011 == 0b00010011

    # A button clears the counters, after it has bounced.
    for level in (1, 0, 1):
        dut.buttons.value = level << 1
        await ClockCycles(dut.clk, 2000 if level == 0 else 300)
    await ClockCycles(dut.clk, 6000)
    assert await rig.read("display_frames") < 5 < frames


@cocotb.test()
async def pictures(dut):
    """All display modes and settings of the matcher."""
    def changes(settings):
        weight = "u3" if "u3" in settings else "above_share"
        return (*(("minimum", value, {"minimum": value}) for value in ((-1, 5) if "minimum" in settings else ())),
                ("show", 1, {"mode": DisplayMode.LEFT}), ("show", 2, {"mode": DisplayMode.BOTH}), ("colour", 1, {"colour": True}),
                ("show", 0, {"mode": DisplayMode.DISPARITY}), (weight, 5, {weight: 5}), ("in_use", 5, {"in_use": 5}))
    await look(dut, changes, 8)


@cocotb.test()
async def glance(dut):
    """A setting of each kind, and both pictures side by side in colour."""
    await look(dut, lambda settings: (
        ("show", 2, {"mode": DisplayMode.BOTH}), ("colour", 1, {"colour": True}), ("minimum", 1, {"minimum": 1}),
        ("in_use", 3, {"in_use": 3})), 4)


@cocotb.test()
async def grab(dut):
    """A kept pair is read line by line while the system runs on: the pair as the cameras sent it, with its disparities, whatever comes."""
    rig = await start(dut)
    assert await rig.block(0, 0) is Status.NOT_KEPT
    rig.change()
    await rig.shows()
    await rig.write("keep", 1)
    await rig.until_reads("kept", 1)
    pair, pairs = rig.pair, await rig.read("pairs")
    expected = (*pair, rig.labels(pair, rig.settings))
    for number, lines in enumerate(LINES):
        # Other scenes, which the monitor shows, before and while a picture is read.
        for _ in range(4):
            rig.change()
            await rig.shows()
        rig.change()
        for line in lines:
            assert list(await rig.block(number, line)) == expected[number][line].tolist(), (number, line)
    await rig.shows()
    assert rig.cut == 0
    assert await rig.read("pairs") - pairs > 60
    assert await rig.block(3, 0) is Status.UNKNOWN_ADDRESS
    assert await rig.block(1, rig.camera.height) is Status.OUT_OF_RANGE

    # The next one.
    await rig.write("keep", 0)
    await rig.until_reads("kept", 0)
    assert await rig.block(0, 0) is Status.NOT_KEPT
    await rig.write("keep", 1)
    await rig.until_reads("kept", 1)
    assert list(await rig.block(1, 7)) == rig.pair[1][7].tolist()
    for name in (*NEVER, "left_unpaired", "right_unpaired", "uart_errors"):
        assert await rig.read(name) == 0, name


@cocotb.test()
async def put(dut):
    """A pair of the host's in place of the cameras': with faults on its way, bit-exact at the monitor and in memory, and matched again with
    another setting; one that is broken off is never shown, and the cameras' pairs are matched once they have their turn."""
    rig = await start(dut)
    height = rig.camera.height
    seen = rig.pair
    given = rig._scene()
    lines = [(plane, line) for plane in range(2) for line in range(height)]
    assert await rig.put_line(0, 0, given[0][0]) is Status.BUSY     # the cameras are the source
    await rig.write("source", 1)
    assert await rig.put_line(0, 1, given[0][1]) is Status.BUSY     # a line ahead
    for plane, line in lines:
        if (plane, line) == (1, 0):
            assert await rig.put_line(plane, line, 255 - given[plane][line], spoiled=True) is Status.BAD_SUM
            assert await rig.put_line(plane, line, 255 - given[plane][line], part=9) is Status.BAD_SUM
            await rig.write("start_pair", 1)
        assert await rig.put_line(plane, line, given[plane][line]) is Status.OK
    assert await rig.read("pair_whole") == 1
    await rig.shows()   # the cameras' last pair
    pairs = await rig.read("pairs")
    rig.pair = given
    rig.change(scene=False)
    await rig.write("start_pair", 1)
    await rig.shows()
    assert rig.cut == 0 and await rig.read("pairs") == pairs + 1

    # Kept, with another setting; meanwhile no line is accepted.
    rig.change(scene=False, in_use=3)
    await rig.write("in_use", 3)
    await rig.write("keep", 1)
    await rig.write("start_pair", 1)
    await rig.until_reads("kept", 1)
    assert await rig.put_line(0, 0, given[0][0]) is Status.BUSY
    for number, picture in enumerate((*given, rig.labels(given, rig.settings))):
        for line in (0, 1, height - 1) if number == 2 else (height // 2,):
            assert list((await rig.block(number, line))[:rig.camera.width]) == picture[line].tolist(), (number, line)
    clocks = await rig.read("clocks_high") << 16 | await rig.read("clocks_low")
    assert rig.camera.width * height < clocks < 20 * rig.camera.width * height
    await rig.write("keep", 0)
    await rig.shows()

    # Another one is broken off.
    other = rig._scene()
    for plane, line in lines[:3]:
        assert await rig.put_line(plane, line, other[plane][line]) is Status.OK
    await rig.write("start_pair", 1)
    assert [await rig.read(name) for name in ("pair_whole", "pairs")] == [0, pairs + 2]
    await rig.shows()
    rig.pair = seen
    rig.change(scene=False)
    await rig.write("source", 0)
    await rig.shows()
    assert rig.cut == 0
    for name in NEVER:
        assert await rig.read(name) == 0, name


@cocotb.test()
async def maps(dut):
    """Maps are loaded while pairs pass, and used from a pair's start on; one that is wrong is reported, and the next one cures it."""
    rig = await start(dut)
    first = rig.rig.rig
    assert [await rig.read(name) for name in ("rectify_lines", "map", "row_offset")] == [
        rig.rig.lines, MapsInUse.BUILT_IN, first.row_offset]

    second = noise_rig(5, -3)
    await load(rig, second)
    assert await rig.read("map") == MapsInUse.BUILT_IN
    rig.change(maps=second)
    await rig.write("map_swap", 1)
    await rig.shows()
    assert [await rig.read(name) for name in ("map", "map_swapping", "map_fault")] == [MapsInUse.LOADED, 0, 0]

    # A copy, then rectified again.
    for on, which in ((0, None), (1, second)):
        rig.change(maps=which)
        await rig.write("rectify", on)
        await rig.shows()
    assert rig.cut == 0

    # Rows that are never free: a rectifier of 22 lines cannot hold 24. Pictures that it leaves black are not looked at.
    wrong = {side: dataclasses.replace(which, bounds=which.bounds - 60) for side, which in (("left", second.left), ("right", second.right))}
    await load(rig, argparse.Namespace(**wrong, row_offset=0))
    await rig.write("map_swap", 1)
    await rig.until_reads("map_fault", 1)
    assert await rig.read("map_abandoned") > 0
    await load(rig, first)
    rig.change(maps=first)
    await rig.write("map_swap", 1)
    await rig.shows(frames=20, every=False)
    await rig.write("clear_counters", 1)
    rig.change()
    await rig.shows()
    assert [await rig.read(name) for name in ("map_fault", "map_abandoned")] == [0, 0]

    # The balance by itself, and a camera that is black for some frames: what was measured of it is forgotten in time.
    rig.change(scene=False, balance=(GAIN_ONE, 0))
    wanted = rig.auto()
    rig.change(scene=False, balance=wanted)
    await rig.write("balance", 1)
    await rig.shows(frames=20)
    assert (await rig.read("gain"), await rig.read("offset")) == wanted
    picture = rig.films["right"].picture
    rig.films["right"].picture = np.full_like(picture, 16)
    for _ in range(100):
        if await rig.read("right_deviation") < 32:
            break
    else:
        raise AssertionError("a black camera was not noticed")
    rig.films["right"].picture = picture
    for name, value in zip(("gain", "offset"), wanted):
        await rig.until_reads(name, value, 400)
    await rig.shows(every=False)
    for name in NEVER:
        assert await rig.read(name) == 0, name


async def load(rig, which):
    """Write the maps of a rig into the registers, and read their sums."""
    for side, each in enumerate((which.left, which.right)):
        words = pack(each)
        for name, value in (("map_side", side), ("map_address", 0), ("map_start", 1)):
            await rig.write(name, value)
        for word in words:
            for name, value in (("map_low", word & 65535), ("map_middle", word >> 16 & 65535), ("map_high", word >> 32), ("map_next", 1)):
                await rig.write(name, value)
        assert await rig.read("map_sum") == map_sum(words)
    await rig.write("row_offset", which.row_offset)


@cocotb.test()
async def fills(dut):
    """Scene after scene, bit-exact, for a number of frames; the greatest fill of each FIFO."""
    rig = await start(dut, STALLS)
    await rig.write("clear_counters", 1)
    memory, frames = rig.memory, rig.films["left"].frames
    clocks, words = memory.now, memory.words_read + memory.words_written
    while rig.films["left"].frames < frames + int(os.environ["FRAMES"]):
        rig.change()
        await rig.shows()
    clocks, words = memory.now - clocks, memory.words_read + memory.words_written - words
    assert rig.cut == 0
    for name in NEVER:
        assert await rig.read(name) == 0, name
    told = {fifo: await rig.read(f"{fifo}_fill") for fifo in ("left_camera", "right_camera", "pair", "picture", "display")}
    assert all(told.values())
    Path(os.environ["REPORT"]).write_text(json.dumps(
        {"fills": told, "frames": rig.films["left"].frames - frames, "clocks": clocks, "words": words}))


@cocotb.test()
async def faults(dut):
    """The faults that ``FAULTS`` names, or all if it names none: each is counted, the pair after it is shown exactly, and the monitor's
    timing holds throughout."""
    rig = await start(dut)
    await rig.until(lambda: rig.decoder.is_set_up(1) and rig.transmitter.is_set_up())
    told = []
    for name in json.loads(os.environ["FAULTS"]) or FAULTS:
        fault = FAULTS[name]
        await rig.write("clear_counters", 1)
        before, cut = rig.monitor.frames, rig.cut
        rig.change()
        await fault.strike(rig)
        rig.change()
        await rig.shows(frames=16)
        recovered = rig.monitor.frames - before
        count = await rig.read(fault.counter)
        assert count > 0, f"{name}: {fault.counter} has not counted"
        if fault.counter.endswith(("_dropped", "_underflows")):
            assert int(dut.leds.value) >> 7 == 1
        if fault.kept:
            assert [await rig.read(f"{side}_dropped") for side in SIDES] == [0, 0]
        assert rig.cut - cut <= await rig.read("display_underflows")
        told.append({"fault": name, "counter": fault.counter, "count": count, "frames": recovered})
        dut._log.info("%s", told[-1])
    for name in ("decoder_state", "transmitter_state", "left_locked", "right_locked"):
        await rig.until_reads(name, 1)
    assert rig.decoder.is_set_up(0) and rig.decoder.is_set_up(1) and rig.transmitter.is_set_up()
    assert await rig.read("matcher_error") == 0

    # A camera that only the decoder misses; then the host has the chips set up again.
    rig.decoder.decoders[1].lock = 0
    await rig.until_reads("right_locked", 0)
    assert await rig.read("left_locked") == 1 and int(dut.leds.value) >> 2 & 3 == 0b01
    writes = len(rig.decoder.writes)
    await rig.write("restart_setup", 1)
    await rig.until_reads("decoder_state", 0)
    await rig.until_reads("decoder_state", 1)
    assert [write for write in rig.decoder.writes[writes:] if write == (0x7F, 0x00)] == 6 * [(0x7F, 0x00)]
    Path(os.environ["REPORT"]).write_text(json.dumps(told))
