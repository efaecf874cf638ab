"""hdl.interfaces.frame_rule in front of the line store, against golden.video.frame_rule; its own rules; a proof of its flags."""

import numpy as np
import pytest
from amaranth import *
from amaranth.hdl import Assert
from amaranth.lib import stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator

from golden.config import MatcherConfig
from golden.video.frame_rule import Closes, Fault, received
from hdl.interfaces.frame_rule import FrameRule, ReceivedPixel
from hdl.matcher.lines import LineStore
from hdl.matcher.stream import ColumnWord
from sim.kit.formal import prove
from sim.kit.streams import check_rules, receive, send

from .faulty_frames import FAULTY, frame, random_words, sizes


class RuleAndStore(wiring.Component):
    """The frame rule and what becomes of its frames."""
    def __init__(self, closes):
        self.rule = FrameRule(8, 6, closes)
        self.store = LineStore(MatcherConfig(4, 8))
        super().__init__({"i": In(stream.Signature(ReceivedPixel())), "o": Out(stream.Signature(ColumnWord(3)))})

    def elaborate(self, platform):
        m = Module()
        m.submodules.rule = self.rule
        m.submodules.store = self.store
        wiring.connect(m, wiring.flipped(self.i), self.rule.i)
        wiring.connect(m, self.rule.o, self.store.i)
        wiring.connect(m, self.store.o, wiring.flipped(self.o))
        return m


def pictures(columns):
    """Pictures of the middle pixels of columns, which must be rectangular."""
    pairs, lines, line = [], [], []
    for column in columns:
        assert column.first == (not lines and not line)
        line.append((int(column.left.line), int(column.right.line)))
        if column.last:
            lines.append(line)
            line = []
        if column.end:
            assert column.last
            whole = np.array(lines, dtype=np.uint8)
            pairs.append((whole[..., 0], whole[..., 1]))
            lines = []
    assert not lines and not line
    return pairs


def run(words, width, height, closes, stall=0.0, seed=1):
    """Pictures and faults of the gateware."""
    dut = RuleAndStore(closes)
    rng = np.random.default_rng(seed)
    expected = received(words, width, height, closes)
    columns, through, faults = [], [], []

    async def source(ctx):
        ctx.set(dut.rule.width, width)
        ctx.set(dut.rule.height, height)
        await send(ctx, dut.i, [word._asdict() for word in words], rng=rng, stall=stall)

    async def sink(ctx):
        await receive(ctx, dut.o, sum(left.size for left, _ in expected.pairs), rng=rng, stall=stall)
        ctx.set(dut.o.ready, 1)
        await ctx.tick().repeat(60)

    async def watch(ctx):
        async for _, _, fault in ctx.tick().sample(dut.rule.fault):
            if fault != Fault.NONE.value:
                faults.append(Fault(fault))

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(source)
    simulator.add_testbench(sink)
    simulator.add_testbench(watch, background=True)
    simulator.add_testbench(check_rules(dut.rule.o, through), background=True)
    simulator.add_testbench(check_rules(dut.o, columns), background=True)
    simulator.run()
    return pictures(columns), faults


def same(given, expected):
    assert sizes(given[0]) == sizes(expected.pairs)
    assert all(np.array_equal(mine, golden) for pair, other in zip(given[0], expected.pairs) for mine, golden in zip(pair, other))
    assert given[1] == expected.faults


@pytest.mark.parametrize("closes", Closes)
def test_contradictions(closes):
    """Each kind: the flag is set, what precedes is matched, and the next frame is whole."""
    words = []
    for number, (name, (change, faults)) in enumerate(FAULTY.items()):
        good, bad, following = (frame(5, 4, closes, 3 * number + n) for n in range(3))
        case = received([*good, *change(bad), *following], 5, 4, closes)
        assert case.faults == faults[closes], name
        for pair, whole in ((case.pairs[0], good), (case.pairs[-1], following)):
            assert np.array_equal(np.stack(pair, axis=-1).reshape(-1, 2), [word[:2] for word in whole]), name
        lost = name in ("start in the first line", "no start") or (name == "short first line" and closes is Closes.LINE)
        assert len(case.pairs) == (2 if lost else 3), name
        words += [*good, *change(bad)]
    words += frame(5, 4, closes, 99)
    same(run(words, 5, 4, closes), received(words, 5, 4, closes))


