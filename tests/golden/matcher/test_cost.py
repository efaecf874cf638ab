"""golden.matcher.cost on numbers worked by hand."""

import numpy as np
import pytest

from golden.config import Arithmetic, MatcherConfig, OnePass
from golden.matcher.cost import aligned, cost_energy, edata, local_disparity, matching_cost, outside, sub_pixels
from golden.pictures.scenes import scene


def config(arithmetic, disparities=2, minimum=0):
    return MatcherConfig(labels=disparities, minimum=minimum, method=OnePass(arithmetic))


@pytest.mark.parametrize("arithmetic, expected", [
    # pixel, above, below, left of the lines (3, 4) and (6, 8); the third column repeats the last pixel: its left is the right of x = 1
    ("float", [[[3, 4, 4], [6, 8, 8]], [[3, 4, 4], [4.5, 6, 6]], [[4.5, 6, 6], [6, 8, 8]], [[3, 3.5, 4], [6, 7, 8]]]),
    ("thesis", [[[3, 4, 4], [6, 8, 8]], [[3, 4, 4], [4, 6, 6]], [[4, 6, 6], [6, 8, 8]], [[3, 3, 4], [6, 7, 8]]]),
    ("linear", [[[6, 8, 8], [12, 16, 16]], [[6, 8, 8], [9, 12, 12]], [[9, 12, 12], [12, 16, 16]], [[6, 7, 8], [12, 14, 16]]]),
])
def test_sub_pixels(arithmetic, expected):
    assert [part.tolist() for part in sub_pixels(np.array([[3, 4], [6, 8]], dtype=np.uint8), config(arithmetic))] == expected


@pytest.mark.parametrize("arithmetic, expected", [
    # Line 10 20 against 12 15; above and below repeat the pixel. (x, d): pixel, above, below + left + right.
    # (0, 0): 2 2 2 + |10 - 12| + |15 - 13.5|; (1, 0): 5 5 5 + |15 - 13.5| + 5; (1, 1): 8 8 8 + |15 - 12| + |20 - 13.5|
    ("float", [[9.5, 2047], [21.5, 33.5]]),
    ("thesis", [[10, 2047], [22, 34]]),  # 13.5 is 13
    ("linear", [[19, 4095], [43, 67]]),
])
def test_matching_cost_of_a_line(arithmetic, expected):
    cost = matching_cost(np.array([[10, 20]], dtype=np.uint8), np.array([[12, 15]], dtype=np.uint8), config(arithmetic))
    assert cost.tolist() == [expected]


@pytest.mark.parametrize("arithmetic, factor", [("float", 1), ("thesis", 1), ("linear", 2)])
def test_matching_cost_of_a_column(arithmetic, factor):
    # Pixels 0 10 40 against 0. (pixel, above, below, left, right): 0 0 5 0 0; 10 5 25 10 10; 40 25 40 40 40.
    left = np.array([[0], [10], [40]], dtype=np.uint8)
    cost = matching_cost(left, np.zeros_like(left), config(arithmetic))
    assert cost[:, 0, 0].tolist() == [5 * factor, 60 * factor, 185 * factor]


@pytest.mark.parametrize("arithmetic", Arithmetic)
def test_extremes(arithmetic):
    this = config(arithmetic, disparities=3)
    for left, right in ((255, 0), (0, 255)):
        cost = matching_cost(np.full((2, 4), left, np.uint8), np.full((2, 4), right, np.uint8), this)
        inside = np.arange(3) <= np.arange(4)[:, None]
        assert (cost == np.where(inside, this.matching_cost.inside_max, this.matching_cost.outside)).all()


def test_differences_and_sum():
    ones = np.ones((3, 2), dtype=np.int16)
    parts = cost_energy([ones, 2 * ones, 3 * ones, 4 * ones], [5 * ones, 0 * ones, 3 * ones, 6 * ones])
    assert [part[0, 0] for part in parts] == [4, 2, 0, 2]
    delayed = np.array([[1, 10], [2, 20], [4, 40]])
    # The difference to the right of x is the one to the left of x + 1.
    assert edata([100 * ones, 200 * ones, 400 * ones, delayed]).tolist() == [[703, 730], [706, 760]]


def test_local_disparity_takes_the_smaller_on_a_tie():
    assert local_disparity(np.array([[[4, 2, 2], [1, 5, 1], [3, 3, 0]]])).tolist() == [[1, 0, 2]]


def test_aligned():
    left, right = np.array([[1, 2, 3], [4, 5, 6]]), np.array([[5, 6, 7], [1, 2, 3]])

    def both(*arguments):
        return [side.tolist() for side in aligned(left, right, *arguments)]

    assert both(0) == [left.tolist(), right.tolist()]
    assert both(1) == [left.tolist(), [[5, 5, 6], [1, 1, 2]]]
    assert both(255) == [left.tolist(), [[5, 5, 5], [1, 1, 1]]]
    assert both(-1) == [[[1, 1, 2, 3], [4, 4, 5, 6]], [[5, 6, 7, 7], [1, 2, 3, 3]]]
    # More lead than the least disparity needs.
    assert both(-1, 2) == [[[1, 1, 1, 2, 3], [4, 4, 4, 5, 6]], [[5, 5, 6, 7, 7], [1, 1, 2, 3, 3]]]
    assert both(1, 1) == [[[1, 1, 2, 3], [4, 4, 5, 6]], [[5, 5, 5, 6], [1, 1, 1, 2]]]


@pytest.mark.parametrize("minimum", [-1, -4, -9, -64])
def test_negative_disparities_are_earlier_labels_of_the_same_costs(minimum):
    """Where the pixel has no match beyond either edge, the costs do not depend on which label is the first."""
    left, right, _ = scene(40, 5, 12, seed=4)
    labels = 12 - minimum
    more, plain = (matching_cost(left, right, MatcherConfig(n, minimum=m)) for n, m in ((labels, minimum), (12, 0)))
    np.testing.assert_array_equal(more[:, :, -minimum:], plain)
    # The other way round: exchanged pictures have negative disparities, and no candidate left of x = 0 is lost.
    swapped = matching_cost(right, left, MatcherConfig(12, minimum=-11))[:, :, ::-1]
    y, x, d = np.indices((5, 40, 12))
    inside = (x + d < 39) & (x > 0)
    np.testing.assert_array_equal(swapped[inside], plain[y, np.minimum(x + d, 39), d][inside])


def test_outside():
    assert outside(4, config("linear", 3, minimum=1)).tolist() == [
        [True, True, True], [False, True, True], [False, False, True], [False, False, False]]


@pytest.mark.parametrize("arithmetic", Arithmetic)
def test_minimum_is_a_later_part_of_the_same_costs(arithmetic):
    left, right, _ = scene(60, 5, 20, seed=4)
    whole = matching_cost(left, right, config(arithmetic, 20))
    part = matching_cost(left, right, config(arithmetic, 8, minimum=12))
    # The delayed picture ends earlier than the picture: the sub-pixel to the right of the last column sees that.
    np.testing.assert_array_equal(part[:, :-1], whole[:, :-1, 12:])
    assert (part[:, -1] != whole[:, -1, 12:]).any()
