"""golden.matcher.confidence: votes counted by hand, and fast against plain."""

import numpy as np
import pytest

from golden.config import FUSED_1, MatcherConfig, changed
from golden.matcher.confidence import CONFIDENCE_MAX, confidence, confidence_plain
from golden.matcher.fused import match
from golden.pictures.scenes import scene


def window(agreeing, passing, support_size, label=4, other=9):
    """A 5x5 picture whose first pixels agree with the centre, the first of them passed; the confidence of its centre."""
    filled, passed, sizes = np.full((5, 5), other), np.zeros((5, 5), bool), np.full((5, 5), support_size)
    filled.flat[:agreeing] = label
    passed.flat[:passing] = True
    return [rule(np.full((5, 5), label), filled, passed, sizes)[2, 2] for rule in (confidence, confidence_plain)]


@pytest.mark.parametrize("agreeing, passing, support_size, expected", [
    (25, 25, 63, 15), (25, 25, 33, 15), (25, 25, 31, 15), (25, 25, 1, 13),  # (50 + 12) >> 2, (50 + 10) >> 2, (50 + 2) >> 2
    (0, 0, 1, 0), (0, 25, 1, 0), (0, 25, 33, 3),  # a pixel that disagrees has no vote, passed or not
    (1, 0, 1, 0), (1, 1, 1, 1), (2, 0, 1, 1),     # 3 >> 2, 4 >> 2
    (10, 4, 8, 5), (10, 4, 7, 5), (10, 6, 8, 6), (10, 6, 7, 5),  # bit length 4 and 3: 22, 20, 24, 22 quarters
])
def test_votes(agreeing, passing, support_size, expected):
    assert window(agreeing, passing, support_size) == [expected, expected]


@pytest.mark.parametrize("other, scale, agree", [(5, 1, True), (3, 1, True), (6, 1, False), (2, 1, False), (12, 8, True), (13, 8, False)])
def test_within_one_pixel(other, scale, agree):
    filled = np.full((5, 5), other)
    for rule in (confidence, confidence_plain):
        assert rule(np.full((5, 5), 4), filled, np.ones((5, 5), bool), np.ones((5, 5), int), scale)[2, 2] == (13 if agree else 0)


def test_edges_are_repeated():
    # A corner pixel has nine of its 25 votes.
    filled, disparity = np.array([[7, 0], [0, 0]]), np.full((2, 2), 7)
    for rule in (confidence, confidence_plain):
        assert rule(disparity, filled, np.ones((2, 2), bool), np.ones((2, 2), int))[0, 0] == (9 + 9 + 2) >> 2


@pytest.mark.parametrize("scale", [1, 8])
def test_fast_equals_plain(scale):
    rng = np.random.default_rng(1)
    filled, disparity = rng.integers(0, 5 * scale, (2, 9, 14))
    passed, support_size = rng.random((9, 14)) < 0.5, rng.integers(1, 64, (9, 14))
    fast = confidence(disparity, filled, passed, support_size, scale)
    assert fast.dtype == np.uint8
    np.testing.assert_array_equal(fast, confidence_plain(disparity, filled, passed, support_size, scale))


@pytest.mark.parametrize("sub_pixel", [False, True])
def test_it_tells_a_match_from_none(sub_pixel):
    left, right, _ = scene(80, 40, 9, seed=1)
    left[20:] = np.random.default_rng(2).integers(0, 256, (20, 80))  # the lower half has no match at all
    result = match(left, right, MatcherConfig(labels=9, method=changed(FUSED_1, sub_pixel=sub_pixel)))
    assert result.confidence.max() <= CONFIDENCE_MAX == 15
    assert result.confidence[:18].mean() > result.confidence[22:].mean() + 3
