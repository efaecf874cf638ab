"""golden.lab.thesis.sweeps: jobs give what the golden model gives."""

import dataclasses

import numpy as np
import pytest

from golden.config import FUSED_1, Arithmetic, MatcherConfig, OnePass
from golden.lab.thesis import sweeps
from golden.lab.thesis.choices import Choice
from golden.lab.thesis.cures import balanced, rectified
from golden.lab.thesis.disturb import distort, disturb, straighten
from golden.matcher.cost import local_disparity, matching_cost
from golden.matcher.matcher import disparities
from golden.pictures.dataset import StereoPair
from golden.pictures.metrics import bad_pixels
from golden.pictures.scenes import layers


@pytest.fixture(scope="module")
def pair():
    left, right, truth, visible = layers(60, 40, 8, seed=1)
    return StereoPair("layers", left, right, truth.astype(float), {"nonocc": visible, "all": np.ones_like(visible)}, 8)


def figures(labels, pair):
    return [bad_pixels(labels, pair.truth, mask) for mask in pair.masks.values()]


def test_methods():
    configs = {name: sweeps.method_config(name, 16) for name in sweeps.METHODS}
    assert [config.method for config in configs.values()] == [
        OnePass(Arithmetic.FLOAT), OnePass(Arithmetic.THESIS), OnePass(Arithmetic.LINEAR), FUSED_1]
    assert {config.labels for config in configs.values()} == {16}


@pytest.mark.parametrize("method", sweeps.METHODS)
def test_labels(pair, method):
    config = sweeps.method_config(method, 8)
    result = sweeps.labels_of(pair, method)
    expected = disparities(pair.left, pair.right, config)
    np.testing.assert_array_equal(result["labels"], expected)
    assert result["bad"].tolist() == figures(expected, pair) and 0 < result["seconds"] < 100


def test_weights(pair):
    sets = [(15, 10, 5), (0, 0, 0), (40, 3, 20)]
    result = sweeps.weight_figures(pair, "thesis", sets)
    for number, (u1, u2, u3) in enumerate(sets):
        config = MatcherConfig(8, method=OnePass(weights=(u1, u2, u3)))
        labels = disparities(pair.left, pair.right, config)
        assert result["bad"][number].tolist() == figures(labels, pair)
        assert result["extended"][number] == sweeps.extension(labels, pair)
        np.testing.assert_array_equal(sweeps.labels_of(pair, "thesis", (u1, u2, u3))["labels"], labels)
    assert len(np.unique(result["bad"][:, 1])) == 3


def test_local(pair):
    labels = local_disparity(matching_cost(pair.left, pair.right, MatcherConfig(labels=8, method=OnePass("float"))))
    result = sweeps.local_figures(pair)
    np.testing.assert_array_equal(result["labels"], labels)
    assert result["bad"].tolist() == figures(labels, pair)


def test_borders_and_choices(pair):
    result = sweeps.border_figures(pair, "edge")
    assert result["bad"].tolist() == figures(result["labels"], pair)
    rgb = tuple(np.repeat(side[..., None], 3, axis=-1) for side in (pair.left, pair.right))
    some = [Choice(border="edge"), Choice(numbers="thesis")]
    expected = [result["bad"].tolist(), sweeps.labels_of(pair, "thesis")["bad"].tolist()]
    assert sweeps.choice_figures(pair, rgb, some)["bad"].tolist() == expected


def test_disturbed(pair):
    still = sweeps.disturbed(pair, "float", 1.0, 0.0)
    assert still["flicker"] == 0 and still["bad"].tolist() == sweeps.labels_of(pair, "float")["bad"].tolist()
    moving = sweeps.disturbed(pair, "float", 0.9, 6.0)
    frames = [disturb(pair, 0.9, 6.0, seed) for seed in (1, 2)]
    labels = [disparities(frame.left, frame.right, sweeps.method_config("float", 8)) for frame in frames]
    np.testing.assert_array_equal(moving["labels"], labels[0])
    assert moving["flicker"] == 100 * np.mean(np.abs(labels[0] - labels[1]) > 1) > 0
    np.testing.assert_array_equal(moving["right"], frames[0].right)
    cured = sweeps.disturbed(pair, "float", 0.9, 6.0, cured=True)
    frames = [balanced(frame) for frame in frames]
    again = [disparities(frame.left, frame.right, sweeps.method_config("float", 8)) for frame in frames]
    np.testing.assert_array_equal(cured["labels"], again[0])
    assert cured["flicker"] == 100 * np.mean(np.abs(again[0] - again[1]) > 1) and cured["bad"].tolist() == figures(again[0], pair)
    np.testing.assert_array_equal(cured["right"], frames[0].right)


def test_lens(pair):
    result = sweeps.lens_figures(pair, "linear", 0.05)
    seen, off_line = distort(pair, 0.05)
    labels = disparities(seen.left, seen.right, sweeps.method_config("linear", 8))
    assert result["bad"].tolist() == figures(labels, seen) and result["off_line"] == off_line > 0
    for name, again in (("straight", straighten(pair, 0.05)), ("rectified", rectified(seen, pair, 0.05))):
        assert result[name].tolist() == figures(disparities(again.left, again.right, sweeps.method_config("linear", 8)), pair)


def test_extension():
    """An object two columns wide at disparity 5 before a ground at 2: of the ten pixels around it, those counted that are too near."""
    truth = np.full((1, 12), 2.0)
    truth[0, 5:7] = 5
    truth[0, 0] = np.inf
    mask = np.ones(truth.shape, bool)
    mask[0, 10] = False
    pair = StereoPair("line", np.zeros((1, 12), np.uint8), np.zeros((1, 12), np.uint8), truth, {"all": mask}, 8)
    labels = np.array([[9, 4, 2, 3, 5, 5, 5, 5, 1, 2, 9, 9]])
    # Within four columns: 1 .. 4 and 7 .. 9 (10 is masked). Too near: 1, 4, 7; column 3 is off by one only.
    assert sweeps.extension(labels, pair) == pytest.approx(100 * 3 / 7)
    # Within one column: 4 and 7.
    assert sweeps.extension(labels, pair, sweeps.background_edges(pair, reach=1)) == 100
    flat = dataclasses.replace(pair, truth=np.full(truth.shape, 2.0))
    assert sweeps.extension(labels, flat) == 0
