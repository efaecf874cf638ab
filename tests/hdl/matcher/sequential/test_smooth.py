import itertools

import numpy as np
import pytest
from amaranth.sim import Simulator

from golden.config import WEIGHT_MAX, Arithmetic, MatcherConfig, OnePass
from golden.matcher.smooth import smooth
from hdl.matcher.sequential.smooth import LookUpTable, Smooth


CONFIGS = [
    MatcherConfig(labels=2, method=OnePass(Arithmetic.THESIS)),
    MatcherConfig(labels=13, method=OnePass(Arithmetic.THESIS)),
    MatcherConfig(labels=2, method=OnePass(Arithmetic.LINEAR, 0)),
    MatcherConfig(labels=7, method=OnePass(Arithmetic.LINEAR, 3)),
    MatcherConfig(labels=5, method=OnePass(Arithmetic.LINEAR, 4)),
]


def simulate(dut, testbench):
    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_testbench(testbench)
    sim.run()


async def fill(ctx, dut, weight, clocks):
    """Fill and count: ``filled`` must be set again after exactly ``clocks`` cycles, whatever the inputs do meanwhile."""
    ctx.set(dut.weight, weight)
    ctx.set(dut.fill, 1)
    await ctx.tick()
    ctx.set(dut.fill, 0)
    for _ in range(clocks):
        assert not ctx.get(dut.filled)
        await ctx.tick()
    assert ctx.get(dut.filled)


@pytest.mark.parametrize("labels", [2, 3, 13, 16])
def test_table_is_filled_and_filled_again(labels):
    dut = LookUpTable(MatcherConfig(labels=labels, method=OnePass(Arithmetic.THESIS)))
    assert dut.fill_clocks == 2 * labels
    distance = np.abs(np.subtract.outer(range(labels), range(labels)))

    async def testbench(ctx):
        for weight in (15, WEIGHT_MAX, 0, 1, 1):
            await fill(ctx, dut, weight, dut.fill_clocks)
            ctx.set(dut.weight, 42)  # sampled with `fill` only
            for label in range(labels):
                ctx.set(dut.label, label)
                ctx.set(dut.read, 1)
                await ctx.tick().repeat(LookUpTable.LATENCY)
                assert list(ctx.get(dut.row)) == (weight * distance[label]).tolist()
            # Without `read` the row is held.
            ctx.set(dut.read, 0)
            ctx.set(dut.label, 0)
            await ctx.tick().repeat(3)
            assert list(ctx.get(dut.row)) == (weight * distance[-1]).tolist()

    simulate(dut, testbench)


def test_table_filled_while_filling():
    """A second ``fill`` starts over with its own weight."""
    dut = LookUpTable(MatcherConfig(labels=4, method=OnePass(Arithmetic.THESIS)))

    async def testbench(ctx):
        for cut in range(1, dut.fill_clocks):
            ctx.set(dut.weight, 63)
            ctx.set(dut.fill, 1)
            await ctx.tick()
            ctx.set(dut.fill, 0)
            await ctx.tick().repeat(cut)
            await fill(ctx, dut, 5, dut.fill_clocks)
            for label in range(4):
                ctx.set(dut.label, label)
                ctx.set(dut.read, 1)
                await ctx.tick()
                assert list(ctx.get(dut.row)) == [5 * abs(d - label) for d in range(4)]
            ctx.set(dut.read, 0)

    simulate(dut, testbench)


def test_table_of_linear_is_fixed():
    dut = LookUpTable(MatcherConfig(labels=6, method=OnePass(Arithmetic.LINEAR)))
    assert dut.fill_clocks == 0

    async def testbench(ctx):
        await fill(ctx, dut, 63, 0)
        ctx.set(dut.read, 1)
        for label in range(6):
            ctx.set(dut.label, label)
            await ctx.tick().repeat(LookUpTable.LATENCY)
            assert list(ctx.get(dut.row)) == [abs(d - label) for d in range(6)]

    simulate(dut, testbench)


@pytest.mark.parametrize("config", CONFIGS, ids=str)
def test_matches_golden(config):
    dut = Smooth(config)
    labels = config.labels
    rng = np.random.default_rng(1)
    weights = (15, 1, 0, WEIGHT_MAX)
    # Equal pixels, the greatest difference both ways, and one grey level off each of them.
    pixels = [(0, 0), (255, 255), (255, 0), (0, 255), (1, 0), (0, 254), *rng.integers(0, 256, (10, 2)).tolist()]
    seen = []

    async def testbench(ctx):
        for weight in weights:
            await fill(ctx, dut, weight, dut.table.fill_clocks)
            cases = [(0, *pixels[0], 1), (labels - 1, *pixels[1], 1), (labels - 1, *pixels[2], 1), (labels - 1, *pixels[0], 0)]
            cases += [(int(rng.integers(labels)), *pair, int(rng.random() < 0.8)) for pair in pixels]
            for label, pixel, neighbour, present in cases:
                # The grey levels stand for one cycle, PIXEL_LATENCY before the energy; the label for one, LATENCY before it.
                for before in range(max(dut.PIXEL_LATENCY, dut.LATENCY), 0, -1):
                    at_pixel, at_label = before == dut.PIXEL_LATENCY, before == dut.LATENCY
                    ctx.set(dut.pixel, pixel if at_pixel else int(rng.integers(256)))
                    ctx.set(dut.neighbour, neighbour if at_pixel else int(rng.integers(256)))
                    ctx.set(dut.present, present if at_pixel else int(rng.integers(2)))
                    ctx.set(dut.label, label if at_label else int(rng.integers(labels)))
                    ctx.set(dut.read, at_label)
                    await ctx.tick()
                expected = present * smooth(np.abs(np.arange(labels) - label), abs(pixel - neighbour), weight, config)
                energy = list(ctx.get(dut.energy))
                assert energy == expected.tolist(), (weight, label, pixel, neighbour, present)
                seen.append(max(energy))

    simulate(dut, testbench)
    assert max(seen) == config.smooth_max  # the widest product occurred


def test_row_stands_while_pixels_change():
    """Without ``read`` the row stays: the energy follows the grey levels."""
    config = CONFIGS[3]
    dut = Smooth(config)

    async def testbench(ctx):
        ctx.set(dut.weight, 10)
        ctx.set(dut.present, 1)
        ctx.set(dut.label, 4)
        ctx.set(dut.read, 1)
        await ctx.tick()
        ctx.set(dut.read, 0)
        ctx.set(dut.label, 0)
        for pixel, neighbour in itertools.product((0, 128, 255), repeat=2):
            ctx.set(dut.pixel, pixel)
            ctx.set(dut.neighbour, neighbour)
            await ctx.tick().repeat(dut.PIXEL_LATENCY)
            assert list(ctx.get(dut.energy)) == smooth(np.abs(np.arange(7) - 4), abs(pixel - neighbour), 10, config).tolist()

    simulate(dut, testbench)
