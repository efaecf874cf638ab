"""golden.pictures.scenes.SCENES: exact, discriminating, and hard where they say so."""

import numpy as np
import pytest

from golden.config import Arithmetic, MatcherConfig, OnePass
from golden.matcher.labelling import match
from golden.pictures.metrics import bad_pixels
from golden.pictures.scenes import SCENES, discriminates, slanted


SIZES = [(64, 64, 16), (96, 64, 8), (160, 128, 32)]


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("width, height, disparities", SIZES)
def test_every_label_wins(name, width, height, disparities):
    for arithmetic in Arithmetic:
        config = MatcherConfig(labels=disparities, method=OnePass(arithmetic))
        for seed in range(2):
            scene = SCENES[name](width, height, disparities, seed)
            assert discriminates(match(scene.left, scene.right, config), config)


@pytest.mark.parametrize("name", SCENES)
@pytest.mark.parametrize("width, height, disparities", [*SIZES, (7, 5, 2)])
def test_truth(name, width, height, disparities):
    scene = SCENES[name](width, height, disparities, seed=3)
    assert scene.left.dtype == scene.right.dtype == np.uint8 and scene.visible.dtype == scene.hard.dtype == bool
    assert {part.shape for part in vars(scene).values()} == {(height, width)}
    assert scene.truth.min() == 0 and scene.truth.max() == disparities - 1
    assert not scene.visible[:, 0][scene.truth[:, 0] > 0].any()
    assert scene.hard.any() and scene.visible.any()


@pytest.mark.parametrize("name", sorted(set(SCENES) - {"unequal"}))
def test_what_both_show_is_alike(name):
    scene = SCENES[name](160, 128, 32, seed=1)
    # Whole disparities away from every edge: nothing is between pixels but the noise of both pictures.
    whole = scene.visible & (np.abs(scene.truth - np.rint(scene.truth)) < 1e-9)
    y, x = np.nonzero(whole)
    difference = scene.left[y, x].astype(int) - scene.right[y, x - np.rint(scene.truth[y, x]).astype(int)]
    assert y.size > 100 and np.mean(np.abs(difference) <= 5) > 0.99 and np.std(difference) < 4


@pytest.mark.parametrize("name, times", [("textureless", 10), ("repetitive", 10), ("thin", 1.5)])
def test_hard_is_harder(name, times):
    scene = SCENES[name](160, 128, 32, seed=1)
    labels = match(scene.left, scene.right, MatcherConfig(labels=32))
    hard, easy = (bad_pixels(labels, scene.truth, scene.visible & region) for region in (scene.hard, ~scene.hard))
    assert hard > times * easy and easy < 10


def test_slanted_is_sub_pixel():
    truth = slanted(160, 128, 32, seed=1).truth
    assert np.mean(np.abs(truth - np.rint(truth)) > 0.1) > 0.5
    assert len(np.unique(truth[20])) > 40  # along a line too


def test_unequal_is_slanted_but_for_the_right_picture():
    same, other = slanted(160, 128, 32, seed=1), SCENES["unequal"](160, 128, 32, seed=1)
    np.testing.assert_array_equal(same.left, other.left)
    np.testing.assert_array_equal(same.truth, other.truth)
    change = other.right - (0.8 * same.right + 5)
    assert abs(change.mean()) < 0.1 and 2.5 < change.std() < 3.5 and other.hard.all()
    config = MatcherConfig(labels=32)
    bad = [bad_pixels(match(scene.left, scene.right, config), scene.truth, scene.visible) for scene in (same, other)]
    assert bad[1] > 5 * bad[0]


@pytest.mark.parametrize("name", SCENES)
def test_seed(name):
    first, again, other = (SCENES[name](64, 48, 8, seed) for seed in (1, 1, 2))
    for part in vars(first):
        np.testing.assert_array_equal(getattr(first, part), getattr(again, part))
    assert (first.left != other.left).any()
