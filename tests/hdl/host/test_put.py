# amaranth: UnusedElaboratable=no
"""Lines of the host's pair over the serial line into a strict memory, against golden.host.camera_device byte by byte; with faults."""

import numpy as np
import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.sim import Simulator

from golden.config import MatcherConfig, OnePass
from golden.host import blocks
from golden.host.camera_device import CameraDevice
from golden.host.protocol import BAUD, Operation, Request, encode_block, encode_request
from golden.video.memory_map import MemoryMap, Plane
from hdl.host.pair_lines import PairLines
from hdl.host.registers import SerialRegisters
from hdl.video.arbiter import Arbiter
from hdl.video.line_access import LineAccess
from sim.kit.cases import noise
from sim.kit.streams import check_rules
from sim.models.ddr2 import Ddr2Timing, LocalMemory, serve
from sim.models.uart import UartHost


WIDTH, HEIGHT, BIT_CYCLES = 12, 2, 16
CONFIG = MatcherConfig(2, WIDTH, method=OnePass())

#: Bits of the time-out, and of a pause after which a request is expected whatever was before.
FRAME_BITS, PAUSE_BITS = 30, 100


class Bench:
    """Serial line, registers and blocks, line access, arbiter and memory; the golden model answers beside them.

    Attributes
    ----------
    starts : int
        How often the host's pair was to be matched.
    """
    def __init__(self):
        self.device = CameraDevice(CONFIG, HEIGHT)
        self.memory_map = MemoryMap(WIDTH, HEIGHT, 3, host=True)
        self.memory = LocalMemory(self.memory_map.total_words, timing=Ddr2Timing(busy=0.5, refresh=(150, 30)))
        self.serial = SerialRegisters(self.device.registers, BAUD * BIT_CYCLES, frame_seconds=FRAME_BITS / BAUD)
        self.access = LineAccess(self.memory_map, burst=4)
        self.arbiter = Arbiter(2, 2, burst=4)
        self.line = UartHost(BIT_CYCLES)
        self.starts = 0

    def run(self, testbench):
        m = Module()
        m.submodules += [self.serial, self.access, self.arbiter]
        serial, access = self.serial, self.access
        wiring.connect(m, serial.line, access.i)
        wiring.connect(m, access.o, serial.byte)
        wiring.connect(m, serial.put, access.put)
        wiring.connect(m, access.read, self.arbiter.read[1])
        wiring.connect(m, access.write, self.arbiter.write[1])
        m.d.comb += [access.put_plane.eq(serial.put_plane), access.put_line.eq(serial.put_line)]

        async def outer(ctx):
            self.ctx = ctx
            await testbench(self)

        simulator = Simulator(m)
        simulator.add_clock(1e-6)
        simulator.add_testbench(outer)
        simulator.add_process(serve(self.arbiter.bus, self.memory))
        for stream in (serial.put, access.write.request, access.read.request):
            simulator.add_testbench(check_rules(stream, []), background=True)
        simulator.run()

    async def advance(self, bits):
        for _ in range(bits * BIT_CYCLES):
            self.ctx.set(self.serial.rx, self.line.step(self.ctx.get(self.serial.tx)))
            *_, start = await self.ctx.tick().sample(self.serial.start_pair)
            self.starts += start

    async def send(self, data, pause=False):
        """Bytes, and the answer to them, which is golden's; then a pause, if there is one."""
        expected = self.device.receive(data) + (self.device.pause() if pause else b"")
        self.line.received.clear()
        self.line.send(data)
        await self.advance(10 * (len(data) + len(expected)) + (PAUSE_BITS if pause else 8))
        assert bytes(self.line.received) == expected, data.hex(" ")
        return expected

    async def write(self, name, value):
        await self.send(encode_request(Request(Operation.WRITE, self.device.registers[name].address, value)))

    async def read(self, name):
        return int.from_bytes((await self.send(encode_request(Request(Operation.READ, self.device.registers[name].address))))[3:5], "big")

    async def put(self, pair, lines=None):
        """Lines of a pair, all if none are named, each a plane and its own number."""
        for plane, line in lines or [(plane, line) for plane in range(2) for line in range(HEIGHT)]:
            await self.send(block(plane, line, pair))

    def stored(self):
        """The pair in memory."""
        return [self.memory.picture(self.memory_map, plane, self.memory_map.buffers) for plane in (Plane.LEFT, Plane.RIGHT)]


def block(plane, line, pair):
    data = np.asarray(pair[plane][line], np.uint8).tobytes().ljust(16, b"\0")
    return encode_request(Request(Operation.BLOCK_WRITE, plane, line)) + encode_block(plane, line, data)


