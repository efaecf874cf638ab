"""golden.matcher.recursive: each step against its plain version, and on numbers worked by hand."""

import numpy as np
import pytest

from golden.config import GradedArms, LineBelow, MatcherConfig, Propagation, Recursive, RecursiveCost, changed
from golden.matcher.census import census, census_plain
from golden.matcher.recursive.arms import graded_arms, graded_arms_plain, reciprocals, support_means, support_means_plain
from golden.matcher.recursive.border_fill import border_fill, border_fill_plain, border_slope
from golden.matcher.recursive.line_below import line_below, line_below_plain
from golden.matcher.recursive.neighbours import from_above, from_above_plain, from_below, from_below_plain
from golden.matcher.recursive.spread import gates, spread, spread_plain
from golden.matcher.recursive.weighted_median import votes, weighted_median, weighted_median_plain
from golden.matcher.support import fuse, fused_cost
from golden.pictures.scenes import scene


RNG = np.random.default_rng


def smooth_grey(height, width, seed):
    """Grey levels that change by a few levels from pixel to pixel, with a jump here and there."""
    rng = RNG(seed)
    steps = rng.integers(-3, 4, (height, width)) + 40 * (rng.random((height, width)) < 0.05)
    return np.clip(100 + np.cumsum(steps, axis=1), 0, 255).astype(np.uint8)


def test_cost_is_capped():
    cost = RecursiveCost()
    # (2 * 174 + 55 * 34) >> 7 = 17.
    assert fuse(np.array([0, 3, 174, 2550]), np.array([0, 9, 20, 34]), cost).tolist() == [0, 3, 11, 15]
    assert (cost.inside_max, cost.maximum, RecursiveCost(cost_limit=5).maximum) == (17, 15, 5)


def test_outside_has_its_own_cost():
    flat = np.full((2, 4), 9, np.uint8)
    assert fused_cost(flat, flat, MatcherConfig(3, method=Recursive()))[0].tolist() == [[0, 5, 5], [0, 0, 5], [0, 0, 0], [0, 0, 0]]


@pytest.mark.parametrize("threshold, bits", [(0, "11111111"), (1, "11111110"), (2, "11111100"), (7, "10000000")])
def test_census_threshold(threshold, bits):
    """A neighbour has a bit if it is darker by more than the threshold."""
    picture = np.array([[9, 8, 7], [6, 10, 5], [4, 3, 2]], dtype=np.uint8)
    cost = RecursiveCost(census_rows=3, census_columns=3, census_threshold=threshold)
    assert f"{int(census(picture, cost)[1, 1]):08b}" == bits
    noise = RNG(1).integers(0, 12, (9, 13))
    np.testing.assert_array_equal(census(noise, cost), census_plain(noise, cost))


@pytest.mark.parametrize("parameters", [LineBelow(), LineBelow(1, 7, 0), LineBelow(7, 0, 255)])
def test_line_below(parameters):
    cost = RNG(1).integers(0, 16, (6, 9, 4), dtype=np.uint8)
    left = RNG(2).integers(0, 60, (6, 9))
    fast = line_below(cost, left, parameters)
    np.testing.assert_array_equal(fast, line_below_plain(cost, left, parameters))
    assert fast.dtype == np.int16
    assert (line_below(cost, np.zeros((6, 9)), parameters)[-1] == (parameters.own_share + parameters.lower_share) * cost[-1]).all()


@pytest.mark.parametrize("line, left_arm, right_arm", [
    ([10, 17, 17, 17], [0, 0, 1, 2], [0, 2, 1, 0]),                    # a step of 7 is too much, a difference of 7 is not
    ([10, 14, 17, 18], [0, 1, 2, 2], [2, 2, 1, 0]),
    ([10, 10, 10, 10, 10, 15, 15], [0, 1, 2, 3, 4, 4, 4], [4, 4, 4, 3, 2, 1, 0]),  # from the fifth step on 4
    ([10, 10, 10, 10, 10, 14, 14], [0, 1, 2, 3, 4, 5, 6], [6, 5, 4, 3, 2, 1, 0]),
])
def test_graded_arms(line, left_arm, right_arm):
    arms = graded_arms(np.array([line]))
    assert [arm.ravel().tolist() for arm in arms] == [left_arm, right_arm]


