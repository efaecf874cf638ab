"""The ECPIX-5 as :mod:`boards.registry` lists it."""

from amaranth_boards.ecpix5 import ECPIX585Platform

from ..ecp5.family import Target, loop_board
from ..ecp5.platform import LoopPlatform
from ..loop.top import Pin, Wiring


__all__ = ["BOARD", "Ecpix5Platform"]


class Ecpix5Platform(LoopPlatform, ECPIX585Platform):
    """The board of amaranth-boards. The reset is its own; state is on the green and blue lights of the four LEDs."""
    README = __package__
    WIRING = Wiring(
        clock=Pin("clk100"), clock_hz=100_000_000, reset=Pin("rst"), rx=Pin("uart", signal="rx"), tx=Pin("uart", signal="tx"),
        leds=tuple(Pin("rgb_led", number, colour) for colour in ("g", "b") for number in range(4)))


BOARD = loop_board("ecpix5", Ecpix5Platform, Target("LFE5UM5G-85F-8BG554", "--um5g-85k", "CABGA554", "8", "38.8"))
