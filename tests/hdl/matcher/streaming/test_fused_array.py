import itertools

import numpy as np
import pytest
from amaranth import *
from amaranth.lib import data, stream, wiring
from amaranth.lib.wiring import In, Out
from amaranth.sim import Simulator

from golden.config import FUSED_1, Fused, MatcherConfig, changed
from golden.matcher.fused import stages
from golden.pictures.scenes import scene
from hdl.matcher.stream import CensusWord
from hdl.matcher.streaming.fused_array import FusedArray, signed_digits
from hdl.matcher.streaming.labels import Queued
from hdl.matcher.streaming.waves import WaveSource
from sim.kit.cases import engine_words, noise
from sim.kit.streams import send
from tests.kit import by_turns


def config_of(labels, width, minimum=0, **fused):
    return MatcherConfig(labels=labels, max_width=width, minimum=minimum, method=changed(FUSED_1, **fused))


class Rig(wiring.Component):
    """The array behind the source of its waves."""
    def __init__(self, config, depth):
        self.config = config
        self.source = WaveSource(config, FusedArray)
        self.array = FusedArray(config, depth)
        label = range(config.labels)
        super().__init__({
            "i": In(stream.Signature(CensusWord(config))), "go": In(1), "in_use": In(9), "minimum": In(8),
            "queued": Out(Queued(config)), "queued_valid": Out(1), "right": Out(label), "right_valid": Out(1),
            "address": In(range(depth)), "cost": Out(data.ArrayLayout(config.data_bits, config.labels)),
            "take": In(1), "size": Out(range(config.method_as(Fused).arms.support_max + 1)),
        })

    def elaborate(self, platform):
        m = Module()
        m.submodules.source = source = self.source
        m.submodules.array = array = self.array
        wiring.connect(m, wiring.flipped(self.i), source.i)
        m.d.comb += [
            source.go.eq(self.go), source.in_use.eq(self.in_use), source.minimum.eq(self.minimum),
            array.i.eq(source.o),
            self.queued.eq(array.queued), self.queued_valid.eq(array.queued_valid),
            self.right.eq(array.sideband.right), self.right_valid.eq(array.sideband.right_valid),
            array.address.eq(self.address), self.cost.eq(array.cost), array.take.eq(self.take), self.size.eq(array.size),
        ]
        return m


def run(dut, pictures, configs, stall):
    """Queued pixels, right labels; then every support sum and size, in the order of their pixels."""
    rng = np.random.default_rng(7)
    labels = configs[0].labels
    count = sum(left.size for left, _ in pictures)
    queued, right, sums, sizes = [], [], [[None] * labels for _ in range(count)], []

    async def source(ctx):
        for (left, right_picture), config in zip(pictures, configs):
            ctx.set(dut.in_use, config.labels_in_use)
            ctx.set(dut.minimum, config.minimum)
            await send(ctx, dut.i, engine_words(left, right_picture, config), rng=rng, stall=stall)
        await ctx.tick().repeat(2 * dut.source.flush_waves + 3 * labels + 60)
        for place in range(count + labels + 2):
            ctx.set(dut.address, place if place < count else 0)
            ctx.set(dut.take, place < count)
            for d in range(labels):
                if 0 <= place - 2 - d < count:
                    sums[place - 2 - d][d] = 2**configs[0].data_bits - 1 - ctx.get(dut.cost)[d]
            if 1 <= place <= count:
                sizes.append(ctx.get(dut.size))
            await ctx.tick()

    async def steps(ctx):
        while True:
            ctx.set(dut.go, rng.random() >= stall)
            await ctx.tick()

    async def watch(ctx):
        async for _, _, valid, word, right_valid, label in ctx.tick().sample(
                dut.queued_valid, dut.queued, dut.right_valid, dut.right):
            if valid:
                queued.append((word.pixel.pixel, word.local, word.pixel.has_upper, word.pixel.has_lower, word.pixel.end))
            if right_valid:
                right.append(label)

    simulator = Simulator(dut)
    simulator.add_clock(1e-6)
    simulator.add_testbench(source)
    simulator.add_testbench(steps, background=True)
    simulator.add_testbench(watch, background=True)
    simulator.run()
    return queued, right, sums, sizes


