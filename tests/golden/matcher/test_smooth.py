"""golden.matcher.smooth on numbers worked by hand."""

import numpy as np
import pytest

from golden.config import MatcherConfig, OnePass
from golden.matcher.smooth import slope, smooth


@pytest.mark.parametrize("arithmetic, fraction_bits, expected", [
    ("float", 3, [3825, 2325, 0]),    # 15 * (255 - dI)
    ("thesis", 3, [3840, 2340, 15]),  # 15 * (256 - dI)
    ("linear", 3, [240, 146, 0]),     # 30 * (256 - dI) * 8 / 256, floor: 146.25, 0.94
    ("linear", 0, [30, 18, 0]),       # 18.28, 0.12
    ("linear", 4, [480, 292, 1]),     # 292.5, 1.88
])
def test_slope(arithmetic, fraction_bits, expected):
    config = MatcherConfig(method=OnePass(arithmetic, fraction_bits))
    assert slope(np.array([0, 100, 255], dtype=np.uint8), 15, config).tolist() == expected


@pytest.mark.parametrize("arithmetic, expected", [
    ("float", [0, 2325, 4650, 6975]),
    ("thesis", [0, 9, 18, 27]),       # 9.14, 18.28, 27.42: floor after the product
    ("linear", [0, 146, 292, 438]),   # floor before it
])
def test_smooth(arithmetic, expected):
    assert smooth(np.arange(4), 100, 15, MatcherConfig(method=OnePass(arithmetic))).tolist() == expected


def test_thesis_floors_after_the_product():
    # 15 * k / 256 reaches 1 at k = 18; a slope floored first would never.
    assert smooth(np.array([17, 18, 127]), 255, 15, MatcherConfig()).tolist() == [0, 1, 7]


def test_widest():
    config = MatcherConfig(labels=128, method=OnePass("linear", 4))
    assert smooth(np.array(127), 0, 63, config) == config.smooth_max == 2 * 63 * 16 * 127
