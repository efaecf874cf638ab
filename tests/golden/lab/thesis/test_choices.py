"""golden.lab.thesis.choices: each reading of the thesis, against the plain rule pixel by pixel."""

import itertools

import numpy as np
import pytest

from golden.config import MatcherConfig, OnePass, changed
from golden.lab.thesis.choices import BORDERS, FORMATS, GREYS, Choice, all_choices, bordered_cost, disparities, grey_levels
from golden.matcher.labelling import match


CONFIG = MatcherConfig(labels=5, method=changed(OnePass(), u1=9, u2=7, u3=4))


def pair(seed=1, shape=(9, 14)):
    """Few grey levels: many ties."""
    return np.random.default_rng(seed).integers(0, 5, (2, *shape), dtype=np.uint8) * 50


def plain(left, right, choice):
    """The rule in floating point or whole numbers, as a choice reads it."""
    height, width = left.shape
    floor = choice.numbers in ("floor", "floor/256", "thesis")
    scale = {"float": 255, "floor": 255, "float/256": 256, "floor/256": 256, "thesis": 1}[choice.numbers]

    def at(picture, y, x):
        inside = 0 <= y < height and 0 <= x < width
        if not inside and choice.border == "zero":
            return 0
        return int(picture[min(max(y, 0), height - 1), min(max(x, 0), width - 1)])

    def cost(y, x, d):
        if choice.border == "ours" and d > x:
            return CONFIG.matching_cost.outside
        total = 0
        for dy, dx in ((0, 0), (-1, 0), (1, 0), (0, -1), (0, 1)):
            l, r = (at(left, y, x) + at(left, y + dy, x + dx), at(right, y, x - d) + at(right, y + dy, x - d + dx))
            total += abs(l // 2 - r // 2) if floor else abs(l - r) / 2
        return total

    def smooth(distance, apart, u):
        over = 255 if scale == 255 else 256
        exact = distance * u * (over - apart)
        return exact // 256 if choice.numbers == "thesis" else exact

    def least(values):
        order = range(len(values) - 1, -1, -1) if choice.last else range(len(values))
        return min(order, key=values.__getitem__)

    labels = range(CONFIG.labels)
    costs = [[[cost(y, x, d) for d in labels] for x in range(width)] for y in range(height)]
    result = np.zeros((height, width), int)
    for y, x in itertools.product(range(height), range(width)):
        energies = [value * scale for value in costs[y][x]]
        for (dy, dx), u in zip(((0, -1), (-1, 0), (1, 0)), CONFIG.rule.weights):
            v, w = y + dy, x + dx
            if 0 <= v < height and 0 <= w < width:
                other = least(costs[v][w]) if dy == 1 else result[v, w]
                apart = abs(int(left[y, x]) - int(left[v, w]))
            elif choice.outside:
                other, apart = 0, 0
            else:
                continue
            energies = [energy + smooth(abs(d - other), apart, u) for d, energy in zip(labels, energies, strict=True)]
        result[y, x] = least(energies)
    return result


# Zeros outside also enter the sub-pixels at the edge of the picture, as in the plain rule above.
@pytest.mark.parametrize("numbers", ["float", "float/256", "floor", "floor/256", "thesis"])
@pytest.mark.parametrize("border", BORDERS)
@pytest.mark.parametrize("outside, last", list(itertools.product((False, True), repeat=2)))
def test_every_reading(numbers, border, outside, last):
    choice = Choice(border=border, numbers=numbers, outside=outside, last=last)
    for seed in (1, 2):
        left, right = pair(seed)
        np.testing.assert_array_equal(disparities(left, right, CONFIG, choice), plain(left, right, choice))


@pytest.mark.parametrize("numbers, settings", [
    ("float", {"arithmetic": "float"}), ("thesis", {"arithmetic": "thesis"}), ("linear", {"arithmetic": "linear"}),
    ("linear q=0", {"arithmetic": "linear", "fraction_bits": 0})])
def test_ours_are_the_matcher(numbers, settings):
    left, right = np.random.default_rng(3).integers(0, 256, (2, 30, 40), dtype=np.uint8)
    expected = match(left, right, MatcherConfig(labels=8, method=OnePass(**settings)))
    np.testing.assert_array_equal(disparities(left, right, MatcherConfig(labels=8), Choice(numbers=numbers)), expected)


def test_all_choices_are_tried_and_each_matters():
    every = list(all_choices())
    assert len(set(every)) == len(every) == len(BORDERS) * len(GREYS) * len(FORMATS) * 4 and every[0] == Choice()
    assert len({str(choice) for choice in every}) == len(every)
    rng = np.random.default_rng(1)
    colours = rng.integers(0, 4, (2, 20, 30, 3), dtype=np.uint8) * 60
    colours[:, 10:] = colours[:, 10:, :, :1]  # few grey levels: ties
    # Over 255 or 256, and what linear does in place of float, is seldom seen.
    alone = [Choice(), *(Choice(border=border) for border in BORDERS[1:]), *(Choice(levels=how) for how in GREYS[1:]),
             *(Choice(numbers=numbers) for numbers in FORMATS[1:] if numbers != "linear" and "/256" not in numbers),
             Choice(outside=True), Choice(last=True)]
    assert set(alone) <= set(every)
    assert len({tuple(disparities(*colours, CONFIG, choice).ravel()) for choice in alone}) == len(alone)


def test_grey():
    rng = np.random.default_rng(1)
    rgb = rng.integers(0, 256, (50, 60, 3), dtype=np.uint8)
    exact = rgb @ np.array([0.2989, 0.587, 0.114])
    np.testing.assert_array_equal(grey_levels(rgb, "floor"), np.floor(np.round(exact, 6)))
    assert np.abs(grey_levels(rgb, "rgb2gray") - exact).max() <= 0.5 + 1e-9
    assert np.abs(grey_levels(rgb, "mean") - rgb.mean(axis=-1)).max() <= 0.5
    for how in GREYS:
        assert grey_levels(rgb, how).dtype == np.uint8
        np.testing.assert_array_equal(grey_levels(rgb[..., 0], how), rgb[..., 0])


def test_borders_agree_inside():
    left, right = pair()
    costs = [bordered_cost(left, right, CONFIG, border) for border in BORDERS]
    for cost in costs:
        assert cost.shape == (9, 14, 5)
        np.testing.assert_array_equal(cost[1:-1, 6:-1], costs[0][1:-1, 6:-1])
    assert (costs[1][:, 0] != costs[2][:, 0]).any() and (costs[0][:, 0, 1:] == CONFIG.matching_cost.outside).all()
