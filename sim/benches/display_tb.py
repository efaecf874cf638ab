"""The cocotb half of ``test_display.py``: a picture reader at one side of the display, a monitor at the other."""

import os
import random

import cocotb
import numpy as np
from cocotb.clock import Clock
from cocotb.triggers import ClockCycles, ReadOnly, RisingEdge

from golden.config import MatcherConfig
from hdl.video.words import ShownPixel
from sim.kit.display_cases import FORMATS, Fetch, shown_pictures, shown_words
from sim.kit.payloads import pack
from sim.models.monitor import PINS, Monitor, watch_cocotb


DISPLAY = FORMATS[os.environ["DISPLAY_FORMAT"]]
SIZE = tuple(int(pixels) for pixels in os.environ["SIZE"].split())
LABELS = int(os.environ["DISPARITIES"])
LAYOUT = ShownPixel(MatcherConfig(labels=LABELS))
SYNC_HZ = 75_000_000
FRAME = DISPLAY.h_total * DISPLAY.v_total * SYNC_HZ // DISPLAY.pixel_clock_hz   # cycles


async def start(dut):
    """Clocks, resets that are released at different times; all inputs are 0."""
    for name in os.environ["INPUTS"].split():
        getattr(dut, name).value = 0
    dut.rst.value = 1
    dut.display_rst.value = 1
    for clock, hertz in ((dut.clk, SYNC_HZ), (dut.display_clk, DISPLAY.pixel_clock_hz)):
        # A clock driven by C++; half a period is a whole number of picoseconds.
        cocotb.start_soon(Clock(clock, 2 * round(0.5e12 / hertz), "ps", impl="gpi").start())
    await ClockCycles(dut.display_clk, 4)
    dut.rst.value = 0
    await ClockCycles(dut.display_clk, 3)
    dut.display_rst.value = 0


async def read_pictures(dut, plan):
    """Reply to each fetch with the next entry of ``plan``, which has the settings too; they change between fetches."""
    rng = random.Random(1)
    dut.mode.value, dut.colour.value = plan[0][0]
    await RisingEdge(dut.fetch)
    for number, (_, entry) in enumerate(plan):
        await RisingEdge(dut.clk)
        dut.i_valid.value = 0
        dut.shown_valid.value = entry.shown_valid
        await RisingEdge(dut.clk)
        dut.shown_valid.value = not entry.shown_valid
        dut.mode.value, dut.colour.value = plan[(number + 1) % len(plan)][0]
        fetch = False
        for word, idle in entry.offers(rng):
            if idle > 1:
                dut.i_valid.value = 0
                await ClockCycles(dut.clk, idle - 1)
            dut.i_payload.value = pack(LAYOUT, word)
            dut.i_valid.value = 1
            accepted = False
            while not accepted:
                await ReadOnly()
                accepted, fetch = dut.i_ready.value == 1, dut.fetch.value == 1
                if fetch:
                    break
                await RisingEdge(dut.clk)
            if fetch:
                break
        else:
            dut.i_valid.value = 0
            await RisingEdge(dut.fetch)


async def show(dut, plan):
    """The monitor's pictures and the counters must be those of the plan."""
    await start(dut)
    monitor = Monitor(DISPLAY)
    cocotb.start_soon(watch_cocotb(monitor, dut.display_clk, {name: getattr(dut, name) for name in PINS}))
    cocotb.start_soon(read_pictures(dut, plan))
    while monitor.frames < len(plan):
        await ClockCycles(dut.display_clk, DISPLAY.h_total)
    for number, (((mode, colour), entry), picture) in enumerate(zip(plan, monitor.pictures)):
        np.testing.assert_array_equal(picture, entry.picture(DISPLAY, mode, colour, LABELS), f"frame {number}")
    # There was one more fetch after the last frame.
    assert dut.frames.value == len(plan) + 1
    assert dut.underflows.value == sum(entry.underflow for _, entry in plan)


def pair(seed):
    return shown_pictures(*SIZE, LABELS, seed)


def modes():
    """Full rate; a frame for each mode, in grey or in colour, of ``MODES``: ``mode colour`` for each."""
    numbers = [int(number) for number in os.environ["MODES"].split()]
    return [(setting, Fetch(pair(seed))) for seed, setting in enumerate(zip(numbers[::2], numbers[1::2]))]


def faults():
    """Pictures with a long pause, without a word, without ``shown_valid``, and cut; each is followed by a complete one."""
    half = (SIZE[1] // 2) * SIZE[0] + 3
    entries = [
        Fetch(pair(0), in_time=half, pause=(half, FRAME // 3)), Fetch(pair(1)), Fetch(pair(2), in_time=0, words=[]),
        Fetch(pair(3), stall=0.3), Fetch(pair(4), shown_valid=False), Fetch(pair(5)),
        Fetch(pair(6), in_time=50, words=shown_words(*pair(6))[:50]), Fetch(pair(7)),
    ]
    return [((0, 1), entry) for entry in entries]


@cocotb.test(timeout_time=1, timeout_unit="sec")
async def display(dut):
    await show(dut, modes() if os.environ["MODES"] else faults())
