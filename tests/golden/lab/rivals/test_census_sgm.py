"""golden.lab.rivals.census_sgm: against its definition pixel by pixel, and on pictures whose answer is known."""

import functools

import numpy as np
import pytest

from golden.lab.rivals import census_sgm
from golden.matcher.census import census_plain
from golden.matcher.refine import fill_plain, median_plain
from golden.pictures.scenes import layers


WAYS = [(dy, dx) for dy in (-1, 0, 1) for dx in (-1, 0, 1) if (dy, dx) != (0, 0)]


def path_sums_plain(cost, grey):
    """The sums of the eight paths, pixel by pixel, by recursion."""
    height, width, labels = cost.shape

    @functools.cache
    def path(y, x, dy, dx):
        own, y_before, x_before = cost[y, x].tolist(), y - dy, x - dx
        if not (0 <= y_before < height and 0 <= x_before < width):
            return own
        before = path(y_before, x_before, dy, dx)
        p2 = max(640 // (8 + abs(int(grey[y, x]) - int(grey[y_before, x_before]))), 16)
        least = min(before)
        return [own[d] - least + min(before[d], *(before[e] + 16 for e in (d - 1, d + 1) if 0 <= e < labels), least + p2)
                for d in range(labels)]

    return np.array([[np.sum([path(y, x, *way) for way in WAYS], axis=0) for x in range(width)] for y in range(height)])


@pytest.mark.parametrize("height, width, labels", [(6, 9, 5), (9, 4, 6), (1, 7, 3), (7, 1, 2), (1, 1, 2), (2, 2, 9)])
def test_path_sums(height, width, labels):
    rng = np.random.default_rng(height)
    # Costs far apart, so that both penalties matter, and grey levels with small and large steps.
    cost = rng.choice([0, 3, 14, 17, 30, 90, 200], (height, width, labels)).astype(np.uint16)
    grey = rng.choice([0, 3, 9, 40, 255], (height, width)).astype(np.uint8)
    before = cost.copy()
    assert (census_sgm.path_sums(cost, grey) == path_sums_plain(cost, grey)).all()
    assert (cost == before).all()


def test_costs():
    left, right = np.random.default_rng(1).integers(0, 256, (2, 6, 8), dtype=np.uint8)
    here, there = census_plain(left).tolist(), census_plain(right).tolist()
    found = census_sgm.costs(left, right, 11)
    for y, x, d in np.ndindex(6, 8, 11):
        assert found[y, x, d] == ((here[y][x] ^ there[y][x - d]).bit_count() if d <= x else census_sgm.COST_OUTSIDE)


def test_disparities():
    """The least sums, checked against the right view of the same sums, filled, smoothed."""
    left, right, *_ = layers(40, 16, 8, seed=5, noise=2.0)
    sums = path_sums_plain(census_sgm.costs(left, right, 8), left)
    labels = sums.argmin(axis=-1)
    passed = np.zeros(labels.shape, bool)
    for y, x in np.ndindex(labels.shape):
        there = x - labels[y, x]
        if there >= 0:
            candidates = [(sums[y, there + d, d], d) for d in range(8) if there + d < 40]
            passed[y, x] = abs(min(candidates)[1] - labels[y, x]) <= 1
    expected = median_plain(fill_plain(labels, passed), 3)
    assert (census_sgm.disparities(left, right, 8) == expected).all() and 0 < passed.mean() < 1


def test_untextured_surfaces_take_the_label_of_what_is_around():
    """Where the costs of all labels are equal, the paths from textured surroundings decide."""
    right = np.random.default_rng(4).integers(0, 256, (40, 70), dtype=np.uint8)
    right[12:28, 25:45] = 100
    left = np.roll(right, 5, axis=1)
    assert (census_sgm.costs(left, right, 12)[15:25, 40:42] == 0).all()
    assert (census_sgm.disparities(left, right, 12)[:, 12:] == 5).all()
