"""golden.pictures.scenes: what the scenes promise to the tests that use them."""

import itertools

import numpy as np
import pytest

from golden.config import Arithmetic, MatcherConfig, OnePass
from golden.matcher.labelling import match
from golden.pictures.scenes import NOISE, discriminates, layers, scene


@pytest.mark.parametrize("arithmetic", Arithmetic)
@pytest.mark.parametrize("width, height, disparities", [(4, 3, 2), (37, 11, 13), (80, 4, 39), (160, 8, 80), (256, 8, 128), (150, 33, 128)])
def test_every_label_wins(arithmetic, width, height, disparities):
    config = MatcherConfig(labels=disparities, method=OnePass(arithmetic))
    for seed in range(3):
        left, right, _ = scene(width, height, disparities, seed)
        assert discriminates(match(left, right, config), config)


@pytest.mark.parametrize("width, height, disparities", [(1, 1, 2), (5, 3, 39), (1, 4, 13), (37, 11, 13)])
def test_left_matches_right(width, height, disparities):
    left, right, truth = scene(width, height, disparities, seed=7)
    assert left.shape == right.shape == truth.shape == (height, width)
    assert left.dtype == right.dtype == np.uint8
    y, x = np.nonzero(np.isfinite(truth))
    d = truth[y, x].astype(int)
    assert (d < disparities).all() and (d <= x).all()
    difference = left[y, x].astype(int) - right[y, x - d]
    assert np.abs(difference).max() <= NOISE
    assert difference.any() or difference.size == 1


def test_every_fourth_line_has_no_match():
    _, _, truth = scene(20, 16, 4, seed=1)
    assert np.nonzero(np.isinf(truth).all(axis=1))[0].tolist() == [3, 7, 11, 15]


def test_arithmetics_differ():
    left, right, _ = scene(150, 33, 128, seed=1)
    results = [match(left, right, MatcherConfig(labels=128, method=OnePass(arithmetic, fraction_bits)))
               for arithmetic, fraction_bits in (("thesis", 3), ("linear", 0), ("linear", 1), ("linear", 3))]
    assert all((one != other).any() for one, other in itertools.combinations(results, 2))


@pytest.mark.parametrize("width, height, disparities", [(1, 1, 2), (40, 9, 8), (160, 120, 16)])
def test_layers(width, height, disparities):
    left, right, truth, visible = layers(width, height, disparities, seed=3, noise=0)
    assert left.dtype == right.dtype == np.uint8 and left.shape == right.shape == truth.shape == visible.shape == (height, width)
    assert truth.min() >= 0 and truth.max() < disparities
    y, x = np.nonzero(visible)
    np.testing.assert_array_equal(left[y, x], right[y, x - truth[y, x]])  # what both pictures show is the same
    # What is hidden is hidden by something nearer, or lies beyond the edge.
    shown = {(row, column - d): d for (row, column), d in np.ndenumerate(truth) for d in [d] if column >= d and visible[row, column]}
    for y, x in np.argwhere(~visible):
        assert x < truth[y, x] or shown[y, x - truth[y, x]] > truth[y, x]


def test_layers_have_occlusions_and_grain():
    left, right, truth, visible = layers(160, 120, 16, seed=1)
    assert 0.7 < visible.mean() < 0.99 and len(np.unique(truth)) > 8
    y, x = np.nonzero(visible)
    difference = left[y, x].astype(int) - right[y, x - truth[y, x]]
    assert 1 < difference.std() < 5  # two grains of two grey levels
    again, other = layers(160, 120, 16, seed=1), layers(160, 120, 16, seed=2)
    np.testing.assert_array_equal(left, again[0])
    assert (left != other[0]).any()


def test_seed():
    first, again, other = (scene(16, 4, 4, seed) for seed in (1, 1, 2))
    np.testing.assert_array_equal(first[0], again[0])
    assert (first[0] != other[0]).any()


@pytest.mark.parametrize("labels, expected", [([[0, 1], [2, 3]], True), ([[0, 1], [2, 2]], False), ([[3, 1], [2, 2]], False)])
def test_discriminates(labels, expected):
    assert discriminates(np.array(labels), MatcherConfig(labels=4)) is expected
