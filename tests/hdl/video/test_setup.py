# amaranth: UnusedElaboratable=no
from dataclasses import replace

import pytest

from golden.video.setup_steps import Chip, Drive, Failure, Lock, Poll, Write
from hdl.video.setup import ChipSetup
from sim.models.i2c_chips import Fault, I2cChip
from tests.hdl.video.chip_setups import CLOCK_HZ, TICK, run_setup


ADDRESS = 0x31

#: Small, with a step of each kind in every place.
SMALL = Chip(
    name="small", address=ADDRESS, pins=("reset", "mode"), channels=2,
    setup=(
        Drive("off", 0.0003, (0, 1)),
        Drive("on", 0.0001, (1, 0)),
        Write("first", 0, 0x10, 0xC3),
        Poll("ready", 0.004, 0x20, 0x14, 0x3C),
        Write("last", 0, 0x11, 0x5A),
    ),
    watch=(
        Write("select", 0.002, 0x12, 0x01),
        Lock("one", 0.002, 0x30, 0x06, 0x06, channel=0),
        Poll("alive", 0, 0x10, 0xC3),
        Lock("two", 0.002, 0x31, 0x80, 0xA0, channel=1),
    ),
)
READY = 0xD7            # is 14 under the mask 3C


class SmallModel(I2cChip):
    def __init__(self, **kwargs):
        super().__init__(ADDRESS, **kwargs)
        self.registers = {0x20: READY}
        self.reads = []

    def read(self, now, register):
        self.reads.append(register)
        return super().read(now, register)


def test_chip_that_is_not_watched():
    model = SmallModel()

    async def script(watched):
        await watched.until("done")
        starts = watched.bus.starts
        await watched.idle(3000)
        assert (watched.get("done"), watched.get("reset"), watched.bus.starts) == (1, 1, starts)

    run_setup(replace(SMALL, watch=(), channels=0), model, script)


def test_pins_and_times():
    """Levels out of reset, then in order; waits are as long as they should be, within a tick."""
    model = SmallModel()

    async def script(watched):
        assert (watched.get("reset"), watched.get("mode")) == (0, 1)
        assert 3 * TICK <= await watched.until("reset") <= 3 * TICK + 10
        assert watched.get("mode") == 0
        waited = 0
        while watched.bus.starts == 0:
            await watched.idle()
            waited += 1
        assert TICK <= waited <= TICK + 15
        await watched.until("done")
        # From one round to the next: five ticks without a start.
        starts, quiet, longest = watched.bus.starts, 0, 0
        for _ in range(3000):
            await watched.idle()
            quiet = quiet + 1 if watched.bus.starts == starts else 0
            longest, starts = max(longest, quiet), watched.bus.starts
        rounds = model.reads.count(0x31)
        assert rounds >= 2
        assert 5 * TICK + 25 * 5 < longest < 5 * TICK + 60 * 8
        assert model.writes == [(0x10, 0xC3), (0x11, 0x5A)] + [(0x12, 0x01)] * (len(model.writes) - 2)

    run_setup(SMALL, model, script)


def test_poll_under_mask():
    """Read again and again until the value is there; what it was before is no failure."""
    model = SmallModel()
    model.registers[0x20] = READY ^ 0x04

    async def script(watched):
        while model.reads.count(0x20) < 3:
            await watched.idle()
        model.registers[0x20] = READY ^ 0xC3
        await watched.until("done")
        assert watched.status == (0, Failure.NONE, 0)

    run_setup(SMALL, model, script)


@pytest.mark.parametrize("ticks", [4, 8])
def test_longest_time_is_a_power_of_two(ticks):
    """Of a step, and of the pauses: no tick of it is lost."""
    chip = replace(SMALL, setup=(replace(SMALL.setup[0], seconds=ticks * 1e-4), *SMALL.setup[1:3]), watch=SMALL.watch[:1])
    model = SmallModel()

    async def script(watched):
        assert ticks * TICK <= await watched.until("reset") <= ticks * TICK + 10
        await watched.until("done")
        model.faults = [Fault("no acknowledge", None, times=3)]
        await watched.until("failures", 1)
        assert ticks * TICK <= await watched.until("reset", 0) <= ticks * TICK + 10

    pause = ticks * 1e-4
    run_setup(replace(chip, watch=(replace(chip.watch[0], seconds=0),)), model, script, pause_seconds=pause, watch_seconds=0)


