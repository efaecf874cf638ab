# amaranth: UnusedElaboratable=no
import numpy as np
import pytest
from amaranth import Module, Signal
from amaranth.sim import Simulator

from golden.video.memory_map import MemoryMap, Plane
from hdl.video.dma import LineScan, PixelPacker, PixelUnpacker, WordFifo, line_number
from sim.kit.cases import comparable, noise
from sim.kit.streams import check_rules, receive, run_stream, send


def run(dut, *testbenches):
    sim = Simulator(dut)
    sim.add_clock(1e-6)
    for testbench in testbenches:
        sim.add_testbench(testbench)
    sim.run()


def bursts_of(memory_map, base, burst, rows):
    """By the docstring: (address, length, last)."""
    expected = []
    for y in rows:
        places = range(0, memory_map.line_words, burst)
        expected += [(base + y * memory_map.pitch + n, min(burst, memory_map.line_words - n), int(n == places[-1])) for n in places]
    return expected


@pytest.mark.parametrize("width, height, burst, interlaced", [
    (1, 1, 1, False), (1, 2, 1, True), (16, 2, 16, False), (20, 6, 1, True), (37, 5, 2, False), (37, 4, 4, True), (130, 2, 4, False),
    (128, 2, 4, True), (720, 4, 16, True), (720, 3, 16, False),
])
def test_line_scan(width, height, burst, interlaced):
    """All bursts of two pictures; a new start in mid-picture; nothing before the first start and after the last burst."""
    memory_map = MemoryMap(width, height)
    dut = LineScan(memory_map, burst=burst, interlaced=interlaced)
    rows = [*range(0, height, 2), *range(1, height, 2)] if interlaced else range(height)

    async def testbench(ctx):
        assert not ctx.get(dut.active)
        for plane, buffer, most in ((Plane.RIGHT, 1, None), (Plane.SHOWN_LEFT, 1, 3), (Plane.LEFT, 0, None), (Plane.SHOWN_LEFT, 1, None)):
            ctx.set(dut.base, memory_map.line(plane, buffer))
            ctx.set(dut.start, 1)
            await ctx.tick()
            ctx.set(dut.start, 0)
            expected = bursts_of(memory_map, memory_map.base(plane, buffer), burst, rows)
            for wanted in expected[:most]:
                await ctx.tick()
                assert ctx.get(dut.active)
                assert (ctx.get(dut.o.address), ctx.get(dut.o.length), ctx.get(dut.o.last)) == wanted
                ctx.set(dut.advance, 1)
                await ctx.tick()
                ctx.set(dut.advance, 0)
            assert ctx.get(dut.active) == (len(expected) > len(expected[:most]))

    run(dut, testbench)


def test_line_scan_refuses():
    with pytest.raises(ValueError, match="a burst must be a power of two of words, not 12"):
        LineScan(MemoryMap(20, 6), burst=12)
    with pytest.raises(ValueError, match="an interlaced picture must have an even number of lines, not 5"):
        LineScan(MemoryMap(20, 5), burst=4, interlaced=True)


@pytest.mark.parametrize("buffers", [2, 3, 4])
def test_line_number(buffers):
    """Any buffer of any plane."""
    memory_map = MemoryMap(20, 6, buffers)
    m = Module()
    buffer = Signal(range(buffers))
    numbers = []
    for plane in Plane:
        numbers.append(Signal(range(memory_map.total_words)))
        m.d.comb += numbers[-1].eq(line_number(memory_map, plane, buffer))

    async def testbench(ctx):
        for number in range(buffers):
            ctx.set(buffer, number)
            await ctx.delay(1e-6)
            assert [ctx.get(value) for value in numbers] == [memory_map.line(plane, number) for plane in Plane]

    sim = Simulator(m)
    sim.add_testbench(testbench)
    sim.run()


@pytest.mark.parametrize("stall", [0.0, 0.4])
def test_word_fifo(stall):
    words = np.random.default_rng(1).bytes(16 * 50)
    words = [int.from_bytes(words[n:n + 16], "little") for n in range(0, len(words), 16)]
    assert run_stream(WordFifo(5), words, rng=np.random.default_rng(2), stall_i=stall, stall_o=stall) == words


