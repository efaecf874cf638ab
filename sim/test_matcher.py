"""The whole matcher: emitted Verilog on text pictures, equal to the golden model in every pixel."""

from dataclasses import replace

import numpy as np
import pytest

from golden.config import Arithmetic, Engine, MatcherConfig
from golden.dataset import data_folder, load_pair
from golden.errors import UserError
from golden.labelling import match
from golden.scenes import discriminates, scene
from hdl.emit import write_verilog
from hdl.matcher import Matcher
from sim.cases import noise
from sim.harness import simulate


def config(disparities, arithmetic, fraction_bits=3, **settings):
    return MatcherConfig(disparities=disparities, arithmetic=arithmetic, fraction_bits=fraction_bits, **settings)


def streaming(disparities, fraction_bits=3, **settings):
    return config(disparities, Arithmetic.LINEAR, fraction_bits, engine=Engine.STREAMING, **settings)


def names(case):
    """Of a parameter, for pytest."""
    if isinstance(case, MatcherConfig):
        fraction_bits = f"q{case.fraction_bits}" if case.arithmetic is Arithmetic.LINEAR else ""
        return f"{case.engine}-{case.disparities}-{case.arithmetic}{fraction_bits}"
    return "+".join(f"{width}x{height}" for width, height in case) if isinstance(case, list) else str(case)


def pictures(sizes, labels):
    """Scenes; noise where a picture is too narrow for one."""
    pairs = [scene(width, height, labels, seed)[:2] if width > 2 else noise(width, height, seed).astype(np.uint8)
             for seed, (width, height) in enumerate(sizes)]
    return [left for left, _ in pairs], [right for _, right in pairs]


class Bench:
    """A matcher's Verilog, for many runs."""
    def __init__(self, case, folder):
        matcher = Matcher(case)
        self.case = case
        self.folder = folder
        self.verilog = write_verilog(matcher, folder / "matcher.v", name="matcher")
        self.clocks_per_pixel = matcher.clocks_per_pixel
        self.latency_clocks = matcher.latency_clocks
        self.full_rate_width = matcher.full_rate_width

    def check(self, lefts, rights, simulator, *, weights=None, in_use=None, **arguments):
        """Equal to golden in every pixel of every frame; no hang, no broken rule, no wrong flag, nothing surplus, no ``error``."""
        result = simulate(self.case, lefts, rights, simulator=simulator, work_dir=self.folder, verilog=self.verilog, weights=weights,
                          in_use=in_use, **arguments)
        case = replace(self.case, in_use=in_use, **dict(zip(("u1", "u2", "u3"), weights or self.case.weights)))
        for left, right, labels in zip(lefts, rights, result.labels, strict=True):
            assert np.count_nonzero(labels != match(left, right, case)) == 0
        assert result.report["pixels_in"] == result.report["pixels_out"] == sum(left.size for left in lefts)
        for fault in ("hang", "error", "rule_errors", "flag_errors", "unknown_words", "extra_words"):
            assert result.report[fault] == 0
        return result

    def check_timing(self, frames):
        """Clocks per pixel, and latency, of frames given and taken without stalls."""
        for number, frame in enumerate(frames):
            # Frames in a row: the first lines of one wait while the last two lines of each before it leave.
            width = max(frame.width for frame in frames[:number + 1])
            if min(frame.width for frame in frames[:number + 1]) < self.full_rate_width:
                continue  # nothing is promised of short lines: pixels come faster than disparities leave, and wait
            assert frame.latency <= 2 * (number + 1) * width * self.clocks_per_pixel + self.latency_clocks
        assert self.clocks_per_pixel <= 8
        assert self.latency_clocks <= 400
        first = frames[0]
        # A line costs a few clocks more than its pixels.
        assert first.clocks_per_pixel <= max(self.full_rate_width / first.width, self.clocks_per_pixel) + 40 / first.width


