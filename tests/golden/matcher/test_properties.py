"""Properties of the disparity rule and its stages, for any picture and parameters: fast is plain, ties, energies, mirrors, transposes."""

import numpy as np
from hypothesis import given
from hypothesis import strategies as st
from hypothesis.extra.numpy import arrays

from golden.config import FUSED_1, FUSED_2, Arithmetic, Arms, Fused, FusedCost, MatcherConfig, OnePass, Vertical, Weights
from golden.matcher import fused, labelling, refine, support
from golden.matcher.argmin import comparator_tree
from golden.matcher.census import census, census_plain, hamming
from golden.matcher.confidence import confidence, confidence_plain
from golden.matcher.cost import local_disparity, matching_cost
from golden.matcher.energy import energy
from golden.matcher.smooth import smooth
from golden.matcher.sub_pixel import fraction, fraction_plain
from golden.matcher.vertical import vertical_support, vertical_support_plain
from tests.golden.strategies import ARITHMETICS, configs, labellings, numbers, pairs, pictures, sizes


ARMS = st.builds(Arms, st.integers(0, 255), st.integers(0, 7))
CENSUS = st.builds(FusedCost, census_rows=st.sampled_from([3, 5]), census_columns=st.sampled_from([3, 5, 7]))


def same(fast, plain):
    np.testing.assert_array_equal(fast, plain)


def transposed(array):
    return np.swapaxes(array, 0, 1)


# ---- fast against plain

@given(pairs(), configs())
def test_one_pass_is_plain(pair, config):
    same(labelling.match(*pair, config), labelling.match_plain(*pair, config))


@given(pictures((4, 7)), CENSUS)
def test_census_is_plain(picture, cost):
    same(census(picture, cost), census_plain(picture, cost))


@given(pictures((3, 9)), ARMS, st.integers(1, 4), st.data())
def test_supports_are_plain(left, limits, labels, data):
    arms = support.arms(left, limits)
    same(arms, support.arms_plain(left, limits))
    cost = data.draw(numbers((*left.shape, labels), 255, np.uint8))
    same(support.support_sums(cost, *arms), support.support_sums_plain(cost, *arms))


@given(pictures((5, 4)), st.builds(Vertical, st.just(1), st.integers(0, 255)), st.data())
def test_vertical_support_is_plain(left, vertical, data):
    cost = data.draw(numbers((*left.shape, 3), 63, np.uint8))
    same(vertical_support(cost, left, vertical), vertical_support_plain(cost, left, vertical))


@given(pictures((4, 6)), st.integers(2, 7), st.builds(Weights, *[st.integers(0, 63)] * 3), st.data())
def test_rule_on_sums_is_plain(left, labels, weights, data):
    config = MatcherConfig(labels, 16, method=Fused(weights=weights))
    sums = data.draw(numbers((*left.shape, labels), config.rule.data_max, np.int16))
    size = data.draw(arrays(np.int64, left.shape, elements=st.integers(1, 33)))
    same(fused.labelling(sums, size, left, config), fused.labelling_plain(sums, size, left, config))


@given(st.integers(2, 6), st.integers(-3, 4), sizes, st.data())
def test_check_of_both_views_is_plain(labels, minimum, shape, data):
    config = MatcherConfig(labels, 16, minimum, method=FUSED_1)
    cost = data.draw(numbers((*shape, labels), 138, np.uint8))
    right = refine.right_view(cost, config)
    same(right, refine.right_view_plain(cost, config))
    found = data.draw(numbers(shape, labels - 1))
    same(refine.check(found, right, config), refine.check_plain(found, right, config))


@given(sizes, st.sampled_from([3, 5]), st.data())
def test_refinement_is_plain(shape, size, data):
    labels, passed = data.draw(numbers(shape, 79)), data.draw(arrays(bool, shape))
    same(refine.fill(labels, passed), refine.fill_plain(labels, passed))
    same(refine.median(labels, size), refine.median_plain(labels, size))


@given(sizes, st.sampled_from([1, 8]), st.data())
def test_confidence_is_plain(shape, scale, data):
    disparity, filled = (data.draw(numbers(shape, 79 * scale)) for _ in range(2))
    given_ = disparity, filled, data.draw(arrays(bool, shape)), data.draw(arrays(np.int64, shape, elements=st.integers(1, 33)))
    same(confidence(*given_, scale), confidence_plain(*given_, scale))