def test_word_fifo_levels():
    """Every word of its depth can be filled; level, high-water mark, and both ways to clear."""
    dut = WordFifo(6)

    async def put(ctx, *words):
        for word in words:
            ctx.set(dut.i.valid, 1)
            ctx.set(dut.i.payload, word)
            assert ctx.get(dut.i.ready)
            await ctx.tick()
        ctx.set(dut.i.valid, 0)

    async def take(ctx, *words):
        for word in words:
            assert ctx.get(dut.o.valid)
            assert ctx.get(dut.o.payload) == word
            ctx.set(dut.o.ready, 1)
            await ctx.tick()
        ctx.set(dut.o.ready, 0)

    async def pulse(ctx, signal):
        ctx.set(signal, 1)
        await ctx.tick()
        ctx.set(signal, 0)

    async def testbench(ctx):
        await put(ctx, *range(6))
        await ctx.tick()
        assert not ctx.get(dut.i.ready)
        assert (ctx.get(dut.level), ctx.get(dut.fill)) == (6, 6)
        await take(ctx, 0, 1, 2, 3)
        await ctx.tick()
        assert (ctx.get(dut.level), ctx.get(dut.fill)) == (2, 6)
        await pulse(ctx, dut.clear_fill)
        assert ctx.get(dut.fill) == 2
        ctx.set(dut.i.valid, 1)     # is lost
        await pulse(ctx, dut.clear)
        ctx.set(dut.i.valid, 0)
        await ctx.tick().repeat(3)
        assert (ctx.get(dut.level), ctx.get(dut.o.valid), ctx.get(dut.fill)) == (0, 0, 2)
        await put(ctx, 10, 11, 12)
        await ctx.tick().repeat(2)
        assert ctx.get(dut.fill) == 3
        await take(ctx, 10, 11, 12)
        assert not ctx.get(dut.o.valid)

    run(dut, testbench)


def test_word_fifo_refuses():
    with pytest.raises(ValueError, match="a queue of memory words must hold at least 4, not 3"):
        WordFifo(3)


@pytest.mark.parametrize("stall", [0.0, 0.4])
@pytest.mark.parametrize("width", [1, 15, 16, 17, 37, 48])
def test_packer(width, stall):
    memory_map = MemoryMap(width, 3)
    picture = noise(width, 3, 1, pictures=1)[0]
    pixels = [{"value": int(value), "last": int(x == width - 1)} for row in picture for x, value in enumerate(row)]
    count = 3 * memory_map.line_words
    words = run_stream(PixelPacker(), pixels, rng=np.random.default_rng(1), stall_i=stall, stall_o=stall, count=count)
    assert len(words) == count
    assert memory_map.picture(dict(zip(memory_map.words(picture), words))).tolist() == picture.tolist()


def test_packer_clear():
    """Neither the word under way nor the one offered leaves."""
    dut = PixelPacker()
    given = []

    async def testbench(ctx):
        rng = np.random.default_rng(1)
        for before in (5, 16, 20):
            await send(ctx, dut.i, [{"value": 255, "last": 0}] * min(before, 16), rng=rng)
            if before > 16:
                ctx.set(dut.o.ready, 1)
                await send(ctx, dut.i, [{"value": 255, "last": 0}] * (before - 16), rng=rng)
                ctx.set(dut.o.ready, 0)
            ctx.set(dut.clear, 1)
            await ctx.tick()
            ctx.set(dut.clear, 0)
            assert not ctx.get(dut.o.valid)
            await send(ctx, dut.i, [{"value": value, "last": 0} for value in range(16)], rng=rng)
            given.extend(await receive(ctx, dut.o, 1, rng=rng))

    run(dut, testbench)
    assert given == [int.from_bytes(bytes(range(16)), "little")] * 3


def pair_words(left, right):
    height, width = np.shape(left)
    return [{"pixels": [int(left[y][x]), int(right[y][x])], "first": int(x == y == 0), "last": int(x == width - 1),
             "end": int(x == width - 1 and y == height - 1)} for y in range(height) for x in range(width)]


