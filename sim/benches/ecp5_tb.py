"""The cocotb half of ``test_ecp5.py``: the pins of a board with an ECP5, whose system is the stand-in of :mod:`sim.models.loop_double`."""

import cocotb
import numpy as np
from cocotb.triggers import Timer

from golden.config import MatcherConfig
from golden.video.side_by_side import side_by_side
from sim.kit.display_cases import SMALL_DISPLAY
from sim.models.dvi_receiver import DviReceiver
from sim.models.loop_double import double_pictures
from sim.models.monitor import Monitor


async def clocks(dut, count, sample=lambda: None):
    """Clock periods of the oscillator, whose clock the stand-ins of the PLLs repeat; ``sample`` is called in each of their halves."""
    for _ in range(count):
        for level in (1, 0):
            dut.clk25_0__io.value = level
            await Timer(4, unit="ns")
            sample()


def leds(dut):
    return sum(int(getattr(dut, f"led_{number}__io").value) << number for number in range(8))


@cocotb.test()
async def line_leds_and_reset(dut):
    """The line reaches the system and is driven by it; LEDs in their order; the button clears, and the ESP32 starts from its flash."""
    dut.button_fire_0__io.value = 0
    dut.uart_0__rx__io.value = 1
    await clocks(dut, 10)
    assert (int(dut.uart_0__tx__io.value), leds(dut), int(dut.esp32_0__gpio0__io.value)) == (1, 0, 1)
    for changes in range(1, 40):
        dut.uart_0__rx__io.value = 1 - changes % 2
        await clocks(dut, 2)
        assert (int(dut.uart_0__tx__io.value), leds(dut)) == (1 - changes % 2, changes)
    dut.button_fire_0__io.value = 1
    await clocks(dut, 3)
    assert leds(dut) == 0
    dut.button_fire_0__io.value = 0
    await clocks(dut, 5)


@cocotb.test()
async def picture_at_the_connector(dut):
    """What a strict receiver reads out of the four pairs is golden's picture."""
    receiver = DviReceiver(Monitor(SMALL_DISPLAY))

    def sample():
        receiver.bits(int(dut.hdmi_0__d__p.value) | int(dut.hdmi_0__clk__p.value) << 3)

    dut.button_fire_0__io.value = 0
    await clocks(dut, 40)
    await clocks(dut, int(5 * 1.3 * SMALL_DISPLAY.h_total * SMALL_DISPLAY.v_total), sample)
    assert receiver.monitor.frames == 1
    wanted = side_by_side(*double_pictures(MatcherConfig(4, 9), 6), SMALL_DISPLAY, 4)
    np.testing.assert_array_equal(receiver.monitor.pictures[0], wanted)
