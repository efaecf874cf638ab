"""The models of the I2C bus and its chips: violations that they must detect."""

import pytest

from sim.models.i2c import I2cBus, Violation
from sim.models.i2c_chips import I2cChip
from sim.models.video_chips import Tfp410, Tvp5154


#: The least values of the standard mode, and a period that keeps 100 kHz.
TIMES = {
    "low": 4_700, "high": 4_000, "period": 10_000, "hold": 300, "set_up": 250, "start_set_up": 4_700, "start_hold": 4_000,
    "stop_set_up": 4_000, "free": 4_700,
}


class Hand:
    """A master by hand: writes with given times."""
    def __init__(self, *chips, pins=None, **times):
        self.bus = I2cBus(*chips)
        self.pins = pins or {}
        self.times = {**TIMES, **times}
        self.now = 0
        self.rose = -10**6
        self.sda = 0

    def lines(self, scl_low, sda_low):
        self.sda = sda_low
        self.bus.drive(self.now, scl_low, sda_low, **self.pins)

    def wait(self, nanoseconds):
        self.now += nanoseconds
        self.bus.drive(self.now, *self.bus._master, **self.pins)

    def start(self):
        self.lines(0, 0)
        self.wait(self.times["start_set_up"])
        self.lines(0, 1)
        self.wait(self.times["start_hold"])
        self.lines(1, 1)
        self.fell = self.now

    def pulse(self, sda_low, high):
        """SCL low with the data, then high for a time; back at its end, SCL still high."""
        self.wait(self.times["hold"])
        self.lines(1, sda_low)
        self.wait(max(self.times["set_up"], self.fell + self.times["low"] - self.now, self.rose + self.times["period"] - self.now))
        self.lines(0, sda_low)
        self.rose = self.now
        self.wait(high)

    def fall(self):
        self.lines(1, self.sda)
        self.fell = self.now

    def byte(self, value):
        for place in range(7, -1, -1):
            self.pulse(not value >> place & 1, self.times["high"])
            self.fall()
        self.pulse(0, self.times["high"])
        acknowledged = not self.bus.sda
        self.fall()
        return acknowledged

    def stop(self):
        self.pulse(1, self.times["stop_set_up"])
        self.lines(0, 0)
        self.rose = -10**6
        self.wait(self.times["free"])

    def repeat(self):
        self.pulse(0, self.times["start_set_up"])
        self.lines(0, 1)
        self.wait(self.times["start_hold"])
        self.fall()

    def write(self, address, *data, stop=True):
        self.start()
        assert all([self.byte(byte) for byte in (address << 1, *data)])
        if stop:
            self.stop()

    def read(self, address, register, *, restart):
        self.write(address, register, stop=not restart)
        self.repeat() if restart else self.start()
        assert self.byte(address << 1 | 1)
        value = 0
        for _ in range(8):
            self.pulse(0, self.times["high"])
            value = value << 1 | self.bus.sda
            self.fall()
        self.pulse(0, self.times["high"])
        self.fall()
        self.stop()
        return value


def transfers(hand):
    for restart in (False, True):
        hand.write(0x31, 0x10, 0xA7)
        assert hand.read(0x31, 0x10, restart=restart) == 0xA7


def test_least_times_are_well():
    hand = Hand(I2cChip(0x31, seed=1))
    transfers(hand)
    assert (hand.bus.starts, hand.bus.stops) == (6, 5)


@pytest.mark.parametrize("less, message", [
    ({"low": 4_699, "period": 0, "set_up": 0}, "SCL low is 4699 ns"),
    ({"period": 9_999}, "period of SCL is 9999 ns"),
    ({"high": 3_999}, "SCL high is 3999 ns"),
    ({"hold": 299}, "hold of data is 299 ns"),
    ({"low": 0, "period": 0, "hold": 4_500, "set_up": 249}, "set-up of data is 249 ns"),
    ({"start_hold": 3_999}, "hold of start is 3999 ns"),
    ({"stop_set_up": 3_999}, "set-up of stop is 3999 ns"),
    ({"start_set_up": 4_699, "free": 0}, "bus free is 4699 ns"),
    ({"start_set_up": 4_699}, "set-up of start is 4699 ns"),
])
def test_one_nanosecond_less(less, message):
    hand = Hand(I2cChip(0x31, seed=1), **less)
    with pytest.raises(Violation, match=message):
        transfers(hand)


@pytest.mark.parametrize("bits", range(1, 9))
@pytest.mark.parametrize("level", [0, 1])
def test_data_change_while_clock_is_high(bits, level):
    """Inside a byte: neither a start nor a stop."""
    hand = Hand(I2cChip(0x31))
    hand.start()
    for _ in range(bits):
        hand.pulse(0, TIMES["high"])
        hand.fall()
    hand.pulse(level, TIMES["start_set_up"])
    with pytest.raises(Violation, match="inside a byte"):
        hand.lines(0, not level)


