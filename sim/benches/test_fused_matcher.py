"""The whole matcher with the fused method: emitted Verilog on text pictures, bit-exact with the golden model."""


import numpy as np
import pytest

from golden.config import FUSED_1, FUSED_2, FUSED_3, Fused, MatcherConfig, Refinement, changed, value_of
from golden.matcher import fused
from golden.pictures.scenes import discriminates
from sim.benches.matcher_bench import MatcherBench, middlebury, names, pictures


ALL = Refinement()
SET_2, SET_3 = ({name: value_of(method, name) for name in Fused.LIMITS} for method in (FUSED_2, FUSED_3))


def config(disparities, max_width, *, refinement=ALL, minimum=0, **parameters):
    return MatcherConfig(disparities, max_width, minimum, method=changed(changed(FUSED_1, refinement=refinement), **parameters))


# A matcher, the sizes of consecutive frames, one of which has its longest line, and the settings of a last run. It differs from the default
# in many ways. Slow, as a build takes ten seconds or more: with Verilator the method runs in the system's bench, and on Icarus below.
CASES = [
    (config(14, 70, refinement=Refinement(check=False, fill=False, median=False, sub_pixel=True), minimum=-9, cost_factor=0, cost_shift=4,
            census_rows=7, census_columns=9, census_weight=25, reach=31, arm_threshold=60, median_size=3),
     [(70, 8), (14, 2), (13, 2), (1, 1)],
     {"check": 1, "fill": 1, "median": 1, "minimum": -4, "u1": 63, "u2": 1, "u3": 62, "in_use": 8}),
]
# Slow: what the case above combines, one at a time; the sizes of cases for Icarus; more labels; and the named parameters, of which a case
# for Icarus has set 2.
MORE = [
    (config(3, 20, minimum=3, reach=0, census_rows=3, census_columns=3), [(20, 5), (1, 7), (2, 2), (5, 1)],
     {"fill": 0, "minimum": 255}),
    (config(2, 5), [(5, 3), (1, 1), (2, 2), (5, 1)], {"check": 0}),
    (config(3, 64, reach=0, census_rows=3, census_columns=3), [(64, 6), (1, 7), (2, 2)], {"fill": 0}),
    (config(15, 62, refinement=Refinement(check=False, fill=False, median=False), minimum=3, cost_factor=0, census_weight=85, cost_shift=4),
     [(62, 12), (5, 3), (51, 4)], {"check": 1, "fill": 1, "median": 1, "minimum": 0}),
    (config(17, 50, census_rows=7, census_columns=9, census_weight=25, reach=31, arm_threshold=60, median_size=3),
     [(50, 9), (16, 2), (17, 2), (1, 1)], {"minimum": 255}),
    (config(20, 90, refinement=Refinement(sub_pixel=True), minimum=-9), [(90, 8), (5, 3)], {"check": 0, "minimum": -4}),
    (config(39, 160), [(150, 33), (1, 1), (37, 11), (160, 3)], {"u1": 63, "u2": 1, "u3": 62, "in_use": 20}),
    (config(2, 300), [(300, 4), (33, 3)], {"median": 0}),
    (config(13, 64), [(64, 6), (37, 11), (5, 3)], {"minimum": 7}),
    (config(13, 37, reach=31, arm_threshold=60, median_size=3), [(37, 11), (12, 5), (1, 1)], {"fill": 0, "median": 0}),
    (config(17, 50, census_rows=7, census_columns=9, census_weight=25), [(50, 9), (16, 2), (17, 2)], {"minimum": 255}),
    (config(26, 99, cost_factor=0, census_weight=85, cost_shift=4), [(99, 8), (5, 3)], {"check": 0, "fill": 0, "median": 0}),
    (config(39, 161, refinement=Refinement(check=False), minimum=3), [(161, 9)], {"check": 1, "minimum": 0}),
    (config(60, 180, refinement=Refinement(fill=False)), [(180, 11), (59, 2)], {"fill": 1, "in_use": 1}),
    (config(80, 192, refinement=Refinement(median=False)), [(192, 12), (5, 3), (161, 4)], {"median": 1}),
    (config(128, 300), [(300, 7), (5, 3), (257, 2)], {"minimum": 40}),
    (config(21, 70, **SET_3), [(70, 8), (5, 3)], {"median": 0}),
    (config(26, 99, **SET_2), [(99, 8), (1, 1), (5, 3), (60, 1)], {"minimum": 3}),
    (config(20, 90, refinement=Refinement(sub_pixel=True), minimum=5), [(90, 8), (5, 3)], {"check": 0}),
    (config(70, 200, minimum=-64, **SET_2), [(200, 8), (1, 3), (30, 3), (64, 2)], {"minimum": 3}),
]
SMALL = [
    (config(2, 1), [(1, 1), (1, 2)], {"median": 0}),
    (config(7, 24, **SET_2), [(22, 8), (1, 1), (24, 2)], {"fill": 0}),
    # Slow: set 1, which the case of two labels has.
    pytest.param("icarus", config(13, 40), [(37, 11), (1, 1), (40, 2)], {"check": 0}, marks=pytest.mark.slow),
]


