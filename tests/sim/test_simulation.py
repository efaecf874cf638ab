"""The faster engine of Amaranth's simulator gives what Amaranth's own gives, in each clock, for all kinds of signals and processes."""

import random

import amaranth.sim
import pytest
from amaranth import *
from amaranth.hdl import ClockDomain
from amaranth.lib.memory import Memory

from sim.kit.simulation import Simulator


class Design(Elaboratable):
    """Signed and unsigned signals, parts of them, memories with and without a clock, two clock domains, one reset at any time."""
    def __init__(self):
        self.a, self.b, self.address = Signal(8), Signal(signed(6)), Signal(3)
        self.reset, self.other = Signal(), Signal()
        self.total, self.narrow, self.halves = Signal(signed(12), init=-3), Signal(3), Signal(8, init=0x5A)
        self.shared, self.counted, self.chosen, self.empty = Signal(8), Signal(5, init=17), Signal(signed(9)), Signal(0)
        self.read, self.direct, self.late = Signal(signed(8)), Signal(signed(8)), Signal(4, reset_less=True)
        self.outputs = [self.total, self.narrow, self.halves, self.shared, self.counted, self.chosen, self.empty, self.read, self.direct,
                        self.late]

    def elaborate(self, platform):
        m = Module()
        m.domains.sync = ClockDomain()
        m.domains.other = ClockDomain(async_reset=True, clk_edge="neg")
        m.d.comb += [ResetSignal("sync").eq(self.reset), ResetSignal("other").eq(self.other)]
        m.d.sync += self.total.eq(self.total + self.b - self.narrow)
        m.d.comb += [self.narrow.eq(self.a + self.b), self.shared[:4].eq(self.a[2:]), self.empty.eq(self.a)]
        m.d.sync += self.shared[4:].eq(self.shared[:4] + self.b)
        m.d.sync += self.halves.word_select(self.a[0], 4).eq(self.a >> 2)
        m.d.other += self.counted.eq(self.counted + Mux(self.b < 0, 3, 1))
        m.d.sync += self.late.eq(self.late ^ self.a)
        with m.Switch(self.a):
            with m.Case("1----0-1", 6):
                m.d.comb += self.chosen.eq(-self.a)
            with m.Case(*range(10, 99)):
                m.d.comb += self.chosen.eq(Cat(self.b, self.narrow).as_signed())
            with m.Default():
                m.d.comb += self.chosen.eq(Array([self.total, self.b, self.halves])[self.a[:2]])
        m.submodules.memory = memory = Memory(shape=signed(8), depth=6, init=[0, -2, 3])
        write, direct = memory.write_port(granularity=None), memory.read_port(domain="comb")
        read = memory.read_port(transparent_for=[write])
        m.d.comb += [write.addr.eq(self.address), write.data.eq(self.total), write.en.eq(self.a[7]), direct.addr.eq(self.address),
                     read.addr.eq(self.address), read.en.eq(self.a[0]), self.read.eq(read.data), self.direct.eq(direct.data)]
        return m


def record(make, runs=1):
    """Outputs before and after each edge of ``sync``, of runs from the start."""
    dut = Design()
    simulator = make(dut)
    simulator.add_clock(1e-6)
    simulator.add_clock(0.7e-6, domain="other")
    trace = []

    async def drive(ctx):
        rng = random.Random(1)
        trace.append([ctx.get(output) for output in dut.outputs])   # as the first inputs, 0, make them
        for _ in range(400):
            for signal in (dut.a, dut.b, dut.address):
                if rng.random() < 0.7:
                    ctx.set(signal, rng.getrandbits(len(signal)))
                    trace.append([ctx.get(output) for output in dut.outputs])
            for signal in (dut.reset, dut.other):
                ctx.set(signal, rng.random() < 0.05)
            trace.append(list((await ctx.tick().sample(*dut.outputs))[2:]))

    async def echo(ctx):
        async for *_, narrow in ctx.tick().sample(dut.narrow):
            trace.append(narrow)

    simulator.add_testbench(drive)
    simulator.add_testbench(echo, background=True)
    for number in range(runs):
        if number:
            simulator.reset()
        simulator.run()
    return trace


@pytest.mark.parametrize("runs", [1, 2])
def test_same_as_amaranth_s_own(runs):
    expected, found = (record(make, runs) for make in (amaranth.sim.Simulator, Simulator))
    assert found == expected
    assert len({str(entry) for entry in expected}) > 500


def test_waveforms_are_refused(tmp_path):
    simulator = Simulator(Design())
    with pytest.raises(NotImplementedError, match=r"import Simulator from amaranth\.sim"), simulator.write_vcd(str(tmp_path / "out.vcd")):
        pass
    assert list(tmp_path.iterdir()) == []