@given(st.integers(0, 5000), st.integers(0, 5000), st.integers(0, 5000))
def test_fraction_is_plain(centre, left, right):
    values = [np.array([centre + left]), np.array([centre]), np.array([centre + right])]
    found = fraction(*values).item()
    assert found == fraction_plain(*(each.item() for each in values)) and -4 <= found <= 4


# ---- the transition of a pixel

@given(st.integers(2, 12), st.integers(0, 5000), st.data())
def test_transition_is_monotone_and_idempotent(labels, slope, data):
    energies = data.draw(numbers((labels,), 100_000))
    found = labelling.transition(energies, slope)
    assert (np.diff(found) >= 0).all()
    same(found[found], found)
    # A label that leads to itself is the end of every label between it and its origin, so those that do are all results.
    same(np.unique(found), np.flatnonzero(found == np.arange(labels)))


# The thesis's arithmetic floors after the product, so that its terms are no slope times a distance.
@given(labellings(ARITHMETICS.filter(lambda each: each is not Arithmetic.THESIS)))
def test_rule_follows_transitions(drawn):
    """Line by line: the label of a pixel is the transition, of its energies without the left neighbour, at that neighbour's label."""
    config, cost, local, left = drawn
    found = labelling.labelling(cost, local, left, config)
    weights = labelling.slopes(left, config)
    label = np.arange(config.labels)
    for y, x in np.ndindex(*local.shape):
        own = cost[y, x] * config.rule.energy_scale
        if y:
            own = own + weights[1, y, x] * np.abs(label - found[y - 1, x])
        if y + 1 < len(local):
            own = own + weights[2, y, x] * np.abs(label - local[y + 1, x])
        step = labelling.transition(own, weights[0, y, x])
        assert found[y, x] == step[found[y, x - 1] if x else 0]


# ---- ties

@given(numbers((3, 7), 5))
def test_smallest_index_wins_a_tie(values):
    least, index = comparator_tree(values)
    for row, value, at in zip(values.tolist(), least, index, strict=True):
        assert value == min(row) and at == row.index(min(row))
    same(local_disparity(values), index)


@given(labellings())
def test_smallest_label_wins_a_tie(drawn):
    """Of the energies that the rule compares, the label of each pixel has the least, and all smaller labels have more."""
    config, cost, local, left = drawn
    found = labelling.labelling(cost, local, left, config)
    label, grey = np.arange(config.labels), left.astype(int)
    for y, x in np.ndindex(*local.shape):
        terms = [0, 0, 0]
        for number, (inside, neighbour, of) in enumerate((
                (x > 0, (y, x - 1), found), (y > 0, (y - 1, x), found), (y + 1 < len(local), (y + 1, x), local))):
            if inside:
                difference = abs(grey[y, x] - grey[neighbour])
                terms[number] = smooth(np.abs(label - of[neighbour]), difference, config.rule.weights[number], config)
        energies = labelling.cost_summation(cost[y, x], *terms, config).tolist()
        assert found[y, x] == energies.index(min(energies))


@given(labellings(), st.data())
def test_rule_sees_differences_of_costs_only(drawn, data):
    """What is added to the costs of all labels of a pixel changes no label: ties stay ties."""
    config, cost, local, left = drawn
    more = data.draw(numbers(local.shape, 50)).astype(cost.dtype)
    same(labelling.labelling(cost + more[..., None], local, left, config), labelling.labelling(cost, local, left, config))


# ---- energies

@given(labellings())
def test_energy_is_the_sum_of_its_terms(drawn):
    config, cost, labels, left = drawn
    grey, weights = left.astype(int), config.rule.weights
    total = sum(cost[y, x, labels[y, x]].item() * config.rule.energy_scale for y, x in np.ndindex(*labels.shape))
    for y, x in np.ndindex(*labels.shape):
        for weight, neighbour in ((weights.u1, (y, x - 1)), (weights.u2, (y - 1, x)), (weights.u3, (y + 1, x))):
            if min(neighbour) >= 0 and neighbour[0] < len(labels):
                distance = abs(labels[y, x] - labels[neighbour])
                total += smooth(distance, np.array(abs(grey[y, x] - grey[neighbour])), weight, config).item()
    assert energy(labels, cost, left, config) == total


@given(labellings())
def test_energy_of_one_label_is_its_cost(drawn):
    config, cost, labels, left = drawn
    one = np.full_like(labels, labels.flat[0])
    assert energy(one, cost, left, config) == cost[..., labels.flat[0]].sum().item() * config.rule.energy_scale
    assert energy(labels, cost, left, config) >= cost.min(axis=-1).sum().item() * config.rule.energy_scale


# ---- mirrors and transposition

