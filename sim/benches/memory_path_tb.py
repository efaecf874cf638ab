"""The cocotb half of ``test_memory_path.py``: pictures through the memory, all masters at work."""

import json
import os
import random

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge

from golden.config import MatcherConfig
from golden.video.memory_map import MemoryMap
from hdl.matcher.stream import PixelPair
from hdl.video.words import CameraWord, PlanePixel, ShownPixel
from sim.kit.cases import comparable, noise, pixel_words
from sim.kit.cocotb_streams import check_rules, drain, sink, source
from sim.kit.payloads import pack
from sim.kit.video_cases import camera_words, plane_words, shown_words
from sim.models.cocotb_ddr2 import serve
from sim.models.ddr2 import Ddr2Timing, LocalMemory


WIDTH, HEIGHT, SIZE, DEPTH = json.loads(os.environ["PATH_SIZE"])
INPUTS = os.environ["INPUTS"].split()
CONFIG = MatcherConfig(labels=256)
FRAMES = 3


async def until(dut, name, member):
    """Wait for a pulse."""
    for _ in range(50_000):
        await ReadOnly()
        pulse = int(getattr(dut, f"{name}_{member}").value)
        await RisingEdge(dut.clk)
        if pulse:
            return
    raise TimeoutError(f"{name}: no {member}")


async def write(dut, name, layout, words, buffer, seed, stall):
    """A picture into a buffer, until the memory has it."""
    getattr(dut, f"{name}_control_buffer").value = buffer
    getattr(dut, f"{name}_control_accept").value = 1
    sender = cocotb.start_soon(source(dut, f"{name}_i", [pack(layout, word) for word in words], rng=random.Random(seed), stall=stall))
    await until(dut, name, "control_complete")
    await sender


async def read(dut, name, layout, count, stall):
    return [comparable(word, layout) for word in await sink(dut, f"{name}_o", count, rng=random.Random(count), stall=stall)]


async def pulse(dut, name):
    getattr(dut, name).value = 1
    await RisingEdge(dut.clk)
    getattr(dut, name).value = 0


@cocotb.test()
@cocotb.parametrize(stall=[0.0, 0.4])
async def pictures_there_and_back(dut, stall):
    """Each turn the cameras fill one pair of buffers while the other is read, its results are written and the ones before are shown."""
    for name in INPUTS:
        getattr(dut, name).value = 0
    memory_map = MemoryMap(WIDTH, HEIGHT)
    memory = LocalMemory(memory_map.total_words, size=SIZE, timing=Ddr2Timing(busy=0.4, refresh=(300, 20), stalls=((500, 300),)))
    cocotb.start_soon(Clock(dut.clk, 10, "ns").start())
    dut.rst.value = 1
    await ClockCycles(dut.clk, 3)
    dut.rst.value = 0
    cocotb.start_soon(serve(dut, "bus", memory))
    for stream in ("left_i", "right_i", "disparity_i", "shown_left_i", "pair_o", "shown_o"):
        cocotb.start_soon(check_rules(dut, stream))

    pictures = [noise(WIDTH, HEIGHT, number) for number in range(FRAMES)]
    results = [noise(WIDTH, HEIGHT, 100 + number) for number in range(FRAMES)]
    pixels = WIDTH * HEIGHT
    for turn in range(FRAMES + 2):
        tasks = []
        if turn < FRAMES:
            left, right = pictures[turn]
            tasks += [cocotb.start_soon(write(dut, "left", CameraWord(), camera_words(left), turn % 2, turn, stall)),
                      cocotb.start_soon(write(dut, "right", CameraWord(), camera_words(right), turn % 2, turn + 50, stall))]
        pair = shown = None
        if 0 <= (number := turn - 1) < FRAMES:
            dut.pair_control_left_buffer.value = dut.pair_control_right_buffer.value = number % 2
            await pulse(dut, "pair_control_start")
            pair = cocotb.start_soon(read(dut, "pair", PixelPair(), pixels, stall))
            done = cocotb.start_soon(until(dut, "pair", "control_done"))
            disparity, left = results[number]
            tasks += [done, cocotb.start_soon(write(dut, "disparity", PlanePixel(), plane_words(disparity), number % 2, turn + 20, stall)),
                      cocotb.start_soon(write(dut, "shown_left", PlanePixel(), plane_words(left), number % 2, turn + 30, stall))]
        if 0 <= (slot := turn - 2) < FRAMES:
            await pulse(dut, "shown_fetch")
            dut.shown_shown_valid.value, dut.shown_shown_buffer.value = 1, slot % 2
            await RisingEdge(dut.clk)
            dut.shown_shown_valid.value = 0
            shown = cocotb.start_soon(read(dut, "shown", ShownPixel(CONFIG), pixels, stall))
        for task in tasks:
            await task
        if pair:
            assert await pair == pixel_words(*pictures[number])
        if shown:
            assert await shown == shown_words(*results[slot])
    assert await drain(dut, "pair_o") == await drain(dut, "shown_o") == []
    assert memory.words_written == memory.words_read == 4 * FRAMES * HEIGHT * memory_map.line_words
    for name in ("left", "right", "disparity", "shown_left", "pair", "shown"):
        fill = int(getattr(dut, f"{name}_fill").value)
        dut._log.info("%s: %d of %d words at most", name, fill, DEPTH)
        assert 0 < fill <= DEPTH
    assert np.all([int(getattr(dut, f"{name}_skipped").value) == 0 for name in ("left", "right", "disparity", "shown_left")])
