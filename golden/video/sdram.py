"""Single-data-rate SDRAM of 16 bit words: geometry, timing after data sheets, and what that is in clocks."""

import math
from dataclasses import dataclass
from enum import IntEnum


__all__ = ["BANK_BITS", "CAS_CLOCKS", "COLUMN_BITS", "ROW_BITS", "SDRAM", "WORD_BITS", "Command", "Sdram",
           "SdramClocks"]


#: Geometry of the chips of 256 Mbit: 4 banks of 8,192 rows of 512 words.
COLUMN_BITS, BANK_BITS, ROW_BITS, WORD_BITS = 9, 2, 13, 16

#: Clocks from a read to its word.
CAS_CLOCKS = 2


class Command(IntEnum):
    """Levels of RAS, CAS and WE, the lowest bit first; 1 is active, which is low at the pins."""
    NOP = 0b000
    ACTIVATE = 0b001
    READ = 0b010
    WRITE = 0b110
    PRECHARGE = 0b101
    REFRESH = 0b011
    MODE = 0b111


@dataclass(frozen=True)
class SdramClocks:
    """Least clocks between commands; each is at least 1.

    Parameters
    ----------
    power_up : int
        From a stable clock to the first command.
    active_to_access : int
        tRCD, and tRRD: the controller waits after an activation, whatever is next.
    precharge, active, refresh_cycle, mode, write_recovery : int
        tRP, tRAS, tRFC, tMRD, tWR.
    read_to_write : int
        The memory's word is off the pins before the other word is driven, half a clock before the write.
    refresh_interval : int
        Most clocks from a refresh to the next one.
    """
    power_up: int
    active_to_access: int
    precharge: int
    active: int
    refresh_cycle: int
    mode: int
    write_recovery: int
    read_to_write: int
    refresh_interval: int


@dataclass(frozen=True)
class Sdram:
    """Timing of a chip, in ns: for each figure the strictest of the sources below, as a board's chip is whichever was to be had.

    ULX3S were made with Micron's MT48LC16M16A2 (its schematic), ISSI's IS42S16160G and Alliance's AS4C32M16SB, whose rows are twice as long
    and half used (``emard/ulx3s`` issue 17, LiteX's target). Speed grades differ from board to board and are not known here.

    - AS4C32M16SB-7, revision 1.0, table 16: 21 ns of tRCD and tRP.
    - Winbond's W9825G6JH-75, a common one, data sheet A04, table 9.5: tRAS, tHZ, two clocks of tRRD, tWR and tRSC, the period.
    - LiteDRAM's IS42S16160: 20 ns of tWR, 70 ns of tRFC; tRC is the same, as data sheets have one figure for both.
    - LiteDRAM's MT48LC16M16: 15 ns of tRRD; 20 ns of tRCD and tRP, 44 ns of tRAS, 15 ns of tWR, 66 ns of tRFC are no stricter.
    - All: 8,192 rows in 64 ms. The pause after power-up is the longest in use, 200 us; some chips take 100 us.

    Parameters
    ----------
    power_up : float
        Pause after the clock is stable.
    active_to_access : float
        tRCD, from a row's activation to a read or write in it.
    precharge : float
        tRP, from a precharge to the next command of its bank.
    active, longest_active : float
        tRAS, from an activation to the precharge, at least and at most.
    cycle : float
        tRC, from an activation to the next one in the same bank.
    banks : float
        tRRD, from an activation to that of another bank; at least ``bank_clocks`` clocks.
    refresh_cycle : float
        tRFC, from a refresh to the next command.
    write_recovery : float
        tWR, from a written word to the precharge; at least ``recovery_clocks`` clocks.
    off : float
        tHZ, after which a read word is off the pins.
    refresh_all : float
        tREF, in which each row must be refreshed.
    mode_clocks, bank_clocks, recovery_clocks : int
        tMRD, and the least tRRD and tWR.
    period : float
        Least clock period with a CAS latency of 2.
    """
    power_up: float = 200_000
    active_to_access: float = 21
    precharge: float = 21
    active: float = 45
    longest_active: float = 100_000
    cycle: float = 70
    banks: float = 15
    refresh_cycle: float = 70
    write_recovery: float = 20
    off: float = 7
    refresh_all: float = 64e6
    mode_clocks: int = 2
    bank_clocks: int = 2
    recovery_clocks: int = 2
    period: float = 10

    @property
    def refresh_interval(self) -> float:
        """From a refresh to the next, if they are spread evenly."""
        return self.refresh_all / (1 << ROW_BITS)

    def clocks(self, clock_hz: int) -> SdramClocks:
        """What a controller must keep.

        Raises
        ------
        ValueError
            If the clock is too fast.

        Examples
        --------
        >>> SDRAM.clocks(60_000_000)
        SdramClocks(power_up=12000, active_to_access=2, precharge=2, active=3, refresh_cycle=5, mode=2, write_recovery=2, read_to_write=3, \
refresh_interval=468)
        """
        period = 1e9 / clock_hz
        if period < self.period:
            raise ValueError(f"an SDRAM with a CAS latency of {CAS_CLOCKS} takes {1e3 / self.period:g} MHz at most, not "
                             f"{clock_hz / 1e6:g}; choose a lower clock")

        def least(ns: float) -> int:
            # Not one clock more for an error of the division.
            return max(1, math.ceil(ns / period - 1e-6))

        precharge = least(self.precharge)
        to_access = max(least(self.active_to_access), least(self.banks), self.bank_clocks)
        return SdramClocks(
            least(self.power_up), to_access, precharge, max(least(self.active), least(self.cycle) - precharge), least(self.refresh_cycle),
            self.mode_clocks, max(self.recovery_clocks, least(self.write_recovery)), math.ceil(CAS_CLOCKS + 0.5 + self.off / period),
            math.floor(self.refresh_interval / period))


#: Of the chips on boards here.
SDRAM = Sdram()
