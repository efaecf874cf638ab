"""The ULX3S as :mod:`boards.registry` lists it."""

from amaranth_boards.ulx3s import ULX3S_85F_Platform

from golden.video.formats import VGA

from ..ecp5.family import Target, loop_board
from ..ecp5.platform import LoopPlatform
from ..loop.top import Pin, Wiring


__all__ = ["BOARD", "Ulx3sPlatform"]


class Ulx3sPlatform(LoopPlatform, ULX3S_85F_Platform):
    """The board of amaranth-boards. The button FIRE 1 is the reset. GPIO0 of the ESP32 is high, so that it starts from its flash."""
    README = __package__
    WIRING = Wiring(
        clock=Pin("clk25"), clock_hz=25_000_000, reset=Pin("button_fire", 0), rx=Pin("uart", signal="rx"), tx=Pin("uart", signal="tx"),
        leds=tuple(Pin("led", number) for number in range(8)), dvi="hdmi", sdram="sdram",
        levels={Pin("esp32", signal="gpio0"): 1})


BOARD = loop_board("ulx3s", Ulx3sPlatform, Target("LFE5U-85F-6BG381C", "--85k", "CABGA381", "6", "38.8"), displays={"640x480": VGA})
