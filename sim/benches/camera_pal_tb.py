"""The cocotb half of the long test in ``test_camera.py``: a frame at full size into a consumer with the longest permitted stalls."""

import random

import cocotb
import numpy as np
from cocotb.triggers import ClockCycles, RisingEdge

from golden.video.bt656 import clip, encode
from golden.video.formats import PAL
from hdl.video.bt656 import CameraInput
from sim.benches.camera_tb import PERIODS, SYNC_PERIOD, counters, start, words_of
from sim.kit.cocotb_streams import check_rules
from sim.models.camera import frames_of, play_cocotb


async def stalls(dut, cycles):
    """Stalls that the FIFO bridges, with pauses in which it drains: a line has 4800 clocks."""
    rng = random.Random(1)
    while True:
        dut.o_ready.value = 1
        await ClockCycles(dut.clk, 1000 + rng.randrange(4000))
        dut.o_ready.value = 0
        await ClockCycles(dut.clk, cycles)


@cocotb.test()
async def frame(dut):
    await start(dut)
    picture = np.random.default_rng(1).integers(0, 256, (PAL.height, PAL.width))
    transfers = []
    cocotb.start_soon(check_rules(dut, "o", transfers))
    cocotb.start_soon(stalls(dut, CameraInput.stall_cycles(PAL, 512, 1e12 / SYNC_PERIOD)))
    await play_cocotb(dut.camera_clk, dut.data, encode(picture, PAL).tolist(), period=PERIODS[0])
    await RisingEdge(dut.clk)
    (received,) = frames_of(words_of(transfers), PAL)
    assert np.array_equal(received, clip(picture))
    assert set(counters(dut).values()) == {0}
    assert dut.present.value == 1
