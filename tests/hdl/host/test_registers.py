# amaranth: UnusedElaboratable=no
"""hdl.host.registers: what the register file answers, byte by byte, against golden.host.registers.answer."""

from dataclasses import replace

import numpy as np
import pytest
from amaranth.hdl import Shape
from amaranth.sim import Simulator

from golden.config import FUSED_1, MatcherConfig, changed
from golden.host.blocks import block_answer
from golden.host.protocol import (
    FRAME_BYTES,
    REQUEST_SYNC,
    Operation,
    Reply,
    Request,
    Status,
    decode_reply,
    encode_reply,
    encode_request,
)
from golden.host.registers import COUNT_MAX, Kind, RegisterMap, answer, register_map
from golden.rig.config import RigConfig
from hdl.host.register_file import ActionLayout, RegisterFile, SettingLayout, StatusLayout
from hdl.host.registers import ByteRegisters
from sim.kit.streams import check_rules, receive, run_stream, send
from tests.kit import refused_components


# A setting may be negative.
REGISTERS = register_map(MatcherConfig(labels=20, max_width=300, minimum=-16, method=changed(FUSED_1, u1=1, u2=2, u3=3)), 200, RigConfig())
STATUS = StatusLayout(REGISTERS, ["uart_errors"])
TIMEOUT = 50
READ_U1 = encode_request(Request(Operation.READ, REGISTERS["u1"].address))


def register_file():
    return ByteRegisters(REGISTERS, TIMEOUT)


def random_status(rng):
    """Every status input, many at their least and greatest."""
    given = {}
    for name in STATUS.members:
        maximum = REGISTERS[name].maximum
        given[name] = int(rng.choice([0, maximum, rng.integers(0, maximum + 1)]))
    return given


def conversation(data, status):
    """The chip's bytes after bytes without a pause: ``(bytes, parameters, actions, errors)``, from the golden answer."""
    values = dict(status)
    settings = {register.name: register.reset for register in REGISTERS.of(Kind.SETTING)}
    actions: list = []
    given = b""
    errors = at = 0
    while at < len(data):
        if data[at] != REQUEST_SYNC:
            at, errors = at + 1, errors + 1
            continue
        if len(data) - at < FRAME_BYTES:
            break
        frame = data[at:at + FRAME_BYTES]
        reply, written = answer(REGISTERS, {**values, **settings, "uart_errors": errors}, frame)
        refused = reply.status is Status.UNKNOWN_OPERATION and frame[1] == Operation.BLOCK
        given += block_answer(None, 1, frame) if refused else encode_reply(reply)
        errors += reply.status is Status.BAD_SUM
        for name, value in written.items():
            if name in settings:
                settings[name] = value
            else:
                actions.append(name)
                errors = 0 if name == "clear_counters" else errors
        at += FRAME_BYTES
    return given, settings, actions, errors


def run_conversation(data, status, *, rng, stall=0.0):
    """The same of the gateware."""
    dut = register_file()
    expected, *_ = conversation(data, status)
    taken, given, actions = [], [], []
    end = {}

    async def source(ctx):
        ctx.set(dut.status, status)
        await send(ctx, dut.i, data, rng=rng, stall=stall)

    async def sink(ctx):
        # Stalls shorter than the time-out within a request, at the rates that are tested.
        await receive(ctx, dut.o, len(expected), rng=rng, stall=stall)
        ctx.set(dut.o.ready, 1)
        await ctx.tick().repeat(TIMEOUT + 20)
        end["settings"] = {name: ctx.get(dut.settings[name]) for name in SettingLayout(REGISTERS).members}
        end["errors"] = ctx.get(dut.errors)

    async def watch(ctx):
        async for _, _, fired in ctx.tick().sample(dut.actions.as_value()):
            actions.extend(name for place, name in enumerate(ActionLayout(REGISTERS).members) if fired >> place & 1)

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(source)
    simulator.add_testbench(sink)
    simulator.add_testbench(watch, background=True)
    simulator.add_testbench(check_rules(dut.i, taken), background=True)
    simulator.add_testbench(check_rules(dut.o, given), background=True)
    simulator.run()
    assert bytes(taken) == data
    return bytes(given), end["settings"], actions, end["errors"]


def every_request():
    """A read of each register, writes about each one's limits and of what must not be written, unknown operations and addresses."""
    for register in REGISTERS:
        yield Request(Operation.READ, register.address, 0x5AA5)
        # Each value, and then a read of what it has left.
        for value in {register.minimum, register.maximum, register.minimum - 1, register.maximum + 1, 0, 0x100, COUNT_MAX}:
            if value <= COUNT_MAX:
                yield Request(Operation.WRITE, register.address, register.encode(value))
        yield Request(Operation.READ, register.address)
        yield Request(0x00, register.address, register.maximum)
    # A register file without anything that reads blocks.
    yield Request(Operation.BLOCK, 0, 0)
    for address in (0x07, 0x0F, 0x1B, 0x1F, 0x22, 0x39, 0x53, 0x7F, 0x80, 0x90, 0xFF):
        yield Request(Operation.READ, address)
        yield Request(Operation.WRITE, address, 1)
    for operation in (Operation.READ ^ 1, Operation.WRITE ^ 0x80, 0xFF):
        yield Request(operation, REGISTERS["u1"].address, 1)