def poll_fails(kind):
    def start(model):
        if kind == "value":
            model.registers[0x20] = READY ^ 0x20
        else:
            model.faults = [Fault(kind, 0x20, nanoseconds=600_000)]
    return start


@pytest.mark.parametrize("start, step, reason", [
    (lambda model: model.faults.append(Fault("no acknowledge", None)), 2, Failure.NO_ACKNOWLEDGE),
    (lambda model: model.faults.append(Fault("clock", 0x10, nanoseconds=600_000)), 2, Failure.CLOCK_HELD),
    (lambda model: model.faults.append(Fault("data", 0x10, clocks=12)), 2, Failure.DATA_HELD),
    (poll_fails("value"), 3, Failure.NOT_READY),
    (poll_fails("no acknowledge"), 3, Failure.NO_ACKNOWLEDGE),
    (poll_fails("clock"), 3, Failure.CLOCK_HELD),
    (lambda model: model.faults.append(Fault("no acknowledge", 0x11)), 4, Failure.NO_ACKNOWLEDGE),
    (lambda model: model.faults.append(Fault("clock", 0x11, nanoseconds=600_000)), 4, Failure.CLOCK_HELD),
])
def test_fails_and_recovers(start, step, reason):
    """All attempts, each from the first step on; then the bus is idle, until ``restart`` after the fault has ended."""
    model = SmallModel()
    start(model)

    async def script(watched):
        await watched.until("failures", 1)
        assert watched.status == (step, reason, 1)
        assert watched.get("busy")
        # After the pause.
        assert await watched.until("reset", 0) >= 5 * TICK
        assert watched.get("busy")
        await watched.until("failed")
        assert watched.status == (step, reason, 2)
        starts = watched.bus.starts
        await watched.idle(1000)
        assert (watched.status, watched.bus.starts) == ((step, reason, 2), starts)
        model.faults, model.registers[0x20] = [], READY
        await watched.restart()
        await watched.until("busy")
        assert watched.status == (0, Failure.NONE, 2)
        await watched.until("done")
        assert watched.status == (0, Failure.NONE, 2)

    run_setup(SMALL, model, script, broken=True)


def test_second_try_succeeds():
    """What failed stays to be read; a later failure while watched has all tries again."""
    model = SmallModel()
    model.faults = [Fault("no acknowledge", 0x11, times=1)]

    async def script(watched):
        await watched.until("failures", 1)
        assert await watched.until("reset", 0) >= 5 * TICK
        await watched.until("done")
        assert watched.status == (4, Failure.NO_ACKNOWLEDGE, 1)
        model.faults = [Fault("no acknowledge", None)]
        await watched.until("failures", 2)
        assert watched.get("busy")
        step, reason, _ = watched.status
        assert step >= len(SMALL.setup)
        assert reason == Failure.NO_ACKNOWLEDGE
        for failures in (3, 4):
            await watched.until("failures", failures)
            assert watched.status == (2, Failure.NO_ACKNOWLEDGE, failures)
        assert watched.get("failed")

    run_setup(SMALL, model, script)


def test_tries_are_counted_from_each_success():
    model = SmallModel()

    async def script(watched):
        for failures in range(1, 8, 2):
            model.faults = [Fault("no acknowledge", 0x11, times=1)]     # the set-up fails once
            await watched.until("failures", failures)
            await watched.until("done")
            model.registers[0x10] = 0x00                                # and once when done
            await watched.until("done", 0)
            assert watched.status == (7, Failure.NOT_READY, failures + 1)

    run_setup(SMALL, model, script)


def test_only_try_is_not_spent_by_a_failure_while_watched():
    model = SmallModel()

    async def script(watched):
        await watched.until("done")
        model.registers[0x10] = 0x00
        await watched.until("done", 0)
        assert watched.get("busy")
        await watched.until("done")
        assert watched.status == (7, Failure.NOT_READY, 1)

    run_setup(SMALL, model, script, tries=1)


