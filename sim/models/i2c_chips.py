"""Model of a chip on the I2C bus: its side of the protocol, random clock stretching, injected faults. Times are nanoseconds."""

import math
import random
from collections.abc import Mapping
from dataclasses import dataclass

from .i2c import DATA_HOLD, DATA_SETUP, DATA_VALID, Violation


__all__ = ["Fault", "I2cChip"]


@dataclass
class Fault:
    """A fault of a chip.

    Parameters
    ----------
    kind : str
        ``"no acknowledge"``: a byte is not acknowledged. ``"clock"``: SCL is held low after the byte's last bit. ``"data"``: SDA is.
    register : int
        At the byte that selects this register; ``None``: at the chip's address; -1: at data.
    after : int
        Number of good times before the first fault.
    times : float
        Number of faults.
    clocks : float
        Falling edges of SCL until SDA is released.
    nanoseconds : float
        Time until SCL is released.
    """
    kind: str
    register: int | None = None
    after: int = 0
    times: float = math.inf
    clocks: float = math.inf
    nanoseconds: float = math.inf

    def strikes(self, register: int | None) -> bool:
        """Whether the fault occurs this time; counts the times."""
        if register != self.register:
            return False
        self.after -= 1
        if self.after >= 0 or self.times <= 0:
            return False
        self.times -= 1
        return True


class I2cChip:
    """A chip with registers behind an auto-incremented sub-address. They are plain memory here; models of chips override them.

    Parameters
    ----------
    address : int
        Seven bits.
    seed : int
    stretch : float
        Probability that SCL is stretched, at each falling edge.
    stretch_ns : int
        Longest stretch.

    Attributes
    ----------
    faults : list of Fault
    writes : list
        ``(register, value)`` of all writes acknowledged.
    """
    #: Whether a read must follow a repeated start; ``None``: either is allowed.
    RESTART: bool | None = None

    def __init__(self, address: int, *, seed: int = 0, stretch: float = 0.0, stretch_ns: float = 128_000):
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
        self.sda_next: tuple[float, bool] | None = None     # time, and whether SDA is low from then on
        self.state = "idle"
        self.sending = False
        self.count = 0
        self.byte = 0
        self.taken = 0                      # data bytes of this transfer
        self.releasing = False
        self.holding = 0.0                  # falling edges of SCL for which a fault holds SDA
        self.repeated = False               # the last start was a repeated one
        self.out = 0                        # byte being read

    # To be overridden by models of chips.

    def awake(self, now: float) -> bool:
        """Whether the chip responds at all."""
        return True

    def set_pins(self, now: float, levels: Mapping[str, int]) -> None:
        """Levels of the chip's pins, by name."""

    def write(self, now: float, register: int, value: int) -> None:
        """A byte is written to a register."""
        self.registers[register] = value

    def read(self, now: float, register: int) -> int:
        """The value that a read of a register returns."""
        return self.registers.get(register, 0)

    # The bus.

    @property
    def due(self) -> float:
        """Time of the chip's next change of a line; infinity if there is none."""
        if self.releasing:
            return -math.inf
        times = [self.scl_until] if self.scl_low else []
        return min(times + ([self.sda_next[0]] if self.sda_next else []), default=math.inf)

    def wake(self, now: float) -> None:
        """Carry out the changes that are due."""
        if self.releasing:
            self.releasing = False
            self.state, self.holding, self.sda_low, self.sda_next = "idle", 0.0, False, None
            self.scl_until = now + DATA_SETUP
        if self.scl_low and self.scl_until <= now:
            self.scl_low = False
        if self.sda_next and self.sda_next[0] <= now:
            self.sda_low = self.sda_next[1]
            self.sda_next = None

    def release(self) -> None:
        """Release both lines, SDA first: ends a fault without an end. Not while the master sends clock pulses."""
        self.releasing = True

    def on_start(self, now: float, repeated: bool, *, strict: bool) -> None:
        """A start condition."""
        if strict and repeated and self.RESTART is False:
            raise Violation(f"chip {self.address:02X} does not support a repeated start")
        self.repeated = repeated
        self.state, self.sending, self.count, self.byte, self.taken = "address", False, -1, 0, 0
        if not self.holding:
            self.sda_low, self.sda_next = False, None

    def on_stop(self, now: float) -> None:
        """A stop condition."""
        self.state = "idle"

    def on_rise(self, now: float, sda: int) -> None:
        """SCL rises."""
        if self.state in ("idle", "ignore"):
            return
        self.count += 1
        if self.count < 8:
            self.byte = self.byte << 1 | sda
        elif self.sending and sda:
            self.state = "ignore"           # no acknowledge: the master ends the transfer

    def on_fall(self, now: float) -> None:
        """SCL falls."""
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

    def _set_sda(self, now: float, low: bool | int) -> None:
        """SDA changes after SCL's falling edge, at a random time within the standard's limits."""
        if low != self.sda_low or self.sda_next:
            self.sda_next = (now + self.rng.uniform(DATA_HOLD, DATA_VALID), bool(low))

    def _hold_scl(self, now: float, nanoseconds: float) -> None:
        """Stretch SCL; data are set up before it is released."""
        self.scl_low = True
        self.scl_until = max(now + nanoseconds, self.sda_next[0] + DATA_SETUP if self.sda_next else 0)

    def _strikes(self, kind: str, register: int | None) -> Fault | None:
        """The fault of this kind that occurs now, if any."""
        return next((fault for fault in self.faults if fault.kind == kind and fault.strikes(register)), None)

    def _take(self, now: float) -> bool:
        """A byte is complete; whether to acknowledge it."""
        register: int | None = None
        if self.state == "address":
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
