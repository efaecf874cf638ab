"""golden.lab.rivals: scanline dynamic programming, windows, OpenCV and the registry; each on scenes whose answer is known."""

import itertools
import pathlib
import subprocess
import sys

import numpy as np
import pytest

from golden.config import Arithmetic, MatcherConfig, OnePass
from golden.lab.published import TABLE_1
from golden.lab.rivals import cuts, opencv, scanline, ssd
from golden.lab.rivals.differences import absolute_differences, outside_candidates
from golden.lab.rivals.registry import COMPARED, METHODS, measure
from golden.matcher.matcher import disparities as match
from golden.matcher.parameters import NAMED
from golden.matcher.refine import fill_plain
from golden.pictures.dataset import PAIRS
from golden.pictures.metrics import bad_pixels
from golden.pictures.scenes import layers
from tests.kit import middlebury, training_sets


def needs(name):
    return pytest.importorskip(name, reason=f"{name}, of the extra lab, is not installed")


@pytest.fixture(scope="module")
def rng():
    return np.random.default_rng(1)


def test_differences(rng):
    left, right = rng.integers(0, 256, (2, 3, 7), dtype=np.uint8)
    result = absolute_differences(left, right, 4)
    for y, x, d in np.ndindex(3, 7, 4):
        assert result[y, x, d] == abs(int(left[y, x]) - int(right[y, max(x - d, 0)]))
        assert outside_candidates(7, 4)[x, d] == (d > x)


@pytest.mark.parametrize("size", [1, 3, 5, 11])
@pytest.mark.parametrize("axis", [0, 1])
def test_windows(rng, size, axis):
    array = rng.integers(-9, 10, (6, 8))
    reach = size // 2
    sums, least = ssd.window_sum(array, size, axis), ssd.window_minimum(array, size, axis)
    for y, x in np.ndindex(array.shape):
        place = [y, x]
        window = []
        for step in range(-reach, reach + 1):
            at = list(place)
            at[axis] = min(max(at[axis] + step, 0), array.shape[axis] - 1)
            window.append(array[tuple(at)])
        assert sums[y, x] == sum(window) and least[y, x] == min(window)


def test_ssd_is_the_least_of_shifted_windows(rng):
    left, right = rng.integers(0, 256, (2, 7, 9), dtype=np.uint8)
    cost = np.pad(absolute_differences(left, right, 3)**2, ((2, 2), (2, 2), (0, 0)), mode="edge").astype(np.int64)
    sums = np.array([[cost[y:y + 3, x:x + 3].sum(axis=(0, 1)) for x in range(11)] for y in range(9)])[1:-1, 1:-1]
    sums = np.pad(sums, ((1, 1), (1, 1), (0, 0)), mode="edge")
    least = np.array([[sums[y:y + 3, x:x + 3].min(axis=(0, 1)) for x in range(9)] for y in range(7)])
    assert (ssd.disparities(left, right, 3, 3) == least.argmin(axis=-1)).all()


def path_costs(cost, occlusion):
    """The least cost of every path of a line by trying all: (disparity entered, match or not) of each column."""
    width, labels = cost.shape
    least = {}
    for entered in itertools.product(range(labels), repeat=width):
        for matches in itertools.product((True, False), repeat=width):
            total, at = 0, None
            for x in range(width):
                before = entered[x] if matches[x] else entered[x] - 1  # the disparity before this pixel
                if before < 0 or (at is not None and before > at):
                    break
                total += 0 if at is None else occlusion * (at - before)
                total += (cost[x, entered[x]] if entered[x] <= x else occlusion) if matches[x] else occlusion
                at = entered[x]
            else:
                seen = tuple(m and e <= x for x, (e, m) in enumerate(zip(entered, matches)))
                key = seen, tuple(e for e, s in zip(entered, seen) if s)
                least[key] = min(total, least.get(key, total))
    return least


@pytest.mark.parametrize("occlusion", [0, 3, 10])
def test_paths_are_the_cheapest(rng, occlusion):
    cost = rng.integers(0, 20, (12, 4, 3))
    labels, matched = scanline.paths(cost, occlusion)
    for y, line in enumerate(cost):
        costs = path_costs(line, occlusion)
        found = tuple(matched[y].tolist()), tuple(labels[y][matched[y]].tolist())
        assert costs[found] == min(costs.values())


def test_paths_step_over_an_occlusion():
    # Disparity 0, then 2: the left picture shows two pixels more. Then 0 again: the right one does.
    cost = np.full((1, 12, 3), 50)
    cost[0, :4, 0] = cost[0, 6:9, 2] = cost[0, 9:, 0] = 0
    labels, matched = scanline.paths(cost, 10)
    assert matched[0].tolist() == [True] * 4 + [False] * 2 + [True] * 6
    assert labels[0][matched[0]].tolist() == [0] * 4 + [2] * 3 + [0] * 3


def test_ties_go_to_a_match_and_the_smaller_disparity():
    labels, matched = scanline.paths(np.zeros((1, 5, 3), int), 0)
    assert matched.all() and not labels.any()


def test_a_match_goes_before_an_occlusion():
    # Disparity 1 throughout costs 5 at every pixel; so does disparity 0 for three pixels, then one that is occluded.
    cost = np.array([[[5, 5], [5, 5], [5, 5], [50, 5]]])
    labels, matched = scanline.paths(cost, 5)
    assert matched[0].tolist() == [False, True, True, True]  # the first has its match outside the picture
    assert (labels == 1).all()


