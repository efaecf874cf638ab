"""hdl.interfaces.words, axi_lite and avalon_mm in front of a register file: against golden.host.core_registers, and their latencies."""

import random

import pytest
from amaranth import *
from amaranth.lib import wiring
from amaranth.sim import Simulator

from golden.config import FUSED_1, MatcherConfig
from golden.host.core_registers import core_register_map, word_access
from golden.host.protocol import Status
from golden.host.registers import Kind
from hdl.host.register_file import RegisterFile
from hdl.interfaces.avalon_mm import AvalonMemoryMapped
from hdl.interfaces.axi_lite import AxiLite
from hdl.interfaces.words import WordAccess
from sim.kit.streams import check_rules, receive, send


REGISTERS = core_register_map(MatcherConfig(6, 20, -16, method=FUSED_1), 10)


class Registers(Elaboratable):
    """A register file behind accesses of words, with the front of a bus or without one."""
    def __init__(self, front=None):
        self.file = RegisterFile(REGISTERS, 32)
        self.access = WordAccess()
        self.front = front

    def elaborate(self, platform):
        m = Module()
        m.submodules.file = self.file
        m.submodules.access = self.access
        wiring.connect(m, self.access.access, self.file.access)
        if self.front:
            m.submodules.front = front = self.front
            wiring.connect(m, front.command, self.access.i)
            wiring.connect(m, self.access.o, front.result)
        return m

    def run(self, *testbenches, background=()):
        simulator = Simulator(self)
        simulator.add_clock(1e-6)
        for testbench in testbenches:
            simulator.add_testbench(testbench)
        for testbench in background:
            simulator.add_testbench(testbench, background=True)
        simulator.run()


def random_commands(count, rng):
    for _ in range(count):
        register = rng.choice([*REGISTERS])
        data = rng.choice([register.minimum, register.maximum, register.minimum - 1, register.maximum + 1, rng.getrandbits(32)]) % 2**32
        yield {"address": rng.choice([register.address] * 4 + [rng.randrange(256)]), "write": rng.randrange(2), "data": data,
               "strobes": rng.choice([15, 15, rng.randrange(16)])}


@pytest.mark.parametrize("stall", [0.0, 0.4])
def test_random_accesses(stall):
    dut, rng = Registers(), random.Random(1)
    status = {register.name: rng.randint(0, register.maximum) for register in REGISTERS.of(Kind.STATUS, Kind.COUNTER)}
    commands = [*random_commands(250, rng)]
    values = status | {register.name: register.reset for register in REGISTERS.of(Kind.SETTING)}
    expected, actions, fired = [], [], []
    for command in commands:
        data = command["data"] if command["write"] else None
        status_, value, written = word_access(REGISTERS, values, command["address"], data, command["strobes"])
        # What a write gives back is not defined.
        expected.append((status_, value if status_ is Status.OK and data is None else None))
        actions += [name for name in written if REGISTERS[name].kind is Kind.ACTION]
        values |= {name: number for name, number in written.items() if REGISTERS[name].kind is Kind.SETTING}
    given, taken, commands_at, responses_at = [], [], [], []

    async def source(ctx):
        ctx.set(dut.file.status, status)
        await send(ctx, dut.access.i, commands, rng=rng, stall=stall)

    async def sink(ctx):
        await receive(ctx, dut.access.o, len(commands), rng=rng, stall=stall)

    async def watch(ctx):
        async for _, _, now in ctx.tick().sample(dut.file.actions.as_value()):
            fired.extend(register.name for place, register in enumerate(REGISTERS.of(Kind.ACTION)) if now >> place & 1)

    dut.run(source, sink, background=[watch, check_rules(dut.access.i, taken, commands_at),
                                      check_rules(dut.access.o, given, responses_at)])
    assert [(Status(word.status), None if value is None else word.data)
            for word, (_, value) in zip(given, expected, strict=True)] == expected
    assert fired == actions and {"apply", "clear"} == set(actions)
    assert {status for status, _ in expected} == {Status.OK, Status.UNKNOWN_ADDRESS, Status.READ_ONLY, Status.OUT_OF_RANGE}
    if not stall:
        assert {after - before for before, after in zip(commands_at, responses_at)} == {5}
        assert {after - before for before, after in zip(responses_at, commands_at[1:])} == {1}


async def cycles_until(ctx, signal):
    """Cycles from this one, whose inputs are accepted at its end, to the one in which ``signal`` is high."""
    cycles = 0
    while not ctx.get(signal):
        await ctx.tick()
        cycles += 1
        assert cycles < 30
    return cycles


