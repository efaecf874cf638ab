"""sim.models.sdram: each violation is seen, what is allowed is not, contents are kept."""

from dataclasses import replace

import pytest

from golden.video.sdram import SDRAM, Command
from sim.models.sdram import PinWord, SdramMemory


CLOCK_HZ = 100_000_000
PERIOD = 1e9 / CLOCK_HZ
CLOCKS = SDRAM.clocks(CLOCK_HZ)
POWER_UP = 5
ALL, MODE = 1 << 10, 2 << 4
NOTHING = PinWord(1, Command.NOP.value, 0, 0, 0, 0, 0)
MASKED = NOTHING._replace(mask=3)


def pins(command, *, bank=0, address=0, **more):
    return NOTHING._replace(command=command.value, bank=bank, address=address, **more)


def activate(bank=0, row=3):
    return pins(Command.ACTIVATE, bank=bank, address=row)


def write(column=1, word=0x1234, **more):
    return pins(Command.WRITE, address=column, word=word, **{"drive": 1, **more})


READ, CLOSE, CLOSE_ALL = pins(Command.READ, address=1), pins(Command.PRECHARGE), pins(Command.PRECHARGE, address=ALL)
REFRESH, SET_MODE = pins(Command.REFRESH), pins(Command.MODE, address=MODE)


def run(memory, *steps):
    """Steps: the pins at an edge, or a number of edges without a command; what was found at the last one."""
    for step in steps:
        for each in [NOTHING if memory.initialised else MASKED] * step if isinstance(step, int) else [step]:
            memory.edge(each)
    return memory.found


def masked(*steps):
    return [step if isinstance(step, int) else step._replace(mask=3) for step in steps]


#: Of a memory that has just got its clock.
BOOT = masked(POWER_UP, CLOSE_ALL, CLOCKS.precharge - 1, *[REFRESH, CLOCKS.refresh_cycle - 1] * 8, SET_MODE)


def fresh():
    return SdramMemory(CLOCK_HZ, power_up=POWER_UP * PERIOD)


@pytest.fixture
def memory():
    result = fresh()
    run(result, *BOOT, CLOCKS.mode - 1)
    return result


OPEN = [activate(), CLOCKS.active_to_access - 1]
VIOLATIONS = {
    "enable falls": ([NOTHING._replace(enable=0)], "the clock enable falls"),
    "no refresh": ([CLOCKS.refresh_interval], "no refresh for"),
    "tMRD": ([SET_MODE, CLOCKS.mode - 2, REFRESH], "tMRD"),
    "activated twice": ([*OPEN, activate(row=4)], "row 3 is open"),
    "tRP": ([activate(), CLOCKS.active - 1, CLOSE, CLOCKS.precharge - 2, activate()], "tRP"),
    "tRP of a refresh": ([activate(), CLOCKS.active - 1, CLOSE, CLOCKS.precharge - 2, REFRESH], "tRP"),
    "tRRD": ([activate(), activate(1)], "tRRD"),
    "tRFC": ([REFRESH, CLOCKS.refresh_cycle - 2, activate()], "tRFC"),
    "tRAS": ([activate(), CLOCKS.active - 2, CLOSE], "tRAS"),
    "tRAS of all": ([activate(2), CLOCKS.active - 2, CLOSE_ALL], "tRAS"),
    "tWR": ([*OPEN, 5, write(), CLOCKS.write_recovery - 2, CLOSE], "tWR"),
    "tRCD of a read": ([activate(), CLOCKS.active_to_access - 2, READ], "tRCD"),
    "tRCD of a write": ([activate(), CLOCKS.active_to_access - 2, write()], "tRCD"),
    "closed": ([READ], "the bank is closed"),
    "another bank": ([*OPEN, READ._replace(bank=1)], "the bank is closed"),
    "refresh of an open bank": ([*OPEN, 9, REFRESH], "a bank is open"),
    "mode of an open bank": ([*OPEN, 9, SET_MODE], "a bank is open"),
    "another mode": ([SET_MODE._replace(address=MODE + 1)], f"the mode is not {MODE}"),
    "mode of a bank": ([SET_MODE._replace(bank=1)], f"the mode is not {MODE}"),
    "automatic precharge": ([*OPEN, READ._replace(address=ALL)], "automatic precharge"),
    "no such column": ([*OPEN, READ._replace(address=512)], "column 512 is beyond the row"),
    "a write that is not driven": ([*OPEN, write(drive=0)], "data are not driven"),
    "driven for nothing": ([NOTHING._replace(drive=1)], "data are driven without a write"),
    "driven for a read": ([*OPEN, READ._replace(drive=1)], "data are driven without a write"),
    "driven against a word": ([*OPEN, READ, CLOCKS.read_to_write - 2, write()], "data are driven while a word that was read"),
}


