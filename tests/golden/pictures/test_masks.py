"""golden.pictures.masks: on lines worked by hand, on scenes whose visible pixels are known, and pixel by pixel."""

import itertools

import numpy as np
import pytest

from golden.pictures.masks import computed_masks, right_truth, visible
from golden.pictures.scenes import SCENES, layers


UNKNOWN = np.inf


def masks_plain(truth, right):
    """The definition, pixel by pixel."""
    height, width = truth.shape

    def near(reach):
        return itertools.product(range(-reach, reach + 1), repeat=2)

    def seen(y, x):
        if truth[y, x] == UNKNOWN:
            return False
        label = int(truth[y, x] + 0.5)
        return x >= label and right[y, x - label] != UNKNOWN and abs(int(right[y, x - label] + 0.5) - label) <= 1

    def at(y, x):
        return min(max(y, 0), height - 1), min(max(x, 0), width - 1)

    known = truth != UNKNOWN
    nonocc = np.zeros_like(known)
    for y, x in np.ndindex(truth.shape):
        nonocc[y, x] = known[y, x] and sum(seen(*at(y + dy, x + dx)) for dy, dx in near(1)) > 4

    def edge(y, x):
        if not known[y, x]:
            return False
        steps = [abs(truth[y, x] - truth[at(y + dy, x + dx)]) for dy, dx in ((0, 1), (1, 0), (0, -1), (-1, 0))]
        return not nonocc[y, x] or any(2 <= step < UNKNOWN for step in steps)

    disc = np.array([[nonocc[y, x] and any(edge(*at(y + dy, x + dx)) for dy, dx in near(4)) for x in range(width)] for y in range(height)])
    return {"nonocc": nonocc, "all": known, "disc": disc}


@pytest.mark.parametrize("seed", range(4))
def test_masks_are_as_defined(seed):
    rng = np.random.default_rng(seed)
    # Smooth truths of two levels with holes, in thirds of a pixel.
    truth = np.where(np.arange(26) // 9 % 2, 5, 1) + rng.integers(0, 4, (14, 26)) / 3
    truth[rng.random(truth.shape) < 0.04] = UNKNOWN
    right = right_truth(truth)
    right[rng.random(truth.shape) < 0.1] = UNKNOWN
    found, expected = computed_masks(truth, right), masks_plain(truth, right)
    assert list(found) == list(expected)
    for name, mask in expected.items():
        assert (found[name] == mask).all() and 0 < mask.sum() < mask.size, name


@pytest.mark.parametrize("there, agrees", [
    (3, True), (2, True), (4, True), (4.4, True), (4.5, False), (1, False), (1.5, True), (UNKNOWN, False),
])
def test_agreement_of_the_truths(there, agrees):
    right = np.full((1, 8), float(there))
    assert visible(np.full((1, 8), 3.0), right)[0].tolist() == [False] * 3 + [agrees] * 5  # the first match outside the picture


def test_half_a_pixel_is_rounded_up():
    right = np.array([[UNKNOWN, 2.0, UNKNOWN, UNKNOWN]])
    assert visible(np.array([[UNKNOWN, UNKNOWN, UNKNOWN, 1.5]]), right).tolist() == [[False, False, False, True]]
    assert visible(np.array([[UNKNOWN, UNKNOWN, 1.25, UNKNOWN]]), right).tolist() == [[False, False, True, False]]


def test_right_truth_is_of_the_nearest():
    truth = np.array([[0.0, 0.0, 2.0, 1.0, UNKNOWN, 7.0]])
    assert right_truth(truth).tolist() == [[2.0, 0.0, 1.0, UNKNOWN, UNKNOWN, UNKNOWN]]


@pytest.mark.parametrize("name", ["layers", *SCENES])
def test_scenes(name):
    """Where a scene tells which pixels are visible, the masks do, from the left truth alone, but for narrow strips."""
    if name == "layers":
        _, _, truth, seen = layers(90, 60, 16, 1)
    else:
        scene = SCENES[name](90, 60, 16, 1)
        truth, seen = scene.truth, scene.visible
    masks = computed_masks(np.asarray(truth, dtype=float))
    assert masks["all"].all() and (masks["nonocc"] != seen).mean() < 0.05
    assert not (masks["disc"] & ~masks["nonocc"]).any()


def test_a_lone_step_of_less_than_two_is_no_discontinuity():
    truth = np.full((12, 40), 3.0)
    truth[:, 20:] = 4.9
    both = computed_masks(truth, np.full((12, 40), 4.0))
    assert not both["disc"][:, 8:].any()  # further left the pixels without a match count as occluded
    truth[:, 20:] = 5.0
    assert np.flatnonzero(computed_masks(truth, np.full((12, 40), 4.0))["disc"][5, 8:]).tolist() == list(range(7, 17))
