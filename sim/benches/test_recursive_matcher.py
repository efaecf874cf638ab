"""The whole matcher with the method recursive: emitted Verilog on text pictures, bit-exact with the golden model."""

import numpy as np
import pytest

from golden.config import RECURSIVE_1, MatcherConfig, changed
from golden.matcher.recursive.method import stages
from golden.pictures.scenes import discriminates
from sim.benches.matcher_bench import MatcherBench, middlebury, names, pictures


def config(disparities, max_width, *, minimum=0, **parameters):
    return MatcherConfig(disparities, max_width, minimum, method=changed(RECURSIVE_1, **parameters))


WIDE = {"near_threshold": 40, "far_threshold": 30, "step_threshold": 50, "reach": 31}  # arms of many lengths in scenes
WIDE_SETTINGS = {name: value for name, value in WIDE.items() if name != "reach"}
NARROW = {"near_threshold": 2, "far_threshold": 9, "step_threshold": 255}
# A matcher, the sizes of consecutive frames, one of which has its longest line, and the settings of a last run. Few, as each build takes
# fifteen seconds or more. With costs from below there is all that there is without, and more.
CASES = [
    (config(9, 90, minimum=-9, from_below=True, sub_pixel=True, fill=False, own_share=7, spread_step=1, spread_jump=127, gate_floor=127,
            above_share=15),
     [(90, 8), (5, 3)], {"fill": 1, "above_share": 1, "below_share": 15, "gate_floor": 3, "minimum": -4}),
]
# Slow: what a case above combines, one at a time; more labels and longer lines; windows and arms of other sizes.
MORE = [
    (config(20, 90, minimum=-9, fill=False, own_share=7, lower_share=0, spread_step=1, spread_jump=127, gate_floor=127, above_share=15),
     [(90, 8), (5, 3)], {"fill": 1, "above_share": 1, "minimum": -4}),
    (config(2, 5, from_below=True, reach=2, fan=3), [(5, 3), (1, 1), (2, 2), (5, 1)], {"check": 0}),
    (config(13, 50, from_below=True, census_rows=7, census_columns=9, census_weight=25, far_step=1, **WIDE),
     [(50, 9), (16, 2), (17, 2), (1, 1)], {"minimum": 255, "below_share": 0}),
    (config(39, 240, from_below=True), [(240, 33), (1, 1), (37, 11), (160, 3)],
     {"in_use": 20, "census_threshold": 7, "near_threshold": 60, "far_threshold": 70, "step_threshold": 80, "above_share": 0}),
    (config(6, 1, from_below=True, census_rows=1, census_columns=1, reach=0), [(1, 9), (1, 1)], {"median": 0}),
    (config(37, 99, from_below=True, soft_multipliers=True, lower_threshold=0, fan=31, **NARROW), [(99, 8), (5, 3)], WIDE_SETTINGS),
    (config(64, 530, from_below=True), [(530, 7), (5, 3), (257, 2)], {"minimum": 40}),
    (config(9, 44, check=False, fill=False, median=False, minimum=3, census_threshold=2), [(44, 9), (5, 3), (31, 4)],
     {"check": 1, "fill": 1, "median": 1, "minimum": 0, "census_threshold": 0}),
    (config(2, 5, reach=2, fan=3), [(5, 3), (1, 1), (2, 2), (5, 1)], {"check": 0}),
    (config(13, 50, census_rows=7, census_columns=9, census_weight=25, far_step=1, **WIDE), [(50, 9), (16, 2), (17, 2), (1, 1)],
     {"minimum": 255}),
    (config(39, 160), [(150, 33), (1, 1), (37, 11), (160, 3)],
     {"in_use": 20, "census_threshold": 7, "near_threshold": 60, "far_threshold": 70, "step_threshold": 80, "above_share": 0}),
    (config(3, 64, census_rows=3, census_columns=3, fan=31), [(64, 6), (1, 7), (2, 2)], {"fill": 0, "above_share": 15}),
    (config(6, 1, census_rows=1, census_columns=1, reach=0), [(1, 9), (1, 1)], {"median": 0}),
    (config(26, 99, median=False, cost_limit=255, cost_shift=4, cost_factor=0), [(99, 8), (5, 3)], {"median": 1, **NARROW}),
    (config(2, 300), [(300, 4), (33, 3)], {"median": 0}),
    (config(13, 37, **WIDE), [(37, 11), (12, 5), (1, 1)], {"fill": 0, "median": 0}),
    (config(21, 70, check=False), [(70, 9), (5, 3)], {"check": 1, "in_use": 1}),
    (config(39, 161, minimum=3, far_step=32), [(161, 9), (40, 2)], NARROW),
    (config(60, 180, lower_threshold=255, gate_floor=0, fan=17), [(180, 11), (59, 2)], {"census_threshold": 1}),
    (config(80, 192, minimum=-64), [(192, 12), (5, 3), (161, 4)], {"fill": 0, "minimum": 0}),
    (config(128, 300), [(300, 7), (5, 3), (257, 2)], {"minimum": 40}),
]
SMALL = [
    (config(5, 20, fan=3), [(18, 4), (1, 1), (20, 2)], {"check": 0}),
    pytest.param("icarus", config(9, 24, from_below=True, reach=5, fan=3), [(24, 7), (1, 1), (20, 2)], {"below_share": 15},
                 marks=pytest.mark.slow),
    pytest.param("icarus", config(13, 40), [(37, 11), (1, 1), (40, 2)], {"census_threshold": 2}, marks=pytest.mark.slow),
]