@pytest.mark.parametrize("case", VIOLATIONS)
def test_violation(memory, case):
    """All steps but the last one are allowed."""
    *before, last = VIOLATIONS[case][0]
    run(memory, *before)
    with pytest.raises(AssertionError, match=f"ns: .*: {VIOLATIONS[case][1]}"):
        run(memory, last)


@pytest.mark.parametrize("steps, told", [
    ([*masked(POWER_UP - 1, CLOSE_ALL)], "within 50 ns of the first edge"),
    ([POWER_UP, NOTHING], "bytes are not masked"),
    (masked(POWER_UP, CLOSE), "the first one is not of all banks"),
    (masked(POWER_UP, REFRESH), "before all banks were precharged"),
    (masked(POWER_UP, SET_MODE), "before all banks were precharged"),
    (masked(POWER_UP, CLOSE_ALL, CLOCKS.precharge - 2, REFRESH), "tRP"),
    ([*BOOT[:-3], *masked(SET_MODE, 1, activate())], "before the memory is initialised"),
    ([*BOOT[:-1], *masked(activate())], "before the memory is initialised"),
    ([*BOOT[:-1], *masked(READ)], "before the memory is initialised"),
    ([*BOOT, activate()], "tMRD"),
])
def test_initialisation(steps, told):
    memory = fresh()
    *before, last = steps
    run(memory, *before)
    with pytest.raises(AssertionError, match=f"ns: .*{told}"):
        run(memory, last)


def test_row_that_is_open_for_too_long():
    """Which the interval between refreshes, of open banks, does not allow either; so with a chip that is refreshed less often."""
    memory = SdramMemory(CLOCK_HZ, power_up=0, chip=replace(SDRAM, refresh_all=1e12))
    run(memory, *BOOT, 1, activate(), 10_000)
    with pytest.raises(AssertionError, match="bank 0 is open for too long"):
        run(memory, 1)


def test_banks_of_a_slow_clock():
    """Two clocks between activations, however long they are."""
    memory = SdramMemory(10_000_000, power_up=0)
    run(memory, *BOOT, 1, activate(), 1, activate(1))
    with pytest.raises(AssertionError, match="tRRD"):
        run(memory, activate(2))


def test_cycle():
    """tRC is more than tRAS and tRP together in some chips."""
    memory = SdramMemory(CLOCK_HZ, power_up=0, chip=replace(SDRAM, cycle=(CLOCKS.active + CLOCKS.precharge + 1) * PERIOD))
    again = [activate(), CLOCKS.active - 1, CLOSE, CLOCKS.precharge - 1]
    run(memory, *BOOT, 1, *again[:-1], CLOCKS.precharge, *again)
    with pytest.raises(AssertionError, match="tRC"):
        run(memory, activate())


def test_words(memory):
    """Two clocks after a read; bytes that are masked stay, and what was never written is noise."""
    after = [1, NOTHING]
    run(memory, *OPEN, write(word=0x1234), write(2, 0x5678, mask=0b01), write(1, 0xABCD, mask=0b10))
    assert run(memory, READ, *after) == 0x12CD
    other = READ._replace(address=2)
    seen = {run(memory, other, *after) for _ in range(20)}
    assert {word >> 8 for word in seen} == {0x56} and len(seen) > 5
    assert len({run(memory, READ._replace(mask=3), *after) for _ in range(20)}) > 5
    # A word a clock, and a write as early as it may be.
    run(memory, READ, other, READ)
    assert memory.found == 0x12CD
    run(memory, CLOCKS.read_to_write - 1, write(7, 7))
    assert run(memory, READ._replace(address=7), *after) == 7
    assert (memory.words_written, memory.activations, memory.refreshes) == (4, 1, 8)


def test_shortest_times(memory):
    """What each violation above is a clock short of."""
    run(memory, activate(), CLOCKS.active_to_access - 1, activate(1), CLOCKS.active_to_access - 1, write(), 3, write(),
        CLOCKS.write_recovery - 1, CLOSE, CLOCKS.precharge - 1, activate(), CLOCKS.active - 1, CLOSE_ALL, CLOCKS.precharge - 1, REFRESH,
        CLOCKS.refresh_cycle - 1, activate(), CLOCKS.active - 1, CLOSE, CLOCKS.precharge - 1, SET_MODE, CLOCKS.mode - 1, activate())