def test_pair():
    """Refused until the source is the host; whole and started once all lines are there, and not before; the next pair replaces it."""
    first, second = noise(WIDTH, HEIGHT, 1), noise(WIDTH, HEIGHT, 2)

    async def testbench(bench):
        await bench.write("source", 1)
        await bench.put(first, [(0, line) for line in range(HEIGHT)])
        await bench.write("start_pair", 1)
        assert (await bench.read("pair_whole"), bench.starts) == (0, 0)
        await bench.put(first, [(1, line) for line in range(HEIGHT)])
        assert await bench.read("pair_whole") == 1
        await bench.write("start_pair", 1)
        assert bench.starts == 1 and bench.ctx.get(bench.serial.register_file.errors) == 0
        assert np.array_equal(bench.stored(), first) and np.array_equal(bench.device.pictures, first)

        # Not while the cameras are the source, while it is read, nor while it is kept.
        await bench.write("source", 0)
        await bench.send(block(0, 0, second), pause=True)
        await bench.write("source", 1)
        bench.ctx.set(bench.serial.putting, 1)
        bench.device.values["keep"] = 1     # golden knows no time: with the same effect
        await bench.send(block(0, 0, second), pause=True)
        bench.ctx.set(bench.serial.putting, 0)
        await bench.write("keep", 1)
        await bench.send(block(0, 0, second), pause=True)
        await bench.write("keep", 0)
        assert np.array_equal(bench.stored(), first)
        await bench.put(second)
        await bench.write("start_pair", 1)
        assert np.array_equal(bench.stored(), second) and bench.starts == 2

    Bench().run(testbench)


GOOD = block(0, 1, noise(WIDTH, HEIGHT, 9))
FAULTS = {
    "a byte is lost": GOOD[:20] + GOOD[21:],
    "a byte is doubled": GOOD[:20] + GOOD[19:],
    "a bit is wrong": GOOD[:20] + bytes([GOOD[20] ^ 4]) + GOOD[21:],
    "the CRC is wrong": GOOD[:-1] + bytes([GOOD[-1] ^ 1]),
    "broken off in the middle": GOOD[:20],
    "broken off in the request": GOOD[:4],
    "a line too early": block(1, 1, noise(WIDTH, HEIGHT, 9)),
    "no such line": encode_request(Request(Operation.BLOCK_WRITE, 0, HEIGHT)) + GOOD[6:],
    "a plane that cannot be written": encode_request(Request(Operation.BLOCK_WRITE, 2, 0)) + GOOD[6:],
}


def test_faults():
    """A bad block changes nothing, and the same line is accepted after a pause; what was stored before stays."""
    pair = noise(WIDTH, HEIGHT, 3)

    async def testbench(bench):
        await bench.write("source", 1)
        await bench.put(pair, [(0, 0)])
        for fault in FAULTS.values():
            await bench.send(fault + GOOD * (len(fault) == len(GOOD)), pause=True)
            await bench.write("start_pair", 1)
        await bench.put(pair, [(0, 1), (1, 0), (1, 1)])
        assert np.array_equal(bench.stored(), pair)
        assert bench.starts == 0
        await bench.write("start_pair", 1)
        assert bench.starts == 1

    Bench().run(testbench)


def test_interrupted_pair():
    """Of a pair that is broken off, and of one whose first line is another's, nothing is started; nor after the cameras had their turn."""
    first, second = noise(WIDTH, HEIGHT, 4), noise(WIDTH, HEIGHT, 5)

    async def testbench(bench):
        await bench.write("source", 1)
        await bench.put(first)
        for lines in ([(0, 0)], [(0, 0), (0, 1), (1, 0)]):
            await bench.put(second, lines)
            await bench.write("start_pair", 1)
            assert (await bench.read("pair_whole"), bench.starts) == (0, 0)
        await bench.write("source", 0)
        await bench.send(block(1, 1, second), pause=True)
        await bench.write("source", 1)
        # Lines are repeated from any on, as after a reply that was lost.
        await bench.put(second, [(0, 1), (1, 0), (1, 0), (1, 1), (1, 0)])
        await bench.write("start_pair", 1)
        assert bench.starts == 0
        await bench.put(second, [(1, 1)])
        await bench.write("start_pair", 1)
        assert bench.starts == 1 and np.array_equal(bench.stored(), second)

    Bench().run(testbench)


@pytest.mark.parametrize("height", [1, 2, 5])
def test_order(height):
    """Any order of lines, against golden."""
    dut, golden, rng = PairLines(height), blocks.PairLines(height), np.random.default_rng(height)

    async def testbench(ctx):
        for _ in range(2000):
            stored, whole = golden._stored, golden.whole
            place = int(np.clip(stored + rng.integers(-2, 3), 0, 2 * height - 1)) if rng.random() < 0.9 else int(rng.integers(2 * height))
            plane, line = divmod(place, height)
            ctx.set(dut.plane, plane)
            ctx.set(dut.line, line)
            assert (ctx.get(dut.accepts), ctx.get(dut.whole)) == (golden.accepts(plane, line), whole)
            if golden.accepts(plane, line):
                golden.store(plane, line)
                ctx.set(dut.stored, 1)
            await ctx.tick()
            ctx.set(dut.stored, 0)

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(testbench)
    simulator.run()


def test_needs_the_hosts_buffers():
    with pytest.raises(ValueError, match="no pair of the host; choose one with host=True"):
        LineAccess(MemoryMap(16, 2, 2), burst=4)
