# amaranth: UnusedElaboratable=no
import random
from collections import deque

import pytest
from amaranth.sim import Simulator

from golden.video.bandwidth import grant_clocks, served_clocks
from golden.video.memory_map import WORD_BYTES
from hdl.video.arbiter import Arbiter
from sim.models.ddr2 import Ddr2Timing, LocalMemory, serve


ALL_BYTES = 2**WORD_BYTES - 1
REGION = 64     # words that each writer has for itself


class Log:
    """What a master's bursts took: clocks from request to grant, and to the last word."""
    def __init__(self):
        self.grants, self.ends, self.words = [], [], []


async def write(ctx, port, bursts, log, rng, pause):
    """Bursts of (address, words with byte enables), one after another; with pauses, a word may be late."""
    for address, words in bursts:
        while rng.random() < pause:
            await ctx.tick()
        words = deque(words)
        ctx.set(port.request.payload, {"address": address, "length": len(words)})
        ctx.set(port.request.valid, 1)
        late = rng.random() < pause
        ctx.set(port.word.valid, int(not late))
        for clock in range(1, 10_000):
            if words and not late:
                ctx.set(port.word.payload, {"data": words[0][0], "be": words[0][1]})
            *_, granted, taken, accepted = await ctx.tick().sample(port.request.ready, port.word.ready, port.accepted)
            if granted:
                log.grants.append(clock)
                ctx.set(port.request.valid, 0)
            if taken:
                words.popleft()
                ctx.set(port.word.valid, 0)
            if words and (taken or late) and not (late := rng.random() < pause):
                ctx.set(port.word.valid, 1)
            if accepted:
                break
        else:
            raise TimeoutError(f"burst at {address} not accepted")
        assert not words
        log.ends.append(clock)


async def read(ctx, port, bursts, log, rng, pause, most=48):
    """Bursts of (address, length); a burst is requested while there is space for its words."""
    requested, granted_at, in_flight, clock = deque(), deque(), 0, 0
    bursts = deque(bursts)
    while bursts or requested or granted_at:
        if bursts and not requested and in_flight + bursts[0][1] <= most and rng.random() >= pause:
            requested.append((clock, bursts.popleft()))
            address, length = requested[0][1]
            ctx.set(port.request.payload, {"address": address, "length": length})
            ctx.set(port.request.valid, 1)
            in_flight += length
        *_, granted, valid, last, word = await ctx.tick().sample(port.request.ready, port.rdata_valid, port.rdata_last, port.rdata)
        clock += 1
        if granted:
            begun, (_, length) = requested.popleft()
            log.grants.append(clock - begun)
            granted_at.append(length)
            ctx.set(port.request.valid, 0)
        if valid:
            log.words.append(word)
            granted_at[0] -= 1
            in_flight -= 1
            assert last == (granted_at[0] == 0)
            if last:
                granted_at.popleft()
        assert clock < 100_000


def run(dut, memory, tasks, *, rng, pause=0.0):
    """Run the masters' bursts: ``tasks`` are of the writers, then of the readers. Return their logs and the clocks until all are done."""
    logs = [Log() for _ in tasks]
    sim = Simulator(dut)
    sim.add_clock(1e-6)
    for port, bursts, log in zip([*dut.write, *dut.read], tasks, logs):
        drive = write if port in [*dut.write] else read

        async def testbench(ctx, drive=drive, port=port, bursts=bursts, log=log):
            await drive(ctx, port, bursts, log, rng, pause)

        sim.add_testbench(testbench)
    sim.add_process(serve(dut.bus, memory))
    sim.run()
    return logs


def noise_bursts(number, count, burst, rng):
    """A writer's bursts within its region."""
    bursts = []
    for _ in range(count):
        length = rng.choice([1, burst, rng.randint(1, burst)])
        address = number * REGION + rng.randrange(REGION - length + 1)
        bursts.append((address, [(rng.getrandbits(128), rng.choice([ALL_BYTES, rng.getrandbits(WORD_BYTES), 0])) for _ in range(length)]))
    return bursts


def enabled(word, be):
    return {n: word >> 8 * n & 0xff for n in range(WORD_BYTES) if be >> n & 1}


@pytest.mark.parametrize("pause", [0.0, 0.6])
@pytest.mark.parametrize("writers, readers, burst, size",
                         [(1, 1, 1, 1), (2, 1, 16, 1), (3, 2, 16, 4), (2, 3, 8, 8), (1, 2, 5, 16), (4, 2, 7, 3)])