@pytest.mark.parametrize("simulator, case, sizes, settings",
                         [*(case if hasattr(case, "marks") else ("icarus", *case) for case in SMALL),
                          # Slow: Verilator compiles for long; the same Verilog runs on Icarus.
                          *(pytest.param("verilator", *case, marks=pytest.mark.slow) for case in (*CASES, *MORE))], ids=names)
def test_matches_golden(simulator, case, sizes, settings, tmp_path):
    """Consecutive frames of different sizes, without and with stalls at both ends, on one build; then with other settings."""
    lefts, rights = pictures(sizes, case.labels)
    if any(width >= 2 * case.labels and height > 2 for width, height in sizes):
        found = [stages(left, right, case) for left, right in zip(lefts, rights)]
        labels = np.concatenate([each.found.ravel() for each in found]) // case.method.disparity_scale
        assert {0, case.labels - 1} <= set(labels.tolist())
        assert not case.method.refinement.check or 0.1 < np.mean(np.concatenate([each.passed.ravel() for each in found])) <= 1

    bench = MatcherBench(case, tmp_path)
    result = bench.check(lefts, rights, simulator)
    bench.check_timing(result.frames)
    bench.check(lefts, rights, simulator, stall_i=0.3, stall_o=0.3)
    bench.check(lefts, rights, simulator, stall_o=0.9, seed=2)
    bench.check(lefts, rights, simulator, stall_i=0.8, seed=3, settings=settings)


def test_scene_tells_labels_apart():
    """The scenes of the cases above distinguish a matcher from one with a small fault, with the method recursive too."""
    case = config(39, 160)
    (left, *_), (right, *_) = pictures([(160, 33)], 39)
    assert discriminates(stages(left, right, case).found, case)


@pytest.mark.slow
def test_middlebury(tmp_path):
    """Real pairs as consecutive frames of two sizes, then scenes with stalls and other settings on the same model."""
    pairs = [middlebury(name) for name in ("tsukuba", "teddy")]
    bench = MatcherBench(config(60, 450), tmp_path)
    result = bench.check([pair.left for pair in pairs], [pair.right for pair in pairs], "verilator")
    bench.check_timing(result.frames)
    lefts, rights = pictures([(450, 5), (5, 3), (70, 8)], 60)
    bench.check(lefts, rights, "verilator", stall_i=0.3, stall_o=0.3)
    bench.check(lefts, rights, "verilator", stall_o=0.9, seed=2, settings={"median": 0})
