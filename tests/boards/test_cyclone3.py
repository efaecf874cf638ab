import os

import pytest
from amaranth import *
from amaranth.hdl import Elaboratable
from amaranth.lib import io

from boards.cyclone3 import platform as cyclone3
from boards.cyclone3.platform import BALLS, BANK_VOLTS, CLOCK_BALLS, Cyclone3Platform


RESOURCES = [(resource.name, resource.number) for resource in Cyclone3Platform.resources]


def pins_of(port):
    """All (ball, attributes) of a requested resource."""
    if isinstance(port, io.SingleEndedPort):
        return [(pin.name, pin.attrs) for pin in port.io.metadata]
    return [pin for part in vars(port).values() for pin in pins_of(part)]


def balls(name, number=0, part=None):
    port = Cyclone3Platform().request(name, number, dir="-")
    return [ball for ball, _ in pins_of(getattr(port, part) if part else port)]


def test_no_two_resources_share_a_pin_and_no_pin_is_idle():
    """Amaranth refuses a pin that is used twice. A row of the table that no resource uses would be a mistake."""
    platform = Cyclone3Platform()
    used = [ball for name, number in RESOURCES for ball, _ in pins_of(platform.request(name, number, dir="-"))]
    assert sorted(used) == sorted(BALLS)
    assert len(used) == 8 + 4 + 8 + 2 + 2 * 9 + 4 + (2 + 24 + 3 + 6 + 2) + (2 + 6 + 13 + 2 + 32 + 4 + 4) + 2


def test_device():
    assert cyclone3.DEVICE == "".join((Cyclone3Platform.device, Cyclone3Platform.package, Cyclone3Platform.speed, Cyclone3Platform.suffix))


@pytest.mark.parametrize("resource", [
    (("clk50",), ["AH15"]), (("rst",), ["T21"]), (("led", 0), ["AD15"]), (("button", 3), ["AA12"]), (("switch", 0), ["AC14"]),
    (("camera", 0, "clk"), ["Y28"]), (("camera", 1, "clk"), ["Y27"]),
    (("camera", 0, "data"), ["AC28", "W21", "AC27", "V21", "AB28", "Y22", "AB27", "W22"]),
    (("decoder", 0, "reset_n"), ["AD27"]), (("decoder", 0, "powerdown_n"), ["AD28"]),
    (("decoder", 0, "scl"), ["H25"]), (("decoder", 0, "sda"), ["H26"]),
    (("dvi", 0, "clk"), ["G6"]), (("dvi", 0, "blue"), ["C2", "D3", "F3", "E3", "F1", "F2", "G3", "G4"]),
    (("dvi", 0, "red"), ["L3", "L4", "N3", "N4", "L6", "L7", "M1", "M2"]), (("dvi", 0, "ctl"), ["G2", "K7", "J7"]),
    (("ddr2", 0, "clk"), ["AE14"]), (("ddr2", 0, "dqs"), ["AE18", "AF17", "AF11", "AE10"]),
])
def test_balls_from_the_manual(resource):
    """Typed from the reference manual's tables and the kit's pin assignments, independently of the table that the board reads."""
    where, expected = resource
    assert balls(*where) == expected


def test_standards_suit_the_banks():
    platform = Cyclone3Platform()
    volts = {"2.5 V": 2.5, "1.8 V": 1.8, "SSTL-18 CLASS I": 1.8}
    for name, number in RESOURCES:
        for ball, attributes in pins_of(platform.request(name, number, dir="-")):
            assert BANK_VOLTS[BALLS[ball]] == volts[attributes["io_standard"]], (name, ball)
            assert (attributes["io_standard"] == "SSTL-18 CLASS I") == (name == "ddr2")


def test_cards_are_in_banks_of_2_5_volts():
    for connector in Cyclone3Platform.connectors:
        assert {BANK_VOLTS[BALLS[ball]] for _, ball in connector} == {2.5}
    assert [{BALLS[ball] for _, ball in connector} for connector in Cyclone3Platform.connectors] == [{1}, {5, 6}]


def test_clocks_come_in_where_clocks_can():
    for where in (("clk50",), ("camera", 0, "clk"), ("camera", 1, "clk")):
        assert set(balls(*where)) <= CLOCK_BALLS


def test_console_is_apart_from_the_cards():
    cards = {ball for connector in Cyclone3Platform.connectors for _, ball in connector}
    assert not cards & set(balls("uart"))
    assert (balls("uart", 0, "rx"), balls("uart", 0, "tx")) == (["AH14"], ["AE23"])


def test_polarity():
    """LEDs and buttons are active low."""
    platform = Cyclone3Platform()
    for name, number in RESOURCES:
        port = platform.request(name, number, dir="-")
        if isinstance(port, io.SingleEndedPort):
            assert any(port.invert) == (name in ("led", "button", "rst")), name


class Blinky(Elaboratable):
    def elaborate(self, platform):
        m = Module()
        m.submodules.led = led = io.Buffer("o", platform.request("led", 0, dir="-"))
        counter = Signal(24)
        m.d.sync += counter.eq(counter + 1)
        m.d.comb += led.o.eq(counter[-1])
        return m


def test_any_design_builds_on_it(monkeypatch):
    """As on the boards of amaranth-boards: default clock and reset, Quartus's files."""
    monkeypatch.setitem(os.environ, "AMARANTH_USE_YOSYS", "builtin")
    files = Cyclone3Platform().prepare(Blinky(), "blinky", add_settings="# mine").files
    settings = files["blinky.qsf"].splitlines()
    assert {*Cyclone3Platform.SETTINGS, "# mine", "set_global_assignment -name DEVICE EP3C120F780C7"} <= set(settings)
    assert 'set_location_assignment -to "clk50_0__io" PIN_AH15' in settings
    assert files["blinky.qpf"].endswith('PROJECT_REVISION = "blinky"\n')
    assert 'create_clock -name "clk50_0__io" -period 20.0' in files["blinky.sdc"]