def run_unpacker(dut, sides, count, *, rng, stall, clear_after=None):
    """Words of both planes in, pixels out; ``clear_after`` so many pixels."""
    given = []

    async def sink(ctx):
        if clear_after is not None:
            await receive(ctx, dut.o, clear_after, rng=rng, stall=stall)
            await ctx.tick().repeat(3)      # a pixel is offered by now
            ctx.set(dut.clear, 1)
            await ctx.tick()
            ctx.set(dut.clear, 0)
        await receive(ctx, dut.o, count, rng=rng, stall=stall)
        ctx.set(dut.o.ready, 1)
        await ctx.tick().repeat(10)

    def source(number):
        async def testbench(ctx):
            await send(ctx, dut.i[number], sides[number], rng=rng, stall=stall)
        return testbench

    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_testbench(source(0))
    sim.add_testbench(source(1))
    sim.add_testbench(sink)
    sim.add_testbench(check_rules(dut.o, given), background=True)
    sim.run()
    return [comparable(word) for word in given]


@pytest.mark.parametrize("stall", [0.0, 0.4])
@pytest.mark.parametrize("width, height", [(1, 1), (1, 3), (15, 2), (16, 1), (37, 3), (64, 2)])
def test_unpacker(width, height, stall):
    """Two frames; the planes' words arrive at different times; noise in the padding."""
    memory_map = MemoryMap(width, height)
    pictures = noise(width, height, 1, pictures=4)
    padding = (2**128 - 1) << 8 * ((width - 1) % 16 + 1) & 2**128 - 1
    words = [[word | (padding if n % memory_map.pitch == memory_map.line_words - 1 else 0) for n, word in memory_map.words(picture).items()]
             for picture in pictures]
    expected = pair_words(*pictures[:2]) + pair_words(*pictures[2:])
    given = run_unpacker(PixelUnpacker(memory_map), (words[0] + words[2], words[1] + words[3]), len(expected),
                         rng=np.random.default_rng(1), stall=stall)
    assert given == expected


@pytest.mark.parametrize("after", [3, 16, 21, 37, 50])
def test_unpacker_clear(after):
    """Cleared at any pixel: the pixel that was offered is sent, then a whole picture from the next word on."""
    memory_map = MemoryMap(37, 2)
    pictures = noise(37, 2, 1, pictures=4)
    words = [list(memory_map.words(picture).values()) for picture in pictures]
    # A word is taken with its last pixel: the one under way is still there, and is the first of the new picture.
    y, x = divmod(after, 37)
    consumed = y * 3 + (x // 16 if x != 36 else 3) + int(x % 16 == 15)
    sides = [words[number][:consumed] + words[number + 2] for number in range(2)]
    old = pair_words(*[memory_map.picture(dict(zip(memory_map.words(pictures[0]), side))) for side in sides])[:after + 1]
    new = pair_words(*pictures[2:])
    assert run_unpacker(PixelUnpacker(memory_map), sides, 1 + len(new), rng=np.random.default_rng(1), stall=0.0,
                        clear_after=after) == old + new


def test_unpacker_rate():
    """A pixel a cycle, across words and lines."""
    memory_map = MemoryMap(37, 3)
    picture = noise(37, 3, 1, pictures=2)
    dut = PixelUnpacker(memory_map)
    cycles, given = [], []

    async def source(ctx, number):
        await send(ctx, dut.i[number], list(memory_map.words(picture[number]).values()), rng=np.random.default_rng(1))

    async def sink(ctx):
        await receive(ctx, dut.o, 111, rng=np.random.default_rng(1))

    sim = Simulator(dut)
    sim.add_clock(1e-6)
    for number in range(2):
        async def testbench(ctx, number=number):
            await source(ctx, number)
        sim.add_testbench(testbench)
    sim.add_testbench(sink)
    sim.add_testbench(check_rules(dut.o, given, cycles), background=True)
    sim.run()
    assert cycles == list(range(1, 112))
