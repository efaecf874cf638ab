"""golden.matcher.sub_pixel: fractions worked by hand, comparisons against division, where no fraction is allowed."""

import numpy as np
import pytest

from golden.config import FUSED_1, MatcherConfig, changed
from golden.matcher.fused import match
from golden.matcher.sub_pixel import fraction, fraction_plain, neighbouring_sums, sub_pixel_labels
from golden.pictures.scenes import scene


@pytest.mark.parametrize("before, own, after, expected", [
    (10, 0, 10, 0),
    # m = 16; an eighth is 4 of difference, rounded half away from the label: at 2, 6, 10, 14
    (16, 0, 15, 0), (16, 0, 14, 1), (16, 0, 11, 1), (16, 0, 10, 2), (16, 0, 7, 2),
    (16, 0, 6, 3), (16, 0, 3, 3), (16, 0, 2, 4), (16, 0, 0, 4),
    (14, 0, 16, -1), (10, 0, 16, -2), (6, 0, 16, -3), (0, 0, 16, -4),
    # The rule held the label although a neighbour's sum is less: no more than half a pixel.
    (20, 8, 3, 4), (3, 8, 20, -4), (9, 8, 0, 4),
    # On the summit, or flat.
    (5, 8, 3, 0), (8, 8, 3, 0), (8, 8, 8, 0), (3, 8, 8, 0),
    (4554, 0, 4554, 0), (4554, 0, 0, 4), (0, 0, 4554, -4),
])
def test_fraction(before, own, after, expected):
    assert fraction(before, own, after) == expected
    assert fraction_plain(before, own, after) == expected


def test_comparisons_equal_division():
    sums = np.random.default_rng(1).integers(0, 60, (3, 5000), dtype=np.int16)  # small: ties and halves are frequent
    fast = fraction(*sums)
    assert fast.tolist() == [fraction_plain(*each) for each in sums.T.tolist()]
    assert set(fast.tolist()) == set(range(-4, 5))


def test_int16_does_not_overflow():
    sums = np.array([16065, 0, 0], np.int16)
    assert fraction(*sums) == 4


def test_neighbouring_sums():
    sums = np.array([[[5, 6, 8], [1, 2, 3], [7, 9, 4]]])
    assert [part.tolist() for part in neighbouring_sums(sums, np.array([[0, 1, 2]]))] == [[[5, 1, 9]], [[5, 2, 4]], [[6, 3, 4]]]


def test_where_no_fraction_is_allowed():
    sums = np.tile(np.array([9, 0, 1, 0, 9]), (1, 7, 1))
    labels, passed = np.array([[0, 1, 1, 2, 3, 3, 4]]), np.array([[True, True, False, True, True, False, True]])
    # Label 1: m = 9, apart 8, 8/18 is 3.6 eighths; label 3 the same to the other side; label 2 stands on a summit no higher than before.
    assert sub_pixel_labels(sums, labels, passed).tolist() == [[0, 12, 8, 16, 20, 24, 32]]


@pytest.mark.parametrize("minimum", [0, 3])
def test_within_half_a_pixel_of_the_whole_disparity(minimum):
    left, right, _ = scene(60, 12, 9, seed=5)

    def result(sub_pixel):
        return match(left, right, MatcherConfig(labels=9, minimum=minimum, method=changed(FUSED_1, sub_pixel=sub_pixel)))

    whole, fine = result(False), result(True)
    assert (whole.scale, fine.scale) == (1, 8)
    # Median and fill keep the order, so eighths stay within four of the label that is chosen without them.
    assert np.abs(fine.disparity - 8 * whole.disparity).max() == 4
    assert fine.disparity.min() >= 8 * minimum and fine.disparity.max() <= 8 * (minimum + 8)
    np.testing.assert_array_equal(fine.pixels, fine.disparity / 8)
    np.testing.assert_array_equal(whole.pixels, whole.disparity)
    assert len(np.unique(fine.disparity % 8)) == 8
