"""Altera Cyclone III development board (EP3C120F780C7) with Bitec's DVI card on HSMC A and its Quad Video card on HSMC B.

Banks 1, 2, 5 and 6 of the device, with both HSMC connectors, are supplied with 2.5 V, which is compatible with the cards' 3.3 V LVTTL.
Banks 3, 4, 7 and 8, with memory, LEDs, buttons and oscillators, are supplied with 1.8 V.
"""

import csv
from importlib import resources
from typing import Any

from amaranth import Module
from amaranth.build import Attrs, Clock, Connector, Pins, PinsN, Resource, Subsignal
from amaranth.build.run import BuildPlan
from amaranth.hdl import Fragment
from amaranth.lib.cdc import AsyncFFSynchronizer, FFSynchronizer
from amaranth.vendor import AlteraPlatform

from ..environment import no_overrides
from .synchronizers import async_ff_synchronizer, ff_synchronizer


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

with resources.files(__package__).joinpath("pins.csv").open(encoding="utf-8") as _file:
    _PINS = {row["signal"]: row for row in csv.DictReader(line for line in _file if not line.startswith("#"))}

#: Ball to I/O bank, of all balls in the table.
BALLS = {row["ball"]: int(row["bank"]) for row in _PINS.values()}
#: I/O bank to its supply.
BANK_VOLTS = {1: 2.5, 2: 2.5, 3: 1.8, 4: 1.8, 5: 2.5, 6: 2.5, 7: 1.8, 8: 1.8}
#: Balls that reach the clock network: those that Quartus reports as dedicated inputs.
CLOCK_BALLS = frozenset(("A14", "A15", "B14", "B15", "AG14", "AG15", "AH14", "AH15", "J1", "J2", "J27", "J28", "Y1", "Y2", "Y27", "Y28"))


def _pins(*signals: str, dir: str, cls: type = Pins) -> Pins:
    """Balls of signals of the board itself."""
    return cls(" ".join(_PINS[signal]["ball"] for signal in signals), dir=dir)


def _card(*signals: str, dir: str) -> Pins:
    """Pins of the connector that carries these signals of a card."""
    pins = [_PINS[signal]["hsmc"] for signal in signals]
    return Pins(" ".join(pin[1:] for pin in pins), dir=dir, conn=("hsmc", "AB".index(pins[0][0])))


def _bus(signal: str, width: int, first: int = 0) -> list[str]:
    return [f"{signal}[{bit}]" for bit in range(first, first + width)]


_V18 = Attrs(io_standard="1.8 V")
_V25 = Attrs(io_standard="2.5 V")
# As in the script that Altera generates for this controller on this board: strong outputs for commands, 12 mA for point-to-point signals.
# Data, strobes and masks share an output enable group: without it the fitter refuses bidirectional pins so close to the reference voltage.
_COMMAND = Attrs(io_standard="SSTL-18 CLASS I", current_strength_new="MAXIMUM CURRENT")
_STROBE  = Attrs(io_standard="SSTL-18 CLASS I", current_strength_new="12MA")
_DATA    = Attrs(io_standard="SSTL-18 CLASS I", current_strength_new="12MA", output_enable_group="1")
_INPUT_REGISTER  = Attrs(fast_input_register="ON")
_OUTPUT_REGISTER = Attrs(fast_output_register="ON")
_PULL_UP = Attrs(weak_pull_up_resistor="ON")


def _camera(number: int, channel: int) -> Resource:
    """A channel of the video decoder: eight bits at each rising edge of the channel's clock."""
    prefix = f"BITEC_QV_CH{channel}_IN_"
    return Resource("camera", number,
        Subsignal("clk", _card(f"{prefix}CLK", dir="i"), Clock(27e6)),
        Subsignal("data", _card(*_bus(f"{prefix}D", 8), dir="i"), _INPUT_REGISTER),
        _V25)


def _dvi() -> Resource:
    """The DVI transmitter: pixels, levels that configure it, and its I2C bus."""
    prefix = "BITEC_DVI_IO_OUT"
    return Resource("dvi", 0,
        Subsignal("clk", _card(f"{prefix}_IDCKp", dir="o")),
        Subsignal("clk_n", _card(f"{prefix}_IDCKn", dir="o")),
        *[Subsignal(name, _card(*_bus(prefix, 8, first), dir="o"), _OUTPUT_REGISTER)
          for name, first in (("blue", 0), ("green", 8), ("red", 16))],
        *[Subsignal(name.lower(), _card(f"{prefix}_{name}", dir="o"), _OUTPUT_REGISTER) for name in ("DE", "HSYNC", "VSYNC")],
        Subsignal("power_up", _card(f"{prefix}_DVI_PD", dir="o")),
        Subsignal("isel", _card(f"{prefix}_DVI_ISEL", dir="o")),
        Subsignal("dken", _card(f"{prefix}_DVI_DKEN", dir="o")),
        Subsignal("ctl", _card(*(f"{prefix}_DVI_CTL{n}" for n in (1, 2, 3)), dir="o")),
        Subsignal("scl", _card(f"{prefix}_DVI_CLK", dir="io"), _PULL_UP),
        Subsignal("sda", _card(f"{prefix}_DVI_DAT", dir="io"), _PULL_UP),
        _V25)


