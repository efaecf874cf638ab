# amaranth: UnusedElaboratable=no
"""hdl.loop.sdram and its stores with the strict model of the memory: words, turns, a monitor that is never late, clocks a pixel."""

import random
from dataclasses import replace
from functools import partial
from itertools import groupby

import numpy as np
import pytest
from amaranth.hdl import ClockDomain, DomainRenamer, Module
from amaranth.lib import wiring
from amaranth.sim import Simulator

from golden.config import MatcherConfig, OnePass, changed
from golden.video.formats import VGA, DisplayFormat
from golden.video.sdram import SDRAM
from golden.video.side_by_side import side_by_side
from hdl.loop.sdram import HALF_BITS, SdramController
from hdl.loop.sdram_store import BURST, SdramStores, WordArbiter
from hdl.video.side_by_side import SideBySide
from sim.models.monitor import Monitor, watch_amaranth
from sim.models.sdram import SdramMemory, serve_sdram
from tests.kit import refused_components


CLOCK_HZ = 60_000_000
SHORT = 30      # clocks of the pause after power-up, which is 12,000
CONFIG = MatcherConfig(4, 6, method=changed(OnePass(), arithmetic="linear"))


def memory_of(clock_hz=CLOCK_HZ):
    """The model, and what the controller keeps: clocks, but for a short pause."""
    return SdramMemory(clock_hz, power_up=SHORT * 1e9 / clock_hz), replace(SDRAM.clocks(clock_hz), power_up=SHORT + 1)


@pytest.mark.parametrize("clock_hz, accesses", [(CLOCK_HZ, 400), (100_000_000, 120), (20_000_000, 120)])
def test_words(clock_hz, accesses):
    """Reads find what was written last, with their tags, whatever rows, banks, directions and pauses; refreshes are in time."""
    memory, clocks = memory_of(clock_hz)
    dut = SdramController(clocks, 4)
    rng = random.Random(clock_hz)
    words, wanted, found = {}, [], []
    delays = []

    async def access(ctx):
        address = 0
        for number in range(accesses):
            jump = rng.random() < 0.15
            address = rng.choice([0, 1 << HALF_BITS]) + rng.choice([0, 510, 1022, 5 << 10]) + rng.randrange(4) if jump else address + 1
            write = address not in words or rng.random() < 0.4
            word, written = rng.getrandbits(16), rng.choice([1, 2, 3]) if address in words else 3
            ctx.set(dut.i.p, {"address": address, "write": write, "data": word, "bytes": written, "tag": number % 16})
            ctx.set(dut.i.valid, 1)
            waited = 0
            while not ctx.get(dut.i.ready):
                await ctx.tick()
                waited += 1
            delays.append(waited)
            await ctx.tick()
            ctx.set(dut.i.valid, 0)
            if write:
                mask = {1: 0xFF, 2: 0xFF00, 3: 0xFFFF}[written]
                words[address] = words.get(address, 0) & ~mask | word & mask
            else:
                wanted.append((words[address], number % 16))
            if rng.random() < 0.05:
                await ctx.tick().repeat(rng.choice([1, 7, 300]))
        await ctx.tick().repeat(SdramController.LATENCY)

    async def receive(ctx):
        async for _, _, valid, word, tag in ctx.tick().sample(dut.valid, dut.found, dut.tag):
            if valid:
                found.append((word, tag))
    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_process(serve_sdram(dut.memory, memory))
    simulator.add_testbench(access)
    simulator.add_process(receive)
    simulator.run()
    assert found == wanted and len(found) > accesses / 10
    # After the first one, which waits for the initialisation.
    assert max(delays[1:]) <= dut.refresh_clocks + dut.row_clocks + clocks.read_to_write and delays.count(0) > accesses / 2
    assert memory.refreshes > 8


