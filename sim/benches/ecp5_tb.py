"""The cocotb half of ``test_ecp5.py``: the pins of a board with an ECP5, whose system is the stand-in of :mod:`sim.models.loop_double`."""

import cocotb
import numpy as np

from sim.benches.loop_pins import LoopPins
from sim.kit.display_cases import SMALL_DISPLAY
from sim.models.dvi_receiver import DviReceiver
from sim.models.loop_double import double_picture
from sim.models.monitor import Monitor


def pins(dut):
    return LoopPins(dut, "clk25_0__io", "button_fire_0__io", pressed=1, half_ns=4)


@cocotb.test()
async def line_leds_and_reset(dut):
    """And the ESP32 starts from its flash."""
    await pins(dut).check_line_leds_and_reset()
    assert int(dut.esp32_0__gpio0__io.value) == 1


@cocotb.test()
async def picture_at_the_connector(dut):
    """What a strict receiver reads out of the four pairs is golden's picture."""
    board = pins(dut)
    receiver = DviReceiver(Monitor(SMALL_DISPLAY))

    def sample():
        receiver.bits(int(dut.hdmi_0__d__p.value) | int(dut.hdmi_0__clk__p.value) << 3)

    board.press(False)
    await board.clocks(40)
    await board.clocks(int(5 * 1.3 * SMALL_DISPLAY.h_total * SMALL_DISPLAY.v_total), sample)
    assert receiver.monitor.frames == 1
    np.testing.assert_array_equal(receiver.monitor.pictures[0], double_picture(SMALL_DISPLAY))
