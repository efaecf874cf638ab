"""golden.matcher.recursive.method: stages on and off, settings, widths, the published rows."""

import dataclasses

import numpy as np
import pytest

from golden.config import RECURSIVE_1, RECURSIVE_2, MatcherConfig, Recursive, changed
from golden.lab.evaluate import average, evaluate
from golden.matcher.matcher import match
from golden.matcher.recursive.method import stages
from golden.pictures.dataset import PAIRS
from golden.pictures.scenes import scene
from tests.kit import middlebury


def config(labels=12, minimum=0, **parameters):
    return MatcherConfig(labels, 90, minimum, method=changed(RECURSIVE_2, **parameters))


LEFT, RIGHT, _ = scene(60, 14, 12, seed=3)


def test_widths_hold_the_greatest():
    """Bounds by arithmetic, and reached nowhere beyond."""
    assert [(method.own_max, method.carried_max, method.joined_max, method.data_max) for method in (RECURSIVE_1, RECURSIVE_2)] == [
        (135, 78, 281, 290), (135, 78, 427, 436)]
    noise = np.random.default_rng(1).integers(0, 256, (2, 14, 60))
    costs = stages(*noise, config()).costs
    assert 0 <= costs.min() and costs.max() <= RECURSIVE_2.data_max


def test_stages():
    whole = match(LEFT, RIGHT, config())
    for off in ("check", "fill", "median"):
        other = match(LEFT, RIGHT, config(**{off: False}))
        assert (other["disparity"] != whole["disparity"]).any()
        assert other["passed"].all() == (off == "check")
    assert not whole["passed"].all() and set(whole) == set(config().result_fields)


def test_sub_pixel():
    fine = config(sub_pixel=True)
    result = match(LEFT, RIGHT, fine)["disparity"]
    assert (result % 8 != 0).any() and result.max() <= 8 * 11
    coarse = match(LEFT, RIGHT, config())["disparity"]
    assert np.mean(np.abs(result / 8 - coarse) <= 0.5) > 0.9


@pytest.mark.parametrize("name, value", [
    ("census_threshold", 3), ("near_threshold", 0), ("far_threshold", 90), ("step_threshold", 0), ("above_share", 0), ("below_share", 15),
    ("gate_numerator", 20), ("gate_offset", 90), ("gate_floor", 120), ("minimum", 4), ("in_use", 3),
])
def test_settings(name, value):
    """Each setting changes the result, and is the golden model's parameter of that name."""
    here = config(reach=8, step_threshold=255, near_threshold=20)
    changed_config = here.with_settings({name: value})
    assert changed_config != here and changed_config.settings[name].default == value
    left, right, _ = scene(60, 14, 12, seed=3)
    rng = np.random.default_rng(1)
    left, right = (np.clip(side + rng.integers(-9, 10, side.shape), 0, 255).astype(np.uint8) for side in (left, right))
    assert (match(left, right, changed_config)["disparity"] != match(left, right, here)["disparity"]).any()


def test_settings_of_the_sets():
    names = ["in_use", "census_threshold", "near_threshold", "far_threshold", "step_threshold", "above_share", "below_share",
             "gate_numerator", "gate_offset", "gate_floor", "minimum", "check", "fill", "median"]
    assert list(config().settings) == names
    assert list(MatcherConfig(method=RECURSIVE_1).settings) == [name for name in names if name != "below_share"]
    assert dataclasses.replace(RECURSIVE_1, propagation=dataclasses.replace(RECURSIVE_1.propagation, from_below=True)) == RECURSIVE_2
    assert Recursive() == RECURSIVE_1


def test_minimum():
    """A shifted right picture and a shifted least disparity give the same labels."""
    wide, _, _ = scene(200, 14, 12, seed=3)
    left, right = wide[:, 40:140], wide[:, 46:146]
    for minimum in (-3, 0, 4):
        moved = wide[:, 46 - minimum - 6:146 - minimum - 6] if minimum else right
        result = match(left, moved if minimum else right, config(minimum=minimum))["disparity"]
        assert result.min() >= minimum and result.max() < minimum + 12


@pytest.mark.parametrize("values, message", [
    ({"cost_limit": 0}, "cost_limit must be a whole number from 1 to 255, not 0"),
    ({"census_threshold": 8}, "census_threshold must be a whole number from 0 to 7, not 8"),
    ({"far_step": 0}, "far_step must be a whole number from 1 to 32"),
    ({"fan": 2}, "fan must be a whole number from 3 to 31"),
    ({"cost_limit": 4}, "cost_outside must be at most cost_limit, 4, not 5"),
    ({"above_share": 16}, "above_share must be a whole number from 0 to 15"),
    ({"own_share": 0}, "own_share must be a whole number from 1 to 7"),
    ({"median_size": 5}, "median_size must be an odd whole number from 7 to 7, not 5"),
    ({"u1": 3}, "u1 is no parameter of the method recursive"),
])
def test_bad_parameters(values, message):
    with pytest.raises(ValueError, match=message):
        changed(RECURSIVE_1, **values)


def test_no_rule():
    with pytest.raises(ValueError, match="the method must label by the disparity rule, and recursive does not"):
        _ = config().rule


@pytest.mark.parametrize("method, rows", [
    (RECURSIVE_1, [1.60, 2.78, 8.43, 0.53, 0.89, 4.62, 5.75, 9.89, 14.65, 2.66, 8.80, 7.83, 5.70]),
    (RECURSIVE_2, [1.52, 2.66, 7.14, 0.44, 0.81, 4.14, 5.26, 9.44, 13.57, 2.71, 8.94, 7.97, 5.38]),
], ids=["recursive-1", "recursive-2"])
def test_published_rows(method, rows):
    """The benchmark's figures, to the second decimal."""
    figures = evaluate([middlebury(name) for name in PAIRS], lambda labels: MatcherConfig(labels, 500, method=method))
    found = [value for of_pair in figures.values() for value in of_pair.values()]
    assert [round(value, 2) for value in (*found, average(figures))] == rows
