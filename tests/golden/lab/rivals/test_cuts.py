"""golden.lab.rivals.cuts: moves against all labellings of tiny pictures; energies never rise."""

import itertools

import numpy as np
import pytest

from golden.config import FUSED_1, Arithmetic, MatcherConfig, OnePass
from golden.lab.rivals import cuts
from golden.matcher.cost import local_disparity, matching_cost
from golden.matcher.energy import energy as energy_of_golden
from golden.matcher.labelling import match
from golden.pictures.scenes import layers


pytest.importorskip("maxflow", reason="maxflow, of the extra lab, is not installed")

SHAPE, LABELS = (2, 4), 3


def tiny(seed, metric):
    """A random energy of eight pixels."""
    rng = np.random.default_rng(seed)
    height, width = SHAPE
    label = np.arange(LABELS)
    distance = {"potts": 1 - np.eye(LABELS, dtype=int), "linear": np.abs(label - label[:, None])}[metric]
    return cuts.GridEnergy(rng.integers(-20, 30, (*SHAPE, LABELS)), rng.integers(0, 15, (height, width - 1)),
                           rng.integers(0, 15, (height - 1, width)), distance)


def labellings(choices):
    """All pictures whose pixels take one of their choices."""
    for values in itertools.product(*choices):
        yield np.array(values).reshape(SHAPE)


def by_hand(energy, labels):
    """The energy, pixel by pixel."""
    total = 0
    for y, x in np.ndindex(SHAPE):
        total += energy.data[y, x, labels[y, x]]
        if x + 1 < SHAPE[1]:
            total += energy.horizontal[y, x] * energy.distance[labels[y, x], labels[y, x + 1]]
        if y + 1 < SHAPE[0]:
            total += energy.vertical[y, x] * energy.distance[labels[y, x], labels[y + 1, x]]
    return total


CASES = [(seed, metric) for seed in range(6) for metric in ("potts", "linear")]


@pytest.mark.parametrize("seed, metric", CASES)
def test_moves_are_the_best_of_their_kind(seed, metric):
    energy = tiny(seed, metric)
    labels = np.random.default_rng(seed + 100).integers(0, LABELS, SHAPE)
    assert energy(labels) == by_hand(energy, labels)
    for alpha in range(LABELS):
        moved = cuts.expand(energy, labels, alpha)
        assert ((moved == labels) | (moved == alpha)).all()
        assert energy(moved) == min(map(energy, labellings([{label, alpha} for label in labels.flat])))
    for alpha, beta in itertools.combinations(range(LABELS), 2):
        moved = cuts.swap(energy, labels, alpha, beta)
        pair, either = {alpha, beta}, np.isin(labels, [alpha, beta])
        assert energy(moved) == min(map(energy, labellings([pair if label in pair else {label} for label in labels.flat])))
        assert np.isin(moved[either], [alpha, beta]).all() and (moved[~either] == labels[~either]).all()


@pytest.mark.parametrize("method, moves", [(cuts.alpha_expansion, LABELS), (cuts.alpha_beta_swap, 3)])
@pytest.mark.parametrize("seed, metric", CASES)
def test_search(method, moves, seed, metric):
    energy = tiny(seed, metric)
    start = np.zeros(SHAPE, dtype=int)
    seen = []
    found = method(energy, start, 5, lambda number, least: seen.append((number, least)))
    numbers, values = zip(*seen)
    assert list(numbers) == list(range(1, len(seen) + 1))
    assert list(values) == sorted(values, reverse=True) and values[0] <= energy(start)
    assert energy(found) == values[-1]
    # It ended as soon as each of the other moves had been tried in vain after the last that was not.
    assert len(seen) < 5 * moves
    assert values[-moves] == values[-1] and (len(seen) == moves or values[-moves] < values[-moves - 1])
    move, count = (cuts.expand, 1) if method is cuts.alpha_expansion else (cuts.swap, 2)
    assert all(energy(move(energy, found, *labels)) == energy(found) for labels in itertools.combinations(range(LABELS), count))


def test_cycles_limit_the_search():
    energy = tiny(1, "potts")
    for method, moves in ((cuts.alpha_expansion, LABELS), (cuts.alpha_beta_swap, 3)):
        seen = []
        method(energy, np.argmin(energy.data, axis=-1), 1, lambda *state: seen.append(state))
        assert len(seen) == moves


def test_swap_of_absent_labels_changes_nothing():
    labels = np.full(SHAPE, 2)
    assert (cuts.swap(tiny(1, "potts"), labels, 0, 1) == labels).all()


def test_potts_energy():
    left = np.array([[10, 18, 27], [10, 18, 27]], dtype=np.uint8)
    right = np.array([[10, 60, 27], [10, 18, 27]], dtype=np.uint8)
    energy = cuts.potts_energy(left, right, 2)
    assert energy.data.tolist() == [[[0, 20], [20, 8], [0, 20]], [[0, 20], [0, 8], [0, 9]]]
    assert energy.distance.tolist() == [[0, 1], [1, 0]]
    smooth, edge = cuts.PENALTY * cuts.SMOOTHNESS, cuts.SMOOTHNESS
    assert energy.horizontal.tolist() == [[smooth, edge]] * 2  # steps of 8 and of 9 grey levels
    assert energy.vertical.tolist() == [[smooth] * 3]


@pytest.fixture(scope="module")
def scene():
    left, right, *_ = layers(40, 24, 9, seed=2)
    return left, right, MatcherConfig(labels=9, method=OnePass(Arithmetic.LINEAR))


def test_thesis_energy_is_golden(scene):
    left, right, config = scene
    cost = matching_cost(left, right, config)
    energy = cuts.thesis_energy(cost, left, config)
    for labels in (match(left, right, config), local_disparity(cost), np.random.default_rng(1).integers(0, 9, left.shape)):
        assert energy(labels) == energy_of_golden(labels, cost, left, config)


def test_expansions_never_end_above_the_one_pass_labels(scene):
    left, right, config = scene
    cost = matching_cost(left, right, config)
    seen = []
    found = cuts.improved(left, right, 9, lambda number, least: seen.append(least))
    start = energy_of_golden(match(left, right, config), cost, left, config)
    assert seen == sorted(seen, reverse=True) and seen[0] <= start
    assert energy_of_golden(found, cost, left, config) == seen[-1] < start


@pytest.mark.parametrize("method, search", [(cuts.potts_expansion, cuts.alpha_expansion), (cuts.potts_swap, cuts.alpha_beta_swap)])
def test_methods_search_the_potts_energy(scene, method, search):
    left, right, _ = scene
    energy = cuts.potts_energy(left, right, 9)
    ran, expected = [], []
    found = method(left, right, 9, lambda *state: ran.append(state))
    assert (found == search(energy, np.argmin(energy.data, axis=-1), advance=lambda *state: expected.append(state))).all()
    assert ran == expected and len(ran) > 9


@pytest.mark.parametrize("config", [
    MatcherConfig(labels=9, method=OnePass(Arithmetic.THESIS)), MatcherConfig(labels=9, method=OnePass(Arithmetic.FLOAT)),
    MatcherConfig(labels=9, method=FUSED_1)])
def test_other_energies_are_refused(scene, config):
    left, right, linear = scene
    with pytest.raises(ValueError, match=r"linear|the method must be thesis, not fused"):
        cuts.thesis_energy(matching_cost(left, right, linear), left, config)
