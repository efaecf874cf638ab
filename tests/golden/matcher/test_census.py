"""golden.matcher.census: bits and distances worked by hand, and fast against plain."""

import numpy as np
import pytest

from golden.config import FUSED_1, FusedCost
from golden.matcher.census import census, census_plain, hamming


def test_bit_order():
    # One dark pixel, in the middle of a flat picture: it is the neighbour number b of one pixel for each b.
    picture = np.full((9, 13), 7, np.uint8)
    picture[4, 6] = 6
    bits = census(picture)
    # In reading order without the centre; the upper left neighbour is bit 0. Seen from (y, x) the dark pixel is at (4 - y, 6 - x).
    for y, x, bit in ((6, 9, 0), (6, 8, 1), (6, 3, 6), (5, 9, 7), (4, 7, 16), (4, 5, 17), (2, 3, 33)):
        assert bits[y, x] == 1 << bit
    assert bits[4, 6] == 0  # nothing is darker than the dark one
    assert np.count_nonzero(bits) == 34


def test_darker_is_strict():
    assert census(np.array([[4, 5, 5, 6]]), FusedCost(census_rows=1, census_columns=3)).tolist() == [[0, 0b01, 0, 0b01]]


def test_outside_repeats_the_edge():
    # Down a column of three: the window's five rows see 1 1 1 2 3, 1 1 2 3 3, 1 2 3 3 3.
    column = census(np.array([[1], [2], [3]]), FusedCost(census_columns=1))
    assert column.tolist() == [[0], [0b0011], [0b0011]]


def test_default_has_34_bits():
    assert FUSED_1.cost.neighbours == 34
    picture = np.zeros((5, 7), np.uint8)
    picture[2, 3] = 255
    assert int(census(picture)[2, 3]) == 2**34 - 1


@pytest.mark.parametrize("rows, columns", [(5, 7), (1, 1), (3, 5), (7, 9)])
@pytest.mark.parametrize("width, height", [(1, 1), (2, 7), (13, 6)])
def test_fast_equals_plain(rows, columns, width, height):
    cost = FusedCost(census_rows=rows, census_columns=columns, census_weight=1)
    picture = np.random.default_rng(1).integers(0, 5, (height, width), dtype=np.uint8)  # few levels: ties are frequent
    fast = census(picture, cost)
    assert fast.dtype == np.uint64
    np.testing.assert_array_equal(fast, census_plain(picture, cost))


def test_hamming():
    left, right = np.array([0, 2**34 - 1, 2**34 - 1, 0b101], np.uint64), np.array([0, 0, 1 << 33, 0b011], np.uint64)
    assert hamming(left, right).tolist() == [0, 34, 33, 2]
