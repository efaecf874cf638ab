"""hdl.matcher.recursive.support: arms with graded limits, against the golden model."""

import numpy as np
import pytest

from golden.config import RECURSIVE_1, GradedArms, MatcherConfig, changed
from golden.matcher.recursive.arms import graded_arms
from hdl.matcher.recursive.support import ArmSource
from sim.kit.clocked import run_clocked


def lines(rng):
    """Lines of grey levels near each other, of several widths; one of equal pixels, for the longest arms."""
    for width in (1, 1, 2, 3, 40, 5, 33, 17):
        yield np.clip(100 + np.cumsum(rng.integers(-4, 5, width) * (rng.random(width) < 0.6)), 0, 255).astype(np.uint8)
    yield np.full(66, 100, dtype=np.uint8)


@pytest.mark.parametrize("stall", [0.0, 0.4])
@pytest.mark.parametrize("limits", [
    GradedArms(), GradedArms(near_threshold=255, far_threshold=255, step_threshold=255, reach=31), GradedArms(reach=0),
    GradedArms(reach=1), GradedArms(3, 9, 2, 3, 6), GradedArms(far_step=1, step_threshold=0),
], ids=lambda limits: "-".join(map(str, (limits.near_threshold, limits.far_threshold, limits.step_threshold, limits.reach))))
def test_arms(limits, stall):
    rng = np.random.default_rng(2)
    given, expected = [], []
    for line in lines(rng):
        left_arm, right_arm = graded_arms(line[None], limits)
        expected += zip(left_arm[0].tolist(), right_arm[0].tolist())
        given += [{"step": 1, "starts_line": int(x == 0), "grey": int(grey)} for x, grey in enumerate(line)]
    given += [{"step": 1, "starts_line": 1, "grey": 100}] * (limits.reach + 1)  # padding
    inputs = []
    for word in given:
        while rng.random() < stall:
            inputs.append({"step": 0, "starts_line": int(rng.integers(2)), "grey": int(rng.integers(256))})
        inputs.append(word)
    inputs[0] |= {"near": limits.near_threshold, "far": limits.far_threshold, "smooth": limits.step_threshold}
    dut = ArmSource(MatcherConfig(labels=2, method=changed(RECURSIVE_1, arms=limits)))
    out = run_clocked(dut, inputs, ["left_arm", "right_arm"], drain=dut.LATENCY, idle={"step": 0})
    at = [cycle + dut.LATENCY for cycle, word in enumerate(inputs) if word["step"]][limits.reach + 1:]
    assert [(out[cycle]["left_arm"], out[cycle]["right_arm"]) for cycle in at] == expected
    lengths = {length for pair in expected for length in pair}
    assert {0, limits.reach} <= lengths
