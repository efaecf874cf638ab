"""Set-up of the video chips as data: pins and registers, step by step.

The gateware's tables are made from these steps, and the console describes a failed step by them. Registers and values are bytes.
"""

import enum
import math
from dataclasses import dataclass


__all__ = ["Chip", "Drive", "Failure", "Lock", "Poll", "Step", "TFP410", "TFP410_STRAPS", "TVP5154", "Write"]


class Failure(enum.IntEnum):
    """Reason for which a step of a set-up failed, as in the status registers.

    ``NO_ACKNOWLEDGE``: a byte was not acknowledged. ``CLOCK_HELD``: SCL stayed low for longer than a chip may stretch it. ``DATA_HELD``:
    SDA stayed low although the bus should be free, clock pulses notwithstanding. ``NOT_READY``: a register did not read as expected in
    time.
    """
    NONE = 0
    NO_ACKNOWLEDGE = 1
    CLOCK_HELD = 2
    DATA_HELD = 3
    NOT_READY = 4

    @property
    def text(self) -> str:
        return {
            Failure.NONE: "no failure",
            Failure.NO_ACKNOWLEDGE: "no acknowledge",
            Failure.CLOCK_HELD: "the chip held SCL low for too long",
            Failure.DATA_HELD: "something holds SDA low",
            Failure.NOT_READY: "the register did not read this in time",
        }[self]


@dataclass(frozen=True)
class Step:
    """One step of a table.

    Parameters
    ----------
    what : str
        The part of the chip concerned.
    seconds : float
        Time for which it is repeated until it succeeds; with 0 it is tried once.
    """
    what: str
    seconds: float

    def __post_init__(self) -> None:
        if not (math.isfinite(self.seconds) and self.seconds >= 0):
            raise ValueError(f"{self.what}: the time of a step must be 0 seconds or more, not {self.seconds!r}")
        for name in ("register", "value", "mask"):
            if (byte := getattr(self, name, 0)) not in range(256):
                raise ValueError(f"{self.what}: {name} must be a byte, 0 to 255, not {byte!r}")

    @property
    def text(self) -> str:
        return self.what


@dataclass(frozen=True)
class Drive(Step):
    """Drive the chip's pins, then wait for ``seconds``; it cannot fail. ``levels`` are in the order of :attr:`Chip.pins`."""
    levels: tuple[int, ...]

    @property
    def text(self) -> str:
        return f"{self.what}, {self.seconds * 1000:g} ms"


@dataclass(frozen=True)
class Write(Step):
    """Write a register."""
    register: int
    value: int

    @property
    def text(self) -> str:
        return f"{self.what}: write {self.register:02X} = {self.value:02X}"


@dataclass(frozen=True)
class Poll(Step):
    """Read a register until ``read & mask == value``."""
    register: int
    value: int
    mask: int = 0xFF

    def __post_init__(self) -> None:
        super().__post_init__()
        if self.value & ~self.mask:
            raise ValueError(f"{self.what}: no byte under the mask {self.mask:02X} is {self.value:02X}")

    @property
    def text(self) -> str:
        mask = "" if self.mask == 0xFF else f" & {self.mask:02X}"
        return f"{self.what}: read {self.register:02X}{mask} = {self.value:02X}"


@dataclass(frozen=True)
class Lock(Poll):
    """Read a register once; ``read & mask == value`` tells whether ``channel`` is locked. Unlocked is no failure."""
    channel: int = 0

    @property
    def text(self) -> str:
        return f"{self.what}: read lock in {self.register:02X}"


@dataclass(frozen=True)
class Chip:
    """A chip, the only one on its I2C bus.

    Parameters
    ----------
    name : str
        Type of the chip.
    address : int
        Seven bits.
    pins : tuple of str
        Pins that the set-up drives.
    setup : tuple of Step
        From power-on to operation. The first one drives the pins if there are any; its levels are those after reset.
    watch : tuple of Step
        Repeated periodically once the set-up is done. If one fails, the set-up is repeated.
    channels : int
        Number of locks that ``watch`` reports.
    restart : bool
        A register is read with a repeated start; otherwise with a stop and a start.
    """
    name: str
    address: int
    pins: tuple[str, ...]
    setup: tuple[Step, ...]
    watch: tuple[Step, ...] = ()
    channels: int = 0
    restart: bool = True

    def __post_init__(self) -> None:
        if self.address not in range(128):
            raise ValueError(f"{self.name}: the address must have seven bits, 0 to 127, not {self.address!r}")
        if not self.setup or (self.pins and not isinstance(self.setup[0], Drive)):
            raise ValueError(f"{self.name}: the first step of the set-up must drive the pins")
        for step in self.steps:
            if isinstance(step, Drive) and len(step.levels) != len(self.pins):
                raise ValueError(f"{self.name}: {step.text}: {len(step.levels)} levels for the pins {', '.join(self.pins)}")
            if isinstance(step, Lock) and step.channel not in range(self.channels):
                raise ValueError(f"{self.name}: {step.text}: channel {step.channel} of {self.channels}")

    @property
    def steps(self) -> tuple[Step, ...]:
        """All steps; the number of a step in status registers and messages is its index here."""
        return self.setup + self.watch

    def explain(self, step: int, failure: int) -> str:
        """A failed step in words.

        >>> TVP5154.explain(4, Failure.NO_ACKNOWLEDGE)
        'TVP5154, step 4 (decoder 1: write 7F = 00): no acknowledge'
        """
        if step not in range(len(self.steps)):
            raise ValueError(f"{self.name} has the steps 0 to {len(self.steps) - 1}, not {step!r}")
        return f"{self.name}, step {step} ({self.steps[step].text}): {Failure(failure).text}"


