# amaranth: UnusedElaboratable=no
from dataclasses import replace

import numpy as np
import pytest
from amaranth import Module
from amaranth.lib import wiring
from amaranth.sim import Simulator

from golden.config import MatcherConfig
from golden.rig.rectify import move_rows
from golden.video.bandwidth import Budget
from golden.video.formats import DISPLAYS
from golden.video.memory_map import MemoryMap, Plane
from hdl.video.arbiter import Arbiter
from hdl.video.frame_read import PairReader, PictureReader
from sim.kit.cases import comparable, noise, pixel_words
from sim.kit.streams import check_rules, receive
from sim.kit.video_cases import shown_words
from sim.models.ddr2 import Ddr2Timing, LocalMemory, serve


HOSTILE = Ddr2Timing(busy=0.5, refresh=(150, 30))
CONFIG = MatcherConfig(labels=256)


def filled(memory_map, planes, *, timing=HOSTILE, seed=1, size=1):
    """A memory whose planes hold noise in every buffer; their pictures by plane and buffer."""
    memory = LocalMemory(memory_map.total_words, size=size, timing=timing, seed=seed)
    pictures = {}
    for plane in planes:
        for buffer in range(memory_map.buffers):
            pictures[plane, buffer], = noise(memory_map.width, memory_map.height, seed + 10 * plane + buffer, pictures=1)
            memory.load(memory_map, plane, buffer, pictures[plane, buffer])
    return memory, pictures


def run(dut, memory, *testbenches, size=1):
    """Return the words of ``o`` and their cycles."""
    given: list = []
    cycles: list = []
    m = Module()
    m.submodules.dut = dut
    m.submodules.arbiter = arbiter = Arbiter(1, 1, burst=dut.burst, size=size)
    wiring.connect(m, dut.port, arbiter.read[0])
    sim = Simulator(m)
    sim.add_clock(1e-6)
    for testbench in testbenches:
        sim.add_testbench(testbench)
    sim.add_process(serve(arbiter.bus, memory))
    sim.add_testbench(check_rules(dut.o, given, cycles), background=True)
    sim.add_testbench(check_rules(dut.port.request, []), background=True)
    sim.run()
    return [comparable(word) for word in given], cycles


PAIRS = [(0, 1), (1, 1), (2, 0), (0, 2)]


@pytest.mark.parametrize("stall", [0.0, 0.5])
@pytest.mark.parametrize("width, height, burst, size, depth", [(20, 3, 16, 1, 32), (37, 2, 2, 4, 5), (1, 1, 1, 1, 4), (64, 2, 4, 3, 8)])
def test_pairs(width, height, burst, size, depth, stall):
    """Pair after pair: ``start`` follows ``done`` immediately, while pixels of the pair before have not been sent yet."""
    memory_map = MemoryMap(width, height, 3)
    memory, pictures = filled(memory_map, (Plane.LEFT, Plane.RIGHT), size=size)
    dut = PairReader(memory_map, burst=burst, depth=depth)
    rng = np.random.default_rng(1)
    dones = []

    async def control(ctx):
        for number, (left, right) in enumerate(PAIRS):
            ctx.set(dut.control.start, 1)
            ctx.set(dut.control.left_buffer, left)
            ctx.set(dut.control.right_buffer, right)
            await ctx.tick()
            ctx.set(dut.control.start, 0)
            for _ in range(10_000):
                *_, done = await ctx.tick().sample(dut.control.done)
                if done:
                    break
            # All words of both have been returned, none of the next pair.
            dones.append(memory.words_read)
            assert memory.words_read == 2 * (number + 1) * height * memory_map.line_words
            assert memory.in_flight == 0
        for _ in range(200):
            *_, done = await ctx.tick().sample(dut.control.done)
            assert not done
        assert ctx.get(dut.fill) <= depth

    async def sink(ctx):
        await receive(ctx, dut.o, len(PAIRS) * width * height, rng=rng, stall=stall)
        ctx.set(dut.o.ready, 1)
        await ctx.tick().repeat(200)

    given, _ = run(dut, memory, control, sink, size=size)
    assert given == [word for left, right in PAIRS for word in pixel_words(pictures[Plane.LEFT, left], pictures[Plane.RIGHT, right])]
    assert len(dones) == len(PAIRS)


