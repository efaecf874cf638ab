"""golden.pictures.metrics on numbers worked by hand."""

import numpy as np
import pytest

from golden.pictures.metrics import bad_pixels


TRUTH = np.array([[3.0, 4.0, 4.25], [np.inf, np.nan, 1.75]])
LABELS = np.array([[3, 3, 3], [3, 3, 3]], dtype=np.uint8)  # errors 0, 1, 1.25, unknown, unknown, 1.25


@pytest.mark.parametrize("threshold, expected", [(1.0, 50), (0.5, 75), (1.25, 0), (0.0, 75)])
def test_threshold(threshold, expected):
    assert bad_pixels(LABELS, TRUTH, np.ones((2, 3), bool), threshold) == expected


def test_threshold_is_one_pixel():
    assert bad_pixels(LABELS, TRUTH, np.ones((2, 3), bool)) == 50


def test_mask():
    mask = np.array([[True, False, True], [True, True, False]])
    assert bad_pixels(LABELS, TRUTH, mask) == 50
    mask[0, 0] = False
    assert bad_pixels(LABELS, TRUTH, mask) == 100


def test_small_numbers_do_not_wrap():
    assert bad_pixels(np.array([[0]], np.uint8), np.array([[255.0]]), np.ones((1, 1), bool)) == 100


@pytest.mark.parametrize("mask, message", [
    (np.zeros((2, 3), bool), "no pixel is both in the mask and of known disparity"),
    (np.array([[False] * 3, [True, True, False]]), "no pixel"),  # only unknown ones
    (np.ones((3, 2), bool), "sizes differ"),
    (np.ones((2, 3), int), "must be bool"),
])
def test_refused(mask, message):
    with pytest.raises(ValueError, match=message):
        bad_pixels(LABELS, TRUTH, mask)