@given(labellings())
def test_energy_of_the_mirror_image(drawn):
    config, cost, labels, left = drawn
    assert energy(labels[:, ::-1], cost[:, ::-1], left[:, ::-1], config) == energy(labels, cost, left, config)


@given(labellings(arithmetics=st.just(Arithmetic.FLOAT)), st.integers(0, 63), st.integers(0, 63))
def test_energy_of_the_transpose(drawn, u2, u3):
    """A pair of neighbours in a line counts once with ``u1``, one in a column with ``u2`` and with ``u3``."""
    config, cost, labels, left = drawn
    u1 = min(63, u2 + u3)
    method = OnePass(Arithmetic.FLOAT, weights=Weights(u1, min(u2, u1), u1 - min(u2, u1)))
    config = MatcherConfig(config.labels, 16, method=method)
    assert energy(labels.T, transposed(cost), left.T, config) == energy(labels, cost, left, config)


@given(labellings())
def test_scan_of_the_transpose(drawn):
    """The left neighbour becomes the upper one; the lower one would become the right one, which has no weight."""
    config, cost, local, left = drawn
    weights = labelling.slopes(left, config)
    weights[2] = 0
    shift = 8 if config.method.arithmetic is Arithmetic.THESIS else 0
    found = labelling.scan(cost, local, weights, config.rule.energy_scale, shift)
    turned = np.stack([weights[1].T, weights[0].T, weights[2].T])
    same(labelling.scan(transposed(cost), local.T, turned, config.rule.energy_scale, shift), found.T)


@given(pairs(), configs(st.just(0)))
def test_cost_upside_down(pair, config):
    left, right = pair
    same(matching_cost(left[::-1], right[::-1], config), matching_cost(left, right, config)[::-1])


@given(pairs(least=(1, 5)), configs(st.just(0)))
def test_cost_of_the_exchanged_mirror_images(pair, config):
    """Pixel ``x`` of the left picture and ``x - d`` of the right one exchange their places; away from the edges, which are replicated."""
    left, right = pair
    width = left.shape[1]
    cost, other = matching_cost(left, right, config), matching_cost(right[:, ::-1], left[:, ::-1], config)
    for d in range(config.labels):
        for x in range(d + 1, width - 1):
            same(other[:, width - 1 - (x - d), d], cost[:, x, d])


@given(pairs(), CENSUS)
def test_hamming_distance_of_mirror_images(pair, cost):
    left, right = pair
    distance = hamming(census(left, cost), census(right, cost))
    same(hamming(census(left[:, ::-1], cost), census(right[:, ::-1], cost)), distance[:, ::-1])
    same(hamming(census(right, cost), census(left, cost)), distance)


@given(pictures((3, 9)), ARMS, st.data())
def test_supports_of_the_mirror_image(left, limits, data):
    left_arm, right_arm = support.arms(left, limits)
    mirrored = support.arms(left[:, ::-1], limits)
    same(mirrored[0][:, ::-1], right_arm)
    same(mirrored[1][:, ::-1], left_arm)
    cost = data.draw(numbers((*left.shape, 2), 255, np.uint8))
    same(support.support_sums(cost[:, ::-1], *mirrored)[:, ::-1], support.support_sums(cost, left_arm, right_arm))


@given(pictures((5, 4)), st.data())
def test_vertical_support_upside_down(left, data):
    cost = data.draw(numbers((*left.shape, 3), 63, np.uint8))
    same(vertical_support(cost[::-1], left[::-1], FUSED_2.vertical), vertical_support(cost, left, FUSED_2.vertical)[::-1])


@given(sizes, st.sampled_from([3, 5]), st.data())
def test_refinement_of_turned_labels(shape, size, data):
    labels, passed = data.draw(numbers(shape, 79)), data.draw(arrays(bool, shape))
    filled, result = refine.fill(labels, passed), refine.median(labels, size)
    same(refine.fill(labels[:, ::-1], passed[:, ::-1]), filled[:, ::-1])
    same(refine.fill(filled, passed), filled)       # what is filled stays
    for turn in (np.transpose, np.fliplr, np.flipud):
        same(refine.median(turn(labels), size), turn(result))
    same(refine.median(79 - labels, size), 79 - result)


@given(pictures((3, 8)), configs(st.just(0)))
def test_equal_pictures_have_no_parallax(left, config):
    cost = matching_cost(left, left, config)
    assert (cost[..., 0] == 0).all() and (local_disparity(cost) == 0).all() and (labelling.match(left, left, config) == 0).all()