@pytest.mark.parametrize("closes", Closes)
def test_a_frame_that_is_cut_does_not_wait_for_the_next_one(closes):
    """Its first line is too long, or the only one."""
    good, bad = frame(5, 4, closes, 1), frame(5, 4, closes, 2)
    words = [*good, *bad[:4], *(bad[:1] * 20 if closes is Closes.LINE else bad[-1:])]
    words = [word._replace(first=word.first and at in (0, 20)) for at, word in enumerate(words)]
    expected = received(words, 5, 4, closes)
    assert sizes(expected.pairs) == [(5, 4), (5, 1)]
    same(run(words, 5, 4, closes), expected)


@pytest.mark.parametrize("closes", Closes)
@pytest.mark.parametrize("width, height, stall", [
    (5, 4, 0.4), (1, 1, 0.0),
    # Slow: sizes between these two.
    *(pytest.param(*size, 0.4, marks=pytest.mark.slow) for size in ((1, 3), (8, 1)))])
def test_random(width, height, stall, closes):
    words = random_words(np.random.default_rng(width), width, height, closes, 10)
    expected = received(words, width, height, closes)
    assert width * height < 20 or len({*expected.faults}) >= 3
    same(run(words, width, height, closes, stall), expected)


class Proved(Elaboratable):
    """The rule behind a stream that holds what it offers, with sizes that change between frames only, and assertions on what it gives."""
    def __init__(self, closes):
        self.rule = FrameRule(3, 3, closes)
        self.offer, self.word, self.ready, self.hold, self.size = Signal(), Signal(18), Signal(), Signal(), Signal(4)

    @property
    def inputs(self):
        return [self.offer, self.word, self.ready, self.hold, self.size]

    def elaborate(self, platform):
        m = Module()
        m.submodules.rule = rule = self.rule
        i, o = rule.i, rule.o
        stalled, word = Signal(), Signal(18)
        m.d.sync += [stalled.eq(i.valid & ~i.ready), word.eq(i.p)]
        m.d.comb += [i.valid.eq(stalled | self.offer), i.p.eq(Mux(stalled, word, self.word)), o.ready.eq(self.ready)]
        size = Signal(4, init=0b0101)
        m.d.comb += [Cat(rule.width, rule.height).eq(size), rule.hold.eq(self.hold)]
        with m.If(rule.idle & self.size[:2].any() & self.size[2:].any()):
            m.d.sync += size.eq(self.size)

        # A pixel that is offered stays. No more pixels in a line, and no more lines in a frame, than there should be.
        offered, before = Signal(), Signal(19)
        m.d.sync += [offered.eq(o.valid & ~o.ready), before.eq(o.p)]
        x, y, ended = Signal(3), Signal(3), Signal(init=1)
        with m.If(o.valid & o.ready):
            m.d.sync += [x.eq(Mux(o.p.last, 0, Mux(o.p.first, 1, x + 1))), y.eq(Mux(o.p.first, 0, y) + o.p.last), ended.eq(o.p.end)]
        taken = o.valid & ~o.p.first
        m.d.comb += [
            Assert(~offered | (o.valid & (Value.cast(o.p) == before))),
            Assert(~taken | ((x < rule.width) & (y < rule.height) & ~ended)),
            Assert(~(o.valid & o.p.end) | o.p.last),
        ]
        return m


@pytest.mark.parametrize("closes", Closes)
def test_proof(closes, tmp_path):
    """For all inputs in all orders."""
    design = Proved(closes)
    assert prove(design, design.inputs, tmp_path)