def test_first_refresh():
    """It is in time even if a row is opened just before it is due."""
    clock_hz = 100_000_000
    memory, clocks = memory_of(clock_hz)
    dut = SdramController(clocks, 1)
    late = []

    async def access(ctx, pause):
        while memory.refreshes < 8:
            await ctx.tick()
        await ctx.tick().repeat(pause)
        ctx.set(dut.i.p, {"write": 1, "bytes": 3})
        ctx.set(dut.i.valid, 1)
        await ctx.tick().until(dut.i.ready)
        ctx.set(dut.i.valid, 0)
        late.append(memory.refreshes == 9)
        await ctx.tick().repeat(3 * dut.row_clocks)

    for pause in range(clocks.refresh_interval - 3 * dut.row_clocks, clocks.refresh_interval):
        memory, _ = memory_of(clock_hz)
        dut = SdramController(clocks, 1)
        simulator = Simulator(dut)
        simulator.add_clock(1e-6)
        simulator.add_process(serve_sdram(dut.memory, memory))
        simulator.add_testbench(partial(access, pause=pause))
        simulator.run()
        assert (memory.refreshes, memory.words_written) == (9, 1)
    assert set(late) == {False, True}


@pytest.mark.parametrize("seed", range(3))
def test_arbiter(seed):
    """A client goes on for a burst, then the first one is next, and as soon as a client pauses; nothing is lost, in any client's order."""
    dut = WordArbiter(3, 2)
    rng = random.Random(seed)
    taken = []

    # Of each client: a pause, and words after it.
    turns = {0: [(10, 100)], 1: [(12, 20), (8, 130)], 2: [(0, 150)]}

    async def client(ctx, number):
        port, word = dut.clients[number], 0
        for pause, words in turns[number]:
            if pause:
                await ctx.tick().repeat(pause)
            for _ in range(words):
                ctx.set(port.p.data, word)
                ctx.set(port.p.tag, number)
                ctx.set(port.valid, 1)
                await ctx.tick().until(port.ready)
                word += 1
            ctx.set(port.valid, 0)

    async def take(ctx):
        while len(taken) < 400:
            ctx.set(dut.o.ready, rng.random() < 0.9)
            *_, valid, ready, word, tag = await ctx.tick().sample(dut.o.valid, dut.o.ready, dut.o.p.data, dut.o.p.tag)
            if valid and ready:
                taken.append((tag, word))
    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    for number in range(3):
        simulator.add_testbench(partial(client, number=number))
    simulator.add_testbench(take)
    simulator.run()
    for number in range(3):
        assert [word for tag, word in taken if tag == number] == [*range(sum(words for _, words in turns[number]))]
    # The last one has begun alone; the second one's pause lets it begin a second burst.
    assert [(tag, len([*words])) for tag, words in groupby(tag for tag, _ in taken)] == [
        (2, BURST), (0, 100), (1, 20), (2, BURST), (1, 130), (2, 150 - 2 * BURST)]


DISPLAY = DisplayFormat(12, range(12, 13), 15, 6, range(6, 7), 9, 5_000_000)


@pytest.mark.parametrize("size, config", [((6, 6), CONFIG), ((13, 9), replace(CONFIG, max_width=13))])
def test_monitor(size, config):
    """The picture of every frame is golden's, while the matcher's accesses take all that is left: no line is late."""
    width, height = size
    memory, clocks = memory_of()
    stores = SdramStores(config, height, CLOCK_HZ, display=DISPLAY, clocks=clocks)
    m = Module()
    m.domains += ClockDomain("pixel")
    m.submodules.stores = stores
    m.submodules.screen = screen = DomainRenamer("pixel")(SideBySide(DISPLAY, width, height, config.labels))
    for name, member in stores.outside.items():
        if name.startswith("display_"):
            inner, outer = getattr(stores, name), getattr(screen, name.removeprefix("display_"))
            m.d.comb += inner.eq(outer) if member.flow is wiring.In else outer.eq(inner)
    rng = np.random.default_rng(3)
    left, label = rng.integers(0, 256, (height, width)), rng.integers(0, 4, (height, width))
    monitor = Monitor(DISPLAY)
    ready = []

    async def fill(ctx):
        ctx.set(stores.write.valid, 1)
        for place in range(width * height):
            ctx.set(stores.write.p, {"plane": 0, "address": place, "level": int(left.flat[place])})
            await ctx.tick().until(stores.write.ready)
        ctx.set(stores.write.valid, 0)
        ctx.set(stores.busy, 1)
        ctx.set(stores.scan.request.valid, 1)
        ctx.set(stores.results.valid, 1)
        while monitor.frames < 4:
            for place in range(width * height):
                ctx.set(stores.results.p, {"address": place, "result": {"disparity": int(label.flat[place])}})
                ctx.set(stores.scan.request.p.address, place)
                await ctx.tick().until(stores.results.ready)
            ready.append(monitor.frames)
    simulator = Simulator(m)
    simulator.add_clock(1 / CLOCK_HZ)
    simulator.add_clock(1 / DISPLAY.pixel_clock_hz, domain="pixel")
    simulator.add_process(serve_sdram(stores.memory, memory))
    simulator.add_process(watch_amaranth(monitor, screen, domain="pixel"))
    simulator.add_testbench(fill)
    simulator.run_until(4.6 * DISPLAY.h_total * DISPLAY.v_total / DISPLAY.pixel_clock_hz)
    assert monitor.frames == 4 and ready[0] < 2
    wanted = side_by_side(left, label, np.ones_like(label, bool), DISPLAY, config.labels)
    for picture in list(monitor.pictures)[2:]:
        np.testing.assert_array_equal(picture, wanted)