# Slow: 33 labels, with parameters that 9 labels have too; benches on Verilog have 16, and by `make slow` 39.
@pytest.mark.parametrize("labels, width, height, fused, stall", by_turns([
    (2, 1, 1, {}), (2, 6, 3, {"reach": 0}), (3, 40, 2, {}), (5, 12, 3, {"reach": 31, "arm_threshold": 90}),
    (13, 30, 2, {"census_rows": 3, "census_columns": 3, "census_weight": 127}), (13, 4, 3, {}),
    (18, 40, 2, {"cost_factor": 7, "truncation": 200, "cost_outside": 77, "census_weight": 0}),
    *(pytest.param(*size, 1, {"cost_factor": 0, "cost_shift": 3, "reach": 3, "cost_outside": 255}, marks=marks)
      for size, marks in (((9, 20), []), ((33, 70), [pytest.mark.slow]))),
    # Every unit of the matching cost counts, and three costs are just above the limit.
    (3, 20, 3, {"census_rows": 3, "census_columns": 3, "census_weight": 1, "truncation": 15, "cost_factor": 15, "cost_shift": 0}),
    (6, 20, 2, {"census_rows": 1, "census_columns": 1, "truncation": 1000, "cost_factor": 1, "cost_shift": 2}),
    # The largest cost, and each of its parts, is a power of two.
    *((4, 20, 3, {"census_rows": 3, "census_columns": 3, **fused}) for fused in (
        {"census_weight": 16, "cost_factor": 2, "truncation": 64, "cost_shift": 1, "cost_outside": 128},
        {"census_weight": 8, "cost_factor": 1, "truncation": 64, "cost_shift": 2, "cost_outside": 32, "vertical_lines": 1})),
    *((*size, {"vertical_lines": 1, "cost_shift": 6, "truncation": 60, "cost_outside": 12, **fused}) for *size, fused in [
        (2, 1, 1, {}), (5, 1, 4, {"vertical_threshold": 255}), (13, 30, 4, {"vertical_threshold": 40}), (6, 20, 1, {"reach": 1}),
        (13, 4, 3, {"census_rows": 1})]),
], (0.0, 0.3)))
def test_matches_golden(labels, width, height, fused, stall):
    """A scene, then noise with another least disparity, not all labels in use; then a line of noise whose first right pixels count."""
    configs = [config_of(labels, width, **fused),
               config_of(labels, width, minimum=min(3, width), **fused), config_of(labels, width, **fused)]
    object.__setattr__(configs[1], "in_use", labels - labels // 3)
    pictures = [scene(width, height, labels, seed=4)[:2], noise(width, height, seed=5).astype(np.uint8),
                noise(width, 1, seed=8).astype(np.uint8)]
    dut = Rig(configs[0], sum(left.size for left, _ in pictures) + 3)
    queued, right, sums, sizes = run(dut, pictures, configs, stall)

    results = [stages(*pair, config) for pair, config in zip(pictures, configs)]
    assert sums == [values for result in results for values in result.sums.reshape(-1, labels).tolist()]
    assert sizes == [size for result in results for size in result.support_size.ravel().tolist()]
    # A pixel meets the local disparity of the pixel below it; below the last line there is none.
    expected = []
    for (left, _), result in zip(pictures, results):
        local = np.argmin(result.sums, axis=-1)
        lines = len(left)
        for y in range(lines):
            below = local[y + 1].tolist() if y + 1 < lines else [None] * width
            expected += [(int(grey), b, int(y > 0), int(y + 1 < lines), int(y + 1 == lines and x == width - 1))
                         for x, (grey, b) in enumerate(zip(left[y], below))]
    assert [(grey, b if has_lower else None, *rest[:1], has_lower, *rest[1:])
            for grey, b, has_upper, has_lower, end in queued for rest in [(has_upper, end)]] == expected
    # In the columns of the delayed picture; those before the least disparity have no pixel.
    at = iter(right)
    for config, result in zip(configs, results):
        for line in result.right:
            got = [next(at) for _ in range(width)]
            assert got[config.minimum:] == line[:max(width - config.minimum, 0)].tolist()
    assert next(at, None) is None


@pytest.mark.parametrize("constant", [0, 1, 2, 3, 7, 15, 47, 85, 127])
def test_signed_digits(constant):
    digits = signed_digits(constant)
    assert sum(sign << shift if sign > 0 else -(1 << shift) for sign, shift in digits) == constant
    assert len(digits) <= constant.bit_count()
    shifts = [shift for _, shift in digits]
    assert all(after - before > 1 for before, after in itertools.pairwise(shifts))