# Time in which a decoder's processor starts: not documented, hence generous.
_START_SECONDS = 0.5

# A single failed transfer is no reason to repeat the set-up, which costs pictures.
_WATCH_SECONDS = 0.01


def _decoder_restart(mask: int) -> tuple[Step, ...]:
    """Restart a decoder's processor and wait until its device identification reads 54."""
    what = f"decoder {mask.bit_length()}"
    return (
        Write(what, 0, 0xFE, mask),
        Write(what, 0, 0x7F, 0x00),
        Write(what, 0, 0xFF, mask),
        Poll(what, _START_SECONDS, 0x81, 0x54),
    )


def _decoder_settings(mask: int) -> tuple[Step, ...]:
    """Restart once more, then: outputs on; no scaler, with SAV and EAV; stable syncs; composite input A.

    Waiting after the restart is our choice: writes while the processor starts may be lost.
    """
    what = f"decoder {mask.bit_length()}"
    return (
        *_decoder_restart(mask),
        Write(what, 0, 0x03, 0x0D),
        Write(what, 0, 0x17, 0x5B),
        Write(what, 0, 0x15, 0x81),
        Write(what, 0, 0x00, 0x00),
    )


def _decoder_watch(mask: int) -> tuple[Step, ...]:
    """Lock of a decoder, both to lines and to fields. If its outputs are off, it was reset without our doing."""
    what = f"decoder {mask.bit_length()}"
    return (
        Write(what, _WATCH_SECONDS, 0xFF, mask),
        Poll(what, _WATCH_SECONDS, 0x03, 0x0D, 0x0D),
        Lock(what, _WATCH_SECONDS, 0x88, 0x06, 0x06, channel=mask.bit_length() - 1),
    )


#: The four decoders of the camera card, of which two are used; mask FE selects those that are written, FF the one that is read. All four
#: are restarted, as the manufacturer's code does.
#:
#: Reset follows the TVP5150, which has the same core (its data sheet, and Linux's driver): 20 ms after power-down is released RESETB is
#: low for at least 500 ns, and the bus works 200 us later. RESETB must not be low while PDN is.
#:
#: A register is read with a stop between its address and its data (TI SLES163A, page 17).
TVP5154 = Chip(
    name="TVP5154",
    address=0xB8 >> 1,
    pins=("resetb", "pdn"),
    setup=(
        Drive("power up", 0.020, (1, 1)),
        Drive("reset", 0.001, (0, 1)),
        Drive("reset released", 0.001, (1, 1)),
        *(step for mask in (1, 2, 4, 8) for step in _decoder_restart(mask)),
        *(step for mask in (1, 2) for step in _decoder_settings(mask)),
    ),
    watch=(*_decoder_watch(1), *_decoder_watch(2)),
    channels=2,
    restart=False,
)

#: The transmitter of the DVI card, set up by I2C. A low pulse of ISEL resets its registers, and is needed after power-on (TI SLDS145D,
#: section 6.4.4). BF: syncs on, 24 bits, data latched at the rising edge of IDCK+, powered up. Bit 7 has no meaning.
#:
#: I2C was chosen because with ISEL low the latching edge follows the EDGE pin, which is also the monitor's hot plug signal and which the
#: FPGA does not drive: the phase of the clock would be a guess. By I2C it is known and read back, and a chip that does not respond shows
#: in the status.
TFP410 = Chip(
    name="TFP410",
    address=0x70 >> 1,
    pins=("isel",),
    setup=(
        Drive("reset", 0.001, (0,)),
        Drive("I2C selected", 0.001, (1,)),
        Write("outputs", 0, 0x08, 0xBF),
        Write("monitor detection", 0, 0x09, 0x20),
        Poll("outputs", 0, 0x08, 0x3F, 0x7F),
    ),
    watch=(Poll("outputs", _WATCH_SECONDS, 0x08, 0x3F, 0x7F),),
)

#: The same chip set up by its straps: SCL and SDA are then BSEL and DSEL, which the card's weak pull-ups hold high.
TFP410_STRAPS = Chip(name="TFP410 (straps)", address=TFP410.address, pins=("isel",), setup=(Drive("straps selected", 0.001, (0,)),))
