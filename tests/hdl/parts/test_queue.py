# amaranth: UnusedElaboratable=no

import numpy as np
import pytest
from amaranth import *
from amaranth.lib import data
from amaranth.lib.fifo import SyncFIFOBuffered
from amaranth.sim import Simulator

from hdl.parts.queue import AsyncQueue, Queue
from sim.kit.streams import check_rules, receive, run_stream, send


DEPTHS = [1, 2, 3, 4, 5, 7, 8, 9, 15, 16, 17]
PERIOD = 1e-6


def words(count, seed=1):
    return np.random.default_rng(seed).integers(0, 256, count).tolist()


@pytest.mark.parametrize("stall_i, stall_o", [(0.0, 0.0), (0.4, 0.4), (0.8, 0.0), (0.0, 0.8)])
@pytest.mark.parametrize("depth", DEPTHS)
def test_order(depth, stall_i, stall_o):
    given = words(6 * depth + 30)
    assert run_stream(Queue(8, depth), given, rng=np.random.default_rng(2), stall_i=stall_i, stall_o=stall_o) == given


@pytest.mark.parametrize("depth", DEPTHS)
def test_latency_and_rate(depth):
    cycles = {}
    given = words(40)
    assert run_stream(Queue(8, depth), given, rng=np.random.default_rng(2), cycles=cycles) == given
    between = 1 if depth >= 3 else 2
    assert np.subtract(cycles["o"], cycles["i"]).tolist() == [1 if depth == 1 else 2] * len(given)
    assert np.diff(cycles["o"]).tolist() == [between] * (len(given) - 1)


@pytest.mark.parametrize("depth", DEPTHS)
def test_level(depth):
    """As many words as the depth are accepted, and the level counts them in each cycle."""
    dut = Queue(8, depth)
    rng = np.random.default_rng(3)
    levels = []

    async def testbench(ctx):
        level = 0
        for enters, leaves in [(1, 0)] * (depth + 3) + [(0, 1)] * (depth + 3) + rng.integers(0, 2, (100, 2)).tolist():
            ctx.set(dut.i.valid, enters)
            ctx.set(dut.o.ready, leaves)
            _, _, ready, valid, shown = await ctx.tick().sample(dut.i.ready, dut.o.valid, dut.level)
            assert shown == level
            assert ready == (level < depth) or depth == 2
            levels.append(level)
            level += (enters and ready) - (leaves and valid)

    simulator = Simulator(dut)
    simulator.add_clock(PERIOD)
    simulator.add_testbench(testbench)
    simulator.run()
    assert max(levels) == levels[depth + 3] == depth
    assert levels[2 * depth + 6] == 0


def test_payload():
    """A layout and a signed value keep their values."""
    layout = data.StructLayout({"value": signed(5), "flags": data.ArrayLayout(1, 2)})
    given = [{"value": value, "flags": [value % 2, value % 3 == 0]} for value in range(-16, 16)]
    out = run_stream(Queue(layout, 4), given, rng=np.random.default_rng(4), stall_i=0.3, stall_o=0.3)
    assert [{"value": word.value, "flags": list(word.flags)} for word in out] == given
    values = list(range(-16, 16))
    assert run_stream(Queue(signed(5), 4), values, rng=np.random.default_rng(4), stall_o=0.3) == values


@pytest.mark.parametrize("depth", [1, 2, 5])
def test_reset_empties(depth):
    reset = Signal()
    dut = Queue(8, depth)

    async def testbench(ctx):
        ctx.set(dut.i.valid, 1)
        await ctx.tick().repeat(2 * depth + 2)
        assert ctx.get(dut.o.valid) and ctx.get(dut.level) == depth
        ctx.set(dut.i.valid, 0)
        ctx.set(reset, 1)
        await ctx.tick()
        ctx.set(reset, 0)
        for _ in range(4):
            assert not ctx.get(dut.o.valid) and ctx.get(dut.level) == 0 and ctx.get(dut.i.ready)
            await ctx.tick()

    simulator = Simulator(ResetInserter(reset)(dut))
    simulator.add_clock(PERIOD)
    simulator.add_testbench(testbench)
    simulator.run()


@pytest.mark.parametrize("depth", [0, -1])
def test_bad_depth(depth):
    with pytest.raises(ValueError, match=f"at least 1 word, not {depth}"):
        Queue(8, depth)


def run_between_clocks(dut, testbenches, *, ratio, watch=()):
    """Run testbenches; ``i`` is in the domain ``enter``, whose period is one, ``o`` in ``sync``, whose period is ``ratio``."""
    simulator = Simulator(dut)
    simulator.add_clock(PERIOD, domain="enter", phase=PERIOD / 7)
    simulator.add_clock(PERIOD * ratio)
    for testbench in testbenches:
        simulator.add_testbench(testbench)
    for testbench in watch:
        simulator.add_testbench(testbench, background=True)
    simulator.run()


class Enter:
    """The context of a testbench whose ticks are those of the domain ``enter``."""
    def __init__(self, ctx):
        self.get, self.set = ctx.get, ctx.set
        self.tick = lambda: ctx.tick("enter")