class Cyclone3Platform(AlteraPlatform):
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
        Resource("clk50", 0, _pins("clkin_50", dir="i"), Clock(OSCILLATOR_HZ), _V18),
        Resource("rst", 0, _pins("cpu_resetn", dir="i", cls=PinsN), _V25),
        *[Resource("led", n, _pins(f"user_led[{n}]", dir="o", cls=PinsN), _V18) for n in range(8)],
        *[Resource("button", n, _pins(f"user_pb[{n}]", dir="i", cls=PinsN), _V18) for n in range(4)],
        *[Resource("switch", n, _pins(f"user_dipsw[{n}]", dir="i"), _V18) for n in range(8)],
        _camera(0, 1),
        _camera(1, 2),
        Resource("decoder", 0,
            Subsignal("reset_n", _card("BITEC_QV_RESETB", dir="o")),
            Subsignal("powerdown_n", _card("BITEC_QV_PDN", dir="o")),
            Subsignal("scl", _card("BITEC_QV_TVP5154_SCL", dir="io"), _PULL_UP),
            Subsignal("sda", _card("BITEC_QV_TVP5154_SDA", dir="io"), _PULL_UP),
            _V25),
        _dvi(),
        Resource("ddr2", 0,
            Subsignal("clk", _pins("ddr2_ck_p[0]", dir="io"), Attrs(pad_to_core_delay="0"), _STROBE),
            Subsignal("clk_n", _pins("ddr2_ck_n[0]", dir="io"), _STROBE),
            *[Subsignal(name, _pins(f"ddr2bot_{signal}", dir="o"), _COMMAND)
              for name, signal in (("cke", "cke"), ("cs_n", "csn"), ("ras_n", "rasn"), ("cas_n", "casn"), ("we_n", "wen"), ("odt", "odt"))],
            Subsignal("addr", _pins(*_bus("ddr2bot_a", 13), dir="o"), _COMMAND),
            Subsignal("ba", _pins(*_bus("ddr2bot_ba", 2), dir="o"), _COMMAND),
            Subsignal("dq", _pins(*_bus("ddr2_dq", 32), dir="io"), _DATA),
            Subsignal("dqs", _pins(*_bus("ddr2_dqs", 4), dir="io"), _DATA),
            Subsignal("dm", _pins(*_bus("ddr2_dm", 4), dir="o"), _DATA)),
        Resource("uart", 0,
            Subsignal("rx", _pins("clkin_sma", dir="i")),
            Subsignal("tx", _pins("clkout_sma", dir="o")),
            _V18),
    )
    connectors = tuple(
        Connector("hsmc", number, {row["hsmc"][1:]: row["ball"] for row in _PINS.values() if row["hsmc"].startswith(letter)})
        for number, letter in enumerate("AB"))

    #: Settings of every project for this board.
    SETTINGS = (
        f'set_global_assignment -name FAMILY "{FAMILY}"',
        'set_global_assignment -name STRATIX_DEVICE_IO_STANDARD "2.5 V"',
        # Unused balls are connected to chips that drive them: they must be inputs.
        'set_global_assignment -name RESERVE_ALL_UNUSED_PINS_WEAK_PULLUP "AS INPUT TRI-STATED WITH WEAK PULL-UP"',
        # As in the projects of the kit: there is no other device in the configuration chain.
        'set_global_assignment -name CYCLONEII_RESERVE_NCEO_AFTER_CONFIGURATION "USE AS REGULAR IO"',
        # The device has room for logic, and the matcher needs its clock. For this family the setting has the name of Cyclone II.
        "set_global_assignment -name CYCLONEII_OPTIMIZATION_TECHNIQUE SPEED",
        # Delays stay in registers, as hdl.resources counts them: in memory they would take blocks that the pictures' lines need.
        "set_global_assignment -name AUTO_SHIFT_REGISTER_RECOGNITION OFF",
    )

    def get_ff_sync(self, ff_sync: FFSynchronizer) -> Module:
        return ff_synchronizer(ff_sync)

    def get_async_ff_sync(self, async_ff_sync: AsyncFFSynchronizer) -> Module:
        return async_ff_synchronizer(async_ff_sync)

    def toolchain_prepare(self, fragment: Fragment, name: str, *, add_settings: str = "", **kwargs: Any) -> BuildPlan:
        with no_overrides():
            plan = super().toolchain_prepare(fragment, name, add_settings="\n".join([*self.SETTINGS, add_settings]), **kwargs)
        plan.add_file(f"{name}.qpf", f'QUARTUS_VERSION = "13.1"\nPROJECT_REVISION = "{name}"\n')
        return plan
