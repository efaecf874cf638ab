"""What tests of properties draw: pictures, pairs, labels and configurations, small, with extremes."""

import numpy as np
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from golden.config import Arithmetic, MatcherConfig, OnePass, Weights


__all__ = ["ARITHMETICS", "configs", "labellings", "numbers", "pairs", "pictures", "sizes"]


ARITHMETICS = st.sampled_from(list(Arithmetic))

#: Height and width.
sizes = st.tuples(st.integers(1, 6), st.integers(1, 9))

# Few grey levels make ties, all of them differences.
_LEVELS = st.one_of(st.sampled_from([0, 1, 127, 254, 255]), st.integers(0, 255))


def pictures(shape):
    """Grey levels of a shape."""
    return arrays(np.uint8, shape, elements=_LEVELS)


def numbers(shape, greatest, dtype=np.int64):
    """Whole numbers ``0 .. greatest`` of a shape, few different ones as often as many."""
    return st.one_of(*(arrays(dtype, shape, elements=st.integers(0, limit)) for limit in {min(3, greatest), greatest}))


@st.composite
def pairs(draw, least=(1, 1)):
    """Left and right picture; the right one is the left one moved, or has nothing to do with it."""
    height, width = (max(*each) for each in zip(draw(sizes), least))
    left = draw(pictures((height, width)))
    if draw(st.booleans()):
        return left, draw(pictures((height, width)))
    return left, np.roll(left, -draw(st.integers(0, 3)), axis=1)


_MINIMUMS = st.integers(-3, 3)


@st.composite
def configs(draw, minimums=_MINIMUMS, arithmetics=ARITHMETICS):
    """Configurations of the thesis's method."""
    weights = Weights(*(draw(st.integers(0, 63)) for _ in Weights._fields))
    arithmetic = draw(arithmetics)
    bits = {"fraction_bits": draw(st.integers(0, 4))} if arithmetic is Arithmetic.LINEAR else {}
    return MatcherConfig(draw(st.integers(2, 9)), 16, draw(minimums), method=OnePass(arithmetic, weights=weights, **bits))


@st.composite
def labellings(draw, arithmetics=ARITHMETICS):
    """A configuration, costs, labels and a left picture that go together."""
    config = draw(configs(st.just(0), arithmetics))
    shape = draw(sizes)
    cost = draw(numbers((*shape, config.labels), config.rule.data_max))
    cost = cost.astype(float if config.method.arithmetic is Arithmetic.FLOAT else int)
    labels = draw(arrays(np.int64, shape, elements=st.integers(0, config.labels - 1)))
    return config, cost, labels, draw(pictures(shape))