def test_occluded_pixels_are_filled(pair):
    left, right, *_ = pair
    labels, matched = scanline.paths(absolute_differences(left, right, 16), scanline.OCCLUSION)
    expected = fill_plain(labels, matched)
    assert (scanline.disparities(left, right, 16) == expected).all() and (expected != labels).any()


@pytest.fixture(scope="module")
def pair():
    return layers(120, 60, 16, seed=3, noise=1.0)


@pytest.mark.parametrize("name", METHODS)
def test_method(pair, name):
    left, right, truth, visible = pair
    if METHODS[name].needs:
        needs(METHODS[name].needs)
    result = METHODS[name].function(left, right, 16)
    assert result.shape == left.shape
    assert 0 <= result.min() and result.max() <= 15
    assert bad_pixels(result, truth, visible) < LIMIT[name]


#: Our named sets of parameters, by their names.
SETS = {name: method for sets in NAMED.values() for name, method in sets.items()}

# Percent of bad pixels, somewhat above what is measured, so that a method that does not do its part shows.
LIMIT = {"dynamic-programming": 4, "ssd-min-filter": 30, "alpha-expansion": 1.5, "alpha-beta-swap": 1.5, "one-pass-expansion": 1,
         "opencv-bm": 10, "opencv-sgbm": 6, "census-sgm": 3, "one-pass-float": 2.5, "one-pass-thesis": 2.5, "one-pass-linear": 2.5,
         **dict.fromkeys(SETS, 2.5)}


def test_ours_are_the_matchers(pair):
    left, right, *_ = pair
    for arithmetic in Arithmetic:
        expected = match(left, right, MatcherConfig(labels=16, method=OnePass(arithmetic)))
        assert (METHODS[f"one-pass-{arithmetic}"].function(left, right, 16) == expected).all()
    for name, method in SETS.items():
        assert (METHODS[name].function(left, right, 16) == match(left, right, MatcherConfig(labels=16, method=method))).all()
        assert METHODS[name].ours and method.name in METHODS[name].about and name in METHODS[name].about


def test_compared():
    """The strong rivals, and the first two sets of each of our methods that has such."""
    assert set(COMPARED) <= set(METHODS) and COMPARED[:4] == ("opencv-sgbm", "census-sgm", "fused-1", "fused-2")
    assert {METHODS[name].ours for name in COMPARED[2:]} == {True} and "fused-3" not in COMPARED


def test_registry_is_whole():
    assert {method.published for method in METHODS.values() if method.published} == set(TABLE_1)
    modules = {cuts.__name__: "maxflow", opencv.__name__: "cv2"}
    assert all(method.needs == modules.get(getattr(method.function, "__module__", "")) for method in METHODS.values())
    # The thesis prints a non-occluded error below that of all pixels, and both below that at edges.
    for row in TABLE_1.values():
        assert row.figures["nonocc"] < row.figures["all"] < row.figures["disc"]


# Slow: the benchmark's figures of these methods are measured by tests of their own.
@pytest.mark.slow
@pytest.mark.parametrize("name", COMPARED)
def test_table_on_data(name):
    """The rows of docs/compare.md that are written by hand; skips without the data."""
    if METHODS[name].needs:
        needs(METHODS[name].needs)
    cells = []
    for pairs in (list(map(middlebury, PAIRS)), training_sets()):
        bad = np.array([measure(pair, name)["bad"] for pair in pairs])
        cells += [" / ".join(f"{value:.2f}" for value in bad.mean(axis=0)), f"{bad.mean():.2f}"]
    page = (pathlib.Path(__file__).parents[4] / "docs" / "compare.md").read_text(encoding="utf-8")
    assert f"\n| `{name}` | {' | '.join(cells)} |\n" in page, "measure it with golden rivals and correct docs/compare.md"


@pytest.mark.parametrize("method", [opencv.block_matching, opencv.semi_global_matching])
def test_opencv(method):
    cv2 = needs("cv2")
    rng = np.random.default_rng(2)
    right = rng.integers(0, 256, (40, 100), dtype=np.uint8)
    left = np.roll(right, 7, axis=1)
    before = cv2.getNumThreads()
    cv2.setNumThreads(3)
    try:
        result = method(left, right, 20)
        assert cv2.getNumThreads() == 3
    finally:
        cv2.setNumThreads(before)
    assert (result * 16 == np.rint(result * 16)).all()
    # The columns are right too that OpenCV leaves out, 32 to the left, the last column, and the first and the last line.
    assert (np.abs(result[:, 7:] - 7) <= 1).all()
    assert not method(np.zeros_like(left), np.zeros_like(left), 20).any()  # no valid pixel at all


def test_opencv_takes_odd_numbers_of_disparities():
    assert [opencv._count(labels) for labels in (2, 16, 17, 60)] == [16, 16, 32, 64]


def test_no_rival_is_loaded_before_it_is_asked_for():
    # The golden model needs NumPy only: a command of it must not need the extra.
    script = "import sys, golden.__main__; print({'cv2', 'maxflow', 'ortools', 'dask', 'distributed'} & set(sys.modules))"
    run = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True, check=True)
    assert run.stdout.strip() == "set()"
