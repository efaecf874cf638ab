import numpy as np
import pytest
from amaranth.sim import Simulator

from golden.config import FUSED_1, MatcherConfig, changed
from golden.matcher.confidence import CONFIDENCE_MAX, confidence
from hdl.matcher.refine.confidence import Confidence


def config_of(disparities, sub_pixel):
    return MatcherConfig(labels=disparities, method=changed(FUSED_1, sub_pixel=sub_pixel))


@pytest.mark.parametrize("gaps", [0.0, 0.3])
@pytest.mark.parametrize("disparities, sub_pixel", [(2, False), (80, False), (127, False), (128, False), (5, True), (128, True)])
def test_matches_golden(disparities, sub_pixel, gaps):
    """Lines of any disparities, near the labels and far from them: the least and the greatest differences occur."""
    config = config_of(disparities, sub_pixel)
    scale, greatest = config.method.disparity_scale, disparities * config.method.disparity_scale - 1
    rng = np.random.default_rng(1)
    height, width = 6, 30
    near = rng.integers(0, greatest + 1, (height, 1)) + rng.integers(-scale - 1, scale + 2, (height, width))
    filled = np.where(rng.random(near.shape) < 0.6, near, rng.choice([0, scale, greatest - scale, greatest], near.shape))
    filled = np.clip(filled, 0, greatest)
    filled[:, :8] = rng.integers(0, greatest + 1)
    passed = rng.random(filled.shape) < 0.8
    passed[:, :8] = True
    n = rng.integers(1, 34, filled.shape)
    n[0] = 33
    disparity = np.where(rng.random(filled.shape) < 0.7, filled, rng.choice([0, greatest, *range(greatest + 1)], filled.shape))
    expected = confidence(disparity, filled, passed, n, scale)
    assert expected.max() == CONFIDENCE_MAX

    dut = Confidence(config)
    labels, votes = (np.pad(part, ((2, 2), (0, 2)), mode="edge").astype(int) for part in (filled, passed))
    sizes = np.pad(n, ((0, 0), (0, 2)), mode="edge")
    given, centers, due = [], [], {}

    async def testbench(ctx):
        cycle = 0

        async def step():
            nonlocal cycle
            await ctx.tick()
            cycle += 1
            if cycle in due:
                given.append(ctx.get(dut.o))

        for y in range(height):
            for x in range(width + 2):
                while rng.random() < gaps:
                    ctx.set(dut.advance, 0)
                    ctx.set(dut.opens, int(rng.integers(2)))
                    await step()
                ctx.set(dut.advance, 1)
                ctx.set(dut.opens, int(x == 0))
                ctx.set(dut.i, {"label": labels[y:y + 5, x].tolist(), "passed": sum(votes[y + line, x] << line for line in range(5)),
                                "size": int(sizes[y, x]).bit_length()})
                if x >= 2:
                    ctx.set(dut.disparity, int(disparity[y, x - 2]))
                    centers.append((ctx.get(dut.center), ctx.get(dut.center_passed)))
                    due[cycle + dut.latency] = True
                await step()
        for _ in range(dut.latency):
            await step()

    sim = Simulator(dut)
    sim.add_clock(1e-6)
    sim.add_testbench(testbench)
    sim.run()
    assert centers == list(zip(filled.ravel().tolist(), passed.ravel().astype(int).tolist()))
    assert given == expected.ravel().tolist()
