"""golden.matcher.labelling: the rule on numbers worked by hand, and fast against plain."""


import numpy as np
import pytest

from golden.config import Arithmetic, MatcherConfig, OnePass, changed
from golden.matcher.cost import local_disparity, matching_cost
from golden.matcher.labelling import labelling, labelling_plain, match, match_plain, slopes
from golden.pictures.scenes import discriminates, scene


RULES = pytest.mark.parametrize("rule", [labelling, labelling_plain])


def test_slopes():
    # Differences: 100 and 0 along the lines, 50 and 50 down the columns. 15 * 156, 15 * 256, 10 * 206, 5 * 206.
    result = slopes(np.array([[0, 100], [50, 50]], dtype=np.uint8), MatcherConfig())
    assert result.tolist() == [[[0, 2340], [0, 3840]], [[0, 0], [2060, 2060]], [[1030, 1030], [0, 0]]]


# Two pixels of equal grey level, two labels: a weight u of the neighbour is worth u grey levels of cost, and a tie is the smaller label.
@RULES
@pytest.mark.parametrize("advantage, expected", [(14, 0), (15, 0), (16, 1)])
def test_left_neighbour(rule, advantage, expected):
    cost = np.array([[[0, 99], [advantage, 0]]])
    labels = rule(cost, np.zeros((1, 2), int), np.zeros((1, 2), np.uint8), MatcherConfig(labels=2))
    assert labels.tolist() == [[0, expected]]


@RULES
@pytest.mark.parametrize("advantage, expected", [(9, 0), (10, 0), (11, 1)])
def test_upper_neighbour(rule, advantage, expected):
    cost = np.array([[[0, 99]], [[advantage, 0]]])
    labels = rule(cost, np.zeros((2, 1), int), np.zeros((2, 1), np.uint8), MatcherConfig(labels=2))
    assert labels.tolist() == [[0], [expected]]


@RULES
@pytest.mark.parametrize("disadvantage, expected", [(4, 1), (5, 0), (6, 0)])
def test_lower_neighbour_counts_by_its_local_disparity(rule, disadvantage, expected):
    # The lower pixel's local disparity is 1, its disparity 0: the former counts.
    cost = np.array([[[0, disadvantage]], [[0, 99]]])
    labels = rule(cost, np.array([[0], [1]]), np.zeros((2, 1), np.uint8), MatcherConfig(labels=2))
    assert labels.tolist() == [[expected], [0]]


@RULES
def test_left_neighbour_counts_by_its_disparity(rule):
    # Of three pixels the second is held at 0 by the first against its own cost, and so holds the third.
    cost = np.array([[[0, 99], [15, 0], [15, 0]]])
    labels = rule(cost, np.array([[0, 1, 1]]), np.zeros((1, 3), np.uint8), MatcherConfig(labels=2))
    assert labels.tolist() == [[0, 0, 0]]


@RULES
@pytest.mark.parametrize("arithmetic, advantage, expected", [
    # 2 labels apart and 100 grey levels: FLOAT 30 * 155 / 255 = 18.24; THESIS 30 * 156 / 256 = 18.28, floor 18;
    # LINEAR 2 * 146 / 8 = 36.5 half levels
    ("float", 18, 0), ("float", 19, 2), ("thesis", 18, 0), ("thesis", 19, 2), ("linear", 36, 0), ("linear", 37, 2),
])
def test_intensity(rule, arithmetic, advantage, expected):
    cost = np.array([[[0, 999, 999], [advantage, 999, 0]]])
    labels = rule(cost, np.zeros((1, 2), int), np.array([[0, 100]], np.uint8), MatcherConfig(labels=3, method=OnePass(arithmetic)))
    assert labels.tolist() == [[0, expected]]