# A matcher, and the sizes of the frames that it gets in a row: one that reaches its longest line among them.
CASES = [
    (config(2, Arithmetic.THESIS, max_width=1), [(1, 1), (1, 7), (1, 1)]),
    (config(2, Arithmetic.LINEAR, 0, max_width=5), [(5, 3), (1, 1), (2, 2), (5, 1)]),
    (config(13, Arithmetic.THESIS, max_width=37, u1=63, u2=62, u3=61), [(5, 3), (37, 11), (1, 1), (26, 2)]),
    (config(13, Arithmetic.LINEAR, 1, max_width=64), [(37, 11), (64, 6), (5, 3)]),
    (config(39, Arithmetic.THESIS, max_width=160), [(150, 33), (5, 3)]),
    (config(39, Arithmetic.LINEAR, 2, max_width=150), [(1, 1), (150, 33), (37, 11)]),
    (config(80, Arithmetic.THESIS, max_width=192), [(192, 12), (5, 3), (150, 4)]),
    (config(80, Arithmetic.LINEAR, 3, max_width=161), [(161, 9), (37, 11), (1, 1)]),
    (config(128, Arithmetic.THESIS, max_width=300), [(257, 7), (5, 3)]),
    (config(128, Arithmetic.LINEAR, 4, max_width=256), [(1, 1), (256, 7), (150, 3)]),
]
STREAMING = [
    (streaming(2, 0, max_width=5), [(5, 3), (1, 1), (2, 2), (5, 1)]),
    (streaming(13, 1, max_width=64), [(64, 6), (37, 11), (5, 3)]),
    (streaming(39, 2, max_width=160), [(150, 33), (1, 1), (37, 11), (160, 3)]),
    (streaming(80, 3, max_width=192), [(192, 12), (5, 3), (161, 4)]),
    (streaming(128, 4, max_width=300), [(300, 7), (5, 3), (257, 2)]),
]
SMALL = [
    (config(2, Arithmetic.THESIS, max_width=5), [(5, 3), (1, 1)]),
    (config(2, Arithmetic.LINEAR, 4, max_width=1), [(1, 1), (1, 2)]),
    (config(13, Arithmetic.THESIS, max_width=40), [(2, 3), (37, 11), (1, 1)]),   # a first line shorter than the fill of the tables
    (config(13, Arithmetic.LINEAR, 3, max_width=26), [(26, 4), (5, 3)]),
    (streaming(2, 4, max_width=1), [(1, 1), (1, 2)]),
    (streaming(13, 3, max_width=40), [(37, 11), (1, 1), (40, 2)]),
]


@pytest.mark.parametrize("simulator, case, sizes",
                         [("verilator", *case) for case in CASES + STREAMING] + [("icarus", *case) for case in SMALL], ids=names)
def test_matches_golden(simulator, case, sizes, tmp_path):
    """Frames of different sizes in a row, without and with stalls at both ends, on one build."""
    lefts, rights = pictures(sizes, case.disparities)
    found = np.concatenate([match(left, right, case).ravel() for left, right in zip(lefts, rights)])
    if any(width > case.disparities for width, _ in sizes):
        assert {0, case.disparities - 1} <= set(found.tolist())
    if any(width >= 2 * case.disparities and height > 1 for width, height in sizes):
        assert discriminates(found, case)

    bench = Bench(case, tmp_path)
    result = bench.check(lefts, rights, simulator)
    bench.check_timing(result.frames)
    bench.check(lefts, rights, simulator, stall_i=0.3, stall_o=0.3)
    bench.check(lefts, rights, simulator, stall_o=0.9, seed=2)
    bench.check(lefts, rights, simulator, stall_i=0.8, seed=3, weights=(63, 1, 62), in_use=case.disparities // 2 + 1)


def middlebury(name):
    try:
        folder = data_folder()
    except UserError as error:
        pytest.skip(str(error))
    return load_pair(folder, name)


def engines(disparities, max_width):
    """One matcher of each kind."""
    return [config(disparities, Arithmetic.THESIS, max_width=max_width), config(disparities, Arithmetic.LINEAR, max_width=max_width),
            streaming(disparities, max_width=max_width)]


@pytest.mark.parametrize("case", engines(16, 384), ids=names)
def test_tsukuba(case, tmp_path):
    pair = middlebury("tsukuba")
    bench = Bench(case, tmp_path)
    result = bench.check([pair.left], [pair.right], "verilator")
    assert result.labels[0].shape == (288, 384)
    bench.check_timing(result.frames)


@pytest.mark.parametrize("case", engines(16, 64), ids=names)
def test_tsukuba_crop_on_icarus(case, tmp_path):
    pair = middlebury("tsukuba")
    crop = slice(150, 162), slice(200, 264)
    bench = Bench(case, tmp_path)
    bench.check([pair.left[crop]], [pair.right[crop]], "icarus", stall_o=0.1)


@pytest.mark.slow
def test_256_labels(tmp_path):
    case = streaming(256, max_width=600)
    lefts, rights = pictures([(600, 5), (7, 3)], 256)
    bench = Bench(case, tmp_path)
    bench.check(lefts, rights, "verilator")
    bench.check(lefts, rights, "verilator", stall_i=0.3, stall_o=0.3)


@pytest.mark.slow
@pytest.mark.parametrize("case", engines(60, 450), ids=names)
def test_venus_teddy_cones(case, tmp_path):
    """As three frames in a row."""
    pairs = [middlebury(name) for name in ("venus", "teddy", "cones")]
    bench = Bench(case, tmp_path)
    result = bench.check([pair.left for pair in pairs], [pair.right for pair in pairs], "verilator")
    bench.check_timing(result.frames)
