"""The cocotb half of ``test_de2_115.py``: the pins of the DE2-115, whose system is the stand-in of :mod:`sim.models.loop_double`."""

import cocotb
import numpy as np

from sim.benches.loop_pins import LoopPins
from sim.kit.display_cases import SMALL_DISPLAY
from sim.models.loop_double import double_picture
from sim.models.monitor import Monitor


def pins(dut):
    return LoopPins(dut, "clk50_0__io", "button_0__io", pressed=0, half_ns=10)


@cocotb.test()
async def line_leds_and_reset(dut):
    """And no sync is added to green."""
    await pins(dut).check_line_leds_and_reset()
    assert int(dut.dac_0__sync_n__io.value) == 0


@cocotb.test()
async def picture_at_the_converter(dut):
    """What a strict monitor samples with the converter's clock is golden's picture; no pin changes at that clock's rising edge."""
    board = pins(dut)
    monitor = Monitor(SMALL_DISPLAY)
    clock, word = "", None

    def sample():
        nonlocal clock, word
        # The clock is "Z" during reset.
        clock_before, word_before, clock = clock, word, str(dut.dac_0__clk__io.value)
        blue, green, red, hsync, vsync = (int(getattr(dut, f"vga_0__{name}__io").value) for name in ("b", "g", "r", "hs", "vs"))
        word = blue | green << 8 | red << 16 | int(dut.dac_0__blank_n__io.value) << 24 | hsync << 25 | vsync << 26
        if (clock_before, clock) == ("0", "1"):
            assert word == word_before
            monitor.clock(word)

    board.press(False)
    await board.clocks(40)
    await board.clocks(int(2.3 * SMALL_DISPLAY.h_total * SMALL_DISPLAY.v_total), sample)
    assert monitor.frames >= 1
    np.testing.assert_array_equal(monitor.pictures[0], double_picture(SMALL_DISPLAY))
