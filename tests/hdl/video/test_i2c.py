# amaranth: UnusedElaboratable=no
from itertools import pairwise
from types import SimpleNamespace

import numpy as np
import pytest
from amaranth.sim import Simulator

from golden.video.setup_steps import Failure
from hdl.video.i2c import I2cMaster
from sim.kit.streams import check_rules, receive, send
from sim.models.i2c import I2cBus, amaranth_bus
from sim.models.i2c_chips import Fault, I2cChip


ADDRESS = 0x5C
CLOCK_HZ = 1_000_000
WELL = Failure.NONE


def address(read=False, *, chip=ADDRESS, **flags):
    return {"data": chip << 1 | read, "start": 1, **flags}


def write(register, *data, chip=ADDRESS):
    *before, last = data
    return [address(chip=chip), {"data": register}, *({"data": byte} for byte in before), {"data": last, "stop": 1}]


def read(register, count=1, *, restart=True):
    return [address(), {"data": register, "stop": not restart}, address(True), *({"read": 1} for _ in range(count - 1)),
            {"read": 1, "nack": 1, "stop": 1}]


def run_master(script, *chips, clock_hz=CLOCK_HZ, rise_ns=0, broken=False, stall=0.0, rules=False, **kwargs):
    """Play ``script(master)`` on a master with ``chips``; give back the bus, which is checked, and its lines in each cycle.

    ``await master.do(commands)`` gives ``(data, result)`` of each up to the first that fails; ``await master.idle(cycles)`` waits.
    """
    dut = I2cMaster(clock_hz, **kwargs)
    bus = I2cBus(*chips, rise_ns=rise_ns)
    bus.broken_allowed = broken
    rng = np.random.default_rng(1)
    lines = []
    taken, given = [], []

    async def play(ctx):
        async def transfer(commands):
            responses = []
            # One at a time: a command after a failed one would start another transfer.
            for command in commands:
                await send(ctx, dut.i, [{"start": 0, "read": 0, "nack": 0, "stop": 0, "data": 0xA5, **command}], rng=rng, stall=stall)
                (response,) = await receive(ctx, dut.o, 1, rng=rng, stall=stall)
                responses.append((response.data, response.result))
                if response.result != WELL:
                    break
            return responses

        async def idle(cycles):
            await ctx.tick().repeat(cycles)

        await script(SimpleNamespace(do=transfer, idle=idle, bus=bus))
        await idle(20)

    async def record(ctx):
        async for _ in ctx.tick():
            lines.append((bus.scl, bus.sda, ctx.get(dut.scl_low), ctx.get(dut.sda_low)))

    sim = Simulator(dut)
    sim.add_clock(1 / clock_hz)
    sim.add_testbench(play)
    sim.add_testbench(amaranth_bus(bus, dut, clock_hz=clock_hz), background=True)
    sim.add_testbench(record, background=True)
    if rules:
        sim.add_testbench(check_rules(dut.i, taken, name="i"), background=True)
        sim.add_testbench(check_rules(dut.o, given, name="o"), background=True)
    sim.run()
    assert len(taken) == len(given)
    return bus, lines


def rises(lines):
    """Cycles at which SCL rises."""
    return [cycle for cycle, (before, after) in enumerate(pairwise(lines)) if after[0] > before[0]]


@pytest.mark.parametrize("clock_hz, rise_ns, stretch, stall", [
    (400_000, 0, 0.0, 0.0), (400_000, 0, 0.05, 0.3), (1_000_000, 900, 0.0, 0.0), (1_000_000, 300, 0.1, 0.0), (2_700_000, 900, 0.0, 0.0),
])
def test_transfers(clock_hz, rise_ns, stretch, stall):
    """Bytes of all kinds, one and several, reads after a stop and after a repeated start; the bus's rules are kept to the nanosecond."""
    rng = np.random.default_rng(1)
    chip = I2cChip(ADDRESS, seed=2, stretch=stretch)
    memory = {}

    async def script(master):
        for number, data in enumerate([[0x00], [0xFF], [0x55, 0xAA], rng.integers(0, 256, 3).tolist()]):
            register = int(rng.integers(0, 256))
            commands = write(register, *data)
            assert await master.do(commands) == [(command["data"], WELL) for command in commands]
            memory.update({(register + place) % 256: byte for place, byte in enumerate(data)})
            got = await master.do(read(register, len(data), restart=bool(number % 2)))
            assert got == [(ADDRESS << 1, WELL), (register, WELL), (ADDRESS << 1 | 1, WELL), *((byte, WELL) for byte in data)]

    bus, _ = run_master(script, chip, clock_hz=clock_hz, rise_ns=rise_ns, stall=stall, rules=stall > 0)
    assert chip.registers == memory
    assert (bus.starts, bus.stops) == (4 + 8, 4 + 4 + 2)
    assert (bus.scl, bus.sda) == (1, 1)