@pytest.mark.parametrize("width, height, burst", [(37, 5, 2), (20, 3, 16)])
def test_right_picture_moved(width, height, burst):
    """By row offsets within the picture and beyond it; each is sampled with ``start``, the pair before is read to its end."""
    memory_map = MemoryMap(width, height, 3)
    memory, pictures = filled(memory_map, (Plane.LEFT, Plane.RIGHT))
    dut = PairReader(memory_map, burst=burst, depth=2 * burst, moves=True)
    offsets = (1, 0, -2, height, -128, 127)

    async def control(ctx):
        for offset in offsets:
            ctx.set(dut.control.start, 1)
            ctx.set(dut.row_offset, offset)
            ctx.set(dut.control.right_buffer, 1)
            await ctx.tick()
            ctx.set(dut.control.start, 0)
            ctx.set(dut.row_offset, -offset)
            while not (await ctx.tick().sample(dut.control.done))[-1]:
                pass

    async def sink(ctx):
        await receive(ctx, dut.o, len(offsets) * width * height, rng=np.random.default_rng(2), stall=0.3)

    given, _ = run(dut, memory, control, sink)
    left, right = pictures[Plane.LEFT, 0], pictures[Plane.RIGHT, 1]
    assert given == [word for offset in offsets for word in pixel_words(left, move_rows(right, offset))]


def test_done_does_not_wait_for_the_pixels():
    """The FIFOs hold the pair: it is done although no pixel is accepted; the next one waits, and nothing is lost."""
    memory_map = MemoryMap(20, 3)
    memory, pictures = filled(memory_map, (Plane.LEFT, Plane.RIGHT))
    dut = PairReader(memory_map, burst=4, depth=8)
    counts = []

    async def control(ctx):
        for buffer in (0, 1):
            ctx.set(dut.control.start, 1)
            ctx.set(dut.control.left_buffer, buffer)
            ctx.set(dut.control.right_buffer, buffer)
            await ctx.tick()
            ctx.set(dut.control.start, 0)
            ctx.set(dut.control.left_buffer, 1 - buffer)
            await ctx.tick().repeat(400)
            counts.append(memory.words_read)
        assert ctx.get(dut.fill) == 6
        given.extend(await receive(ctx, dut.o, 2 * 60, rng=np.random.default_rng(1)))

    given: list = []
    run(dut, memory, control)
    assert counts == [12, 12]
    assert [comparable(word) for word in given] == [word for buffer in (0, 1) for word in pixel_words(
        pictures[Plane.LEFT, buffer], pictures[Plane.RIGHT, buffer])]


