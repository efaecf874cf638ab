"""The cocotb half of ``test_camera.py``: frames with each fault into the emitted receiver."""

import random

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, Timer

from hdl.video.words import CameraWord
from sim.benches.camera import FORMAT
from sim.kit.cases import comparable
from sim.kit.cocotb_streams import check_rules, drain, sink
from sim.models.camera import FAULTS, Camera, frames_of, play_cocotb


# Picoseconds: 27 MHz, a camera 100 ppm slower, and 75 MHz.
PERIODS = [37_037, 37_041]
SYNC_PERIOD = 13_334


async def start(dut):
    for name in ("o_ready", "clear", "data", "camera_clk"):
        getattr(dut, name).value = 0
    dut.rst.value = dut.camera_rst.value = 1
    cocotb.start_soon(Clock(dut.clk, SYNC_PERIOD, "ps").start())
    await play_cocotb(dut.camera_clk, dut.data, [0x10] * 4, period=PERIODS[0])
    dut.rst.value = dut.camera_rst.value = 0
    await ClockCycles(dut.clk, 3)


def counters(dut):
    return {name: getattr(dut, name).value.to_unsigned() for name in ("corrected", "rejected", "dropped", "overflow")}


def words_of(transfers):
    return [comparable(word, CameraWord()) for word in transfers]


def pictures(count):
    return np.random.default_rng(1).integers(0, 256, (count, FORMAT.height, FORMAT.width))


async def show(dut, data, *, period, stall):
    """Play bytes; return every word that left until some time after the last one."""
    transfers = []
    checker = cocotb.start_soon(check_rules(dut, "o", transfers))
    consumer = cocotb.start_soon(sink(dut, "o", 10**9, rng=random.Random(1), stall=stall))
    await play_cocotb(dut.camera_clk, dut.data, data, period=period, phase=period // 5)
    await Timer(100 * SYNC_PERIOD, "ps")
    consumer.cancel()
    checker.cancel()
    return words_of(transfers)


async def drain_while_the_clock_runs(dut):
    """A full FIFO has room again, is clocked by the camera, and accepts the drop word."""
    camera = cocotb.start_soon(play_cocotb(dut.camera_clk, dut.data, [0x10] * 60, period=PERIODS[0]))
    words = await drain(dut, "o", clocks=100)
    await camera
    return words


@cocotb.test()
@cocotb.parametrize((("period", "stall"), list(zip(PERIODS, (0.5, 0.0)))))
async def faults(dut, period, stall):
    """Every fault between good frames; each is counted, and every other frame is exact."""
    await start(dut)
    names = list(FAULTS)
    data, expected = Camera(FORMAT, seed=2).film(pictures(2 * len(names) + 1), {2 * n + 1: name for n, name in enumerate(names)})
    frames = frames_of(await show(dut, data, period=period, stall=stall), FORMAT)
    assert [frame.tolist() for frame in frames if frame is not None] == [picture.tolist() for picture in expected]
    counted = counters(dut)
    assert counted["corrected"] >= 2 * FORMAT.frame_lines
    assert counted["rejected"] >= 1
    assert counted["dropped"] >= sum(not fault.kept for fault in FAULTS.values())
    assert counted["overflow"] == 0
    assert dut.present.value == 1
    dut.clear.value = 1
    await ClockCycles(dut.clk, 2)
    assert set(counters(dut).values()) == {0}


@cocotb.test()
async def overflow(dut):
    """``ready`` is low for two frames: the first is cut, the second lost, the third bit-exact."""
    await start(dut)
    camera = Camera(FORMAT)
    data, expected = camera.film(pictures(3))
    await play_cocotb(dut.camera_clk, dut.data, data[:2 * FORMAT.frame_bytes], period=PERIODS[0])
    assert counters(dut) == {"corrected": 0, "rejected": 0, "dropped": 1, "overflow": 2}
    held = frames_of(words_of(await drain_while_the_clock_runs(dut)), FORMAT)
    assert held == [None]
    frames = frames_of(await show(dut, data[2 * FORMAT.frame_bytes:], period=PERIODS[0], stall=0.0), FORMAT)
    assert [frame.tolist() for frame in frames] == [expected[2].tolist()]
    assert counters(dut) == {"corrected": 0, "rejected": 0, "dropped": 2, "overflow": 2}


@cocotb.test()
async def clock_stops(dut):
    """In mid-frame and for good: the frame is dropped, ``present`` falls."""
    await start(dut)
    data, expected = Camera(FORMAT).film(pictures(2))
    cut = FORMAT.frame_bytes + (FORMAT.before_top + 1) * FORMAT.line_bytes
    transfers = []
    cocotb.start_soon(check_rules(dut, "o", transfers))
    cocotb.start_soon(sink(dut, "o", 10**9, rng=random.Random(1)))
    await play_cocotb(dut.camera_clk, dut.data, data[:cut], period=PERIODS[0])
    assert dut.present.value == 1
    await ClockCycles(dut.clk, 350)
    assert dut.present.value == 0
    whole, dropped = frames_of(words_of(transfers), FORMAT)
    assert whole.tolist() == expected[0].tolist()
    assert dropped is None
    assert counters(dut)["dropped"] == 1