def test_words_arrive(writers, readers, burst, size, pause):
    """Bursts of all lengths, byte enables at random; then everything is read, by all readers at once."""
    rng = random.Random(1)
    dut = Arbiter(writers, readers, burst=burst, size=size)
    memory = LocalMemory(writers * REGION, size=size, timing=Ddr2Timing(busy=0.5, refresh=(150, 12)))
    tasks = [noise_bursts(number, 12, burst, rng) for number in range(writers)]
    bytes_expected = {}
    for bursts in tasks:
        for address, words in bursts:
            for n, (word, be) in enumerate(words):
                bytes_expected.setdefault(address + n, {}).update(enabled(word, be))
    run(dut, memory, [*tasks, *[[] for _ in range(readers)]], rng=rng, pause=pause)
    assert memory.words_written == sum(len(words) for bursts in tasks for _, words in bursts)

    everywhere = [(address, min(rng.randint(1, burst), writers * REGION - address)) for address in range(0, writers * REGION, 3)]
    dut = Arbiter(writers, readers, burst=burst, size=size)
    memory.now, memory.init_done, memory.ready = 0, 0, 0
    logs = run(dut, memory, [*[[] for _ in range(writers)], *[everywhere[n::readers] for n in range(readers)]], rng=rng, pause=pause)
    checked = 0
    for log, bursts in zip(logs[writers:], [everywhere[n::readers] for n in range(readers)]):
        places = [address + n for address, length in bursts for n in range(length)]
        assert len(log.words) == len(places) > 0
        for place, word in zip(places, log.words):
            for byte, value in bytes_expected.get(place, {}).items():
                assert word >> 8 * byte & 0xff == value
                checked += 1
    assert checked > 40


@pytest.mark.parametrize("size", [1, 4])
def test_a_read_after_accepted_sees_the_burst(size):
    """A writer and a reader take turns; the other masters write and read elsewhere meanwhile."""
    rng = random.Random(2)
    dut = Arbiter(2, 2, size=size)
    memory = LocalMemory(2 * REGION, size=size, timing=Ddr2Timing(busy=0.4))
    log, seen = Log(), Log()
    bursts = [(rng.randrange(40), [(rng.getrandbits(128), ALL_BYTES) for _ in range(rng.randint(1, 16))]) for _ in range(15)]

    async def testbench(ctx):
        for address, words in bursts:
            await write(ctx, dut.write[0], [(address, words)], log, rng, 0.0)
            seen.words.clear()
            await read(ctx, dut.read[1], [(address, len(words))], seen, rng, 0.0)
            assert seen.words == [word for word, _ in words]

    async def elsewhere(ctx):
        await write(ctx, dut.write[1], noise_bursts(1, 30, 16, rng), Log(), rng, 0.2)

    async def elsewhere_too(ctx):
        await read(ctx, dut.read[0], [(REGION + n, 7) for n in range(30)], Log(), rng, 0.2)

    sim = Simulator(dut)
    sim.add_clock(1e-6)
    for process in (testbench, elsewhere, elsewhere_too):
        sim.add_testbench(process)
    sim.add_process(serve(dut.bus, memory))
    sim.run()


NO_REFRESH = (10**9, 0)


@pytest.mark.parametrize("writers, readers, burst, patience", [(4, 2, 16, 0), (4, 2, 16, 2), (2, 1, 5, 1), (1, 1, 4, 3), (3, 3, 1, 1)])
@pytest.mark.parametrize("stall", [0, 100])
def test_latency_is_within_the_formula(writers, readers, burst, patience, stall):
    """Every master requests all the time and the memory is as slow as its pace allows: the bound holds, and is tight."""
    rng = random.Random(3)
    timing = Ddr2Timing(init=1, busy=1.0 if patience else 0.0, patience=patience, refresh=NO_REFRESH, stalls=((60, stall),))
    memory = LocalMemory(timing=timing)
    dut = Arbiter(writers, readers, burst=burst)
    full = [(address, [(rng.getrandbits(128), ALL_BYTES)] * burst) for address in range(10)]
    logs = run(dut, memory, [*[full for _ in range(writers)], *[[(5, burst)] * 10 for _ in range(readers)]], rng=rng)
    masters, pace = writers + readers, patience + 1
    granted = max(clocks for log in logs for clocks in log.grants)
    ended = max(clocks for log in logs for clocks in log.ends)
    assert granted <= grant_clocks(masters, burst, pace, stall)
    assert ended <= served_clocks(masters, burst, pace, stall)
    assert granted >= (masters - 1) * burst * pace + stall - pace
    assert ended >= masters * burst * pace + stall - pace


