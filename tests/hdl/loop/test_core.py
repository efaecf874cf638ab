# amaranth: UnusedElaboratable=no
"""hdl.loop.core against its golden model, byte by byte: pairs, blocks with faults, pauses, refusals; and the display's read port."""

from dataclasses import replace

import numpy as np
import pytest
from amaranth.sim import Simulator

from golden.config import FUSED_1, RECURSIVE_1, MatcherConfig, OnePass, changed
from golden.host.loop_device import LoopDevice
from golden.host.loop_registers import LOOP_PLANES
from golden.host.protocol import Operation, Request, encode_block, encode_request
from golden.matcher.matcher import match
from golden.video.sdram import SDRAM
from hdl.loop.core import LoopCore
from hdl.loop.sdram_store import SdramStores
from hdl.loop.store import BlockStores
from sim.kit.cases import noise
from sim.models.sdram import SdramMemory, serve_sdram


TIMEOUT = 24
CLOCK_HZ, POWER_UP_CLOCKS = 60_000_000, 30
CLOCKS = replace(SDRAM.clocks(CLOCK_HZ), power_up=POWER_UP_CLOCKS + 1)
LINEAR = changed(OnePass(), arithmetic="linear")
SMALL = MatcherConfig(4, 7, method=LINEAR)


class Bench:
    """Bytes to gateware and golden model alike; their answers are compared.

    Attributes
    ----------
    clocks : list of int
        What the gateware tells that pairs took.
    """
    def __init__(self, config, height, *, display=False, sdram=False, seed=0):
        self.display = display
        self.memory = SdramMemory(CLOCK_HZ, power_up=POWER_UP_CLOCKS * 1e9 / CLOCK_HZ) if sdram else None
        self.dut = LoopCore(SdramStores(config, height, CLOCK_HZ, clocks=CLOCKS) if sdram else BlockStores(config, height, display=display),
                            TIMEOUT)
        self.device = LoopDevice(config, height)
        self.rng = np.random.default_rng(seed)
        self.received = bytearray()
        self.expected = b""
        self.clocks = []

    def run(self, testbench):
        async def outer(ctx):
            self.ctx = ctx
            await testbench(self)
            await ctx.tick().repeat(20)
            assert bytes(self.received) == self.expected, f"{len(self.received)} bytes of {len(self.expected)}"

        async def receive(ctx):
            """As a line that is slow: a byte is accepted in every second or third cycle."""
            while True:
                ctx.set(self.dut.o.ready, 1)
                *_, valid, payload = await ctx.tick().sample(self.dut.o.valid, self.dut.o.payload)
                if valid:
                    self.received.append(payload)
                    ctx.set(self.dut.o.ready, 0)
                    await ctx.tick().repeat(int(self.rng.integers(1, 3)))

        simulator = Simulator(self.dut)
        simulator.add_clock(1e-6)
        if self.display:
            simulator.add_clock(0.7e-6, domain="pixel")
        if self.memory:
            simulator.add_process(serve_sdram(self.dut.memory, self.memory))
        simulator.add_testbench(outer)
        simulator.add_testbench(receive, background=True)
        simulator.run()

    async def send(self, data, wait=True):
        """Bytes without a pause; waits for the whole answer, or sends ahead."""
        self.expected += self.device.receive(data)
        for byte in data:
            self.ctx.set(self.dut.i.payload, byte)
            self.ctx.set(self.dut.i.valid, 1)
            await self.ctx.tick().until(self.dut.i.ready)
            self.ctx.set(self.dut.i.valid, 0)
        if wait:
            await self.settle()

    async def settle(self, clocks=2000):
        for _ in range(clocks):
            if len(self.received) >= len(self.expected):
                break
            await self.ctx.tick()
        assert bytes(self.received) == self.expected

    async def pause(self):
        """The silence after which a request is expected; nothing less will do."""
        self.expected += self.device.pause()
        await self.ctx.tick().repeat(TIMEOUT + 1)
        await self.settle()

    async def write(self, name, value):
        register = self.device.registers[name]
        await self.send(encode_request(Request(Operation.WRITE, register.address, register.encode(value))))

    async def read(self, name):
        await self.send(encode_request(Request(Operation.READ, self.device.registers[name].address)))
        return int.from_bytes(self.received[-3:-1], "big")

    async def put(self, pair, *, wait=True):
        for plane, picture in enumerate(pair):
            for number, line in enumerate(np.asarray(picture, np.uint8)):
                await self.send(put(plane, number, line.tobytes()), wait)

    async def start(self):
        """Until the pair is matched; the golden model knows no time."""
        height, width = (self.device._value(name) for name in ("picture_height", "picture_width"))
        await self.write("start", 1)
        for _ in range(self.dut.pair_clocks(width, height)):
            if self.ctx.get(self.dut.leds) & 0b11 == 0b10:
                break
            await self.ctx.tick()
        for name in ("clocks_high", "clocks_low"):
            self.device.values[name] = self.ctx.get(self.dut.register_file.status[name])
        self.clocks.append(await self.read("clocks_low"))
        assert width * height < self.clocks[-1] <= self.dut.pair_clocks(width, height)

    async def get(self, planes=None):
        """All lines of planes, requested ahead."""
        for plane in planes or range(len(LOOP_PLANES)):
            for line in range(self.device._value("picture_height")):
                await self.send(encode_request(Request(Operation.BLOCK, plane, line)), wait=False)
        await self.settle(20_000)