def test_both_lines_at_once():
    """SDA that changes as SCL falls has no hold time."""
    hand = Hand(I2cChip(0x31))
    hand.start()
    hand.pulse(0, TIMES["high"])
    with pytest.raises(Violation):
        hand.lines(1, 1)


def decoder(*, power_up=20_000_000, pulse=500, to_bus=200_000):
    """A decoder after its reset, with these times."""
    model = Tvp5154(start_ns=1)
    hand = Hand(model, pins={"resetb": 1, "pdn": 1})
    hand.lines(0, 0)
    for resetb, wait in ((1, power_up), (0, pulse), (1, to_bus)):
        hand.pins = {"resetb": resetb, "pdn": 1}
        hand.wait(0)
        hand.wait(wait)
    return model, hand


def test_decoder_takes_its_settings():
    model, hand = decoder()
    for register, value in [(0xFE, 2), (0x7F, 0), *Tvp5154.SETTINGS.items(), (0xFF, 2)]:
        hand.write(model.address, register, value)
    assert [model.is_set_up(number) for number in range(4)] == [False, True, False, False]
    assert hand.read(model.address, 0x81, restart=False) == 0x54
    model.decoders[1].lock = 0x86
    assert hand.read(model.address, 0x88, restart=False) == 0x86
    hand.write(model.address, 0xFF, 1)
    assert hand.read(model.address, 0x88, restart=False) == 0x00


@pytest.mark.parametrize("less, message", [
    ({"power_up": 19_990_000}, "reset 19990000 ns after power-up"),
    ({"pulse": 499}, "reset for 499 ns"),
    ({"to_bus": 100_000}, "addressed 1"),
])
def test_decoder_has_its_time(less, message):
    with pytest.raises(Violation, match=message):
        model, hand = decoder(**less)
        hand.write(model.address, 0xFE, 1)


@pytest.mark.parametrize("register, value", [(0x03, 0x0C), (0x04, 0x00), (0xFE, 0x03), (0x7F, 0x01)])
def test_decoder_takes_no_other_values(register, value):
    model, hand = decoder()
    with pytest.raises(Violation, match=f"{register:02X} = {value:02X} must not be written"):
        hand.write(model.address, register, value)


def test_decoder_refuses():
    """Two bytes at once, a repeated start, settings while its processor starts."""
    model, hand = decoder()
    with pytest.raises(Violation, match="more than one byte"):
        hand.write(model.address, 0xFE, 0x01, 0x01)
    model, hand = decoder()
    with pytest.raises(Violation, match="does not support a repeated start"):
        hand.read(model.address, 0x81, restart=True)
    model, hand = decoder()
    model.start_ns = 10**9
    hand.write(model.address, 0xFE, 1)
    hand.write(model.address, 0x7F, 0)
    hand.write(model.address, 0xFF, 1)
    assert hand.read(model.address, 0x81, restart=False) == 0
    with pytest.raises(Violation, match="decoder 1 is written while its processor starts"):
        hand.write(model.address, 0x03, 0x0D)


def test_transmitter_refuses():
    """It does not respond before a reset, is read after a repeated start only, and accepts no other values."""
    model = Tfp410()
    hand = Hand(model, pins={"isel": 1})
    hand.start()
    assert not hand.byte(model.address << 1)
    hand.stop()
    hand.pins = {"isel": 0}
    hand.wait(1000)
    hand.pins = {"isel": 1}
    hand.wait(1000)
    assert hand.read(model.address, 0x08, restart=True) == 0xFE
    hand.write(model.address, 0x08, 0xBF)
    assert model.is_set_up()
    with pytest.raises(Violation, match="08 = BE must not be written"):
        hand.write(model.address, 0x08, 0xBE)
    hand = Hand(model, pins={"isel": 1})
    with pytest.raises(Violation, match="read without a repeated start"):
        hand.read(model.address, 0x08, restart=False)


def test_master_is_reset():
    """Both lines rise at once in the midst of a byte; from the next start on the rules apply again."""
    for restarted in (False, True):
        hand = Hand(I2cChip(0x31))
        hand.start()
        for place in range(3):
            hand.pulse(place & 1, TIMES["high"])
            hand.fall()
        hand.wait(1000)
        hand.lines(1, 1)
        if not restarted:
            with pytest.raises(Violation):
                hand.lines(0, 0)
            continue
        hand.bus.restart()
        hand.lines(0, 0)
        hand.wait(10_000)
        hand.write(0x31, 0x10, 0xA7)
        assert hand.read(0x31, 0x10, restart=True) == 0xA7
        hand.times["high"] = 3_000
        with pytest.raises(Violation, match="SCL high"):
            hand.write(0x31, 0x10, 0xA7)
