"""Vertical support of a group of labels; in the matcher it is tested with the others."""

import numpy as np
import pytest

from golden.config import FUSED_1, Fused, MatcherConfig, changed
from golden.matcher.vertical import alike, vertical_support
from hdl.matcher.streaming.vertical import VerticalSupport
from sim.kit.clocked import run_clocked


def config_of(max_width, labels):
    return MatcherConfig(labels, max_width,
                         method=changed(FUSED_1, vertical_lines=1, vertical_threshold=25, truncation=80, census_weight=20))


@pytest.mark.parametrize("pause", [0.0, 0.5])
@pytest.mark.parametrize("max_width, labels, sizes", [
    (1, 1, [(1, 1), (1, 5)]), (9, 4, [(9, 4), (3, 1), (1, 3), (8, 6)]), (16, 3, [(16, 5), (15, 5)]),
])
def test_matches_golden(max_width, labels, sizes, pause):
    """Frames in a row: with the costs of a line those of the line above are joined; padding follows the last line."""
    config = config_of(max_width, max(labels, 2))
    dut = VerticalSupport(config, range(labels))
    rng = np.random.default_rng(1)
    greatest = config.method_as(Fused).cost.maximum
    assert greatest == 62

    inputs, expected = [], []
    for width, height in sizes:
        cost = rng.choice([0, 1, 31, greatest], (height, width, labels)).astype(np.uint8)
        left = rng.choice([0, 25, 51], (height, width))
        above, below = alike(left, config.method.vertical)
        joined = vertical_support(cost, left, config.method.vertical)
        for y in range(height + 1):
            inputs += [{"i": {"write": 0}, "cost": rng.integers(0, greatest + 1, labels).tolist()}]  # before the line
            for x in range(width):
                while rng.random() < pause:
                    inputs.append({"i": {"write": 0, "column": x}, "cost": rng.integers(0, greatest + 1, labels).tolist()})
                if y:
                    expected.append((len(inputs), joined[y - 1, x].tolist()))
                neighbours = {"above": int(above[y - 1, x]), "below": int(below[y - 1, x])} if y else {"above": 1, "below": 1}
                inputs.append({"i": {"write": 1, "column": x, **neighbours},
                               "cost": cost[y, x].tolist() if y < height else [greatest] * labels})
            inputs += [{"i": {"write": 0}, "cost": [greatest] * labels}]
    out = run_clocked(dut, inputs, ["joined", "o"], drain=dut.LATENCY)
    assert [list(out[cycle + dut.LATENCY]["joined"]) for cycle, _ in expected] == [word for _, word in expected]
    for cycle, word in enumerate(inputs):  # the group above has the wave a cycle later
        assert {name: out[cycle + 1]["o"][name] for name in word["i"]} == word["i"]
