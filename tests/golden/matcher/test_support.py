"""golden.matcher.support: the fused cost, arms and sums on numbers worked by hand, and fast against plain."""

import numpy as np
import pytest

from golden.config import FUSED_1, Arms, FusedCost, MatcherConfig, changed
from golden.matcher.census import census_plain
from golden.matcher.cost import aligned, matching_cost
from golden.matcher.support import arms, arms_plain, fuse, fused_cost, support_sizes, support_sums, support_sums_plain
from golden.pictures.scenes import scene


def config(disparities, minimum=0, **parameters):
    return MatcherConfig(labels=disparities, minimum=minimum, method=changed(FUSED_1, **parameters))


@pytest.mark.parametrize("cost, distance, expected", [
    (0, 0, 0), (4, 0, 1), (3, 0, 0),           # 16 >> 4; 12 >> 4 is floored
    (0, 1, 2), (1, 1, 3), (0, 34, 99),         # 47 >> 4; 51 >> 4; 1598 >> 4
    (155, 0, 38), (156, 0, 39), (157, 0, 39),  # 620 >> 4; 624 >> 4; truncated
    (156, 34, 138), (2550, 34, 138),           # 2222 >> 4: the largest
])
def test_fuse(cost, distance, expected):
    assert fuse(np.int16(cost), np.uint8(distance)) == expected
    assert FUSED_1.cost.maximum == 138


def test_fuse_holds_the_largest_that_parameters_allow():
    # (15 * 1023 + 127 * 34) >> 7 = 153 and 15 * 1023 + 127 * 62 = 23219 leave int16 whole; the limit of 255 does the same for all others.
    parameters = FusedCost(truncation=1023, cost_factor=15, census_weight=127, cost_shift=7)
    assert fuse(np.int16(2550), np.uint8(34), parameters) == parameters.maximum == 153
    parameters = FusedCost(truncation=1023, cost_factor=15, census_weight=127, cost_shift=7, census_rows=7, census_columns=9)
    assert fuse(np.int16(2550), np.uint8(62), parameters) == parameters.maximum == 181


def test_outside_has_its_own_cost():
    # No texture: inside everything is 0.
    flat = np.full((2, 4), 9, np.uint8)
    assert fused_cost(flat, flat, config(3))[0].tolist() == [[0, 30, 30], [0, 0, 30], [0, 0, 0], [0, 0, 0]]
    assert fused_cost(flat, flat, config(3, cost_outside=7, minimum=1))[0].tolist() == [[7, 7, 7], [0, 7, 7], [0, 0, 7], [0, 0, 0]]


@pytest.mark.parametrize("minimum", [0, 3, -1, -3, -6, -64])
@pytest.mark.parametrize("width, height, disparities", [(1, 1, 2), (5, 3, 13), (23, 6, 6)])
def test_fused_cost_equals_plain(minimum, width, height, disparities):
    left, right, _ = scene(width, height, disparities, seed=2)
    this = config(disparities, minimum)
    cost = matching_cost(left, right, this)
    lead = max(-minimum, 0)
    left_bits, right_bits = (census_plain(side).tolist() for side in aligned(left, right, minimum))
    expected = [[[
        30 if d + minimum > x else
        (4 * min(int(cost[y, x, d]), 156) + 47 * (left_bits[y][x + lead] ^ right_bits[y][x + lead - d]).bit_count()) // 16
        for d in range(disparities)] for x in range(width)] for y in range(height)]
    fast = fused_cost(left, right, this)
    assert fast.dtype == np.uint8
    np.testing.assert_array_equal(fast, expected)


def test_minimum_is_a_later_part_of_the_same_costs():
    left, right, _ = scene(60, 5, 20, seed=4)
    whole, part = fused_cost(left, right, config(20)), fused_cost(left, right, config(8, minimum=12))
    # The delayed picture ends earlier than the picture: a window of seven columns sees that from the third last column on.
    np.testing.assert_array_equal(part[:, :-3], whole[:, :-3, 12:])
    assert (part[:, -3:] != whole[:, -3:, 12:]).any()


@pytest.mark.parametrize("line, left_arm, right_arm", [
    ([0, 10, 20, 31], [0, 1, 1, 0], [1, 1, 0, 0]),       # differences of 10 are alike, 11 are not; against the centre, not step by step
    ([50, 50, 90, 50, 50], [0, 1, 0, 0, 1], [1, 0, 0, 1, 0]),  # nothing behind another object is reached
    ([255, 250, 245, 244], [0, 1, 2, 2], [2, 2, 1, 0]),
])
def test_arms(line, left_arm, right_arm):
    for rows in (1, 3):
        result = arms(np.array([line] * rows, np.uint8))
        assert [arm.tolist() for arm in result] == [[left_arm] * rows, [right_arm] * rows]


def test_arms_end_at_their_reach():
    left_arm, right_arm = arms(np.zeros((1, 40), np.uint8))
    assert left_arm[0].tolist() == [min(x, 16) for x in range(40)] and right_arm[0].tolist() == left_arm[0, ::-1].tolist()
    assert support_sizes(left_arm, right_arm).max() == 33 == FUSED_1.arms.support_max
    assert not np.any(arms(np.zeros((1, 40), np.uint8), Arms(reach=0)))


@pytest.mark.parametrize("reach, threshold", [(16, 10), (3, 1), (31, 255)])
@pytest.mark.parametrize("width, height", [(1, 1), (2, 3), (50, 4)])
def test_arms_fast_equals_plain(reach, threshold, width, height):
    limits = Arms(reach=reach, arm_threshold=threshold)
    rng = np.random.default_rng(3)
    left = np.cumsum(rng.integers(-4, 5, (height, width)), axis=1).clip(-120, 120).astype(np.int16) + 120
    for fast, plain in zip(arms(left, limits), arms_plain(left, limits)):
        np.testing.assert_array_equal(fast, plain)


def test_sums():
    cost = np.array([[[1, 0], [2, 5], [4, 7], [8, 9]]], np.uint8)
    # Supports: x = 0 alone; 0 .. 2; 1 .. 3; 3 alone.
    sums = support_sums(cost, np.array([[0, 1, 1, 0]]), np.array([[0, 1, 1, 0]]))
    assert sums.tolist() == [[[1, 0], [7, 12], [14, 21], [8, 9]]]


def test_largest_sum():
    cost = np.full((1, 33, 2), 138, np.uint8)
    assert support_sums(cost, *arms(np.zeros((1, 33), np.uint8)))[0, 16].tolist() == [4554, 4554]
    assert FUSED_1.data_max == 4554


def test_sums_fast_equals_plain():
    rng = np.random.default_rng(4)
    cost = rng.integers(0, 256, (5, 70, 4), dtype=np.uint8)
    left_arm, right_arm = arms(rng.integers(0, 12, (5, 70), dtype=np.uint8), Arms(reach=31))
    assert left_arm.max() == 31
    np.testing.assert_array_equal(support_sums(cost, left_arm, right_arm), support_sums_plain(cost, left_arm, right_arm))
