"""golden.matcher.energy on a picture of four pixels worked by hand."""

import numpy as np
import pytest

from golden.config import Arithmetic, MatcherConfig, OnePass
from golden.matcher.cost import local_disparity, matching_cost
from golden.matcher.energy import energy
from golden.matcher.labelling import match
from golden.pictures.scenes import scene


LEFT = np.array([[0, 100], [50, 50]], dtype=np.uint8)
COST = np.arange(12).reshape(2, 2, 3)


# Labels 0 1 over 2 2: costs 0 + 4 + 8 + 11 = 23. Terms (k, dI): left of (1,0) 1, 100; left of (1,1) 0, 0;
# column 0 both ways 2, 50; column 1 both ways 1, 50.
@pytest.mark.parametrize("arithmetic, expected", [
    ("float", 255 * 23 + 15 * 155 + (2 + 1) * (10 + 5) * 205),
    ("thesis", 23 + 9 + (16 + 8) + (8 + 4)),  # 9.1, 16.1, 8.05, 8.05, 4.02: each floored
    ("linear", 8 * 23 + 146 + (2 + 1) * (128 + 64)),
])
def test_four_pixels(arithmetic, expected):
    result = energy(np.array([[0, 1], [2, 2]]), COST, LEFT, MatcherConfig(labels=3, method=OnePass(arithmetic)))
    assert result == expected
    assert isinstance(result, float if arithmetic == "float" else int)


def test_equal_labels_have_no_smoothness():
    assert energy(np.full((2, 2), 1), COST, LEFT, MatcherConfig(labels=3)) == 1 + 4 + 7 + 10


def test_thesis_shifts_by_eight():
    # 15 * 256 * 17 >> 8 = 255; a division by 255 gives 256.
    assert energy(np.array([[0, 17]]), np.zeros((1, 2, 18), int), np.zeros((1, 2), np.uint8), MatcherConfig(labels=18)) == 255


@pytest.mark.parametrize("arithmetic", Arithmetic)
def test_the_rule_lowers_it(arithmetic):
    config = MatcherConfig(labels=13, method=OnePass(arithmetic))
    left, right, _ = scene(37, 11, 13, seed=1)
    cost = matching_cost(left, right, config)
    assert energy(match(left, right, config), cost, left, config) < energy(local_disparity(cost), cost, left, config)