@pytest.mark.parametrize("stall", [0.0, 0.5])
def test_every_request(stall):
    rng = np.random.default_rng(1)
    status = random_status(rng)
    data = b"".join(map(encode_request, every_request()))
    expected = conversation(data, status)
    assert run_conversation(data, status, rng=rng, stall=stall) == expected
    replies = [decode_reply(expected[0][at:at + FRAME_BYTES]) for at in range(0, len(expected[0]), FRAME_BYTES)]
    assert {reply.status for reply in replies} == set(Status) - {Status.BAD_SUM, Status.BUSY}


@pytest.mark.parametrize("seed", range(3))
def test_requests_in_noise(seed):
    """Good requests, requests with a fault, and bytes of noise, among them sync bytes, in any order and without a pause."""
    rng = np.random.default_rng(seed)
    status = random_status(rng)
    data = b""
    for _ in range(60):
        register = REGISTERS.registers[rng.integers(len(REGISTERS))]
        operation = rng.choice([Operation.READ, Operation.WRITE])
        frame = bytearray(encode_request(Request(int(operation), register.address, int(rng.integers(0, register.maximum + 2) % 65536))))
        if rng.random() < 0.3:
            frame[rng.integers(FRAME_BYTES)] ^= 1 << int(rng.integers(8))
        if rng.random() < 0.3:
            frame += bytes(rng.choice([REQUEST_SYNC, 0, 255, rng.integers(256)], rng.integers(1, 5)).astype(np.uint8).tolist())
        data += bytes(frame)
    # An end that leaves no request open.
    data += bytes(FRAME_BYTES)
    expected = conversation(data, status)
    assert expected[3] > 20
    assert run_conversation(data, status, rng=rng, stall=[0.0, 0.3, 0.6][seed]) == expected


def play(dut, testbench):
    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(testbench)
    simulator.run()


async def put(ctx, dut, data):
    for byte in data:
        ctx.set(dut.i.payload, byte)
        ctx.set(dut.i.valid, 1)
        for _ in range(100):
            _, _, ready = await ctx.tick().sample(dut.i.ready)
            if ready:
                break
        else:
            raise TimeoutError("a byte is not taken for 100 cycles")
    ctx.set(dut.i.valid, 0)


async def reply_of(ctx, dut, cycles=40):
    """The bytes received within so many cycles."""
    given = []
    ctx.set(dut.o.ready, 1)
    for _ in range(cycles):
        _, _, valid, byte = await ctx.tick().sample(dut.o.valid, dut.o.payload)
        if valid:
            given.append(byte)
    ctx.set(dut.o.ready, 0)
    return bytes(given)


def test_latency():
    """The reply begins 3 cycles after the request's last byte is taken, and the next request is taken after its last byte."""
    cycles: dict = {}
    run_stream(register_file(), READ_U1 * 2, rng=np.random.default_rng(1), cycles=cycles)
    assert cycles["i"] == [*range(6), *range(14, 20)]
    assert cycles["o"] == [*range(8, 14), *range(22, 28)]


def test_reset_values():
    dut = register_file()

    async def testbench(ctx):
        assert {name: ctx.get(dut.settings[name]) for name in SettingLayout(REGISTERS).members} == {
            "u1": 1, "u2": 2, "u3": 3, "in_use": 20, "show": 0, "colour": 0, "hold": 0, "keep": 0, "source": 0,
            "minimum": -16, "check": 1, "fill": 1, "median": 1,
            "rectify": 1, "balance": 1, "fixed_gain": 256, "fixed_offset": 0, "row_offset": 0, "map_side": 0, "map_address": 0,
            "map_low": 0, "map_middle": 0, "map_high": 0}
        assert ctx.get(dut.actions.as_value()) == ctx.get(dut.errors) == 0

    play(dut, testbench)


@pytest.mark.parametrize("given", range(1, FRAME_BYTES))
def test_time_out(given):
    """A byte in the last cycle still counts; one after it begins a new request."""
    dut = register_file()

    async def testbench(ctx):
        await put(ctx, dut, READ_U1[:given])
        await ctx.tick().repeat(TIMEOUT - 1)
        await put(ctx, dut, READ_U1[given:])
        assert await reply_of(ctx, dut) == encode_reply(Reply(Status.OK, 0x10, 1))
        assert ctx.get(dut.errors) == 0
        # A long silence between requests is none within one.
        await ctx.tick().repeat(2 * TIMEOUT)
        assert ctx.get(dut.errors) == 0
        for count in (1, 2):
            await put(ctx, dut, READ_U1[:given])
            await ctx.tick().repeat(TIMEOUT)
            assert ctx.get(dut.errors) == count
            await put(ctx, dut, READ_U1)
            assert await reply_of(ctx, dut) == encode_reply(Reply(Status.OK, 0x10, 1))
            assert ctx.get(dut.errors) == count

    play(dut, testbench)


