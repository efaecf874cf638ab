# amaranth: UnusedElaboratable=no
"""hdl.host.blocks and hdl.video.line_access: block reads byte by byte, from a strict memory, through the register file."""

import numpy as np
import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.sim import Simulator

from golden.config import MatcherConfig, OnePass, changed
from golden.host.blocks import block_answer
from golden.host.protocol import (
    BAUD,
    FRAME_BYTES,
    Operation,
    Reply,
    Request,
    Status,
    block_bits,
    crc,
    decode_reply,
    encode_reply,
    encode_request,
)
from golden.host.registers import register_map
from golden.video.memory_map import MemoryMap, Plane
from hdl.host.blocks import BlockRead, crc_step
from hdl.host.registers import ByteRegisters
from hdl.video.arbiter import Arbiter
from hdl.video.line_access import LineAccess
from sim.kit.cases import noise
from sim.kit.streams import check_rules, receive, send
from sim.models.ddr2 import Ddr2Timing, LocalMemory, serve
from sim.models.uart import SimulatedChip


#: Of streams without a stall.
RNG = np.random.default_rng(0)


def test_crc_step():
    rng = np.random.default_rng(1)
    value, byte, result = Signal(16), Signal(8), Signal(16)
    m = Module()
    m.d.comb += result.eq(crc_step(value, byte))

    async def testbench(ctx):
        state = 0xFFFF
        data = b""
        for number in rng.bytes(300):
            ctx.set(value, state)
            ctx.set(byte, number)
            state = ctx.get(result)
            data += bytes([number])
            assert state == crc(data)

    simulator = Simulator(m)
    simulator.add_testbench(testbench)
    simulator.run()


class System:
    """Register file, block read and line reader before a memory in whose buffers there is noise; buffers 0, 1 and 2 are the kept ones."""
    BUFFERS = (0, 1, 2)

    def __init__(self, width, height, *, seed=1, busy=0.5):
        self.memory_map = MemoryMap(width, height, 3, host=True)
        self.memory = LocalMemory(self.memory_map.total_words, timing=Ddr2Timing(busy=busy, refresh=(150, 30)), seed=seed)
        self.planes = []
        for plane in (Plane.LEFT, Plane.RIGHT, Plane.DISPARITY):
            for buffer in range(3):
                picture, = noise(width, height, seed + 10 * plane + buffer, pictures=1)
                self.memory.load(self.memory_map, plane, buffer, picture)
                if buffer == self.BUFFERS[plane]:
                    self.planes.append(picture)
        self.height = height
        self.registers = register_map(MatcherConfig(max_width=max(width, 16), method=OnePass()), height)
        self.file = ByteRegisters(self.registers, 50)
        self.read = BlockRead(height)
        self.reader = LineAccess(self.memory_map, burst=4)
        self.arbiter = Arbiter(1, 2, burst=4)

    def run(self, *testbenches):
        m = Module()
        m.submodules += [self.file, self.read, self.reader, self.arbiter]
        wiring.connect(m, self.file.block, self.read.port)
        wiring.connect(m, self.read.request, self.reader.i)
        wiring.connect(m, self.reader.o, self.read.i)
        wiring.connect(m, self.reader.read, self.arbiter.read[1])
        m.d.comb += [chosen.eq(buffer) for chosen, buffer in zip((self.reader.left, self.reader.right, self.reader.slot), self.BUFFERS)]
        simulator = Simulator(m)
        simulator.add_clock(1e-6)
        for testbench in testbenches:
            simulator.add_testbench(testbench)
        simulator.add_process(serve(self.arbiter.bus, self.memory))
        for stream in (self.file.o, self.read.request, self.reader.o, self.reader.read.request):
            simulator.add_testbench(check_rules(stream, []), background=True)
        simulator.run()

    def answer(self, *requests, kept=True):
        return b"".join(block_answer(self.planes if kept else None, self.height, encode_request(request)) for request in requests)


def block(plane, line):
    return Request(Operation.BLOCK, plane, line)