def test_many_chips():
    """Each chip accepts only its own transfers."""
    chips = [I2cChip(number, seed=number) for number in (0x00, 0x5C, 0x5D, 0x7F)]

    async def script(master):
        for chip in chips:
            for result in await master.do(write(0x12, chip.address ^ 0xFF, chip=chip.address)):
                assert result[1] == WELL

    run_master(script, *chips)
    assert [chip.writes for chip in chips] == [[(0x12, chip.address ^ 0xFF)] for chip in chips]


def test_timing_at_full_speed():
    """The board's clock: 100 kHz and no less, but for the two cycles that a level takes to be seen."""
    master = I2cMaster(75_000_000)
    assert (master.low, master.high, master.hold, master.stretch) == (405, 345, 23, 75_000)

    async def script(master):
        # A repeated start and a stop too: here the two cycles hide nothing.
        assert await master.do([address(), address(stop=1)]) == [(ADDRESS << 1, WELL)] * 2

    _, lines = run_master(script, I2cChip(ADDRESS), clock_hz=75_000_000)
    at = rises(lines)
    assert len(at) == 9 + 1 + 9 + 1
    assert {after - before for before, after in pairwise(at[:9])} == {750 + 3}


def test_slower_bus():
    slow = I2cMaster(1_000_000, 10_000)
    assert (slow.low, slow.high) == (54, 46)

    async def script(master):
        await master.do([address()])

    _, lines = run_master(script, I2cChip(ADDRESS), bus_hz=10_000)
    at = rises(lines)
    assert {after - before for before, after in pairwise(at)} == {100 + 3}


@pytest.mark.parametrize("register, answered", [(None, 0), (0x12, 1), (-1, 2)])
def test_no_acknowledge(register, answered):
    """A stop follows immediately; the rest of the transfer is not sent; the next transfer succeeds."""
    chip = I2cChip(ADDRESS)
    chip.faults = [Fault("no acknowledge", register, times=1)]

    async def script(master):
        commands = write(0x12, 0x34, 0x56)
        expected = [(command["data"], WELL) for command in commands]
        expected[answered] = (commands[answered]["data"], Failure.NO_ACKNOWLEDGE)
        assert await master.do(commands) == expected[:answered + 1]
        assert master.bus.stops == 1
        for command in ({"data": 0x77}, {"read": 1, "stop": 1}):
            ((_, result),) = await master.do([command])
            assert result == Failure.NO_ACKNOWLEDGE
        assert (master.bus.starts, master.bus.stops) == (1, 1)
        assert {result for _, result in await master.do(write(0x13, 0x57))} == {WELL}

    run_master(script, chip)
    assert chip.writes[-1] == (0x13, 0x57)


def test_nobody_there():
    async def script(master):
        assert await master.do(write(0x12, 0x34)) == [(ADDRESS << 1, Failure.NO_ACKNOWLEDGE)]

    bus, _ = run_master(script)
    assert (bus.starts, bus.stops) == (1, 1)


@pytest.mark.parametrize("stretch_ns, result", [(180_000, WELL), (220_000, Failure.CLOCK_HELD)])
def test_limit_of_stretching(stretch_ns, result):
    """Up to the limit, counted from the master's release of SCL, transfers succeed."""
    class Slow(I2cChip):
        def on_fall(self, now):
            super().on_fall(now)
            if self.count == 4:             # the master sends a zero
                self._hold_scl(now, stretch_ns)

    async def script(master):
        assert (await master.do([address()]))[0][1] == result

    _, lines = run_master(script, Slow(ADDRESS), stretch_seconds=200e-6, broken=True)
    assert lines[-1][2:] == ((1, 0) if result == WELL else (0, 0))


@pytest.mark.parametrize("register, commands", [(None, 0), (0x12, 1), (-1, 2)])
def test_clock_held_for_ever(register, commands):
    """Both lines are released; once the chip releases them too, the next transfer succeeds."""
    chip = I2cChip(ADDRESS)
    chip.faults = [Fault("clock", register, times=1)]

    async def script(master):
        responses = await master.do(write(0x12, 0x34, 0x56))
        assert [result for _, result in responses] == [WELL] * commands + [Failure.CLOCK_HELD]
        # SCL is still low as the next transfer begins.
        assert [result for _, result in await master.do([address()])] == [Failure.CLOCK_HELD]
        chip.release()
        assert {result for _, result in await master.do(write(0x13, 0x57))} == {WELL}

    _, lines = run_master(script, chip, stretch_seconds=300e-6, broken=True)
    held = max(len(run) for run in "".join(str(line[0]) for line in lines).split("1"))
    assert 600 < held < 650
    assert chip.writes[-1] == (0x13, 0x57)


