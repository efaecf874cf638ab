"""golden.matcher.refine: every stage on numbers worked by hand, and fast against plain."""

import numpy as np
import pytest

from golden.config import FUSED_1, MatcherConfig, changed
from golden.matcher.refine import check, check_plain, fill, fill_plain, median, median_plain, right_view, right_view_plain


def config(disparities=4, minimum=0, tolerance=1):
    return MatcherConfig(labels=disparities, minimum=minimum, method=changed(FUSED_1, tolerance=tolerance))


def test_right_view():
    # Costs of four columns by three labels; the right pixel 0 sees (0, 0), (1, 1), (2, 2).
    cost = np.array([[[5, 0, 0], [9, 4, 0], [3, 9, 4], [9, 1, 9]]], np.uint8)
    # 5 4 4: the smaller label of a tie; 9 9 9; 3 1 and no third column; 9 alone
    assert right_view(cost, config(3)).tolist() == [[1, 0, 1, 0]]
    # Label 0 is disparity 1: (1, 0), (2, 1), (3, 2); (2, 0), (3, 1); (3, 0); nothing
    assert right_view(cost, config(3, minimum=1)).tolist() == [[0, 1, 0, 0]]


def test_right_view_knows_no_cost_beyond_the_picture():
    cost = np.full((1, 3, 4), 255, np.uint8)
    assert right_view(cost, config()).tolist() == [[0, 0, 0]]


@pytest.mark.parametrize("minimum", [0, 1, 5, 255, -1, -4, -64])
@pytest.mark.parametrize("width, disparities", [(1, 2), (3, 9), (30, 7)])
def test_right_view_fast_equals_plain(minimum, width, disparities):
    this = config(disparities, minimum)
    cost = np.random.default_rng(1).integers(0, 6, (3, width, disparities), dtype=np.uint8)
    cost[2] += 250
    cost[1] = 255
    np.testing.assert_array_equal(right_view(cost, this), right_view_plain(cost, this))
    wide = 32_766 - (255 - cost.astype(np.uint16)) * 120    # down to 2,166
    np.testing.assert_array_equal(right_view(wide, this), right_view_plain(wide, this))


@pytest.mark.parametrize("label, seen, tolerance, expected", [
    (2, 2, 1, True), (2, 1, 1, True), (2, 3, 1, True), (2, 0, 1, False), (1, 3, 1, False),
    (2, 1, 0, False), (2, 2, 0, True), (0, 3, 3, True), (0, 4, 3, False),
])
def test_check(label, seen, tolerance, expected):
    labels, right = np.zeros((1, 5), int), np.full((1, 5), 9)
    labels[0, 3], right[0, 3 - label] = label, seen
    assert check(labels, right, config(tolerance=tolerance))[0, 3] == expected


def test_check_fails_outside():
    assert check(np.array([[1, 1, 2, 3]]), np.ones((1, 4), int), config(tolerance=7)).tolist() == [[False, True, True, True]]
    assert check(np.array([[0, 0, 1, 0]]), np.zeros((1, 4), int), config(minimum=2)).tolist() == [[False, False, False, True]]


@pytest.mark.parametrize("minimum", [0, 2, -2, -3, -64])
def test_check_fast_equals_plain(minimum):
    rng = np.random.default_rng(2)
    this = config(minimum=minimum)
    labels, right = rng.integers(0, 4, (9, 21)), rng.integers(0, 4, (9, 21 + this.lead))
    fast = check(labels, right, this)
    assert 0.2 < fast.mean() < 0.8
    np.testing.assert_array_equal(fast, check_plain(labels, right, this))


@pytest.mark.parametrize("labels, passed, expected", [
    ([7, 1, 2, 3, 8], "01010", [1, 1, 1, 3, 3]),  # one side only at both ends, the smaller between
    ([0, 5, 0, 0, 6], "01001", [5, 5, 5, 5, 6]),
    ([0, 6, 9, 9, 5], "01001", [6, 6, 5, 5, 5]),  # the farther one may be the smaller
    ([4, 3, 2, 1, 0], "00000", [4, 3, 2, 1, 0]),  # nothing to take: as it was
    ([4, 3, 2, 1, 0], "11111", [4, 3, 2, 1, 0]),
    ([4, 3, 2, 1, 0], "00100", [2, 2, 2, 2, 2]),
    ([0, 3, 0, 2, 9], "01011", [3, 3, 2, 2, 9]),  # the nearest, not the least of all
    ([1, 3, 0, 2, 0], "11010", [1, 3, 2, 2, 2]),
])
def test_fill(labels, passed, expected):
    passed = np.array([[bit == "1" for bit in passed]])
    # A line of its own: the other one does not help.
    two = np.array([labels, [9, 9, 9, 9, 9]])
    assert fill(two, np.vstack([passed, ~passed]))[0].tolist() == expected


@pytest.mark.parametrize("share", [0, 0.05, 0.5, 0.95])
def test_fill_fast_equals_plain(share):
    rng = np.random.default_rng(3)
    labels, passed = rng.integers(0, 99, (9, 30), dtype=np.int32), rng.random((9, 30)) < share
    np.testing.assert_array_equal(fill(labels, passed), fill_plain(labels, passed))


def test_median():
    # A line of thirteen ones out of 25 wins, twelve lose.
    picture = np.zeros((5, 5), int)
    picture.flat[:12] = 1
    assert median(picture, 5)[2, 2] == 0
    picture.flat[12] = 1
    assert median(picture, 5)[2, 2] == 1
    # The corner repeats itself nine times in 25, its two neighbours along the edges three times each, and so on.
    corner = np.array([[5, 1, 1], [9, 9, 9], [9, 9, 9]])
    assert median(corner, 5)[0, 0] == 5  # 6 times 1, 9 times 5, 10 times 9


@pytest.mark.parametrize("size", [3, 5])
@pytest.mark.parametrize("width, height", [(1, 1), (1, 6), (4, 2), (17, 8)])
def test_median_fast_equals_plain(size, width, height):
    labels = np.random.default_rng(4).integers(0, 60, (height, width), dtype=np.int32)
    fast = median(labels, size)
    assert fast.dtype == np.int32
    np.testing.assert_array_equal(fast, median_plain(labels, size))