@pytest.mark.parametrize("stall", [0.0, 0.6])
@pytest.mark.parametrize("width, height", [(16, 3), (80, 260)])
def test_every_plane(width, height, stall):
    """First, last and other lines, and what is refused, without a pause."""
    system = System(width, height)
    requests = [block(plane, line) for plane in range(3) for line in (0, height - 1, height // 2)]
    requests += [block(3, 0), block(0, height), block(0, 0x8000), block(0x80, 0), block(1, 1)]
    expected = system.answer(*requests)
    rng = np.random.default_rng(1)
    received = []

    async def source(ctx):
        ctx.set(system.read.kept, 1)
        await ctx.tick()
        await send(ctx, system.file.i, b"".join(map(encode_request, requests)), rng=rng)

    async def sink(ctx):
        received.extend(await receive(ctx, system.file.o, len(expected), rng=rng, stall=stall))
        assert ctx.get(system.file.errors) == 0

    system.run(source, sink)
    assert bytes(received) == expected


async def bytes_until_quiet(ctx, stream, quiet=200):
    """Bytes of a stream that is always ready, until none is received for so many cycles."""
    data, since = [], 0
    ctx.set(stream.ready, 1)
    while since < quiet:
        _, _, valid, byte = await ctx.tick().sample(stream.valid, stream.payload)
        since = 0 if valid else since + 1
        data += [byte] if valid else []
    return bytes(data)


def test_refused_unless_a_pair_is_kept():
    system = System(32, 2)

    async def testbench(ctx):
        for kept in (0, 1, 0):
            ctx.set(system.read.kept, kept)
            await send(ctx, system.file.i, encode_request(block(2, 1)), rng=RNG)
            assert await bytes_until_quiet(ctx, system.file.o) == system.answer(block(2, 1), kept=kept)

    system.run(testbench)


def test_let_go_in_a_block():
    """In any cycle of a block, for one cycle: it ends with the inverted CRC unless its line was sent before; the next block is good."""
    system = System(16, 2, busy=0.0)
    request = encode_request(block(1, 1))
    good = system.answer(block(1, 1))
    inverted = good[:-2] + bytes(byte ^ 0xFF for byte in good[-2:])
    seen = []

    async def testbench(ctx):
        ctx.set(system.read.kept, 1)
        await ctx.tick()
        for cycle in range(60):
            await send(ctx, system.file.i, request, rng=RNG)
            data, since, quiet, sent = [], 0, 0, None
            ctx.set(system.file.o.ready, 1)
            while quiet < 60:
                ctx.set(system.read.kept, since != cycle)
                sent = len(data) if since == cycle else sent
                _, _, valid, byte = await ctx.tick().sample(system.file.o.valid, system.file.o.payload)
                data += [byte] if valid else []
                since, quiet = since + 1, 0 if valid else quiet + 1
            ctx.set(system.file.o.ready, 0)
            seen.append((sent, bytes(data)))
        await send(ctx, system.file.i, request, rng=RNG)
        assert await bytes_until_quiet(ctx, system.file.o) == good

    system.run(testbench)
    refused = encode_reply(Reply(Status.NOT_KEPT, 1))
    assert all(data == (inverted if sent < FRAME_BYTES + 16 else good) for sent, data in seen if data != refused)
    assert [cycle for cycle, (_, data) in enumerate(seen) if data == refused] == [0]
    assert {data for _, data in seen} == {good, inverted, refused}


def test_no_byte_is_taken_in_a_block():
    """A request in the middle of a block waits, to be answered after it."""
    system = System(32, 2)
    requests = [block(0, 0), Request(Operation.READ, 0), block(2, 1)]
    taken = []

    async def source(ctx):
        ctx.set(system.read.kept, 1)
        await ctx.tick()
        await send(ctx, system.file.i, b"".join(map(encode_request, requests)), rng=RNG)
        taken.append(len(received))

    received = []

    async def sink(ctx):
        received.extend(await receive(ctx, system.file.o, len(expected), rng=RNG))

    first, last = system.answer(requests[0]), system.answer(requests[2])
    expected = first + encode_reply(Reply(Status.OK, 0, system.registers["identity"].reset)) + last
    system.run(source, sink)
    assert bytes(received) == expected


FRAME_BITS = 30


def chip(width=16, **options):
    registers = register_map(MatcherConfig(max_width=width, method=changed(OnePass(), u1=1)), 4)
    simulated = SimulatedChip(registers, frame_seconds=FRAME_BITS / BAUD, **options)
    simulated.planes = noise(width, 4, 1, pictures=3)
    simulated.write(encode_request(Request(Operation.WRITE, registers["keep"].address, 1)))
    assert decode_reply(simulated.read(FRAME_BYTES, 2e-3)).status is Status.OK
    return simulated


@pytest.mark.parametrize("width", [16, pytest.param(720, marks=pytest.mark.slow)])    # 117,440 clocks
def test_time_of_a_line(width):
    """Request, reply and block take as many bits as golden says, but for less than one."""
    simulated = chip(width)
    expected = block_answer(simulated.planes, 4, encode_request(block(2, 3)))
    before = simulated.line.cycle
    simulated.write(encode_request(block(2, 3)))
    assert simulated.read(len(expected), 0.1) == expected
    assert abs(simulated.line.cycle - before - 16 * block_bits(width)) < 16


# All kinds of noise take several seconds.
@pytest.mark.parametrize("seed, kinds", [(0, 2), *(pytest.param(seed, 4, marks=pytest.mark.slow) for seed in (1, 2, 3))])
def test_line_noise_in_a_block(seed, kinds):
    """Whatever the host sends meanwhile, the block is undisturbed; after its end and a pause the chip answers."""
    rng = np.random.default_rng(seed)
    simulated = chip(rng=rng)
    request = encode_request(block(1, 2))
    expected = block_answer(simulated.planes, 4, request)
    bursts = (lambda: simulated.line.send(request * 2), lambda: simulated.line.send_noise(100),
              lambda: simulated.line.send_level(0, 100), lambda: simulated.line.send(rng.integers(0, 256, 12).tolist()))
    for burst in bursts[:kinds]:
        simulated.write(request)
        assert simulated.read(FRAME_BYTES + 3, 0.1) == expected[:FRAME_BYTES + 3]
        burst()
        assert simulated.read(len(expected) - FRAME_BYTES - 3, 0.1) == expected[FRAME_BYTES + 3:]
        simulated.line.send_level(1, FRAME_BITS + 10 * FRAME_BYTES + 1)
        while not simulated.line.idle:
            simulated.advance(16)
        simulated.line.received.clear()
        simulated.write(request)
        assert simulated.read(len(expected), 0.1) == expected