@pytest.mark.parametrize("latency", [10, 30])
def test_a_pixel_a_cycle(latency):
    """From the first pixel on, as long as the memory keeps pace; the depth by the formula is enough for that."""
    memory_map = MemoryMap(64, 6)
    memory, pictures = filled(memory_map, (Plane.LEFT, Plane.RIGHT),
                              timing=Ddr2Timing(init=1, busy=0.5, patience=1, latency=(latency, latency), refresh=(10**9, 0)))
    depth = 4 + -(-(2 * 4 * 2 * 2 + 3 + latency) // 16) + 1
    dut = PairReader(memory_map, burst=4, depth=depth)

    async def control(ctx):
        ctx.set(dut.control.start, 1)
        await ctx.tick()
        ctx.set(dut.control.start, 0)
        await receive(ctx, dut.o, 64 * 6, rng=np.random.default_rng(1))
        assert depth - 4 < ctx.get(dut.fill) <= depth

    given, cycles = run(dut, memory, control)
    assert given == pixel_words(pictures[Plane.LEFT, 0], pictures[Plane.RIGHT, 0])
    assert np.diff(cycles).tolist() == [1] * (64 * 6 - 1)


def test_fill():
    """The fuller FIFO counts: the left one fills first."""
    memory_map = MemoryMap(64, 1)
    memory, _ = filled(memory_map, (Plane.LEFT, Plane.RIGHT))
    dut = PairReader(memory_map, burst=4, depth=8)

    async def control(ctx):
        ctx.set(dut.control.start, 1)
        await ctx.tick()
        ctx.set(dut.control.start, 0)
        while not ctx.get(dut.fill):
            await ctx.tick()
        assert memory.words_read - memory.in_flight <= 4
        await receive(ctx, dut.o, 64, rng=np.random.default_rng(1))
        assert ctx.get(dut.fill) == 4
        ctx.set(dut.clear_fill, 1)
        await ctx.tick()
        ctx.set(dut.clear_fill, 0)
        assert ctx.get(dut.fill) == 0

    run(dut, memory, control)


@pytest.mark.parametrize("depth", [8, 9])
@pytest.mark.parametrize("kind", ["pair", "picture"])
def test_fill_of_full_fifos(kind, depth):
    """Nobody takes a pixel: both FIFOs hold all their words, of a power of two too, and ``clear_fill`` does not forget these."""
    memory_map = MemoryMap(64, 8)
    memory, _ = filled(memory_map, Plane)
    dut = PairReader(memory_map, burst=1, depth=depth) if kind == "pair" else PictureReader(memory_map, CONFIG, burst=1, depth=depth)

    async def control(ctx):
        if kind == "pair":
            ctx.set(dut.control.start, 1)
            await ctx.tick()
            ctx.set(dut.control.start, 0)
        else:
            await fetch(ctx, dut, 0, 1, np.random.default_rng(1))
        await ctx.tick().repeat(50 * depth)
        assert memory.in_flight == 0
        assert ctx.get(dut.fill) == depth
        ctx.set(dut.clear_fill, 1)
        await ctx.tick()
        ctx.set(dut.clear_fill, 0)
        assert ctx.get(dut.fill) == depth
        await receive(ctx, dut.o, 64 * 8, rng=np.random.default_rng(1))
        ctx.set(dut.clear_fill, 1)
        await ctx.tick()
        assert ctx.get(dut.fill) == 0

    run(dut, memory, control)


def check_shown(given, fetches, pictures):
    """What was given is, for fetches in their order, a beginning of the picture fetched; of the last one all, if it was valid."""
    segments: list = []
    for word in given:
        if word["first"]:
            segments.append([])
        segments[-1].append(word)
    wanted = [shown_words(pictures[Plane.DISPARITY, buffer], pictures[Plane.SHOWN_LEFT, buffer]) if valid else None
              for buffer, valid in fetches]
    turn = iter(wanted)
    for segment in segments:
        assert any(picture is not None and segment == picture[:len(segment)] for picture in turn), "pixels that were not fetched"
    if wanted[-1] is not None:
        assert segments[-1] == wanted[-1]
    return segments


async def fetch(ctx, dut, buffer, valid, rng):
    """``shown_buffer`` and ``shown_valid`` mean something in the cycle after ``fetch`` only."""
    ctx.set(dut.fetch, 1)
    ctx.set(dut.shown_valid, int(rng.integers(2)))
    await ctx.tick()
    ctx.set(dut.fetch, 0)
    ctx.set(dut.shown_buffer, buffer)
    ctx.set(dut.shown_valid, valid)
    await ctx.tick()
    ctx.set(dut.shown_buffer, int(rng.integers(3)))
    ctx.set(dut.shown_valid, int(rng.integers(2)))


@pytest.mark.parametrize("stall", [0.0, 0.6])
@pytest.mark.parametrize("width, height, burst, size, depth", [(20, 6, 16, 1, 32), (37, 5, 2, 4, 5), (5, 1, 1, 1, 4)])
def test_fetch_at_any_time(width, height, burst, size, depth, stall):
    """Fetches before a picture is over, right after one another, without a picture to show: nothing stale follows a ``first``."""
    memory_map = MemoryMap(width, height, 3)
    memory, pictures = filled(memory_map, (Plane.DISPARITY, Plane.SHOWN_LEFT), size=size)
    dut = PictureReader(memory_map, CONFIG, burst=burst, depth=depth)
    rng = np.random.default_rng(int(10 * stall) + depth)
    fetches = [(int(rng.integers(3)), int(rng.random() < 0.8)) for _ in range(40)] + [(1, 1), (2, 0), (2, 1)]

    async def control(ctx):
        for number, (buffer, valid) in enumerate(fetches):
            await fetch(ctx, dut, buffer, valid, rng)
            pause = (0, 1, 5, 30, 60, width * height // 2, 2 * width * height + 100)[number % 7]
            await ctx.tick().repeat(int(rng.integers(pause + 1)) + 1)
        await ctx.tick().repeat(4 * width * height + 400)

    async def sink(ctx):
        for _ in range(20_000):
            ctx.set(dut.o.ready, int(rng.random() >= stall))
            await ctx.tick()
            if finished:
                break

    finished: list = []

    async def all_of_it(ctx):
        await control(ctx)
        finished.append(True)

    given, _ = run(dut, memory, all_of_it, sink, size=size)
    segments = check_shown(given, fetches, pictures)
    assert len(segments) > (10 if width * height > 10 else 2)
    assert any(len(segment) < width * height for segment in segments) or width * height < 10


def test_nothing_to_show():
    """Before the first fetch nothing is sent; after one without a picture only words in flight, and no more are requested."""
    memory_map = MemoryMap(37, 30, 3)
    memory, pictures = filled(memory_map, (Plane.DISPARITY, Plane.SHOWN_LEFT))
    dut = PictureReader(memory_map, CONFIG, burst=2, depth=4)
    rng = np.random.default_rng(1)

    async def control(ctx):
        ctx.set(dut.o.ready, 1)
        await ctx.tick().repeat(100)
        await fetch(ctx, dut, 0, 0, rng)
        await ctx.tick().repeat(300)
        assert memory.words_read == 0
        await fetch(ctx, dut, 2, 1, rng)
        await ctx.tick().repeat(200)
        before = memory.words_read
        assert before > 0
        await fetch(ctx, dut, 1, 0, rng)
        await ctx.tick().repeat(600)
        assert memory.words_read <= before + 2 * 4

    given, cycles = run(dut, memory, control)
    assert len(check_shown(given, [(2, 1), (1, 0)], pictures)) == 1
    assert cycles[-1] < 100 + 300 + 200 + 150


def test_disparities_have_their_width():
    """80 labels are 7 bits of the byte in memory."""
    memory_map = MemoryMap(20, 2)
    memory, _ = filled(memory_map, (Plane.SHOWN_LEFT,))
    labels = np.arange(40).reshape(2, 20) * 2 + 1
    memory.load(memory_map, Plane.DISPARITY, 1, labels)
    dut = PictureReader(memory_map, MatcherConfig(labels=80), burst=2, depth=4)
    assert len(dut.o.p.disparity) == 7

    async def control(ctx):
        await fetch(ctx, dut, 1, 1, np.random.default_rng(1))
        await receive(ctx, dut.o, 40, rng=np.random.default_rng(1))

    given, _ = run(dut, memory, control)
    assert [word["disparity"] for word in given] == labels.ravel().tolist()


def test_default_depths():
    """They are the depths in the budget of the thesis's system, on either monitor."""
    memory_map = MemoryMap()
    for display in DISPLAYS.values():
        budget = replace(Budget(), display=display)
        assert budget.display_depth <= PictureReader(memory_map, CONFIG).depth < 2 * budget.display_depth
        assert budget.matcher_depth <= PairReader(memory_map).depth < 2 * budget.matcher_depth


@pytest.mark.parametrize("reader", [PairReader, lambda memory_map, **options: PictureReader(memory_map, CONFIG, **options)])
def test_refuses(reader):
    with pytest.raises(ValueError, match="must hold at least 32 words, two bursts, not 31"):
        reader(MemoryMap(), depth=31)
    with pytest.raises(ValueError, match="a burst must be a power of two of words, not 6"):
        reader(MemoryMap(), burst=6)