def test_locks():
    """Each channel by its register and mask; low from a failure on until it is read again."""
    model = SmallModel()

    async def script(watched):
        await watched.until("done")
        for one, two, locked in ((0x06, 0x00, 1), (0x07, 0x80, 3), (0x02, 0xDF, 2), (0x04, 0xA0, 0), (0xFE, 0x9F, 3)):
            model.registers.update({0x30: one, 0x31: two})
            await watched.idle(2500)
            assert watched.get("locked") == locked
        model.registers[0x10] = 0x00
        await watched.until("locked", 0)
        assert watched.get("busy")
        await watched.until("done")
        await watched.until("locked", 3)

    run_setup(SMALL, model, script)


@pytest.mark.parametrize("register", [0x12, 0x30, 0x31])
def test_one_bad_transfer_while_watched_is_forgiven(register):
    model = SmallModel()
    model.registers.update({0x30: 0x06, 0x31: 0x80})

    async def script(watched):
        await watched.until("locked", 3)
        model.faults = [Fault("no acknowledge", register, times=2)]
        for _ in range(30):
            await watched.idle(100)
            assert (watched.get("done"), watched.get("locked")) == (1, 3)
        assert model.faults[0].times == 0
        assert watched.status == (0, Failure.NONE, 0)

    run_setup(SMALL, model, script)


@pytest.mark.parametrize("register, step", [(0x12, 5), (0x30, 6), (0x10, 7), (0x31, 8)])
def test_chip_that_stops_answering(register, step):
    model = SmallModel()

    async def script(watched):
        await watched.until("done")
        model.faults = [Fault("no acknowledge", register)]
        await watched.until("done", 0)
        assert watched.status == (step, Failure.NO_ACKNOWLEDGE, 1)
        model.faults = []
        await watched.until("done")

    run_setup(SMALL, model, script)


@pytest.mark.parametrize("cycles", [5, 100, 200, 317, 333, 600, 1100, 1500, 1777])
def test_restart(cycles):
    """At any time, in the middle of a byte too: the transfer ends first, then the set-up is repeated."""
    model = SmallModel()

    async def script(watched):
        await watched.idle(cycles)
        await watched.restart()
        await watched.until("reset", 0, cycles=300)
        assert watched.get("busy")
        assert not watched.bus.busy
        del model.writes[:]
        await watched.until("done")
        assert model.writes == [(0x10, 0xC3), (0x11, 0x5A)]
        assert watched.status == (0, Failure.NONE, 0)

    run_setup(SMALL, model, script)


def test_restart_when_locked():
    """Not locked any more, as long as it is set up."""
    model = SmallModel()
    model.registers.update({0x30: 0x06, 0x31: 0x80})

    async def script(watched):
        await watched.until("locked", 3)
        await watched.restart()
        await watched.until("done", 0)
        assert watched.get("locked") == 0
        await watched.until("locked", 3)

    run_setup(SMALL, model, script)


def test_restart_while_pausing():
    """It does not wait, and has all tries."""
    model = SmallModel()
    model.faults = [Fault("no acknowledge", 0x10, times=2)]

    async def script(watched):
        await watched.until("failures", 1)
        await watched.restart()
        assert await watched.until("reset", 0) < 5
        await watched.until("failures", 2)
        assert watched.get("busy")
        await watched.until("done")

    run_setup(SMALL, model, script)


def test_count_of_failures_stays_at_its_greatest():
    model = SmallModel()
    model.faults = [Fault("no acknowledge", None)]

    async def script(watched):
        watched.ctx.set(watched.dut.failures, 2**16 - 2)
        await watched.until("failures", 2**16 - 1)
        await watched.until("failed")
        assert watched.get("failures") == 2**16 - 1

    run_setup(SMALL, model, script)


@pytest.mark.parametrize("arguments, message", [
    ({"tries": 0}, r"at least 1 try, not 0$"),
    ({"pause_seconds": -1}, r"pause_seconds must be 0 or more, not -1$"),
    ({"watch_seconds": float("nan")}, r"watch_seconds must be 0 or more, not nan$"),
])
def test_bad_parameters(arguments, message):
    with pytest.raises(ValueError, match=message):
        ChipSetup(SMALL, CLOCK_HZ, **arguments)