@pytest.mark.parametrize("out", [0x00, 0x55, 0xAA, 0xFE, 0xF7])
@pytest.mark.parametrize("place", range(8))
def test_recovery_of_a_chip_that_sends(place, out):
    """A chip is left in the middle of a byte that it sends, as by a reset of the master: if SDA is low, it is clocked out of it."""
    chip = I2cChip(ADDRESS)
    chip.state, chip.sending, chip.out, chip.count = "read", True, out, place
    chip.sda_low = not out >> (7 - place) & 1

    async def script(master):
        assert [result for _, result in await master.do(write(0x12, 0x34))] == [WELL] * 3

    run_master(script, chip, broken=True)
    assert chip.writes == [(0x12, 0x34)]


def test_recovery_of_a_chip_that_acknowledges():
    """One clock, and it waits for data: eight more would write them."""
    chip = I2cChip(ADDRESS)
    chip.state, chip.count, chip.register, chip.sda_low = "write", 8, 0x66, True

    async def script(master):
        assert [result for _, result in await master.do(write(0x12, 0x34))] == [WELL] * 3

    run_master(script, chip, broken=True)
    assert chip.writes == [(0x12, 0x34)]


@pytest.mark.parametrize("clocks", [1, 2, 9, 10, 11, np.inf])
def test_recovery_has_nine_clocks(clocks):
    chip = I2cChip(ADDRESS)
    chip.holding, chip.sda_low = clocks, True

    async def script(master):
        result = [result for _, result in await master.do(write(0x12, 0x34))]
        # The pulse of the stop begins with the tenth fall of SCL.
        if clocks <= 10:
            assert result == [WELL] * 3
        else:
            assert result == [Failure.DATA_HELD]
            assert master.bus.starts == 0
            await master.idle(50)
            chip.release()
            await master.idle(50)
            assert [result for _, result in await master.do(write(0x12, 0x34))] == [WELL] * 3

    _, lines = run_master(script, chip, broken=True)
    assert chip.writes == [(0x12, 0x34)]
    if clocks > 10:
        released = next(cycle for cycle, line in enumerate(lines) if line[1])
        assert len([at for at in rises(lines) if at < released]) == 10      # nine, and the one of the stop


def test_data_held_within_a_transfer():
    """SDA low where a one is sent."""
    chip = I2cChip(ADDRESS)
    chip.faults = [Fault("data", 0x12, times=1)]

    async def script(master):
        assert [result for _, result in await master.do(write(0x12, 0x08))] == [WELL, WELL, Failure.DATA_HELD]
        assert [result for _, result in await master.do(write(0x12, 0x08))] == [Failure.DATA_HELD]
        chip.release()
        assert [result for _, result in await master.do(write(0x12, 0x08))] == [WELL] * 3

    run_master(script, chip, broken=True)
    assert chip.writes == [(0x12, 0x08)]


def test_data_held_at_a_repeated_start():
    chip = I2cChip(ADDRESS)
    chip.faults = [Fault("data", 0x12, times=1)]

    async def script(master):
        assert [result for _, result in await master.do(read(0x12))] == [WELL, WELL, Failure.DATA_HELD]
        assert master.bus.starts == 1

    _, lines = run_master(script, chip, broken=True)
    assert lines[-1][2:] == (0, 0)


def test_clock_that_bounces():
    """SCL is seen low again after it was seen high: its high time restarts."""
    dut = I2cMaster(CLOCK_HZ)

    async def testbench(ctx):
        ctx.set(dut.i.payload, address())
        ctx.set(dut.i.valid, 1)
        await ctx.tick().repeat(dut.low - 1)
        ctx.set(dut.scl_i, 0)
        await ctx.tick()
        ctx.set(dut.scl_i, 1)
        for _ in range(dut.low):
            await ctx.tick()
            assert not ctx.get(dut.sda_low)
        await ctx.tick().repeat(4)
        assert ctx.get(dut.sda_low)

    sim = Simulator(dut)
    sim.add_clock(1 / CLOCK_HZ)
    sim.add_testbench(testbench)
    sim.run()


def test_bus_is_held_between_commands():
    """Nothing moves while the response waits, nor until the next command."""
    async def script(master):
        await master.do([address()])
        await master.idle(200)
        await master.do([{"data": 0x12}])

    _, lines = run_master(script, I2cChip(ADDRESS))
    at = rises(lines)
    assert len(at) == 18
    gap = lines[at[8] + 10:at[9] - 8]
    assert len(gap) > 180
    assert {(scl, scl_low) for scl, _, scl_low, _ in gap} == {(0, 1)}


@pytest.mark.parametrize("arguments, message", [
    ({"clock_hz": 1_000_000, "bus_hz": 0}, r"from 1 to 100000, .* not 0$"),
    ({"clock_hz": 1_000_000, "bus_hz": 100_001}, r"from 1 to 100000, .* not 100001$"),
    ({"clock_hz": 399_999}, r"at least four times bus_hz, 400000, not 399999$"),
    ({"clock_hz": 1_000_000, "stretch_seconds": 0}, r"greater than 0, not 0$"),
])
def test_bad_parameters(arguments, message):
    with pytest.raises(ValueError, match=message):
        I2cMaster(**arguments)
