"""The cocotb half of ``test_de2_115.py``: the pins of the DE2-115, whose system is the stand-in of :mod:`sim.models.loop_double`."""

import cocotb
import numpy as np
from cocotb.triggers import Timer

from golden.config import MatcherConfig
from golden.video.side_by_side import side_by_side
from sim.kit.display_cases import SMALL_DISPLAY
from sim.models.loop_double import double_pictures
from sim.models.monitor import Monitor


# Oscillator's half-period; the stand-ins of the PLLs repeat its clock.
HALF_NS = 10


async def clocks(dut, count, sample=lambda rising: None):
    """Clock periods of the oscillator; ``sample`` is called in each of their halves, with whether it began with a rising edge of the
    converter's clock, which is "Z" during reset.
    """
    before = ""
    for _ in range(count):
        for level in (1, 0):
            dut.clk50_0__io.value = level
            await Timer(HALF_NS, unit="ns")
            now = str(dut.dac_0__clk__io.value)
            sample((before, now) == ("0", "1"))
            before = now


def leds(dut):
    return sum(int(getattr(dut, f"led_{number}__io").value) << number for number in range(8))


@cocotb.test()
async def line_leds_and_reset(dut):
    """The line reaches the system and is driven by it; LEDs in their order, lit by 1; the button, active low, clears."""
    dut.button_0__io.value = 1
    dut.uart_0__rx__io.value = 1
    await clocks(dut, 10)
    assert (int(dut.uart_0__tx__io.value), leds(dut), int(dut.dac_0__sync_n__io.value)) == (1, 0, 0)
    for changes in range(1, 40):
        dut.uart_0__rx__io.value = 1 - changes % 2
        await clocks(dut, 2)
        assert (int(dut.uart_0__tx__io.value), leds(dut)) == (1 - changes % 2, changes)
    dut.button_0__io.value = 0
    await clocks(dut, 3)
    assert leds(dut) == 0
    dut.button_0__io.value = 1
    await clocks(dut, 5)


@cocotb.test()
async def picture_at_the_converter(dut):
    """What a strict monitor samples with the converter's clock is golden's picture; no pin changes at that clock's rising edge."""
    monitor = Monitor(SMALL_DISPLAY)
    before = None

    def sample(rising):
        nonlocal before
        vga = [int(getattr(dut, f"vga_0__{name}__io").value) for name in ("b", "g", "r", "hs", "vs")]
        blank_n = int(dut.dac_0__blank_n__io.value)
        blue, green, red, hsync, vsync = vga
        word = blue | green << 8 | red << 16 | blank_n << 24 | hsync << 25 | vsync << 26
        if rising:
            assert word == before
            monitor.clock(word)
        before = word

    dut.button_0__io.value = 1
    await clocks(dut, 40)
    await clocks(dut, int(2.3 * SMALL_DISPLAY.h_total * SMALL_DISPLAY.v_total), sample)
    assert monitor.frames >= 1
    wanted = side_by_side(*double_pictures(MatcherConfig(4, 9), 6), SMALL_DISPLAY, 4)
    np.testing.assert_array_equal(monitor.pictures[0], wanted)
