"""golden.matcher.vertical: numbers worked by hand, and fast against plain."""

import numpy as np
import pytest

from golden.config import FUSED_1, MatcherConfig, changed
from golden.matcher.fused import stages
from golden.matcher.refine import right_view
from golden.matcher.support import arms, fused_cost, support_sums
from golden.matcher.vertical import alike, vertical_support, vertical_support_plain
from golden.pictures.scenes import scene


def method(threshold=10, **more):
    return changed(FUSED_1, vertical_lines=1, vertical_threshold=threshold, cost_shift=7, cost_outside=9, **more)


def costs(*column):
    return np.array(column, dtype=np.uint8)[:, None, None]


def grey(*column):
    return np.array(column, dtype=np.uint8)[:, None]


@pytest.mark.parametrize("column, left, expected", [
    ([7], [50], [28]),                                  # neither neighbour
    ([7, 3], [50, 60], [7 + 14 + 3, 7 + 6 + 3]),        # ten apart is alike
    ([7, 3], [60, 50], [7 + 14 + 3, 7 + 6 + 3]),
    ([7, 3], [50, 61], [28, 12]),                       # eleven is not
    ([1, 5, 9], [0, 0, 0], [1 + 2 + 5, 1 + 10 + 9, 5 + 18 + 9]),
    ([1, 5, 9], [0, 10, 255], [1 + 2 + 5, 1 + 10 + 5, 36]),
    ([1, 5, 9], [255, 10, 0], [4, 5 + 10 + 9, 5 + 18 + 9]),
    ([63, 63, 63], [0, 0, 0], [252, 252, 252]),         # the largest
])
def test_by_hand(column, left, expected):
    assert vertical_support(costs(*column), grey(*left), method().vertical).ravel().tolist() == expected


def test_threshold():
    left = grey(0, 255)
    assert vertical_support(costs(1, 2), left, method(254).vertical).ravel().tolist() == [4, 8]
    assert vertical_support(costs(1, 2), left, method(255).vertical).ravel().tolist() == [5, 7]
    assert [flags.ravel().tolist() for flags in alike(grey(8, 8, 9), method(0).vertical)] == [[False, True, False], [True, False, False]]


def test_off_is_the_cost_itself():
    cost = costs(9, 200, 255)
    assert vertical_support(cost, grey(1, 2, 3), FUSED_1.vertical) is cost
    assert vertical_support_plain(cost, grey(1, 2, 3), FUSED_1.vertical).tolist() == cost.tolist()


@pytest.mark.parametrize("width, height", [(1, 1), (9, 1), (1, 6), (17, 13)])
def test_fast_against_plain(width, height):
    rng = np.random.default_rng(width)
    cost = rng.integers(0, 64, (height, width, 5), dtype=np.uint8)
    left = rng.choice([0, 20, 29, 30, 41, 255], (height, width)).astype(np.uint8)
    given = vertical_support(cost, left, method().vertical)
    assert given.dtype == np.uint8
    assert given.tolist() == vertical_support_plain(cost, left, method().vertical).tolist()


def test_in_the_method():
    """Sums and the right view are those of joined costs."""
    config = MatcherConfig(labels=6, method=method(40))
    left, right, _ = scene(30, 12, 6, seed=3)
    found = stages(left, right, config)
    joined = vertical_support(fused_cost(left, right, config), left, config.method.vertical)
    assert found.sums.tolist() == support_sums(joined, *arms(left, config.method.arms)).tolist()
    assert found.right.tolist() == right_view(joined, config).tolist()
    assert found.right.tolist() != right_view(fused_cost(left, right, config), config).tolist()


def test_limits():
    assert (method().cost.maximum, method().joined_max, method().data_max) == (17, 68, 33 * 68)
    assert (FUSED_1.joined_max, FUSED_1.data_max) == (138, 4554)
    assert changed(FUSED_1, vertical_lines=1, cost_outside=63, census_weight=20, truncation=80, cost_shift=4).joined_max == 252
    with pytest.raises(ValueError, match="the fused cost of three lines reaches 552, more than the 255 that its 8 bits hold"):
        changed(FUSED_1, vertical_lines=1)
    with pytest.raises(ValueError, match="vertical_lines must be"):
        changed(FUSED_1, vertical_lines=2)
