import numpy as np
import pytest
from amaranth import *
from amaranth.sim import Simulator

from golden.config import FUSED_1, MatcherConfig, changed
from golden.matcher.support import arms
from hdl.matcher.streaming.support import Arms, StepDelay, SupportSource
from sim.kit.clocked import run_clocked


def config_of(reach, threshold=10):
    return MatcherConfig(labels=2, method=changed(FUSED_1, reach=reach, arm_threshold=threshold))


def lines(rng, threshold):
    """Lines of few grey levels, some just like enough, some just unlike; of every width up to 70."""
    near = [100, 100 + threshold, 101 + threshold, 100 - threshold, 99 - threshold, 0, 255]
    for width in (1, 1, 2, 3, 40, 5, 70, 1, 33, 16, 17):
        line = rng.choice(np.clip(near, 0, 255), (1, width), p=[0.58, 0.2, 0.02, 0.15, 0.01, 0.02, 0.02])
        yield line.astype(np.uint8)
    yield np.full((1, 66), 100, dtype=np.uint8)  # arms as long as they may be


@pytest.mark.parametrize("stall", [0.0, 0.5])
@pytest.mark.parametrize("steps", [1, 2, 17])
def test_step_delay(steps, stall):
    rng = np.random.default_rng(1)
    inputs = [{"i": int(rng.integers(1, 256)), "step": int(rng.random() >= stall)} for _ in range(200)]
    out = run_clocked(StepDelay(8, steps), inputs, ["o"], drain=2, idle={"step": 0})
    words = [word["i"] for word in inputs if word["step"]]
    at = [cycle for cycle, word in enumerate(inputs) if word["step"]]
    assert [out[cycle + StepDelay.LATENCY]["o"] for cycle in at] == ([0] * steps + words)[:len(words)]


def test_step_delay_after_reset():
    """Words from before a reset are not output after it."""
    reset = Signal()
    delay = StepDelay(8, 3)

    async def testbench(ctx):
        ctx.set(delay.i, 0xFF)
        ctx.set(delay.step, 1)
        await ctx.tick().repeat(8)
        assert ctx.get(delay.o) == 0xFF
        ctx.set(reset, 1)
        await ctx.tick()
        ctx.set(reset, 0)
        words = []
        for word in range(1, 9):
            ctx.set(delay.i, word)
            await ctx.tick()
            words.append(ctx.get(delay.o))
        assert words[StepDelay.LATENCY - 1:] == [0, 0, 0, 1, 2, 3, 4]

    simulator = Simulator(ResetInserter(reset)(delay))
    simulator.add_clock(1e-6)
    simulator.add_testbench(testbench)
    simulator.run()


@pytest.mark.parametrize("stall", [0.0, 0.4])
@pytest.mark.parametrize("reach, threshold", [(0, 10), (1, 10), (2, 0), (3, 255), (16, 10), (31, 20)])
def test_arms(reach, threshold, stall):
    rng = np.random.default_rng(2)
    given, expected = [], []
    for line in lines(rng, threshold):
        left_arm, right_arm = arms(line, config_of(reach, threshold).method.arms)
        expected += zip(left_arm[0].tolist(), right_arm[0].tolist())
        given += [{"step": 1, "starts_line": int(x == 0), "grey": int(grey)} for x, grey in enumerate(line[0])]
    given += [{"step": 1, "starts_line": 1, "grey": 100}] * (reach + 1)  # padding
    inputs = []
    for word in given:
        while rng.random() < stall:
            inputs.append({"step": 0, "starts_line": int(rng.integers(2)), "grey": int(rng.integers(256))})
        inputs.append(word)
    dut = Arms(config_of(reach, threshold))
    out = run_clocked(dut, inputs, ["left_arm", "right_arm"], drain=dut.LATENCY, idle={"step": 0})
    at = [cycle + dut.LATENCY for cycle, word in enumerate(inputs) if word["step"]][reach + 1:]
    assert [(out[cycle]["left_arm"], out[cycle]["right_arm"]) for cycle in at] == expected
    lengths = {length for pair in expected for length in pair}
    assert {0, reach} <= lengths


@pytest.mark.parametrize("stall", [0.0, 0.4])
@pytest.mark.parametrize("reach", [0, 3, 16, 31])
def test_support_source(reach, stall):
    """The addresses, applied to a ring as the groups keep one, here of grey levels, give the sum over each support."""
    config = config_of(reach)
    rng = np.random.default_rng(3)
    nothing = {"clear": 0, "complete": 0, "starts_line": 0, "in_picture": 0}
    inputs, expected, number = [], [], 0

    def put(completion, **pixel):
        while rng.random() < stall:
            inputs.append({"completion": {**nothing, "starts_line": int(rng.integers(2))}, "pixel_valid": 0})
        inputs.append({"completion": {**nothing, **completion}, "pixel_valid": 0, **pixel})

    for line in lines(rng, 10):
        left_arm, right_arm = arms(line, config.method.arms)
        put({"clear": 1})
        in_picture = int(rng.integers(2))
        for x, grey in enumerate(line[0].tolist()):
            put({"complete": 1, "starts_line": int(x == 0), "in_picture": in_picture},
                pixel={"lower": grey, "pixel": number % 256}, pixel_valid=int(x != 1))
            first, beyond = x - int(left_arm[0, x]), x + int(right_arm[0, x]) + 1
            expected.append({"pixel": number % 256, "pixel_valid": int(x != 1), "in_picture": in_picture,
                             "support_size": beyond - first, "sum": sum(line[0, first:beyond].tolist())})
            number += 1
    for _ in range(reach + 1):
        put({"complete": 1, "starts_line": 1})

    latency = 7
    dut = SupportSource(config, latency)
    out = run_clocked(dut, inputs, ["sums", "ends", "slot"], drain=latency + 2, idle={"completion": nothing, "pixel_valid": 0})
    ring, total, got = [0] * dut.ring_of(config), 0, []
    for cycle, word in enumerate(out):
        # The ends are due a cycle after the sums: the ring is read before it is written again.
        slot = word["slot"]
        if slot.pixel_valid or slot.in_picture:
            ends = word["ends"]
            got.append({"pixel": slot.pixel.pixel, "pixel_valid": slot.pixel_valid, "in_picture": slot.in_picture,
                        "support_size": slot.support_size, "sum": ring[ends.high] - ring[ends.low]})
        completion = word["sums"].completion
        if completion.clear or completion.complete:
            ring[word["sums"].place] = total
            grey = inputs[cycle - latency].get("pixel", {}).get("lower", 0)
            total = 0 if completion.clear else total + grey
    assert got == [word for word in expected if word["pixel_valid"] or word["in_picture"]]