@pytest.mark.parametrize("simulator, case, sizes, settings",
                         [*(pytest.param("verilator", *case, marks=pytest.mark.slow) for case in CASES),
                          *(case if hasattr(case, "marks") else ("icarus", *case) for case in SMALL),
                          *(pytest.param("verilator", *case, marks=pytest.mark.slow) for case in MORE)], ids=names)
def test_matches_golden(simulator, case, sizes, settings, tmp_path):
    """Consecutive frames of different sizes, without and with stalls at both ends, on one build; then with other settings."""
    lefts, rights = pictures(sizes, case.labels)
    if any(width >= 2 * case.labels and height > 2 for width, height in sizes):
        found = [fused.stages(left, right, case) for left, right in zip(lefts, rights)]
        labels = np.concatenate([stages.found.ravel() // case.method.disparity_scale for stages in found])
        assert {0, case.labels - 1} <= set(labels.tolist())
        assert not case.method.refinement.check or 0.1 < np.mean(np.concatenate([stages.passed.ravel() for stages in found])) <= 1

    bench = MatcherBench(case, tmp_path)
    result = bench.check(lefts, rights, simulator)
    bench.check_timing(result.frames)
    bench.check(lefts, rights, simulator, stall_i=0.3, stall_o=0.3)
    bench.check(lefts, rights, simulator, stall_o=0.9, seed=2)
    bench.check(lefts, rights, simulator, stall_i=0.8, seed=3, settings=settings)


def test_scene_tells_labels_apart():
    """The scenes of the cases above distinguish a matcher from one with a small fault, with the fused method too."""
    case = config(39, 160)
    (left, *_), (right, *_) = pictures([(160, 33)], 39)
    assert discriminates(fused.stages(left, right, case).found, case)


@pytest.mark.slow
@pytest.mark.parametrize("parameters", [pytest.param({}, id="1"), pytest.param(SET_3, id="3")])
def test_tsukuba(parameters, tmp_path):
    """A real pair, then scenes with stalls and other settings on the same model. Slow: scenes show as much, but for the time."""
    pair = middlebury("tsukuba")
    bench = MatcherBench(config(16, 384, **parameters), tmp_path)
    result = bench.check([pair.left], [pair.right], "verilator")
    assert result.fields[0]["disparity"].shape == (288, 384)
    bench.check_timing(result.frames)
    lefts, rights = pictures([(384, 5), (5, 3), (70, 8)], 16)
    bench.check(lefts, rights, "verilator", stall_i=0.3, stall_o=0.3)
    bench.check(lefts, rights, "verilator", stall_o=0.9, seed=2, settings={"median": 0})


@pytest.mark.slow
def test_venus_teddy_cones(tmp_path):
    """As three consecutive frames."""
    pairs = [middlebury(name) for name in ("venus", "teddy", "cones")]
    bench = MatcherBench(config(60, 450), tmp_path)
    result = bench.check([pair.left for pair in pairs], [pair.right for pair in pairs], "verilator")
    bench.check_timing(result.frames)