def put(plane, line, data):
    return encode_request(Request(Operation.BLOCK_WRITE, plane, line)) + encode_block(plane, line, data)


# Slow: the matchers take longer than all the rest, and are compared with golden elsewhere; results of several bytes are in the bench.
@pytest.mark.parametrize("sdram", [False, True])
@pytest.mark.parametrize("config, minimum, size", [
    pytest.param(SMALL, None, (7, 3), id="thesis"),
    pytest.param(MatcherConfig(4, 9, minimum=-2, method=changed(FUSED_1, sub_pixel=True)), -1, (8, 2), id="fused", marks=pytest.mark.slow),
    pytest.param(MatcherConfig(4, 10, method=RECURSIVE_1), 3, (10, 2), id="recursive", marks=pytest.mark.slow),
])
def test_pairs(config, minimum, size, sdram):
    """Two pairs of different sizes, with other settings for the second one; all planes are read. In either store."""
    async def testbench(bench):
        for seed, (width, height) in enumerate([size, (size[0] - 3, size[1] - 1)]):
            await bench.write("picture_width", width)
            await bench.write("picture_height", height)
            await bench.write("in_use", 2 + 2 * seed)
            if minimum is not None:
                await bench.write("minimum", minimum + seed)
            await bench.put(noise(width, height, seed), wait=False)
            await bench.settle()
            await bench.start()
            await bench.get()
        assert (await bench.read("pairs"), await bench.read("uart_errors"), await bench.read("kept")) == (2, 0, 1)

    Bench(config, size[1] + 1, sdram=sdram).run(testbench)


BLOCK = put(0, 1, bytes(range(7)))
FAULTS = {
    "no sync byte": b"\x00",
    "a byte before a request": b"\x17" + encode_request(Request(Operation.WRITE, 0x10, 1)),
    "bad sum": b"\xa5\xad\x10\x00\x01\x00",
    "half a request": b"\xa5\x52",
    "a byte of a block is changed": BLOCK[:8] + bytes([BLOCK[8] ^ 1]) + BLOCK[9:],
    "the block's CRC is changed": BLOCK[:-1] + bytes([BLOCK[-1] ^ 1]),
    "a byte of a block is lost": BLOCK[:9] + BLOCK[10:],
    "a byte of a block is doubled": BLOCK[:9] + BLOCK[8:],
    "a block of another line": put(0, 2, bytes(7))[:6] + BLOCK[6:],
    "no data": BLOCK[:6],
    "a plane that cannot be written": put(2, 1, bytes(7)),
    "no such line": put(0, 3, bytes(7)),
    "no such line at all": put(0, 0xFFFF, bytes(7)),
    "unknown operation": encode_request(Request(0x77, 0, 3)),
}


