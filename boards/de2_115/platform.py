"""Terasic's DE2-115, with an EP4CE115F29C7.

The pins of its HSMC connector, LEDs and buttons are supplied with 2.5 V, all others that are used with 3.3 V.
"""

from amaranth.build import Attrs, Clock, Pins, Resource, Subsignal
from amaranth_boards.resources import ButtonResources, LEDResources, UARTResource, VGAResource

from ..altera.check import Ball
from ..altera.pins import PinTable
from ..altera.platform import QuartusPlatform, quartus_settings


__all__ = ["BALLS", "CLOCK_BALLS", "DEVICE", "FAMILY", "OSCILLATOR_HZ", "De2115Platform"]


FAMILY = "Cyclone IV E"
DEVICE = "EP4CE115F29C7"

OSCILLATOR_HZ = 50_000_000

_PINS = PinTable(__package__)
_balls, _bus = _PINS.balls, _PINS.bus

#: Supply of all balls in the table.
BALLS = {row["ball"]: Ball(float(row["volts"])) for row in _PINS.rows}
#: Balls that reach the clock network: those with an oscillator.
CLOCK_BALLS = frozenset(("Y2",))


_V33 = Attrs(io_standard="3.3-V LVTTL")
_V25 = Attrs(io_standard="2.5 V")
_VGA = Attrs(io_standard="3.3-V LVTTL", fast_output_register="ON")


class De2115Platform(QuartusPlatform):
    """The board, with resources as in amaranth-boards.

    Resources
    ---------
    clk50
        Oscillator.
    led 0..7, button 0..3
        The green LEDs; a lit LED and a pressed button are 1.
    uart
        Two pins of the 40-pin header: ``rx`` is GPIO[0], ``tx`` is GPIO[1]. The board's RS-232 is too slow for pictures.
    vga
        Colours and sync signals of the VGA connector.
    dac
        Of the converter ADV7123: its clock, ``blank_n`` and ``sync_n``.
    hsmc 0
        The connector for the cards of :mod:`boards.altera.bitec`, but for its pins 33 and 34, whose balls are not known.
    """
    device, package, speed, suffix = "EP4CE115", "F29", "C7", ""
    default_clk = "clk50"
    resources = (
        Resource("clk50", 0, Pins(_balls("CLOCK_50"), dir="i"), Clock(OSCILLATOR_HZ), _V33),
        *LEDResources(pins=_bus("LEDG", 8), attrs=_V25),
        *ButtonResources(pins=_bus("KEY", 4), invert=True, attrs=_V25),
        UARTResource(0, rx=_balls("GPIO[0]"), tx=_balls("GPIO[1]"), attrs=_V33),
        VGAResource(0, r=_bus("VGA_R", 8), g=_bus("VGA_G", 8), b=_bus("VGA_B", 8), hs=_balls("VGA_HS"), vs=_balls("VGA_VS"), attrs=_VGA),
        Resource("dac", 0,
            Subsignal("clk", Pins(_balls("VGA_CLK"), dir="o"), _V33),
            Subsignal("blank_n", Pins(_balls("VGA_BLANK_N"), dir="o"), _VGA),
            Subsignal("sync_n", Pins(_balls("VGA_SYNC_N"), dir="o"), _V33)),
    )
    connectors = (_PINS.hsmc(0),)

    SETTINGS = quartus_settings(FAMILY, "2.5 V")
