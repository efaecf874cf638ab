"""Models of the video cards' chips on the I2C bus: each checks every write, and responds only when it can. Times are nanoseconds."""

import math
from collections.abc import Mapping
from typing import Any, ClassVar

from .i2c import Violation
from .i2c_chips import I2cChip


__all__ = ["Tfp410", "Tvp5154"]


class _StrictChip(I2cChip):
    """A chip that accepts only the values of its set-up, one byte a transfer."""
    #: Values that may be written to each register.
    ALLOWED: ClassVar[dict[int, set[int]]] = {}

    def write(self, now: float, register: int, value: int) -> None:
        if value not in self.ALLOWED.get(register, ()):
            raise Violation(f"{type(self).__name__}: {register:02X} = {value:02X} must not be written")
        if self.taken:
            raise Violation(f"{type(self).__name__}: more than one byte in a transfer")
        self.take(now, register, value)

    def take(self, now: float, register: int, value: int) -> None:
        """A write that passed the check."""
        self.registers[register] = value


class _Decoder:
    """One of the decoders of a TVP5154."""
    RESET: ClassVar = {0x00: 0x00, 0x03: 0x01, 0x15: 0x01, 0x17: 0x1B}

    def __init__(self) -> None:
        self.registers = dict(self.RESET)
        self.ready = math.inf               # time from which its processor is running
        self.lock = 0x00                    # value of register 88


class Tvp5154(_StrictChip):
    """Four video decoders behind one address: mask FE selects those that are written, FF the one that is read.

    Sources: the card's notes; the times of RESETB and PDN are those of the TVP5150, which has the same core. Where nothing is documented,
    the worst case is assumed: a restart of a decoder's processor (7F = 00) loses all settings and takes a random time, in which 81 does not
    read 54 and nothing may be written.

    Attributes
    ----------
    decoders : list of _Decoder
    """
    RESTART = False
    ALLOWED: ClassVar = {
        0xFE: {1, 2, 4, 8}, 0xFF: {1, 2, 4, 8}, 0x7F: {0x00}, 0x03: {0x0D}, 0x17: {0x5B}, 0x15: {0x81}, 0x00: {0x00},
    }
    SETTINGS: ClassVar = {0x03: 0x0D, 0x17: 0x5B, 0x15: 0x81, 0x00: 0x00}
    POWER_UP, RESET_PULSE, RESET_TO_BUS = 20_000_000, 500, 200_000
    LOCKED = 0x06

    def __init__(self, *, start_ns: float = 1_000_000, **kwargs: Any):
        super().__init__(0xB8 >> 1, **kwargs)
        self.start_ns = start_ns
        self.pins: dict[str, int] = {}
        self.powered_at = self.reset_at = self.released_at = math.inf
        self.reset()

    def reset(self) -> None:
        """Lose all settings, and nothing else, as after a spike on the supply."""
        self.write_mask, self.read_mask = 0, 0
        self.decoders = [_Decoder() for _ in range(4)]
        for decoder in self.decoders:
            decoder.ready = -math.inf

    def set_pins(self, now: float, levels: Mapping[str, int]) -> None:
        resetb, pdn = levels["resetb"], levels["pdn"]
        if not resetb and not pdn:
            raise Violation("TVP5154: RESETB and PDN are both low, which has no meaning")
        if pdn != self.pins.get("pdn"):
            self.powered_at = now if pdn else math.inf
            self.released_at = math.inf     # must be reset
        if resetb != self.pins.get("resetb", 1):
            if not resetb:
                if now - self.powered_at < self.POWER_UP:
                    raise Violation(f"TVP5154: reset {now - self.powered_at:.0f} ns after power-up; the least is {self.POWER_UP} ns")
                self.reset_at, self.released_at = now, math.inf
            else:
                if now - self.reset_at < self.RESET_PULSE:
                    raise Violation(f"TVP5154: reset for {now - self.reset_at:.0f} ns; the least is {self.RESET_PULSE} ns")
                self.released_at = now
                locks = [decoder.lock for decoder in self.decoders]
                self.reset()
                for decoder, lock in zip(self.decoders, locks):
                    decoder.lock = lock     # depends on the camera only
        self.pins = dict(levels)

    def awake(self, now: float) -> bool:
        if self.released_at == math.inf:
            return False
        if now - self.released_at < self.RESET_TO_BUS:
            raise Violation(f"TVP5154: addressed {now - self.released_at:.0f} ns after reset; the least is {self.RESET_TO_BUS} ns")
        return True

    def take(self, now: float, register: int, value: int) -> None:
        if register == 0xFE:
            self.write_mask = value
        elif register == 0xFF:
            self.read_mask = value
        for number, decoder in enumerate(self.decoders):
            if register < 0xFE and self.write_mask >> number & 1:
                if register == 0x7F:
                    decoder.registers = dict(decoder.RESET)
                    decoder.ready = now + self.rng.uniform(0, self.start_ns)
                elif now < decoder.ready:
                    raise Violation(f"TVP5154: decoder {number + 1} is written while its processor starts")
                else:
                    decoder.registers[register] = value

    def read(self, now: float, register: int) -> int:
        if not self.read_mask:
            return 0x00
        decoder = self.decoders[self.read_mask.bit_length() - 1]
        if now < decoder.ready:
            return 0x00
        return {0x80: 0x51, 0x81: 0x54, 0x88: decoder.lock}.get(register, decoder.registers.get(register, 0))

    def is_set_up(self, number: int) -> bool:
        """Whether decoder ``number``, from 0, has all its settings."""
        return self.decoders[number].registers == self.SETTINGS


class Tfp410(_StrictChip):
    """DVI transmitter; while ISEL is low its registers are reset and cannot be accessed."""
    RESTART = True
    ALLOWED: ClassVar = {0x08: {0xBF}, 0x09: {0x20}}
    RESET: ClassVar = {0x00: 0x4C, 0x01: 0x01, 0x02: 0x10, 0x03: 0x04, 0x08: 0xFE, 0x09: 0x00}

    def __init__(self, **kwargs: Any):
        super().__init__(0x70 >> 1, **kwargs)
        self.pins: dict[str, int] = {}
        self.was_reset = False              # required after power-on
        self.reset()

    def reset(self) -> None:
        """Reset all registers."""
        self.registers = dict(self.RESET)

    def set_pins(self, now: float, levels: Mapping[str, int]) -> None:
        self.pins = dict(levels)
        if not levels["isel"]:
            self.reset()
            self.was_reset = True

    def awake(self, now: float) -> bool:
        return bool(self.pins.get("isel")) and self.was_reset

    def is_set_up(self) -> bool:
        """Whether it sends pictures, and samples its input with the rising edge."""
        return self.registers[0x08] & 0x7F == 0x3F
