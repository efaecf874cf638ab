"""golden.matcher.fused: the rule on numbers worked by hand, fast against plain, stages on and off, the published rows."""

import itertools

import numpy as np
import pytest

from golden.config import FUSED_1, MatcherConfig, Refinement, changed
from golden.matcher.confidence import confidence_plain
from golden.matcher.fused import labelling, labelling_plain, match
from golden.matcher.labelling import match as match_thesis
from golden.matcher.refine import check_plain, fill_plain, median_plain, right_view_plain
from golden.matcher.sub_pixel import sub_pixel_labels
from golden.matcher.support import arms_plain, fused_cost, support_sums_plain
from golden.pictures.scenes import discriminates, scene


RULES = pytest.mark.parametrize("rule", [labelling, labelling_plain])
NO_REFINEMENT = Refinement(check=False, fill=False, median=False)


def config(disparities, refinement=NO_REFINEMENT, minimum=0, **parameters):
    return MatcherConfig(labels=disparities, minimum=minimum, method=changed(FUSED_1, **parameters, refinement=refinement))


# Two pixels of equal grey level, two labels, n = 1: a weight u of the neighbour is worth u eighths of cost, and a tie is the smaller label.
@RULES
@pytest.mark.parametrize("u1, advantage, expected", [(17, 2, 0), (16, 2, 0), (15, 2, 1), (17, 3, 1)])
def test_left_neighbour(rule, u1, advantage, expected):
    sums = np.array([[[0, 99], [advantage, 0]]])
    assert rule(sums, np.ones((1, 2), int), np.zeros((1, 2), np.uint8), config(2, u1=u1)).tolist() == [[0, expected]]


@RULES
@pytest.mark.parametrize("n, advantage, expected", [(1, 4, 1), (2, 4, 0), (33, 70, 0), (33, 71, 1)])
def test_slopes_grow_with_the_support(rule, n, advantage, expected):
    # 17 n eighths; the support of the pixel itself counts, not its neighbour's.
    sums = np.array([[[0, 99], [advantage, 0]]])
    assert rule(sums, np.array([[9, n]]), np.zeros((1, 2), np.uint8), config(2)).tolist() == [[0, expected]]


@RULES
@pytest.mark.parametrize("n, advantage, expected", [(4, 5, 0), (4, 6, 1)])
def test_intensity_is_floored_before_the_support(rule, n, advantage, expected):
    # 100 grey levels: 17 * 156 / 256 = 10.36, floor 10, times 4 is 40 eighths; unfloored it were 41.4.
    sums = np.array([[[0, 99], [advantage, 0]]])
    assert rule(sums, np.array([[1, n]]), np.array([[0, 100]], np.uint8), config(2)).tolist() == [[0, expected]]


@RULES
@pytest.mark.parametrize("advantage, expected", [(3, 0), (4, 1)])
def test_upper_neighbour(rule, advantage, expected):
    sums = np.array([[[0, 99]], [[advantage, 0]]])  # 30 eighths are 3.75
    assert rule(sums, np.ones((2, 1), int), np.zeros((2, 1), np.uint8), config(2)).tolist() == [[0], [expected]]


@RULES
@pytest.mark.parametrize("disadvantage, expected", [(2, 1), (3, 0)])
def test_lower_neighbour_counts_by_its_local_disparity(rule, disadvantage, expected):
    # 22 eighths are 2.75. The lower pixel's local disparity is 1; above it, 0, it becomes 0 itself.
    sums = np.array([[[0, disadvantage]], [[3, 0]]])
    assert rule(sums, np.ones((2, 1), int), np.zeros((2, 1), np.uint8), config(2)).tolist() == [[expected], [expected]]


@pytest.mark.parametrize("disparities, width, height", [(2, 1, 1), (2, 37, 5), (13, 5, 3), (13, 37, 5), (39, 80, 4)])
def test_fast_equals_plain(disparities, width, height):
    this = config(disparities, u1=13, u2=9, u3=21)
    left, right, _ = scene(width, height, disparities, seed=1)
    left[:, width // 3:width // 2] //= 16  # arms of several pixels
    left_arm, right_arm = arms_plain(left, this.method.arms)
    sums = support_sums_plain(fused_cost(left, right, this), left_arm, right_arm)
    plain = labelling_plain(sums, left_arm + right_arm + 1, left, this)
    np.testing.assert_array_equal(labelling(sums, left_arm + right_arm + 1, left, this), plain)
    np.testing.assert_array_equal(match(left, right, this).disparity, plain)


@pytest.mark.parametrize("disparities, width", [(2, 40), (13, 60), (40, 130)])
def test_scene_discriminates(disparities, width):
    left, right, _ = scene(width, 8, disparities, seed=1)
    assert discriminates(match(left, right, config(disparities)).disparity, config(disparities))


@pytest.mark.parametrize("stages", list(itertools.product([False, True], repeat=4)))
def test_stages(stages):
    check, fill, median, sub_pixel = stages
    scale = 8 if sub_pixel else 1
    left, right, _ = scene(60, 12, 9, seed=5)
    this = config(9, Refinement(*stages), minimum=2)
    left_arm, right_arm = arms_plain(left)
    cost = fused_cost(left, right, this)
    sums = support_sums_plain(cost, left_arm, right_arm)
    labels = match(left, right, config(9, minimum=2)).disparity - 2
    passed = check_plain(labels, right_view_plain(cost, this), this) if check else np.ones(labels.shape, bool)
    found = sub_pixel_labels(sums, labels, passed) if sub_pixel else labels
    filled = fill_plain(found, passed) if fill else found
    expected = median_plain(filled, 5) if median else filled
    result = match(left, right, this)
    assert result.scale == scale
    np.testing.assert_array_equal(result.passed, passed)
    np.testing.assert_array_equal(result.disparity, expected + 2 * scale)
    sure = confidence_plain(expected, filled, passed, left_arm + right_arm + 1, scale)
    np.testing.assert_array_equal(result.confidence, sure)
    assert not check or 0.02 < passed.mean() < 0.9


def test_every_stage_changes_the_scene():
    left, right, _ = scene(60, 12, 9, seed=5)
    results = [match(left, right, config(9, Refinement(*stages))).disparity
               for stages in itertools.product([False, True], repeat=3) if not (stages[1] and not stages[0])]
    assert sum((one != other).any() for one, other in itertools.combinations(results, 2)) == 13  # of 15: check alone changes no disparity


def test_minimum():
    # The right picture moved by 7 and the labels from 7 on: the same disparities, but for the columns that are lost.
    left, right, _ = scene(60, 8, 9, seed=2)
    far = np.roll(right, -7, axis=1)
    near, result = match(left, right, config(9)).disparity, match(left, far, config(9, minimum=7)).disparity
    assert result.min() == 7 and result.max() == 15
    assert (result - 7 == near)[:, 30:50].mean() > 0.95


def test_each_cost_has_its_own_matcher():
    picture = np.zeros((2, 2), np.uint8)
    with pytest.raises(ValueError, match="the method must be fused, not thesis"):
        match(picture, picture, MatcherConfig())
    with pytest.raises(ValueError, match="the method must be thesis, not fused"):
        match_thesis(picture, picture, config(2))


def test_arguments_are_left_alone():
    left, right, _ = scene(30, 5, 4, seed=1)
    before = left.copy(), right.copy()
    match(left, right, config(4, Refinement(), minimum=1))
    np.testing.assert_array_equal((left, right), before)