@pytest.mark.parametrize("change, told", [
    ({"clock_hz": 25_000_000}, "a line of the monitor lasts 800 clocks of 25 MHz, and reading the next one takes up to 898; choose a clock "
                               "of at least 28.1 MHz"),
    ({"clock_hz": 101_000_000}, "an SDRAM with a CAS latency of 2 takes 100 MHz at most, not 101; choose a lower clock"),
    ({"height": 16384}, "pictures of 640x16384 pixels do not fit into half of an SDRAM of 16,777,216 words; choose smaller ones"),
])
def test_refused(change, told):
    arguments = {"height": 480, "clock_hz": CLOCK_HZ, "display": VGA if "height" not in change else None, **change}
    with refused_components(), pytest.raises(ValueError, match=f"^{told}$"):
        SdramStores(MatcherConfig(64, 640), **arguments)


# Slow: a minute of a simulator that is not fast; the parts are tested above.
@pytest.mark.slow
@pytest.mark.parametrize("monitor, most", [(False, 2.2), (True, 3.6)])
def test_clocks_of_a_pixel(monitor, most):
    """A matcher that takes and gives a pixel a clock, with lines of 640 pixels; with a monitor while all of its lines are shown ones."""
    config, lines = MatcherConfig(64, 640, method=CONFIG.method), 8
    memory, clocks = memory_of()
    stores = SdramStores(config, lines, CLOCK_HZ, display=VGA if monitor else None, clocks=clocks)
    count = 640 * lines
    taken = []

    async def requests(ctx):
        ctx.set(stores.busy, 1)
        ctx.set(stores.scan.request.valid, 1)
        for place in range(count):
            ctx.set(stores.scan.request.p.address, place)
            await ctx.tick().until(stores.scan.request.ready)
        ctx.set(stores.scan.request.valid, 0)

    async def results(ctx):
        """Each word comes back as a result; as in the core, no more are on their way than fit."""
        waiting, place = 0, 0
        while place < count:
            ctx.set(stores.results.valid, waiting > 0)
            ctx.set(stores.results.p.address, place)
            *_, found, moved = await ctx.tick().sample(stores.scan.valid, stores.results.valid & stores.results.ready)
            waiting, place = waiting + found - moved, place + moved
            taken.append(None)
        ctx.set(stores.results.valid, 0)

    async def events(ctx):
        clocks_of_line = 0
        ctx.set(stores.display_frame, 1)
        async for _ in ctx.tick("pixel"):
            clocks_of_line = (clocks_of_line + 1) % VGA.h_total
            ctx.set(stores.display_frame, 0)
            ctx.set(stores.display_line, clocks_of_line == 0)
    simulator = Simulator(stores)
    simulator.add_clock(1 / CLOCK_HZ)
    if monitor:
        simulator.add_clock(1 / VGA.pixel_clock_hz, domain="pixel")
        simulator.add_testbench(events, background=True)
    simulator.add_process(serve_sdram(stores.memory, memory))
    simulator.add_testbench(requests)
    simulator.add_testbench(results)
    simulator.run()
    assert 2 < len(taken) / count < most, len(taken) / count