def test_a_word_a_clock():
    """The bus does not idle while there are requests, across bursts and masters, for reads and writes."""
    rng = random.Random(4)
    dut = Arbiter(2, 2, burst=8)
    memory = LocalMemory(timing=Ddr2Timing(init=1, busy=0.0, refresh=NO_REFRESH, latency=(10, 10)))
    requests = []

    async def watch(ctx):
        async for *_, read_req, write_req in ctx.tick().sample(dut.bus.read_req, dut.bus.write_req):
            requests.append(read_req | write_req)

    full = [(address, [(rng.getrandbits(128), ALL_BYTES)] * 8) for address in range(10)]
    sim = Simulator(dut)
    sim.add_clock(1e-6)
    for port in dut.write:
        async def writer(ctx, port=port):
            await write(ctx, port, full, Log(), rng, 0.0)
        sim.add_testbench(writer)
    for port in dut.read:
        async def reader(ctx, port=port):
            await read(ctx, port, [(0, 8)] * 10, Log(), rng, 0.0)
        sim.add_testbench(reader)
    sim.add_process(serve(dut.bus, memory))
    sim.add_testbench(watch, background=True)
    sim.run()
    assert sum(requests) == 4 * 80
    first = requests.index(1)
    assert all(requests[first:first + 300])


def test_round_robin():
    """Each is served once before any is served twice."""
    dut = Arbiter(3, 2, burst=4)
    memory = LocalMemory(timing=Ddr2Timing(init=1))
    rng = random.Random(5)
    order = []

    async def watch(ctx):
        ready = [port.request.ready for port in (*dut.write, *dut.read)]
        async for *_, in ctx.tick():
            order.extend(n for n, signal in enumerate(ready) if ctx.get(signal))

    words = [(0, [(1, ALL_BYTES)] * 4)] * 8
    tasks = [words] * 3 + [[(0, 4)] * 8] * 2
    sim = Simulator(dut)
    sim.add_clock(1e-6)
    for number, port in enumerate((*dut.write, *dut.read)):
        async def drive(ctx, number=number, port=port):
            await (write if number < 3 else read)(ctx, port, tasks[number], Log(), rng, 0.0)
        sim.add_testbench(drive)
    sim.add_process(serve(dut.bus, memory))
    sim.add_testbench(watch, background=True)
    sim.run()
    assert order == [0, 1, 2, 3, 4] * 8


def test_a_memory_may_wait_for_requests():
    """``ready`` is low until there is a request."""
    dut = Arbiter(1, 1)

    async def memory(ctx):
        ctx.set(dut.bus.init_done, 1)
        async for *_, request, ready in ctx.tick().sample(dut.bus.write_req | dut.bus.read_req, dut.bus.ready):
            ctx.set(dut.bus.ready, request & ~ready)

    log = Log()

    async def testbench(ctx):
        await write(ctx, dut.write[0], [(7, [(n, ALL_BYTES)] * 3) for n in range(4)], log, random.Random(1), 0.0)

    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_testbench(testbench)
    sim.add_process(memory)
    sim.run()
    assert len(log.ends) == 4


def test_many_bursts_in_flight():
    """More bursts of one word than may be in flight: reads wait, none is lost, and writes are granted."""
    dut = Arbiter(1, 1, outstanding=4)
    memory = LocalMemory(timing=Ddr2Timing(init=1, busy=0.0, latency=(40, 40)))
    for address in range(100):
        memory[address] = address
    written = Log()
    words = [(200 + n, [(n, ALL_BYTES)]) for n in range(20)]
    rng = random.Random(6)
    writer, reader = run(dut, memory, [words, [(n, 1) for n in range(100)]], rng=rng)
    assert reader.words == list(range(100))
    assert max(reader.grants) > 30
    assert max(writer.grants) < 10
    assert written.words == []


@pytest.mark.parametrize("parameter", ["writers", "readers", "burst", "size"])
def test_bad_parameters(parameter):
    with pytest.raises(ValueError, match=rf"{parameter} of the arbiter must be at least 1, not 0"):
        Arbiter(**{"writers": 1, "readers": 1, parameter: 0})
    with pytest.raises(ValueError, match=r"outstanding of the arbiter must be at least 4, not 3"):
        Arbiter(1, 1, outstanding=3)
