"""A chip on the I2C bus: its side of the protocol, clock stretching at random, and what may go wrong with it. Times are nanoseconds."""

import math
import random
from dataclasses import dataclass

from .i2c import DATA_HOLD, DATA_SETUP, DATA_VALID, Violation


__all__ = ["Fault", "I2cChip"]


@dataclass
class Fault:
    """What goes wrong at a chip.

    Parameters
    ----------
    kind : str
        ``"no acknowledge"``: a byte is not taken. ``"clock"``: SCL is held low after the byte's last bit. ``"data"``: SDA is.
    register : int
        At the byte that names this register; at the chip's address with ``None``, at data with -1.
    after : int
        So many times all goes well before.
    times : float
        So many times it goes wrong.
    clocks : float
        Falls of SCL until SDA is free again.
    nanoseconds : float
        Time until SCL is free again.
    """
    kind: str
    register: int | None = None
    after: int = 0
    times: float = math.inf
    clocks: float = math.inf
    nanoseconds: float = math.inf

    def strikes(self, register):
        if register != self.register:
            return False
        self.after -= 1
        if self.after >= 0 or self.times <= 0:
            return False
        self.times -= 1
        return True


class I2cChip:
    """A chip with registers behind a sub-address that counts up. The registers are those of a memory; a real chip overrides them.

    Parameters
    ----------
    address : int
        Seven bits.
    seed : int
    stretch : float
        Probability that SCL is stretched, at each fall.
    stretch_ns : int
        Longest stretch.

    Attributes
    ----------
    faults : list of Fault
    writes : list
        ``(register, value)`` of all writes taken.
    """
    #: Whether a read comes after a repeated start; ``None``: either will do.
    RESTART: bool | None = None

    def __init__(self, address, *, seed=0, stretch=0.0, stretch_ns=128_000):
        self.address = address
        self.rng = random.Random(seed)
        self.stretch = stretch
        self.stretch_ns = stretch_ns
        self.faults: list[Fault] = []
        self.writes: list[tuple[int, int]] = []
        self.registers: dict[int, int] = {}
        self.register = 0
        self.scl_low = False
        self.sda_low = False
        self.scl_until = 0.0                # SCL is held low until then
        self.sda_next = None                # (time, level)
        self.state = "idle"
        self.sending = False
        self.count = 0
        self.byte = 0
        self.taken = 0                      # data bytes of this transfer
        self.releasing = False
        self.holding = 0.0                  # falls of SCL for which a fault holds SDA

    # What a real chip overrides.

    def awake(self, now):
        """Whether the chip answers at all."""
        return True

    def set_pins(self, now, levels):
        """Levels of the chip's pins, by name."""

    def write(self, now, register, value):
        self.registers[register] = value

    def read(self, now, register):
        return self.registers.get(register, 0)

    # The bus.

    @property
    def due(self):
        """When the chip will change a line by itself."""
        if self.releasing:
            return -math.inf
        times = [self.scl_until] if self.scl_low else []
        return min(times + ([self.sda_next[0]] if self.sda_next else []), default=math.inf)

    def wake(self, now):
        if self.releasing:
            self.releasing = False
            self.state, self.holding, self.sda_low, self.sda_next = "idle", 0.0, False, None
            self.scl_until = now + DATA_SETUP
        if self.scl_low and self.scl_until <= now:
            self.scl_low = False
        if self.sda_next and self.sda_next[0] <= now:
            self.sda_low = self.sda_next[1]
            self.sda_next = None

    def release(self):
        """Let go of both lines, SDA first: the end of a fault that has none. Not while the master clocks."""
        self.releasing = True

    def on_start(self, now, repeated, *, strict):
        if strict and repeated and self.RESTART is False:
            raise Violation(f"chip {self.address:02X} knows no repeated start")
        self.repeated = repeated
        self.state, self.sending, self.count, self.byte, self.taken = "address", False, -1, 0, 0
        if not self.holding:
            self.sda_low, self.sda_next = False, None

    def on_stop(self, now):
        self.state = "idle"

    def on_rise(self, now, sda):
        if self.state in ("idle", "ignore"):
            return
        self.count += 1
        if self.count < 8:
            self.byte = self.byte << 1 | sda
        elif self.sending and sda:
            self.state = "ignore"           # the master wants no more

    def on_fall(self, now):
        if self.holding:
            self.holding -= 1
            if self.holding <= 0:
                self._set_sda(now, 0)
            return
        if self.state in ("idle", "ignore"):
            self._set_sda(now, 0)
            return
        if self.count == 7:
            self._set_sda(now, not self.sending and self._take(now))
        elif self.count == 8:
            self.count, self.byte = -1, 0
            self.sending = self.state == "read"
            self._set_sda(now, 0)
        if self.sending and self.count < 7:
            if self.count == -1:
                self.out = self.read(now, self.register)
                self.register = (self.register + 1) % 256
            self._set_sda(now, not self.out >> (6 - self.count) & 1)
        if not self.scl_low and self.rng.random() < self.stretch:
            self._hold_scl(now, self.rng.uniform(0, self.stretch_ns))

    def _set_sda(self, now, low):
        """SDA changes a while after SCL's fall, at whatever time the standard allows."""
        if low != self.sda_low or self.sda_next:
            self.sda_next = (now + self.rng.uniform(DATA_HOLD, DATA_VALID), bool(low))

    def _hold_scl(self, now, nanoseconds):
        """Data are set up before SCL is let go."""
        self.scl_low = True
        self.scl_until = max(now + nanoseconds, self.sda_next[0] + DATA_SETUP if self.sda_next else 0)

    def _strikes(self, kind, register):
        """The fault of this kind that strikes now, if any does."""
        return next((fault for fault in self.faults if fault.kind == kind and fault.strikes(register)), None)

    def _take(self, now):
        """A whole byte has come; whether to acknowledge it."""
        if self.state == "address":
            register = None
            if self.byte >> 1 != self.address or not self.awake(now):
                self.state = "ignore"
                return False
            self.state = "read" if self.byte & 1 else "register"
            if self.state == "read" and self.RESTART and not self.repeated:
                raise Violation(f"chip {self.address:02X} is read without a repeated start")
        elif self.state == "register":
            register = self.register = self.byte
            self.state = "write"
        else:
            register = -1
            self.write(now, self.register, self.byte)
            self.writes.append((self.register, self.byte))
            self.register = (self.register + 1) % 256
            self.taken += 1
        if self._strikes("no acknowledge", register):
            self.state = "ignore"
            return False
        if fault := self._strikes("clock", register):
            self._hold_scl(now, fault.nanoseconds)
        if fault := self._strikes("data", register):
            self.holding = fault.clocks
            self.state = "ignore"
        return True