@pytest.mark.parametrize("limits", [
    GradedArms(), GradedArms(reach=3), GradedArms(2, 9, 255, 3, 31), GradedArms(reach=0), GradedArms(far_step=1)])
@pytest.mark.parametrize("width", [1, 2, 90])
def test_graded_arms_equal_plain(limits, width):
    left = smooth_grey(5, width, 3)
    fast = graded_arms(left, limits)
    for arm, plain in zip(fast, graded_arms_plain(left, limits)):
        np.testing.assert_array_equal(arm, plain)
    assert width < 90 or max(arm.max() for arm in fast) == limits.reach


def test_means():
    """Twice a floor, and never above the greatest cost."""
    assert reciprocals([1, 3, 33]).tolist() == [1024, 341, 31]
    left = smooth_grey(1, 60, 1)[0]
    left_arm, right_arm = (arm[0] for arm in graded_arms(left[None]))
    cost = RNG(2).integers(0, 272, (60, 5))
    fast = support_means(cost, left_arm, right_arm)
    np.testing.assert_array_equal(fast, support_means_plain(cost, left_arm, right_arm))
    assert support_means(np.full((60, 1), 271), left_arm, right_arm).max() == 271
    assert support_means(np.full((3, 1), 9), np.array([0, 1, 2]), np.array([2, 1, 0])).ravel().tolist() == [8, 8, 8]  # 27 * 341 >> 10


@pytest.mark.parametrize("parameters", [Propagation(), Propagation(1, 3), Propagation(127, 9)])
@pytest.mark.parametrize("labels", [2, 3, 17])
def test_spread(parameters, labels):
    cost = RNG(labels).integers(0, 281, (40, labels))
    fast = spread(cost, parameters)
    np.testing.assert_array_equal(fast, [spread_plain(line, parameters) for line in cost.tolist()])
    assert fast.min() == 0 and fast.max() <= parameters.spread_jump
    assert fast.dtype == cost.dtype


def test_gates():
    assert gates([0, 0, 0, 0, 0], [0, 1, 9, 27, 255]).tolist() == [78, 62, 24, 10, 10]
    assert gates(27, 0) == gates(0, 27)
    assert max(Propagation(gate_numerator=4000).gate) == Propagation().spread_jump  # no more is ever carried


@pytest.mark.parametrize("fan", [3, 8, 31])
def test_from_above(fan):
    method = changed(Recursive(), fan=fan)
    rng = RNG(fan)
    carried, line, above = rng.integers(0, 79, (20, 6)), rng.integers(0, 40, 20), rng.integers(0, 40, 20)
    np.testing.assert_array_equal(from_above(carried, line, above, method), from_above_plain(carried, line, above, method))
    assert from_above(np.full((20, 1), 78), line, line * 0 + 200, method).max() == 10  # behind the gate: 40 >> 2


def test_from_below():
    rng = RNG(4)
    cost, line, below = rng.integers(0, 136, (30, 5)), rng.integers(90, 110, 30), smooth_grey(1, 30, 2)[0].astype(int)
    arms = [arm[0] for arm in graded_arms(below[None])]
    np.testing.assert_array_equal(from_below(cost, *arms, line, below), from_below_plain(cost, *arms, line, below))