def test_faults():
    """After each fault pixels and requests that follow are ignored until a pause, and a bad block changes nothing."""
    write_u1 = encode_request(Request(Operation.WRITE, 0x10, 63))

    async def testbench(bench):
        await bench.put(noise(7, 3, 9))
        for fault in FAULTS.values():
            await bench.send(fault)
            await bench.send(write_u1 + BLOCK)
            await bench.pause()
        assert await bench.read("u1") == 15
        await bench.send(BLOCK)
        await bench.start()
        await bench.get([0, 3])
        for plane, line in ((4, 0), (255, 0), (0, 3)):
            await bench.send(encode_request(Request(Operation.BLOCK, plane, line)))
        assert await bench.read("uart_errors") == 10

    Bench(SMALL, 3).run(testbench)


def test_lost_byte_of_the_line():
    """Tells that a block is cut short, and that what follows must be ignored. So does silence, and the next block is good."""
    async def testbench(bench):
        for data in (b"\xa5\x52", BLOCK[:9], b""):
            await bench.send(data)
            bench.ctx.set(bench.dut.line_error, 1)
            await bench.ctx.tick()
            bench.ctx.set(bench.dut.line_error, 0)
            if not data:
                bench.device._error()
            bench.expected += bench.device.pause()      # the answer to what is cut short
            bench.device._ignores = True
            await bench.settle()
            await bench.send(BLOCK)
            await bench.pause()
        assert await bench.read("uart_errors") == 3
        for data in (BLOCK[:9], b"\xa5\x52"):
            await bench.send(data)
            await bench.pause()     # after which the reply is sent to a block that is cut short, and the next one is good
            await bench.send(BLOCK)
        assert await bench.read("uart_errors") == 5

    Bench(SMALL, 3).run(testbench)


def test_keep_and_counters():
    """A kept pair stays: blocks and start are refused. Without a pair there is nothing to read."""
    async def testbench(bench):
        await bench.send(encode_request(Request(Operation.BLOCK, 2, 0)))
        await bench.write("picture_height", 1)
        await bench.put(noise(7, 1, 2))
        await bench.start()
        await bench.write("keep", 1)
        await bench.send(BLOCK)
        await bench.pause()
        await bench.write("start", 1)
        await bench.get()
        assert await bench.read("pairs") == 1
        await bench.write("clear_counters", 1)
        assert await bench.read("pairs") == 0
        await bench.write("keep", 0)
        await bench.send(put(1, 0, bytes(7)))
        assert await bench.read("kept") == 0
        await bench.send(encode_request(Request(Operation.BLOCK, 0, 0)))

    Bench(SMALL, 2).run(testbench)


@pytest.mark.parametrize("config", [
    # Slow: its matcher takes longer than all the rest; what is particular are labels of a fraction.
    pytest.param(MatcherConfig(3, 7, method=changed(FUSED_1, sub_pixel=True)), id="fused", marks=pytest.mark.slow),
    pytest.param(SMALL, id="thesis"),
])
def test_display(config):
    """Left picture, labels and the check in another clock domain."""
    pair = noise(7, 2, 4)
    golden = match(*pair, config)

    async def testbench(bench):
        await bench.put(pair)
        await bench.start()
        dut, ctx = bench.dut, bench.ctx
        for place in (0, 6, 7, 13, 3):
            ctx.set(dut.display_address, place)
            await ctx.tick("pixel")
            await ctx.tick("pixel")     # the first one may be anywhere
            label = golden["disparity"][divmod(place, 7)] // config.method.disparity_scale
            known = golden["passed"][divmod(place, 7)] if "passed" in golden else 1
            assert (ctx.get(dut.display_left), ctx.get(dut.display_label), ctx.get(dut.display_known)) == (
                pair[0][divmod(place, 7)], label, known)

    Bench(config, 2, display=True).run(testbench)
