"""Altera Cyclone III development board (EP3C120F780C7) with Bitec's DVI card on HSMC A and its Quad Video card on HSMC B.

Banks 1, 2, 5 and 6 of the device, with both HSMC connectors, are supplied with 2.5 V, which is compatible with the cards' 3.3 V LVTTL.
Banks 3, 4, 7 and 8, with memory, LEDs, buttons and oscillators, are supplied with 1.8 V.
"""

from amaranth.build import Attrs, Clock, Pins, PinsN, Resource, Subsignal
from amaranth_boards.resources import ButtonResources, LEDResources, SwitchResources, UARTResource

from ..altera.bitec import dvi_card, quad_video_card
from ..altera.pins import PinTable
from ..altera.platform import QuartusPlatform, quartus_settings


__all__ = [
    "BALLS", "BANK_VOLTS", "CLOCK_BALLS", "DEVICE", "FAMILY", "LOCAL_CLOCKS_MHZ", "MEMORY_CLOCK_MHZ", "OSCILLATOR_HZ", "Cyclone3Platform",
]


FAMILY = "Cyclone III"
DEVICE = "EP3C120F780C7"

OSCILLATOR_HZ = 50_000_000

#: Clocks that the memory can run at, to that of the controller's local interface: half of it, for which the device allows 83 MHz.
LOCAL_CLOCKS_MHZ: dict[int, float] = {125: 62.5, 150: 75}
#: Which of them the memory has, unless another one is chosen.
MEMORY_CLOCK_MHZ = 150

_PINS = PinTable(__package__)
_balls, _bus = _PINS.balls, _PINS.bus

#: Ball to I/O bank, of all balls in the table.
BALLS = {row["ball"]: int(row["bank"]) for row in _PINS.rows}
#: I/O bank to its supply.
BANK_VOLTS = {1: 2.5, 2: 2.5, 3: 1.8, 4: 1.8, 5: 2.5, 6: 2.5, 7: 1.8, 8: 1.8}
#: Balls that reach the clock network: those that Quartus reports as dedicated inputs.
CLOCK_BALLS = frozenset(("A14", "A15", "B14", "B15", "AG14", "AG15", "AH14", "AH15", "J1", "J2", "J27", "J28", "Y1", "Y2", "Y27", "Y28"))


_V18 = Attrs(io_standard="1.8 V")
_V25 = Attrs(io_standard="2.5 V")
# As in the script that Altera generates for this controller on this board: strong outputs for commands, 12 mA for point-to-point signals.
# Data, strobes and masks share an output enable group: without it the fitter refuses bidirectional pins so close to the reference voltage.
_COMMAND = Attrs(io_standard="SSTL-18 CLASS I", current_strength_new="MAXIMUM CURRENT")
_STROBE  = Attrs(io_standard="SSTL-18 CLASS I", current_strength_new="12MA")
_DATA    = Attrs(io_standard="SSTL-18 CLASS I", current_strength_new="12MA", output_enable_group="1")


class Cyclone3Platform(QuartusPlatform):
    """The board and its two cards, with resources as in amaranth-boards.

    Resources
    ---------
    clk50, rst
        Oscillator; the button CPU_RESET.
    led 0..7, button 0..3, switch 0..7
        A lit LED, a pressed button and an open switch are 1.
    camera 0, 1
        Channels 1 and 2 of the video decoder: left and right.
    decoder
        Reset and power-down of the video decoder TVP5154, both active low, and its I2C bus.
    dvi
        DVI transmitter TFP410.
    ddr2
        The bottom memory: two MT47H32M16CC-3, 32 bits, 128 MB.
    uart
        The two SMA connectors. The board has no RS-232; these are the only free pins with connectors, since the cards occupy both HSMC
        connectors. ``tx`` is CLKOUT_SMA, ``rx`` is CLKIN_SMA, a clock input that drives nothing else. Both are 1.8 V.
    """
    device, package, speed, suffix = "EP3C120", "F780", "C7", ""
    default_clk, default_rst = "clk50", "rst"
    resources = (
        Resource("clk50", 0, Pins(_balls("clkin_50"), dir="i"), Clock(OSCILLATOR_HZ), _V18),
        Resource("rst", 0, PinsN(_balls("cpu_resetn"), dir="i"), _V25),
        *LEDResources(pins=_bus("user_led", 8), invert=True, attrs=_V18),
        *ButtonResources(pins=_bus("user_pb", 4), invert=True, attrs=_V18),
        *SwitchResources(pins=_bus("user_dipsw", 8), attrs=_V18),
        *quad_video_card(1, [1, 2], _V25),
        dvi_card(0, _V25),
        # The package has no helper for DDR2: that of DDR3 wants a reset and differential strobes.
        Resource("ddr2", 0,
            Subsignal("clk", Pins(_balls("ddr2_ck_p[0]"), dir="io"), Attrs(pad_to_core_delay="0"), _STROBE),
            Subsignal("clk_n", Pins(_balls("ddr2_ck_n[0]"), dir="io"), _STROBE),
            *[Subsignal(name, Pins(_balls(f"ddr2bot_{signal}"), dir="o"), _COMMAND)
              for name, signal in (("cke", "cke"), ("cs_n", "csn"), ("ras_n", "rasn"), ("cas_n", "casn"), ("we_n", "wen"), ("odt", "odt"))],
            Subsignal("addr", Pins(_bus("ddr2bot_a", 13), dir="o"), _COMMAND),
            Subsignal("ba", Pins(_bus("ddr2bot_ba", 2), dir="o"), _COMMAND),
            Subsignal("dq", Pins(_bus("ddr2_dq", 32), dir="io"), _DATA),
            Subsignal("dqs", Pins(_bus("ddr2_dqs", 4), dir="io"), _DATA),
            Subsignal("dm", Pins(_bus("ddr2_dm", 4), dir="o"), _DATA)),
        UARTResource(0, rx=_balls("clkin_sma"), tx=_balls("clkout_sma"), attrs=_V18),
    )
    connectors = tuple(_PINS.hsmc(number, letter) for number, letter in enumerate("AB"))

    SETTINGS = quartus_settings(FAMILY, "2.5 V")
