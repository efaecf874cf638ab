"""Strict model of a single-data-rate SDRAM at its pins: checks commands, states and times, stores the contents."""

import random
from collections import deque
from collections.abc import Callable, Coroutine
from typing import Any, NamedTuple

from amaranth.hdl import Cat

from golden.video.sdram import BANK_BITS, CAS_CLOCKS, COLUMN_BITS, SDRAM, WORD_BITS, Command, Sdram


__all__ = ["PinWord", "SdramMemory", "pins_of", "serve_sdram"]


_ALL_BANKS = _AUTO_PRECHARGE = 1 << 10
_BANKS = range(1 << BANK_BITS)
_MASKED = (1 << WORD_BITS // 8) - 1
_REFRESHES = 8      # before the first activation
_MODE = CAS_CLOCKS << 4
# Of times in ns that are sums of clock periods.
_ROUNDING = 1e-6


class PinWord(NamedTuple):
    """The pins at an edge of the memory's clock, each active at 1; ``drive``: from half a clock before until half a clock after it, the
    data pins are driven from outside.
    """
    enable: int
    command: int
    bank: int
    address: int
    mask: int
    word: int
    drive: int


class SdramMemory:
    """The memory; :meth:`edge` is called at each rising edge of its clock.

    A violation is an ``AssertionError``. **Initialisation**: a command, or an unmasked byte, within the pause after the first edge; another
    command than a precharge of all banks, then refreshes and the mode, of a burst length of 1 and the right latency; an activation before
    eight refreshes and the mode. **States**: an activation of an open bank; an access to a closed one; a refresh or mode with an open bank;
    a clock enable that falls; automatic precharge; a column beyond the row. **Times**: tRCD, tRP, tRAS, tRC, tRRD, tRFC, tMRD, tWR, the
    longest tRAS, and the interval between refreshes. **Data pins**: driven without a write, not driven for one, or driven while a word that
    was read is on them.

    A word that was never written reads as noise, different each time; so do bytes of a word that were never written, and pins on which
    there is no word.

    Parameters
    ----------
    clock_hz : int
    chip : Sdram
    power_up : float
        Pause in ns, if it is not the chip's.
    seed : int

    Attributes
    ----------
    found : int
        On the data pins at the edge that was given last.
    upcoming : int or None
        A word that is on them at the next edge.
    words_read, words_written, refreshes, activations : int
        Since the beginning.
    """
    def __init__(self, clock_hz: int, *, chip: Sdram = SDRAM, power_up: float | None = None, seed: int = 1):
        self.chip = chip
        self.period = 1e9 / clock_hz
        self.power_up = chip.power_up if power_up is None else power_up
        self.words_read = self.words_written = self.refreshes = self.activations = 0
        self._rng = random.Random(seed)
        self._edges = -1
        self._now = 0.0
        self._contents: dict[tuple[int, int, int], int] = {}
        self._written_bytes: dict[tuple[int, int, int], int] = {}
        self._on_pins: deque[tuple[int, int]] = deque()     # edge, word
        self._busy_until = -1e9     # words that were read are on the pins
        self._enabled = self._closed_once = self._mode_set = False
        self._row: list[int | None] = [None for _ in _BANKS]
        self._activated, self._closed, self._written = ([-1e9 for _ in _BANKS] for _ in range(3))
        self._refreshed = self._mode_at = -1e9
        self.found = self._noise()
        self.upcoming: int | None = None

    def _noise(self) -> int:
        return self._rng.getrandbits(WORD_BITS)

    @property
    def initialised(self) -> bool:
        return self._mode_set and self.refreshes >= _REFRESHES

    def edge(self, pins: PinWord) -> None:
        """A rising edge of the clock, with the pins' levels."""
        self._edges += 1
        self._now = self._edges * self.period
        if (fault := self._fault(pins)) is not None:
            raise AssertionError(f"edge {self._edges}, {self._now:.0f} ns: {Command(pins.command).name} of bank {pins.bank}, "
                                 f"address {pins.address}: {fault}")
        if pins.enable:
            self._enabled = True
            self._obey(pins)
        self.found = self._noise() if self.upcoming is None else self.upcoming
        due = self._on_pins and self._on_pins[0][0] == self._edges + 1
        self.upcoming = self._on_pins.popleft()[1] if due else None

    def _since(self, when: float) -> float:
        return self._now - when + _ROUNDING

    def _fault(self, pins: PinWord) -> str | None:
        """The violation at this edge; ``None`` if there is none."""
        chip = self.chip
        command = Command(pins.command) if pins.enable else Command.NOP
        if self._enabled and not pins.enable:
            return "the clock enable falls"
        if pins.enable and not self.initialised and pins.mask != _MASKED:
            return "bytes are not masked before the memory is initialised"
        if self.initialised and self._since(self._refreshed) > chip.refresh_interval + 2 * _ROUNDING:
            return f"no refresh for {self._since(self._refreshed):.0f} ns"
        for bank in _BANKS:
            if self._row[bank] is not None and self._since(self._activated[bank]) > chip.longest_active + 2 * _ROUNDING:
                return f"bank {bank} is open for too long"
        if pins.drive and command is not Command.WRITE:
            return "data are driven without a write"
        if pins.drive and self._since(self._busy_until) < self.period / 2:
            return "data are driven while a word that was read is on the pins"
        if command is Command.NOP:
            return None
        if not self._closed_once and self._now + _ROUNDING < self.power_up:
            return f"within {self.power_up:.0f} ns of the first edge"
        if self._since(self._refreshed) < chip.refresh_cycle:
            return "tRFC"
        if self._since(self._mode_at) < chip.mode_clocks * self.period:
            return "tMRD"
        return self._fault_of(command, pins)

    def _fault_of(self, command: Command, pins: PinWord) -> str | None:
        """The violation of a command, for its bank or all of them."""
        chip, bank, row = self.chip, pins.bank, self._row[pins.bank]
        if command is Command.PRECHARGE:
            return self._fault_of_precharge(pins)
        if not self._closed_once:
            return "before all banks were precharged"
        if command in (Command.REFRESH, Command.MODE):
            if any(each is not None for each in self._row):
                return "a bank is open"
            if any(self._since(closed) < chip.precharge for closed in self._closed):
                return "tRP"
            if command is Command.MODE and (pins.address != _MODE or bank):
                return f"the mode is not {_MODE}"
            return None
        if not self.initialised:
            return "before the memory is initialised"
        if command is Command.ACTIVATE:
            if row is not None:
                return f"row {row} is open"
            if self._since(self._closed[bank]) < chip.precharge:
                return "tRP"
            if self._since(self._activated[bank]) < chip.cycle:
                return "tRC"
            return "tRRD" if self._since(max(self._activated)) < max(chip.banks, chip.bank_clocks * self.period) else None
        if row is None:
            return "the bank is closed"
        if self._since(self._activated[bank]) < chip.active_to_access:
            return "tRCD"
        if pins.address & _AUTO_PRECHARGE:
            return "automatic precharge"
        if pins.address >> COLUMN_BITS:
            return f"column {pins.address} is beyond the row"
        if command is Command.WRITE and not pins.drive:
            return "data are not driven"
        return None

    def _fault_of_precharge(self, pins: PinWord) -> str | None:
        if not self._closed_once and not pins.address & _ALL_BANKS:
            return "the first one is not of all banks"
        for bank in self._banks_closed(pins):
            if self._row[bank] is not None and self._since(self._activated[bank]) < self.chip.active:
                return "tRAS"
            if self._since(self._written[bank]) < max(self.chip.write_recovery, self.chip.recovery_clocks * self.period):
                return "tWR"
        return None

    @staticmethod
    def _banks_closed(pins: PinWord) -> list[int]:
        return [*_BANKS] if pins.address & _ALL_BANKS else [pins.bank]

    def _obey(self, pins: PinWord) -> None:
        command, bank = Command(pins.command), pins.bank
        if command is Command.PRECHARGE:
            self._closed_once = True
            for each in self._banks_closed(pins):
                self._row[each], self._closed[each] = None, self._now
        elif command is Command.REFRESH:
            self._refreshed = self._now
            self.refreshes += 1
        elif command is Command.MODE:
            self._mode_at, self._mode_set = self._now, True
        elif command is Command.ACTIVATE:
            self._row[bank], self._activated[bank] = pins.address, self._now
            self.activations += 1
        elif command in (Command.READ, Command.WRITE):
            row = self._row[bank]
            assert row is not None
            self._access(pins, (bank, row, pins.address))

    def _access(self, pins: PinWord, place: tuple[int, int, int]) -> None:
        known = self._written_bytes.get(place, 0)
        if pins.command == Command.WRITE:
            mask = _bits(~pins.mask & _MASKED)
            self._contents[place] = self._contents.get(place, 0) & ~mask | pins.word & mask
            self._written_bytes[place] = known | ~pins.mask & _MASKED
            self._written[pins.bank] = self._now
            self.words_written += 1
        else:
            known &= ~pins.mask
            word = self._contents.get(place, 0) & _bits(known) | self._noise() & ~_bits(known)
            self._on_pins.append((self._edges + CAS_CLOCKS, word))
            self._busy_until = self._now + CAS_CLOCKS * self.period + self.chip.off
            self.words_read += 1


def _bits(enabled: int) -> int:
    """Mask of the bits in enabled bytes."""
    return sum(0xff << 8 * byte for byte in range(WORD_BITS // 8) if enabled >> byte & 1)


def pins_of(memory: Any) -> tuple[Any, Callable[[int], PinWord]]:
    """All outputs of a :class:`hdl.loop.sdram.SdramPins` as one value, and what a number means."""
    signals = [getattr(memory, name) for name in PinWord._fields]
    value = Cat(*signals)
    places, low = [], 0
    for signal in signals:
        width = len(Cat(signal))
        places.append((low, (1 << width) - 1))
        low += width
    return value, lambda number: PinWord(*(number >> place & mask for place, mask in places))


def serve_sdram(pins: Any, memory: SdramMemory, domain: str = "sync") -> Callable[[Any], Coroutine[Any, Any, None]]:
    """A process for Amaranth's simulator (``add_process``): the memory behind a :class:`hdl.loop.sdram.SdramPins`."""
    value, decoded = pins_of(pins)

    async def process(ctx: Any) -> None:
        async for _, _, number in ctx.tick(domain).sample(value):
            memory.edge(decoded(number))
            ctx.set(pins.found, memory.found)
    return process