@pytest.mark.parametrize("given", range(1, FRAME_BYTES))
def test_lost_byte(given):
    """A request of which the line has lost a byte is dropped; what follows is read from its beginning."""
    dut = register_file()

    async def testbench(ctx):
        await put(ctx, dut, READ_U1[:given])
        ctx.set(dut.line_error, 1)
        await ctx.tick()
        ctx.set(dut.line_error, 0)
        await put(ctx, dut, READ_U1)
        assert await reply_of(ctx, dut) == encode_reply(Reply(Status.OK, 0x10, 1))
        assert ctx.get(dut.errors) == 1

    play(dut, testbench)


def test_line_error_in_a_reply():
    """Counted; the reply is not disturbed."""
    dut = register_file()

    async def testbench(ctx):
        await put(ctx, dut, READ_U1)
        ctx.set(dut.line_error, 1)
        await ctx.tick().repeat(4)
        ctx.set(dut.line_error, 0)
        assert await reply_of(ctx, dut) == encode_reply(Reply(Status.OK, 0x10, 1))
        assert ctx.get(dut.errors) == 4

    play(dut, testbench)


def test_errors_stay_at_their_greatest_and_are_cleared():
    dut = register_file()

    async def testbench(ctx):
        ctx.set(dut.reader.errors, COUNT_MAX - 1)
        for expected in (COUNT_MAX, COUNT_MAX, COUNT_MAX):
            await put(ctx, dut, b"\0")
            assert ctx.get(dut.errors) == expected
        await put(ctx, dut, encode_request(Request(Operation.READ, REGISTERS["uart_errors"].address)))
        assert await reply_of(ctx, dut) == encode_reply(Reply(Status.OK, REGISTERS["uart_errors"].address, COUNT_MAX))
        await put(ctx, dut, encode_request(Request(Operation.WRITE, REGISTERS["clear_counters"].address, 1)))
        await reply_of(ctx, dut)
        assert ctx.get(dut.errors) == 0

    play(dut, testbench)


def test_no_value_is_torn():
    """A counter whose two bytes change in every cycle: the value read is that of the cycle after the request's last byte."""
    dut = register_file()
    address = REGISTERS["pairs"].address
    shown = []

    async def counter(ctx):
        for number in range(10_000):
            value = number * 0x0101 % 65536
            shown.append(value)
            ctx.set(dut.status.pairs, value)
            await ctx.tick()

    async def testbench(ctx):
        for pause in range(1, 20):
            await put(ctx, dut, encode_request(Request(Operation.READ, address)))
            now = len(shown)
            reply = decode_reply(await reply_of(ctx, dut, cycles=20 + pause))
            assert reply.value in shown[now - 1:now + 1]

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(counter, background=True)
    simulator.add_testbench(testbench)
    simulator.run()


def test_actions_and_parameters_change_before_the_reply():
    dut = register_file()

    async def testbench(ctx):
        for name, value in (("restart_setup", 1), ("clear_counters", 1), ("u3", 63), ("in_use", 7)):
            await put(ctx, dut, encode_request(Request(Operation.WRITE, REGISTERS[name].address, value)))
            await ctx.tick()
            assert not ctx.get(dut.o.valid)
            if name in ActionLayout(REGISTERS).members:
                assert [other for other in ActionLayout(REGISTERS).members if ctx.get(dut.actions[other])] == [name]
            await ctx.tick()
            assert ctx.get(dut.o.valid)
            assert ctx.get(dut.actions.as_value()) == 0
            if name in SettingLayout(REGISTERS).members:
                assert ctx.get(dut.settings[name]) == value
            await reply_of(ctx, dut)

    play(dut, testbench)


def test_layouts():
    assert "uart_errors" not in STATUS.members
    assert len(STATUS.members) + 1 == len(REGISTERS.of(Kind.STATUS, Kind.COUNTER))
    for layout in (STATUS, SettingLayout(REGISTERS), ActionLayout(REGISTERS)):
        for name, width in layout.members.items():
            register = REGISTERS[name]
            assert Shape.cast(width) == Shape(register.width, register.signed)


def test_bad_arguments():
    with refused_components(), pytest.raises(ValueError, match=r"at least 2 cycles, not 1$"):
        ByteRegisters(REGISTERS, 1)
    with refused_components(), pytest.raises(ValueError, match=r"at least 16 bits, not 8$"):
        RegisterFile(REGISTERS, 8)
    for name in ("uart_errors", "clear_counters"):
        registers = RegisterMap(tuple(register for register in REGISTERS if register.name != name))
        with pytest.raises(ValueError, match=f"no {name}"):
            ByteRegisters(registers, 100)


def test_extra_register_is_answered():
    """The map is data: a register more needs nothing else."""
    extra = replace(REGISTERS["decoder_step"], name="extra", address=0xEE, maximum=500)
    dut = ByteRegisters(RegisterMap((*REGISTERS, extra)), TIMEOUT)

    async def testbench(ctx):
        ctx.set(dut.status.extra, 499)
        await put(ctx, dut, encode_request(Request(Operation.READ, 0xEE)))
        assert await reply_of(ctx, dut) == encode_reply(Reply(Status.OK, 0xEE, 499))

    play(dut, testbench)
