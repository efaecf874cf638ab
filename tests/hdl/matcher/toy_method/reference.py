"""The toy method's golden model."""

import numpy as np

from golden.config import PIXEL_MAX
from golden.matcher.cost import local_disparity, outside, sub_pixel_buffers
from golden.matcher.labelling import labelling
from golden.matcher.matcher import MATCHERS

from .parameters import Toy


def match(left, right, config):
    """Fields of the result, as :func:`golden.matcher.matcher.match` gives them."""
    left, right = np.asarray(left, dtype=np.int16), np.asarray(right, dtype=np.int16)
    cost = np.array([np.abs(line[:, None] - sub_pixel_buffers(other, config.labels)) for line, other in zip(left, right)])
    cost[:, outside(left.shape[1], config)] = PIXEL_MAX
    return {"disparity": labelling(cost, local_disparity(cost), left, config)}


MATCHERS[Toy] = match
