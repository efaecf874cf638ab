"""golden.matcher.matcher: each configuration gets its method."""

import numpy as np

from golden.config import FUSED_1, MatcherConfig, OnePass, changed
from golden.matcher import fused, labelling
from golden.matcher.matcher import disparities
from golden.pictures.scenes import scene


def test_disparities():
    left, right, _ = scene(60, 12, 9, seed=5)
    thesis = MatcherConfig(9, method=OnePass("linear"))
    whole, fine = (MatcherConfig(9, method=changed(FUSED_1, sub_pixel=sub_pixel)) for sub_pixel in (False, True))
    np.testing.assert_array_equal(disparities(left, right, thesis), labelling.match(left, right, thesis))
    np.testing.assert_array_equal(disparities(left, right, whole), fused.match(left, right, whole).disparity)
    np.testing.assert_array_equal(disparities(left, right, fine), fused.match(left, right, fine).disparity / 8)
