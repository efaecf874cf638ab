"""golden.lab.rivals.maxflow: the cut of a line against all its labellings, and a line's energy against the rule's."""

import itertools

import numpy as np
import pytest

from golden.config import FUSED_1, Arithmetic, MatcherConfig, OnePass
from golden.lab.rivals import gaps as gaps_command
from golden.lab.rivals import maxflow
from golden.matcher.cost import local_disparity, matching_cost
from golden.matcher.labelling import labelling, slopes
from golden.pictures.dataset import StereoPair
from golden.pictures.scenes import layers


SOLVERS = {"augmenting_path": "maxflow", "push_relabel": "ortools"}


@pytest.fixture(params=SOLVERS)
def solver(request):
    module = SOLVERS[request.param]
    pytest.importorskip(module, reason=f"{module}, of the extra lab, is not installed")
    return getattr(maxflow, request.param)


def brute_force(data, weight):
    """The least energy of a line, by trying all labels."""
    width, labels = data.shape
    return min(sum(data[x, d] for x, d in enumerate(line)) + sum(w * abs(a - b) for w, a, b in zip(weight, line, line[1:]))
               for line in itertools.product(range(labels), repeat=width))


@pytest.mark.parametrize("width, labels", [(1, 2), (1, 4), (6, 2), (5, 3), (5, 4), (3, 7)])
def test_cut_is_the_least_energy(solver, width, labels):
    rng = np.random.default_rng(width * 10 + labels)
    for _ in range(20):
        data, weight = rng.integers(0, 30, (width, labels)), rng.integers(0, 12, width - 1)
        flow, source = solver(maxflow.line_graph(data, weight))
        found = maxflow.cut_labels(source)
        assert source.shape == (width, labels - 1)
        assert flow == brute_force(data, weight) == maxflow.line_energy(found, data, weight)
        # A row is cut once: the source's side is its first vertices.
        assert (source == (np.arange(labels - 1) < found[:, None])).all()


def test_rows_are_cut_once(solver):
    # Cheap t-links at both ends of a row, and neighbours that pull it both ways: two of them would be no cheaper.
    rng = np.random.default_rng(5)
    for _ in range(200):
        data, weight = rng.choice([0, 1, 2, 50], (6, 5)), rng.choice([0, 1, 3, 20], 5)
        flow, source = solver(maxflow.line_graph(data, weight))
        found = maxflow.cut_labels(source)
        assert (source == (np.arange(4) < found[:, None])).all() and flow == maxflow.line_energy(found, data, weight)


def picture(height=12):
    left, right, truth, visible = layers(40, height, 9, seed=2)
    return StereoPair("scene", left, right, truth.astype(float), {"all": visible}, 9)


def line_of(pair):
    """What :func:`golden.lab.rivals.maxflow.line_terms` starts from."""
    config = MatcherConfig(labels=9, method=OnePass(Arithmetic.LINEAR))
    cost = matching_cost(pair.left, pair.right, config)
    local = local_disparity(cost)
    return cost, pair.left, labelling(cost, local, pair.left, config), local, config


@pytest.fixture(scope="module")
def line():
    return line_of(picture(8))


@pytest.mark.parametrize("y", [0, 3, 7])
def test_terms_are_the_rules(line, y):
    cost, left, labels, local, config = line
    data, weight = maxflow.line_terms(cost, left, labels, local, y, config)
    w1, w2, w3 = slopes(left, config)[:, y]
    assert weight.tolist() == w1[1:].tolist()
    for x in range(40):
        for d in range(9):
            expected = 8 * int(cost[y, x, d])
            expected += w2[x] * abs(d - labels[y - 1, x]) if y > 0 else 0
            expected += w3[x] * abs(d - local[y + 1, x]) if y < 7 else 0
            assert data[x, d] == expected
        # The rule itself: the label that is least given the one before.
        step = data[x] + (weight[x - 1] * np.abs(np.arange(9) - labels[y, x - 1]) if x else 0)
        assert np.argmin(step) == labels[y, x]


def test_other_energies_are_refused(line):
    cost, left, labels, local, _ = line
    for config in (MatcherConfig(labels=9, method=OnePass("thesis")), MatcherConfig(labels=9, method=FUSED_1)):
        with pytest.raises(ValueError, match=r"linear|the method must be thesis, not fused"):
            maxflow.line_terms(cost, left, labels, local, 1, config)


@pytest.fixture
def solvers():
    for module in SOLVERS.values():
        pytest.importorskip(module, reason=f"{module}, of the extra lab, is not installed")


def test_gaps(solvers):
    calls = []
    result = gaps_command.gaps(picture(), 5, lambda: calls.append(1))
    assert len(result) == len(calls) == 3  # lines 0, 5, 10
    assert all(gap.rule >= gap.least for gap in result) and any(gap.rule > gap.least for gap in result)
    cost, left, labels, local, config = line_of(picture())
    for y, gap in zip((0, 5, 10), result):
        terms = maxflow.line_terms(cost, left, labels, local, y, config)
        found = maxflow.cut_labels(maxflow.augmenting_path(maxflow.line_graph(*terms))[1])
        assert gap.differ == np.mean(found != labels[y])
        assert (gap.rule, gap.least) == (maxflow.line_energy(labels[y], *terms), maxflow.line_energy(found, *terms))
    assert gaps_command.gaps(picture())[5].rule == result[1].rule


def test_gap_percent():
    def gap(rule, least):
        return gaps_command.LineGap(rule, least, 0.0, (0.0, 0.0)).percent

    assert (gap(110, 100), gap(100, 100), gap(0, 0), gap(1, 0)) == (10, 0, 0, float("inf"))


def test_flows_that_disagree_are_reported(solvers, monkeypatch):
    def wrong(graph):
        flow, side = maxflow.push_relabel(graph)
        return flow - 1, side

    monkeypatch.setattr(gaps_command, "push_relabel", wrong)
    with pytest.raises(ArithmeticError, match="line 0 of scene"):
        gaps_command.gaps(picture())