def test_border_slope():
    labels = np.array([0, 0, 30, 30, 29, 29, 28, 28, 27, 27, 26, 26, 25, 25, 24, 24, 23, 23, 22, 22, 9])
    passed = np.arange(21) >= 2
    assert border_slope(labels, passed) == (2, 8 * (1024 // 17))     # from x0 = 2 to x1 = 19, where the labels jump
    assert border_fill(labels[None], passed[None], 64)[0, :3].tolist() == [31, 30, 30]
    passed[18:] = False
    assert border_slope(labels, passed) == (2, 0)                    # 15 columns are too few
    assert border_slope(labels * 8, np.arange(21) >= 2, 8) == (2, 64 * (1024 // 17))


def test_border_slope_is_measured_over_32_columns():
    labels = np.arange(60, 0, -1)
    assert border_slope(labels, np.arange(60) >= 5) == (5, 32 * 32)
    few = np.isin(np.arange(60), [5, 6, 38])                         # 38 is the 33rd; it is too far
    assert border_slope(np.full(60, 7), few) == (5, 0)
    gap = np.isin(np.arange(60), [5, 6, 37])
    assert border_slope(np.where(np.arange(60) < 37, 7, 6), gap) == (5, 32)


@pytest.mark.parametrize("scale", [1, 8])
def test_border_fill_equals_plain(scale):
    rng = RNG(scale)
    for seed in range(20):
        ramp = np.clip(np.cumsum(rng.integers(-1, 2, (4, 70)) * (rng.random((4, 70)) < 0.4), axis=1) + 20, 0, 39)
        labels = scale * ramp + (rng.integers(-3, 4, ramp.shape) if scale > 1 else 0)
        labels = np.clip(labels, 0, 39 * scale)
        passed = (rng.random((4, 70)) < 0.7) & (np.arange(70) >= rng.integers(0, 45, (4, 1)))
        passed[3] &= seed % 2 == 0                                   # a line without any
        np.testing.assert_array_equal(border_fill(labels, passed, 40, scale), border_fill_plain(labels, passed, 40, scale))


@pytest.mark.parametrize("rule", [border_fill, border_fill_plain])
def test_border_fill_is_clipped(rule):
    labels = np.repeat(np.arange(40, 20, -1), 2)[None]
    passed = np.arange(40)[None] >= 20
    assert rule(labels, passed, 33)[0, :20].max() == 32
    falling = np.repeat(np.arange(20), 2)[None]
    assert rule(falling + 1, passed, 64)[0, :1].tolist() == [2]
    assert rule(falling - 8, passed, 64)[0, :3].tolist() == [0, 0, 0]


def test_votes():
    assert votes(np.array([0, 16, 17, 32, 33, 64, 65, 255]), np.zeros(8, bool)).tolist() == [4, 4, 2, 2, 1, 1, 0, 0]
    assert votes(np.array([0, 17, 33, 65]), np.ones(4, bool)).tolist() == [8, 4, 2, 0]


@pytest.mark.parametrize("labels, height, width", [(2, 1, 1), (9, 4, 5), (200, 9, 12), (2048, 5, 7)])
def test_weighted_median_equals_plain(labels, height, width):
    rng = RNG(labels)
    picture, left = rng.integers(0, labels, (height, width)), rng.integers(0, 120, (height, width))
    passed = rng.random((height, width)) < 0.5
    np.testing.assert_array_equal(weighted_median(picture, passed, left), weighted_median_plain(picture, passed, left))


def test_weighted_median_keeps_to_its_surface():
    """Two surfaces of different grey: the median does not cross the edge between them, whatever the majority is."""
    left = np.zeros((9, 9), dtype=np.uint8)
    left[:, 6:] = 200
    labels = np.where(left > 0, 3, 8)
    np.testing.assert_array_equal(weighted_median(labels, np.ones((9, 9), bool), left), labels)


@pytest.mark.parametrize("below", [False, True])
def test_fast_equals_plain_together(below):
    """The whole recursion, composed of the plain steps."""
    from golden.matcher.recursive.method import recursion
    method = changed(Recursive(), from_below=below, reach=5, fan=3)
    config = MatcherConfig(6, method=method)
    left, right, _ = scene(19, 6, 6, seed=3)
    own = line_below_plain(fused_cost(left, right, config), left, method.line_below)
    left_arm, right_arm = graded_arms_plain(left, method.arms)
    previous, expected = None, []
    for y in range(6):
        joined = own[y].astype(int)
        above = np.zeros_like(joined)
        if y:
            carried = np.array([spread_plain(costs, method.propagation) for costs in previous.tolist()])
            above = from_above_plain(carried, left[y], left[y - 1], method)
        joined += 10 * above >> 3
        if below and y < 5:
            joined += 4 * from_below_plain(own[y + 1].astype(int), left_arm[y + 1], right_arm[y + 1], left[y], left[y + 1], method) >> 3
        previous = support_means_plain(joined, left_arm[y], right_arm[y]) + (above >> 3)
        expected.append(previous)
    np.testing.assert_array_equal(recursion(own, left, method), expected)
