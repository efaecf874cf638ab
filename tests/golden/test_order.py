"""golden.order: a pair that is given the wrong way round is told."""

import numpy as np
import pytest

from golden.config import MatcherConfig
from golden.order import FEW, LEAST_PIXELS, note_order, passing
from golden.pictures.dataset import motorcycle
from golden.pictures.scenes import scene


def told(capsys, left, right, labels, minimum=0):
    note_order(left, right, MatcherConfig(labels, minimum=minimum))
    return capsys.readouterr().err


@pytest.fixture(scope="module")
def pairs():
    pair = motorcycle()
    return {"scene": (*scene(120, 40, 12, seed=1)[:2], 16), "photograph": (pair.left, pair.right, pair.disparities)}


@pytest.mark.parametrize("name", ["scene", "photograph"])
def test_exchanged_pair_is_told(name, pairs, capsys):
    left, right, labels = pairs[name]
    assert told(capsys, left, right, labels) == ""
    text = told(capsys, right, left, labels)
    assert text.startswith("note: ") and text.count("\n") == 1
    assert "with the pictures exchanged: the pair may be given the wrong way round; left(x) must match right(x - d)" in text


def test_negative_disparities_are_no_exchange(pairs, capsys):
    """What was exchanged for disparities from 0 on is in order for those up to 0."""
    left, right, labels = pairs["scene"]
    assert told(capsys, right, left, labels, minimum=1 - labels) == ""


def test_noise_is_no_exchange(capsys):
    """Few pixels pass, whichever way."""
    left, right = np.random.default_rng(1).integers(0, 256, (2, 40, 90), dtype=np.uint8)
    assert passing(left, right, MatcherConfig(16)) < FEW
    assert told(capsys, left, right, 16) == ""


def test_middle_is_looked_at():
    """The lines above and below the middle do not count."""
    left, right, _ = scene(60, 200, 8, seed=2)
    noise = np.random.default_rng(1).integers(0, 256, (68, 60), dtype=np.uint8)
    spoilt = np.concatenate([noise, right[68:132], noise])
    assert passing(left, spoilt, MatcherConfig(8)) == passing(left[68:132], right[68:132], MatcherConfig(8)) > 0.5


def test_few_pixels_say_nothing(pairs, capsys):
    left, right, labels = pairs["scene"]
    lines = LEAST_PIXELS // 120
    assert told(capsys, right[:lines], left[:lines], labels) == ""