@pytest.mark.parametrize("arithmetic", Arithmetic)
@pytest.mark.parametrize("disparities", [2, 13, 39])
@pytest.mark.parametrize("width, height", [(1, 1), (5, 3), (1, 4), (7, 1), (37, 11)])
def test_fast_equals_plain(arithmetic, disparities, width, height):
    config = MatcherConfig(labels=disparities, method=OnePass(arithmetic))
    left, right, _ = scene(width, height, disparities, seed=3)
    left[:, width // 2] = 255  # a line of extremes through the texture
    right[height // 2] = 0
    fast = match(left, right, config)
    assert fast.shape == (height, width)
    np.testing.assert_array_equal(fast, match_plain(left, right, config))


@pytest.mark.parametrize("arithmetic", Arithmetic)
@pytest.mark.parametrize("disparities, width, height", [(2, 37, 11), (13, 37, 11), (39, 80, 4), (128, 258, 3)])
def test_fast_equals_plain_where_every_label_wins(arithmetic, disparities, width, height):
    # Other weights than the defaults; odd, so that halves are seen.
    config = MatcherConfig(labels=disparities, method=changed(OnePass(arithmetic, 1), u1=13, u2=9, u3=3))
    left, right, _ = scene(width, height, disparities, seed=1)
    cost = matching_cost(left, right, config)
    local = local_disparity(cost)
    fast = labelling(cost, local, left, config)
    assert discriminates(local, config) and discriminates(fast, config)
    np.testing.assert_array_equal(fast, labelling_plain(cost, local, left, config))


@pytest.mark.parametrize("minimum", [1, 20, 255, -1, -5, -12, -40, -64])
def test_minimum(minimum):
    config = MatcherConfig(labels=13, minimum=minimum)
    left, right, _ = scene(37, 7, 13, seed=3)
    fast = match(left, np.roll(right, -minimum, axis=1), config)
    assert fast.min() >= minimum and fast.max() < minimum + 13
    np.testing.assert_array_equal(fast, match_plain(left, np.roll(right, -minimum, axis=1), config))


@pytest.mark.parametrize("minimum", [1, 3, -2])
def test_minimum_at_the_last_column(minimum):
    """No right column beyond the last one that is shifted into the picture is compared: in noise it would make a difference."""
    config = MatcherConfig(labels=2, minimum=minimum)
    for seed in range(20):
        left, right = np.random.default_rng(seed).integers(0, 256, (2, 4, 6))
        np.testing.assert_array_equal(match(left, right, config), match_plain(left, right, config))


@pytest.mark.parametrize("arithmetic", Arithmetic)
@pytest.mark.parametrize("left, right", [(0, 0), (255, 255), (255, 0), (0, 255)])
def test_ties_go_to_zero(arithmetic, left, right):
    config = MatcherConfig(labels=5, method=OnePass(arithmetic))
    assert not match(np.full((4, 9), left, np.uint8), np.full((4, 9), right, np.uint8), config).any()


@pytest.mark.parametrize("arithmetic", Arithmetic)
def test_never_outside_the_picture(arithmetic):
    # The greatest weights pull hardest at a candidate outside.
    config = MatcherConfig(labels=128, method=changed(OnePass(arithmetic), u1=63, u2=63, u3=63))
    rng = np.random.default_rng(5)
    left, right = rng.integers(0, 256, (2, 40, 60), dtype=np.uint8)
    labels = match(left, right, config)
    assert (labels <= np.arange(60)).all()
    assert (labels == np.arange(60)).any()  # the limit is reached


@pytest.mark.parametrize("arithmetic", Arithmetic)
def test_without_weights_the_disparity_is_local(arithmetic):
    config = MatcherConfig(labels=13, method=changed(OnePass(arithmetic), u1=0, u2=0, u3=0))
    left, right, _ = scene(37, 11, 13, seed=1)
    np.testing.assert_array_equal(match(left, right, config), local_disparity(matching_cost(left, right, config)))
    weighted = config.with_settings({"u3": 5})
    assert (match(left, right, weighted) != match(left, right, config)).any()


def test_arguments_are_left_alone():
    config = MatcherConfig(labels=4)
    left, right, _ = scene(9, 5, 4, seed=1)
    cost = matching_cost(left, right, config)
    local = local_disparity(cost)
    before = [array.copy() for array in (cost, local, left)]
    labelling(cost, local, left, config)
    for array, copy in zip((cost, local, left), before):
        np.testing.assert_array_equal(array, copy)