def test_axi_latency_and_no_write_without_data():
    bus = AxiLite()
    dut = Registers(bus)
    width = REGISTERS["width"].address

    async def testbench(ctx):
        ctx.set(bus.araddr, 4 * width + 3)
        ctx.set(bus.arvalid, 1)
        await ctx.tick()
        ctx.set(bus.arvalid, 0)
        assert 1 + await cycles_until(ctx, bus.rvalid) == 8
        assert ctx.get(bus.rdata) == REGISTERS["width"].reset
        # The response to the read is not accepted; neither is the one to the first write. The second one's address and data wait.
        for value in (7, 9):
            ctx.set(bus.awaddr, 4 * width)
            ctx.set(bus.awvalid, 1)
            await ctx.tick()
            ctx.set(bus.awvalid, 0)
            assert not ctx.get(bus.awready)
            await ctx.tick().repeat(20)
            assert ctx.get(dut.file.settings.width) == (REGISTERS["width"].reset if value == 7 else 7)
            ctx.set(bus.wdata, value)
            ctx.set(bus.wstrb, 15)
            ctx.set(bus.wvalid, 1)
            await ctx.tick()
            ctx.set(bus.wvalid, 0)
            if value == 7:
                assert 1 + await cycles_until(ctx, bus.bvalid) == 8
            await ctx.tick().repeat(20)
            assert ctx.get(dut.file.settings.width) == 7 and ctx.get(bus.bvalid) and ctx.get(bus.rvalid)
        # A second read waits, too.
        ctx.set(bus.araddr, 4 * REGISTERS["height"].address)
        ctx.set(bus.arvalid, 1)
        await ctx.tick()
        ctx.set(bus.arvalid, 0)
        await ctx.tick().repeat(20)
        assert ctx.get(bus.rvalid) and ctx.get(bus.rdata) == REGISTERS["width"].reset
        ctx.set(bus.rready, 1)
        await ctx.tick()
        await cycles_until(ctx, bus.rvalid)
        assert ctx.get(bus.rdata) == REGISTERS["height"].reset
        ctx.set(bus.bready, 1)
        await ctx.tick()
        assert not ctx.get(bus.bvalid)
        await cycles_until(ctx, bus.bvalid)
        assert ctx.get(dut.file.settings.width) == 9

    dut.run(testbench)


def test_axi_takes_turns():
    """A master that reads all the time does not keep writes waiting, and the other way round."""
    bus = AxiLite()
    dut = Registers(bus)
    order = []

    async def testbench(ctx):
        for name in ("awvalid", "wvalid", "arvalid", "bready", "rready"):
            ctx.set(getattr(bus, name), 1)
        for _ in range(80):
            _, _, wrote, read = await ctx.tick().sample(bus.bvalid, bus.rvalid)
            assert not (wrote and read)
            order.extend("w" * wrote + "r" * read)

    dut.run(testbench)
    assert "".join(order)[:8] in ("wrwrwrwr", "rwrwrwrw")


def test_avalon_latency_and_responses():
    bus = AvalonMemoryMapped()
    dut = Registers(bus)

    async def access(ctx, kind, address, data=0):
        ctx.set(bus.address, address)
        ctx.set(bus.writedata, data)
        ctx.set(bus.byteenable, 15)
        ctx.set(getattr(bus, kind), 1)
        assert not ctx.get(bus.waitrequest)
        await ctx.tick()
        # The next access is offered at once, and must wait.
        ctx.set(bus.address, 0xFF)
        assert ctx.get(bus.waitrequest)
        ctx.set(getattr(bus, kind), 0)
        told, other = (bus.readdatavalid, bus.writeresponsevalid)[::1 if kind == "read" else -1]
        assert 1 + await cycles_until(ctx, told) == 7 and not ctx.get(other)
        result = ctx.get(bus.response), ctx.get(bus.readdata)
        await ctx.tick()
        assert not ctx.get(told)
        return result

    async def testbench(ctx):
        u1 = REGISTERS["u1"].address
        assert await access(ctx, "read", u1) == (0b00, REGISTERS["u1"].reset)
        assert (await access(ctx, "write", u1, 9))[0] == 0b00
        assert await access(ctx, "read", u1) == (0b00, 9)
        assert (await access(ctx, "write", u1, 64))[0] == 0b10
        assert (await access(ctx, "write", REGISTERS["frames"].address, 0))[0] == 0b10
        assert await access(ctx, "read", 0xFE) == (0b11, 0)

    dut.run(testbench)