@pytest.mark.parametrize("stall_i, stall_o", [(0.0, 0.0), (0.4, 0.4), (0.8, 0.0), (0.0, 0.8)])
@pytest.mark.parametrize("ratio", [0.36, 1.01, 2.7])
@pytest.mark.parametrize("depth, buffered", [(8, True), (16, False)])
def test_between_clocks(depth, buffered, ratio, stall_i, stall_o):
    """Every word once, in order, held until taken; never more in the queue than it holds; at the pace of the slower clock."""
    dut = AsyncQueue(8, depth, i_domain="enter", buffered=buffered)
    given, taken, entered, left, levels = words(100), [], [], [], []

    async def source(ctx):
        await send(Enter(ctx), dut.i, given, rng=np.random.default_rng(5), stall=stall_i)

    async def sink(ctx):
        await receive(ctx, dut.o, len(given), rng=np.random.default_rng(6), stall=stall_o)
        ctx.set(dut.o.ready, 1)
        await ctx.tick().repeat(20)

    async def entering(ctx):
        async for _, _, valid, ready in ctx.tick("enter").sample(dut.i.valid, dut.i.ready):
            if valid and ready:
                entered.append(len(levels))

    async def leaving(ctx):
        async for _, _, valid, ready, level in ctx.tick().sample(dut.o.valid, dut.o.ready, dut.level):
            if valid and ready:
                left.append(len(levels))
            levels.append(level)

    run_between_clocks(dut, [source, sink], ratio=ratio, watch=[check_rules(dut.o, taken), entering, leaving])
    assert taken == given
    assert max(levels) <= depth + buffered
    if stall_o == 0.8 and stall_i == 0:
        assert max(levels) == depth + buffered
    assert levels[-1] == 0
    # Cycles of `sync` that begin after a word is accepted, up to the one in which it is first offered.
    latency = np.subtract(left, entered)
    assert latency.min() >= 2 + buffered
    if stall_i == 0.8 and stall_o == 0 and ratio < 2:
        assert latency.max() <= 3 + buffered
    if stall_i == stall_o == 0:
        pace = ratio * (left[-1] - left[40]) / (len(left) - 41)
        assert pace == pytest.approx(max(1.0, ratio), rel=0.02)


@pytest.mark.parametrize("buffered", [False, True])
def test_reset_between_clocks(buffered):
    """A reset of the domain where words enter empties the queue, and is reported; later words pass."""
    dut = AsyncQueue(8, 8, i_domain="enter", buffered=buffered)
    m = Module()
    m.domains.enter = enter = ClockDomain()
    m.submodules.dut = dut
    resets = []

    async def testbench(ctx):
        await send(Enter(ctx), dut.i, words(5), rng=np.random.default_rng(5))
        await ctx.tick().repeat(6)
        ctx.set(enter.rst, 1)
        await ctx.tick().repeat(6)
        ctx.set(enter.rst, 0)
        ctx.set(dut.o.ready, 1)     # the word that the output register still held
        await ctx.tick().repeat(6)
        assert not ctx.get(dut.o.valid)
        ctx.set(dut.o.ready, 0)
        await send(Enter(ctx), dut.i, [1, 2, 3], rng=np.random.default_rng(5))
        assert await receive(ctx, dut.o, 3, rng=np.random.default_rng(5)) == [1, 2, 3]

    async def watch(ctx):
        async for _, _, emptied in ctx.tick().sample(dut.emptied):
            resets.append(emptied)

    run_between_clocks(m, [testbench], ratio=1.3, watch=[watch])
    assert any(resets) and not resets[-1]


@pytest.mark.parametrize("depth", [0, 4, 7, 9, 15, 17])
def test_bad_depth_between_clocks(depth):
    with pytest.raises(ValueError, match=f"power of two of words, at least 8, not {depth}"):
        AsyncQueue(8, depth)


@pytest.mark.parametrize("depth", [2, 3, 6, 17])
def test_memory_needs_no_bypass(depth, monkeypatch):
    """The memory is marked as never read in the cycle in which the same word is written, and it is so."""
    found = []
    elaborate = SyncFIFOBuffered.elaborate
    monkeypatch.setattr(SyncFIFOBuffered, "elaborate", lambda *arguments: found.append(elaborate(*arguments)) or found[0])
    dut = Queue(8, depth)
    rng, collisions, together = np.random.default_rng(3), [], []

    async def testbench(ctx):
        for cycle in range(400):
            busy = (0.9, 0.3, 0.6)[cycle // 50 % 3]  # it is full, empty, in between
            ctx.set(dut.i.valid, rng.random() < busy)
            ctx.set(dut.o.ready, rng.random() < 1.1 - busy)
            both = ctx.get(read.en) and ctx.get(write.en)
            together.append(both)
            collisions.append(both and ctx.get(read.addr) == ctx.get(write.addr))
            await ctx.tick()

    simulator = Simulator(dut)
    storage = found[0].submodules.storage
    assert storage.attrs == {"no_rw_check": 1}
    (read,), (write,) = storage.read_ports, storage.write_ports
    simulator.add_clock(PERIOD)
    simulator.add_testbench(testbench)
    simulator.run()
    assert any(together) == (depth > 2) and not any(collisions)
