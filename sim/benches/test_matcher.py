"""The whole matcher: emitted Verilog on text pictures, bit-exact with the golden model."""

import numpy as np
import pytest

from golden.config import Arithmetic, Engine, MatcherConfig, OnePass
from golden.matcher.labelling import match
from golden.pictures.scenes import discriminates
from sim.benches.matcher_bench import MatcherBench, middlebury, names, pictures


def config(disparities, arithmetic, fraction_bits=3, weights=OnePass.weights, **settings):
    return MatcherConfig(disparities, method=OnePass(arithmetic, fraction_bits, weights), **settings)


def streaming(disparities, fraction_bits=3, **settings):
    return config(disparities, Arithmetic.LINEAR, fraction_bits, engine=Engine.STREAMING, **settings)


# A matcher, and the sizes of consecutive frames, one of which has its longest line.
CASES = [
    (streaming(13, 1, max_width=64), [(64, 6), (37, 11), (5, 3)]),
]
# Slow: the sequential engine and two labels, which Icarus has below; more labels. Trees and groups of 2, 13 and 39 labels are full, odd and
# partly filled ones, with either arithmetic. Amaranth simulates 26 labels of the sequential engine, and an array of 33 of the other one.
MORE = [
    (config(13, Arithmetic.THESIS, max_width=37, weights=(63, 62, 61)), [(5, 3), (37, 11), (1, 1), (26, 2)]),
    (config(13, Arithmetic.LINEAR, 1, max_width=64), [(37, 11), (64, 6), (5, 3)]),
    (streaming(2, 0, max_width=5), [(5, 3), (1, 1), (2, 2), (5, 1)]),
    (config(2, Arithmetic.THESIS, max_width=1), [(1, 1), (1, 7), (1, 1)]),
    (config(2, Arithmetic.LINEAR, 0, max_width=5), [(5, 3), (1, 1), (2, 2), (5, 1)]),
    (config(39, Arithmetic.THESIS, max_width=160), [(150, 33), (5, 3)]),
    (streaming(39, 2, max_width=160), [(150, 33), (1, 1), (37, 11), (160, 3)]),
    (config(39, Arithmetic.LINEAR, 2, max_width=150), [(1, 1), (150, 33), (37, 11)]),
    (config(80, Arithmetic.THESIS, max_width=192), [(192, 12), (5, 3), (150, 4)]),
    (config(80, Arithmetic.LINEAR, 3, max_width=161), [(161, 9), (37, 11), (1, 1)]),
    (config(128, Arithmetic.THESIS, max_width=300), [(257, 7), (5, 3)]),
    (config(128, Arithmetic.LINEAR, 4, max_width=256), [(1, 1), (256, 7), (150, 3)]),
    (streaming(80, 3, max_width=192), [(192, 12), (5, 3), (161, 4)]),
    (streaming(128, 4, max_width=300), [(300, 7), (5, 3), (257, 2)]),
]
SMALL = [
    (config(2, Arithmetic.THESIS, max_width=1), [(1, 1), (1, 7), (1, 1)]),
    (config(2, Arithmetic.LINEAR, 4, max_width=1), [(1, 1), (1, 2)]),
    (config(13, Arithmetic.THESIS, max_width=40), [(2, 3), (37, 11), (1, 1)]),   # a first line that is shorter than the fill of the tables
    (config(13, Arithmetic.LINEAR, 3, max_width=26), [(26, 4), (5, 3)]),
    (streaming(2, 4, max_width=1), [(1, 1), (1, 2)]),
    (streaming(13, 3, max_width=40), [(37, 11), (1, 1), (40, 2)]),
]


@pytest.mark.parametrize("simulator, case, sizes",
                         [*(("verilator", *case) for case in CASES), *(("icarus", *case) for case in SMALL),
                          *(pytest.param("verilator", *case, marks=pytest.mark.slow) for case in MORE)], ids=names)
def test_matches_golden(simulator, case, sizes, tmp_path):
    """Consecutive frames of different sizes, without and with stalls at both ends, on one build."""
    lefts, rights = pictures(sizes, case.labels)
    found = np.concatenate([match(left, right, case).ravel() for left, right in zip(lefts, rights)])
    if any(width > case.labels for width, _ in sizes):
        assert {0, case.labels - 1} <= set(found.tolist())
    if any(width >= 2 * case.labels and height > 1 for width, height in sizes):
        assert discriminates(found, case)

    bench = MatcherBench(case, tmp_path)
    result = bench.check(lefts, rights, simulator)
    bench.check_timing(result.frames)
    bench.check(lefts, rights, simulator, stall_i=0.3, stall_o=0.3)
    bench.check(lefts, rights, simulator, stall_o=0.9, seed=2)
    bench.check(lefts, rights, simulator, stall_i=0.8, seed=3, settings={"u1": 63, "u2": 1, "u3": 62, "in_use": case.labels // 2 + 1})


def engines(disparities, max_width):
    """One matcher of each kind."""
    return [config(disparities, Arithmetic.THESIS, max_width=max_width), config(disparities, Arithmetic.LINEAR, max_width=max_width),
            streaming(disparities, max_width=max_width)]


@pytest.mark.slow
@pytest.mark.parametrize("case", engines(16, 384), ids=names)
def test_tsukuba(case, tmp_path):
    """Slow: a scene of 13 labels above shows as much, and the streaming engine has this pair with the method fused."""
    pair = middlebury("tsukuba")
    bench = MatcherBench(case, tmp_path)
    result = bench.check([pair.left], [pair.right], "verilator")
    assert result.fields[0]["disparity"].shape == (288, 384)
    bench.check_timing(result.frames)


@pytest.mark.slow
@pytest.mark.parametrize("case", engines(16, 64), ids=names)
def test_tsukuba_crop_on_icarus(case, tmp_path):
    """Slow: scenes on Icarus above have each engine and arithmetic, too."""
    pair = middlebury("tsukuba")
    crop = slice(150, 162), slice(200, 264)
    bench = MatcherBench(case, tmp_path)
    bench.check([pair.left[crop]], [pair.right[crop]], "icarus", stall_o=0.1)


@pytest.mark.slow
def test_256_labels(tmp_path):
    case = streaming(256, max_width=600)
    lefts, rights = pictures([(600, 5), (7, 3)], 256)
    bench = MatcherBench(case, tmp_path)
    bench.check(lefts, rights, "verilator")
    bench.check(lefts, rights, "verilator", stall_i=0.3, stall_o=0.3)


@pytest.mark.slow
@pytest.mark.parametrize("case", engines(60, 450), ids=names)
def test_venus_teddy_cones(case, tmp_path):
    """As three consecutive frames."""
    pairs = [middlebury(name) for name in ("venus", "teddy", "cones")]
    bench = MatcherBench(case, tmp_path)
    result = bench.check([pair.left for pair in pairs], [pair.right for pair in pairs], "verilator")
    bench.check_timing(result.frames)
