"""Properties of the steps of the method recursive, for any picture and parameters: fast is plain, mirrors, bounds."""

import dataclasses

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from golden.config import RECURSIVE_1, RECURSIVE_2, GradedArms, LineBelow
from golden.matcher.recursive.arms import graded_arms, graded_arms_plain, support_means, support_means_plain
from golden.matcher.recursive.border_fill import border_fill, border_fill_plain
from golden.matcher.recursive.line_below import line_below, line_below_plain
from golden.matcher.recursive.neighbours import from_above, from_above_plain, from_below, from_below_plain
from golden.matcher.recursive.spread import spread, spread_plain
from golden.matcher.recursive.weighted_median import weighted_median, weighted_median_plain
from tests.golden.strategies import numbers, pictures, sizes


PARAMETERS = st.sampled_from([RECURSIVE_1, RECURSIVE_2])
ARMS = st.builds(lambda near, reach: dataclasses.replace(RECURSIVE_1.arms, near_threshold=near, reach=reach), st.integers(0, 255),
                 st.integers(1, 7))


def same(fast, plain):
    np.testing.assert_array_equal(fast, plain)


@given(pictures((3, 9)), ARMS, st.data())
def test_supports(left, limits, data):
    arms = graded_arms(left, limits)
    same(arms, graded_arms_plain(left, limits))
    mirrored = graded_arms(left[:, ::-1], limits)
    same((mirrored[1][:, ::-1], mirrored[0][:, ::-1]), arms)
    cost = data.draw(numbers((9, 3), 500))
    means = support_means(cost, arms[0][0], arms[1][0])
    same(means, support_means_plain(cost, arms[0][0], arms[1][0]))


@given(pictures((4, 5)), st.builds(LineBelow, st.integers(1, 7), st.integers(0, 7), st.integers(0, 255)), st.data())
def test_line_below(left, parameters, data):
    cost = data.draw(numbers((*left.shape, 3), 100, np.int16))
    same(line_below(cost, left, parameters), line_below_plain(cost, left, parameters))


@given(st.integers(2, 9), PARAMETERS, st.data())
def test_spread(labels, parameters, data):
    cost = data.draw(numbers((3, labels), 500))
    found = spread(cost, parameters.propagation)
    same(found, [spread_plain(line, parameters.propagation) for line in cost.tolist()])
    same(spread(cost[:, ::-1], parameters.propagation), found[:, ::-1])
    same(spread(cost + 7, parameters.propagation), found)      # differences of costs alone
    assert (found >= 0).all() and (found <= cost - cost.min(axis=-1, keepdims=True)).all()


@given(pictures((2, 7)), PARAMETERS, st.data())
def test_neighbours(lines, parameters, data):
    one, other = lines
    carried = data.draw(numbers((7, 4), parameters.propagation.spread_jump))
    above = from_above(carried, one, other, parameters)
    same(above, from_above_plain(carried, one, other, parameters))
    same(from_above(carried[::-1], one[::-1], other[::-1], parameters), above[::-1])
    arms = graded_arms(other[None], GradedArms())
    same(from_below(carried, arms[0][0], arms[1][0], one, other, parameters),
         from_below_plain(carried, arms[0][0], arms[1][0], one, other, parameters))


@given(sizes, st.sampled_from([1, 8]), st.data())
def test_border_fill(shape, scale, data):
    labels, passed = data.draw(numbers(shape, 15 * scale)), data.draw(arrays(bool, shape))
    found = border_fill(labels, passed, 16, scale)
    same(found, border_fill_plain(labels, passed, 16, scale))
    same(found[passed], labels[passed])


@given(sizes, st.data())
def test_weighted_median(shape, data):
    labels, passed, left = data.draw(numbers(shape, 79)), data.draw(arrays(bool, shape)), data.draw(pictures(shape))
    found = weighted_median(labels, passed, left)
    same(found, weighted_median_plain(labels, passed, left))
    assert np.isin(found, labels).all()
